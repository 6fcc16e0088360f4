"""What a comparison says while it runs: how much of its work is done, and how far each fitted model is off.

A comparison has phases: the candidates of each kind of model, what their fits call for, and the choice. A lag is fitted
in a second and a memory in twenty, so phases are weighed by the time that they take, not by the number of their models.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset


@dataclass(frozen=True)
class FitStep:
    """A step of a comparison that has just been done.

    Attributes:
        done: how much of the comparison is done, 0 to 1; an estimate, since the fits decide what is fitted next.
        doing: the step in words.
        fitted: name of the model that was fitted; "" where the step was no fit.
        train_share: RMSE of that model on the training rows, over the standard deviation of their effort. It ranks
            nothing: rows that a fit has seen flatter the freest model.
    """

    done: float
    doing: str
    fitted: str = ""
    train_share: float | None = None


#: Called after each step.
FitProgress = Callable[[FitStep], None]


class Course:
    """How far a comparison has come.

    Args:
        phases: weight of each phase, the first one first.
        report: called with each step; None: nobody asks.
    """

    def __init__(self, phases: tuple[float, ...], report: FitProgress | None) -> None:
        self._weights = phases
        self._report = report
        self._phase = -1

    def begin(self) -> None:
        """The next phase begins."""
        self._phase += 1

    def fitted(
        self,
        share: float,
        name: str,
        outcome: AnyOutcome | None,
        train: Dataset,
    ) -> None:
        """Tell that a model was fitted, or could not be (None), with which this share of the phase is done."""
        if outcome is None:
            self._tell(FitStep(self._done(share), f"left out {name}"))
            return
        spread = float(np.std(train.effort))
        rmse = float(np.sqrt(outcome.train_cost / outcome.train_rows))
        error = rmse / spread if spread > 0.0 else np.inf
        known = error if np.isfinite(error) else None
        self._tell(FitStep(self._done(share), f"fitted {name}", name, known))

    def told(self, share: float, doing: str) -> None:
        """Tell another step, with which this share of the phase is done."""
        self._tell(FitStep(self._done(share), doing))

    def _done(self, share: float) -> float:
        """Share of the whole work that is done, with this share of the phase."""
        before = sum(self._weights[: self._phase])
        now = share * self._weights[self._phase]
        return min(1.0, (before + now) / sum(self._weights))

    def _tell(self, step: FitStep) -> None:
        if self._report is not None:
            self._report(step)
