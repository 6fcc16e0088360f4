"""The outcome of a fit is a value: the model, how the solver ended, and each parameter with its interval."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Generic, Literal, TypeVar

import numpy as np

from erclutch.fit.solver.intervals import as_json
from erclutch.fit.solver.levenberg_marquardt import Stop
from erclutch.models.model import Model
from erclutch.signals.array import Array
from erclutch.signals.shown import Shown, one_line

#: Condition of the Jacobian beyond which single parameters are lost in each other's intervals.
MEANINGLESS = 1e8
#: Inputs that a name lists, and characters of each: a name is read by people, and a run folder bounds it.
_MANY, _LONG = 8, 60


@dataclass(frozen=True)
class Estimate:
    """One parameter in the user's units.

    Attributes:
        name, meaning, unit: what it is.
        value: the estimate.
        low, high: 95 % interval; -inf and inf where the data do not identify it; nan where no intervals were made.
        at_bound: the bound that it lies on.
    """

    name: str
    meaning: str
    unit: str
    value: float
    low: float
    high: float
    at_bound: Literal["lower", "upper"] | None = None

    def to_dict(self) -> dict[str, Any]:
        """As JSON values; an unidentified interval is null."""
        body = asdict(self)
        body["low"] = as_json(self.low)
        body["high"] = as_json(self.high)
        return body


M = TypeVar("M", bound=Model, covariant=True)


@dataclass(frozen=True, repr=False)
class FitOutcome(Shown, Generic[M]):
    """What came out of a fit.

    Attributes:
        model: the fitted model.
        stop: how the solver ended; "converged" is good.
        iterations: steps of the last solver run.
        estimates: all parameters, nonlinear ones first.
        paper_form: the same numbers in the published symbols, where those differ; by element for a pair.
        rank, unknowns: numerical rank of the Jacobian against the number of free parameters.
        condition: its condition number, columns scaled to one.
        bandwidth: of the covariance behind the intervals, in rows, after whitening; 1 where rows have no order.
        train_cost: sum of squared residuals on the training rows.
        train_rows: number of training rows.
        weights: number of weights of a network, whose parameters mean nothing one by one; 0 for a law.
        idle: names of parameters that move nothing, since all gains that they shape are zero.
        without: names of the gains that were kept at zero, since a memory says what they say.
        notes: what the fit has to say, for people.
        unseen: errors on the training rows by fits without the logs of a row's motion, shape (n,); None: not known.
    """

    model: M
    stop: Stop
    iterations: int
    estimates: tuple[Estimate, ...]
    paper_form: Mapping[str, float]
    rank: int
    unknowns: int
    condition: float
    bandwidth: int
    train_cost: float
    train_rows: int
    weights: int = 0
    idle: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    unseen: Array | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        size = f"{self.weights} weights" if self.weights else f"{self.parameters} parameters"
        ended = f"{self.stop}, last solver {self.iterations} steps"
        return one_line(self, self.model.name, size, ended, f"rank {self.rank} of {self.unknowns}")

    @property
    def name(self) -> str:
        """What tells it from the other fits of a comparison: the model's name, and the further inputs of its law.

        The same law with the same stages may stand there twice, with an input that helps it and without.
        """
        if not self.chosen_inputs:
            return self.model.name
        listed = [
            name if len(name) <= _LONG else f"{name[:_LONG]}..."
            for name in self.chosen_inputs[:_MANY]
        ]
        further = len(self.chosen_inputs) - len(listed)
        more = f" and {further} more" if further else ""
        return f"{self.model.name}@with {', '.join(listed)}{more}"

    @property
    def chosen_inputs(self) -> tuple[str, ...]:
        """Further inputs of its law that no stage brings; none for a model without a law."""
        law = self.model.law_part
        return () if law is None else law.structure.chosen_inputs

    @property
    def converged(self) -> bool:
        """Whether the solver met its tolerance."""
        return self.stop == "converged"

    @property
    def parameters(self) -> int:
        """Number of parameters of the model, those on a bound included."""
        return len(self.estimates) + self.weights

    @property
    def at_bounds(self) -> tuple[str, ...]:
        """Names of the parameters that the fit left on a bound; those that were kept at zero are none of these."""
        return tuple(e.name for e in self.estimates if e.at_bound and e.name not in self.without)

    @property
    def unidentified(self) -> tuple[str, ...]:
        """Names of the parameters that these data do not identify, and that no bound holds either."""
        lost: list[str] = []
        for estimate in self.estimates:
            no_width = np.isinf(estimate.high - estimate.low)
            if no_width and not estimate.at_bound and estimate.name not in self.idle:
                lost.append(estimate.name)
        return tuple(lost)

    @property
    def sound(self) -> bool:
        """Whether the fit ended well and the data identify all that the model says."""
        if self.weights:
            return self.stop != "stalled"
        known = self.rank + len(self.idle) >= self.unknowns and not self.unidentified
        # An idle parameter makes the condition infinite, and says nothing of the others.
        return self.converged and known and (self.condition <= MEANINGLESS or bool(self.idle))

    @property
    def freedom(self) -> int:
        """How free the model is of physics beyond its rows: a law 0, a law with a network 1, weights alone 2."""
        if not self.weights:
            return 0
        return 1 if self.model.correction is not None else 2

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "model": self.model.to_dict(),
            "converged": self.converged,
            "stop": self.stop,
            "iterations": self.iterations,
            "parameters": [e.to_dict() for e in self.estimates],
            "paper_form": {name: as_json(value) for name, value in self.paper_form.items()},
            "rank": self.rank,
            "unknowns": self.unknowns,
            "condition": as_json(self.condition),
            "bandwidth_rows": self.bandwidth,
            "train_rows": self.train_rows,
            "weights": self.weights,
        }


#: The outcome of a fit of any kind of model.
AnyOutcome = FitOutcome[Any]
