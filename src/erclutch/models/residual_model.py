"""A ResidualModel has a law, and a bounded network that adds what the law misses where there were training rows.

::

    effort = law + weight(x) * within(network(x), -limit, limit)

The inputs x are the field in the fluid, the slips, past samples of these, the memory of the law's stages, and further
logged inputs. The network's share is added behind the stages on the effort. Without it, all is the law alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.arithmetic.dual import rows_before
from erclutch.models.band import Band
from erclutch.models.covered_cells import CoveredCells, within
from erclutch.models.given_rows import further_inputs
from erclutch.models.law_model import TorqueModel, model_from_dict
from erclutch.models.model import FluidSignals, Pair, Range, settled_memory
from erclutch.models.model_file import SCHEMA, number_of, read_model, sealed, table_of
from erclutch.models.networks import NetworkStructure, is_network
from erclutch.models.networks.network_file import network_from_dict
from erclutch.models.networks.network_inputs import inputs_from
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.shared_answers import ModelBase
from erclutch.models.stages import stage_equations
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.models.structure import Structure
from erclutch.registry import Plugin
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import DeviceName, Element, Units

KIND = "erclutch law with residual network"
_LEAST_SHARE = 1e-3  # of the network that is kept, so that its limit stays above zero


def parts_of(specification: str) -> tuple[str, str] | None:
    """The law and the network of a name such as ``bingham+fnn-16``, stages may follow; None for any other name."""
    law, *further = specification.replace(" ", "").split("+")
    return (law, further[0]) if further and is_network(further[0]) else None


@dataclass(frozen=True)
class ResidualStructure:
    """What is fitted, without numbers.

    Attributes:
        law: the law with all stages.
        network: the network on the law's residual; its dynamics are those of the law.
    """

    law: Structure
    network: NetworkStructure

    @property
    def device(self) -> DeviceName:
        """Which device it is of."""
        return self.law.device

    @property
    def specification(self) -> str:
        """Names of law and network, for example ``bingham+fnn-16``."""
        return f"{self.law.specification}+{self.network.specification}"

    @property
    def dynamics(self) -> str:
        """Names of the law's stages."""
        return self.law.dynamics


@dataclass(frozen=True)
class BoundedResidual:
    """What the network adds to the law's effort.

    Attributes:
        network: from its inputs to the effort that the law misses.
        limit: the largest effort that is added or taken away.
        covered: where there were training rows.
    """

    network: NetworkModel
    limit: float
    covered: CoveredCells

    def inputs(self, signals: FluidSignals) -> list[Any]:
        """All inputs of the network, elementwise on any operand."""
        return inputs_from(self.network.structure, signals)

    def of(self, *inputs: Any) -> Any:
        """Effort that is added, for inputs that record."""
        return self._bounded(inputs, inputs[0].record("network", *inputs))

    def of_inputs(self, inputs: Array, *, exactly: bool = True) -> Array:
        """Effort that is added, shape (n,), for all inputs of the network (inputs, n)."""
        added = self.network.of_inputs(inputs, exactly=exactly)
        return np.asarray(self._bounded(list(inputs), added))

    def _bounded(self, inputs: Sequence[Any], missed: Any) -> Any:
        return self.covered.weight(inputs) * within(missed, -self.limit, self.limit)


@dataclass(frozen=True, repr=False)
class ResidualModel(ModelBase):
    """A law and a bounded network on its residual.

    Attributes:
        law: with its stages and numbers; it has the units and the period of all.
        correction: what the network adds.
        band: how far the measured effort may lie from the estimate.
    """

    law: TorqueModel
    correction: BoundedResidual
    band: Band | None = None

    @property
    def structure(self) -> ResidualStructure:
        """Law, stages and network."""
        return ResidualStructure(self.law.structure, self.correction.network.structure)

    @property
    def law_part(self) -> TorqueModel:
        """The law."""
        return self.law

    @property
    def network_part(self) -> NetworkModel:
        """The network on the law's residual."""
        return self.correction.network

    @property
    def units(self) -> Units:
        """Of inputs and output."""
        return self.law.units

    @property
    def trained_on(self) -> Range:
        """Range of the training data."""
        return self.law.trained_on

    @property
    def title(self) -> str:
        """Name for people."""
        return f"{self.law.title} with {self.correction.network.title} on its residual"

    @property
    def period(self) -> float:
        """Sampling period of the training data in s."""
        return self.law.period

    @property
    def times(self) -> Mapping[str, float]:
        """Parameters of the stages by name."""
        return self.law.times

    @property
    def extras(self) -> Mapping[str, Pair]:
        """Further inputs of the law, then those of the network alone, and the range of each."""
        return {**self.law.extras, **self.correction.network.extras}

    @property
    def past(self) -> tuple[int, ...]:
        """Rows back whose signals are inputs of the network."""
        return self.correction.network.past

    @property
    def signed(self) -> bool:
        """A law sees the magnitude of the field, and the network may see its sign."""
        return True

    @property
    def numbers(self) -> Mapping[str, Any]:
        """Everything that was fitted or measured, by name."""
        numbers = dict(self.law.numbers)
        for name, value in self.correction.network.numbers.items():
            numbers[f"network {name}"] = value
        numbers["limit"] = self.correction.limit
        cells = self.correction.covered
        numbers["covered from"] = cells.low
        numbers["covered to"] = cells.high
        numbers["reach"] = cells.reach
        return numbers

    def in_units(self) -> Iterator[tuple[str, float, str, str]]:
        """Parameters of the law."""
        return self.law.in_units()

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """What the law needs of other packages."""
        return self.law.plugins

    def effort_of_rows(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool,
    ) -> Array:
        """Effort on the long road, shape (n,); see `ModelBase.effort`."""
        law = self.law.effort_of_rows(elements, clock, extras, exactly=exactly)
        return law + self.added(elements, clock, extras, exactly=exactly)

    def added(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool = True,
    ) -> Array:
        """What the network adds to the law's effort, shape (n,).

        Raises:
            MappingError: a further input is not there.
        """
        inputs = residual_inputs(
            self.law, self.correction.network.structure, elements, clock, extras
        )
        return self.correction.of_inputs(inputs, exactly=exactly)

    def scaled(self, factor: float, offset: float = 0.0) -> ResidualModel:
        """Law and network with their effort times a factor; the law has the constant effort."""
        return self.with_parts(self.law.scaled(factor, offset), factor)

    def with_parts(self, law: TorqueModel, share: float) -> ResidualModel:
        """The same network on other numbers of the law, its output and its limit times a share."""
        share = max(share, _LEAST_SHARE)
        network = self.correction.network.scaled(share)
        correction = replace(self.correction, network=network, limit=share * self.correction.limit)
        return ResidualModel(law, correction)

    def steady(
        self,
        fields: Sequence[Array],
        slips: Sequence[Array],
        extras: Sequence[Array] = (),
    ) -> Array:
        """Effort at rest, shape (n,): the fluid settled, all past rows as the present one."""
        of_law = extras[: len(self.law.extras)]  # the law's own come first
        law = self.law.steady(fields, slips, of_law)
        fluids = [self.command(array_as_in_c(np.atleast_1d(field))) for field in fields]
        slips_as_in_c = [array_as_in_c(np.atleast_1d(slip)) for slip in slips]
        remembered = settled_memory(self, self.moved(fluids, slips_as_in_c))
        further = dict(zip(self.extras, extras, strict=True))
        inputs = self.correction.inputs(FluidSignals(fluids, slips_as_in_c, remembered, further))
        rows = np.array(np.broadcast_arrays(*inputs), np.float64)
        return law + self.correction.of_inputs(rows)

    def command(self, field: Any) -> Any:
        """What the stages on the command work on, as for the law."""
        return self.law.command(field)

    def moved(self, fluids: Sequence[Any], slips: Sequence[Any]) -> list[SlipAndStrength]:
        """What the stages on the slip of each element work on, as for the law."""
        return self.law.moved(fluids, slips)

    def from_fluid(self, signals: FluidSignals) -> Any:
        """The law's effort ahead of the stages on it; the correction comes behind them."""
        return self.law.from_fluid(signals)

    def equation(self) -> list[str]:
        """The equation and what it needs, as lines of a comment."""
        bounded = f"effort = law + weight * (y within -{self.correction.limit:.9g} .. {self.correction.limit:.9g})"
        fades = (
            "The weight is 1 where there were training rows and fades to 0 where there were none."
        )
        # Of the law, whose memory the network shares.
        of_law = stage_equations(self.structure.dynamics)
        network = [line for line in self.correction.network.equation() if line not in of_law]
        return [*self.law.equation(), "", bounded, "", fades, "", *network]

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values, with a schema version and a digest over all of them."""
        cells = self.correction.covered
        body: dict[str, Any] = {
            "kind": KIND,
            "schema": SCHEMA,
            "law": self.law.to_dict(),
            "network": self.correction.network.to_dict(),
            "limit": self.correction.limit,
            "covered": {
                "low": cells.low.tolist(),
                "high": cells.high.tolist(),
                "reach": cells.reach.tolist(),
            },
        }
        return sealed(body, self.band)


def residual_inputs(
    law: TorqueModel,
    structure: NetworkStructure,
    elements: Sequence[Element],
    clock: Clock,
    extras: Mapping[str, Array],
) -> Array:
    """Inputs of a network on a law's residual, shape (inputs, n): the law's own signals, with the bits of the C.

    Raises:
        MappingError: a further input is not there.
    """
    further = further_inputs(structure.extras, extras)
    q = list(law.shape.values())
    fluids, slips, _, remembered = law.structure.signals(
        elements, clock, law.reference, q, array_as_in_c
    )
    signals = FluidSignals(
        fluids, slips, remembered, further, lambda x, k: rows_before(x, clock, k)
    )
    return np.array(inputs_from(structure, signals), np.float64)


def residual_from_dict(body: Mapping[str, Any], where: str = "model") -> ResidualModel:
    """The model that `ResidualModel.to_dict` wrote.

    Raises:
        RunError: another schema, a missing or unfitting entry, or numbers that do not match the digest.
    """

    def model_of(content: Mapping[str, Any]) -> ResidualModel:
        """The model of a file's content; `read_model` makes a RunError of what is raised here."""
        law = model_from_dict(content["law"], where)
        network = network_from_dict(content["network"], where, alone=False)
        of_network = (network.structure.device, network.structure.dynamics, network.units)
        of_law = (law.structure.device, law.structure.dynamics, law.units)
        if of_network != of_law:
            raise ValueError(f"a network of {network.name} on {law.name}")

        covered = content["covered"]
        inputs = len(network.structure.inputs)
        boxes = len(covered["low"])
        low = table_of(covered["low"], "low", boxes, inputs)
        high = table_of(covered["high"], "high", boxes, inputs)
        if not low.size or np.any(low > high):
            raise ValueError("corners of the boxes")
        reach = table_of(covered["reach"], "reach", inputs, positive=True)
        limit = number_of(content["limit"], "limit", positive=True)
        cells = CoveredCells(low, high, reach)
        return ResidualModel(law, BoundedResidual(network, limit, cells))

    return read_model(body, KIND, where, model_of)
