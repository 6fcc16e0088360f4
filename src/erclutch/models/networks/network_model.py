"""A NetworkModel has a device, inputs, their normalisation and tables of weights. It predicts effort."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.models import model_file, plugin_efforts
from erclutch.models.band import Band
from erclutch.models.given_rows import further_inputs
from erclutch.models.law_model import TorqueModel
from erclutch.models.model import FluidSignals, GivesWay, Pair, Range, settled_memory
from erclutch.models.near_cells import Nearness, faded
from erclutch.models.networks import NetworkStructure
from erclutch.models.networks.forward import forward_fnn, forward_rbfn, gaussians, last_hidden
from erclutch.models.networks.network_inputs import field_in_fluid, inputs_from, inputs_of, moved_of
from erclutch.models.shared_answers import ModelBase
from erclutch.models.stages import outside_stages, slip_stages, stage_equations, stages_at
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.registry import Plugin
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import WAYS_OF, Element, Units

KIND = "erclutch network model"
_GIVES_WAY = (
    "Where no training row was near, the effort is that of a law, and a share of both in between:"
)
_BLOCK = 131_072  # activations of a layer at a time: they stay in the cache


@dataclass(frozen=True)
class Scaling:
    """Affine normalisation: (x - offset) / scale for inputs, y * scale + offset for the output.

    Attributes:
        offset, scale: of each input, shape (inputs,).
        effort_offset, effort_scale: of the output.
    """

    offset: Array
    scale: Array
    effort_offset: float
    effort_scale: float

    def inputs(self, x: Array) -> Array:
        """Normalised inputs, shape (inputs, n)."""
        return (x - self.offset[:, None]) / self.scale[:, None]


@dataclass(frozen=True, repr=False)
class NetworkModel(ModelBase):
    """Effort of a device from its inputs.

    Attributes:
        structure: which network, which inputs.
        scaling: normalisation of inputs and output.
        weights: tables by name. fnn: W1 (h1, inputs), b1 (h1,), ..., W_out (1, h), b_out (1,). rbfn: centres
            (n, inputs), spreads (n,), w (n,), b (1,); all in normalised units.
        dynamics: numbers of the stages by name, in s and in the unit of the slip, and those of
            `network_inputs.STRENGTH`; empty for none.
        units: units of the device's signals.
        trained_on: range of the training data.
        input_range: smallest and largest training value of each input, shape (inputs, 2).
        period: sampling period of the training data in s: how far back past rows lie. None: not known.
        band: how far the measured effort may lie from the estimate.
        beyond: law whose effort takes the place of the network's where no training row was near, see
            `models.near_cells`; None: nothing bounds the network there, as in files of older versions.
        near: cells near training rows as in `Range`, by the field in the fluid; empty: by the field itself.
    """

    structure: NetworkStructure
    scaling: Scaling
    weights: Mapping[str, Array]
    dynamics: Mapping[str, float]
    units: Units
    trained_on: Range
    input_range: Array
    about: Mapping[str, str] = field(default_factory=dict[str, str])
    period: float | None = None
    band: Band | None = None
    beyond: TorqueModel | None = None
    near: tuple[tuple[int, ...], ...] = ()
    #: Nothing is added to a network's effort.
    correction: None = field(
        default=None,
        init=False,
        repr=False,
        compare=False,
    )

    @property
    def network_part(self) -> NetworkModel:
        """The model itself."""
        return self

    @property
    def title(self) -> str:
        """Name for people."""
        return self.structure.title

    @property
    def times(self) -> Mapping[str, float]:
        """Parameters of the stages by name."""
        return self.dynamics

    @property
    def extras(self) -> Mapping[str, Pair]:
        """Further inputs, and the range of each."""
        names = self.structure.extras
        first = len(self.input_range) - len(names)  # they are the last of all inputs
        extras: dict[str, Pair] = {}
        for name, (low, high) in zip(names, self.input_range[first:].tolist(), strict=True):
            extras[name] = (low, high)
        return extras

    @property
    def past(self) -> tuple[int, ...]:
        """Rows back whose signals are inputs too."""
        return self.structure.past

    @property
    def signed(self) -> bool:
        """A network sees the sign of the field."""
        return True

    @property
    def numbers(self) -> Mapping[str, Any]:
        """Weights, time constants and what normalises the inputs, by name."""
        numbers: dict[str, Any] = {**self.weights, **self.dynamics}
        numbers["offset"] = self.scaling.offset
        numbers["scale"] = self.scaling.scale
        numbers["effort_offset"] = self.scaling.effort_offset
        if self.beyond is not None:
            for name, value in self.beyond.numbers.items():
                numbers[f"beyond {name}"] = value
        numbers["effort_scale"] = self.scaling.effort_scale
        numbers["input range"] = self.input_range
        return numbers

    @property
    def parameters(self) -> int:
        """Number of weights."""
        return int(sum(table.size for table in self.weights.values()))

    @property
    def gives_way(self) -> GivesWay | None:
        """The network, where it has a law beyond its rows."""
        return None if self.beyond is None else self

    @property
    def unbounded(self) -> str:
        """What to know of a network alone that has no law beyond its rows; else empty."""
        if self.beyond is not None:
            return ""
        return (
            f"{self.name} has no law beyond its rows, as files of older versions: nothing bounds its effort, nor its "
            "band, where no training row was near. Fit the log again"
        )

    @property
    def nearness(self) -> Nearness:
        """Where training rows were, by field in the fluid, slip and further inputs."""
        return self._nearness

    @cached_property
    def _nearness(self) -> Nearness:
        covered = replace(self.trained_on, near=self.near or self.trained_on.near)
        count = len(WAYS_OF[self.structure.device])
        elements = [covered.near_cells(element) for element in range(count)]
        return Nearness(elements, list(self.extras.values()))

    def effort(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array] | None = None,
        *,
        exactly: bool = True,
    ) -> Array:
        """See `ModelBase.effort`; a lone row where the law has a share takes the long road."""
        if clock.time.size == 1 and self.beyond is not None:
            further = further_inputs(self.structure.extras, extras or {}).values()
            fields = [element.field.item() for element in elements]
            slips = [element.slip.item() for element in elements]
            if not self.nearness.amid(fields, slips, [value.item() for value in further]):
                return self.effort_of_rows(elements, clock, extras or {}, exactly=exactly)
        return super().effort(elements, clock, extras, exactly=exactly)

    def effort_of_rows(
        self,
        elements: Sequence[Element],
        clock: Clock,
        extras: Mapping[str, Array],
        *,
        exactly: bool,
    ) -> Array:
        """Effort on the long road, shape (n,); see `ModelBase.effort`."""
        structure = self.structure
        inputs = inputs_of(structure, elements, clock, extras, self.dynamics)
        effort = self.of_inputs(inputs, exactly=exactly)
        if self.beyond is not None:
            fluids = [
                field_in_fluid(element.field, structure, clock, self.dynamics)
                for element in elements
            ]
            slips = [element.slip for element in elements]
            further = list(further_inputs(structure.extras, extras).values())
            effort = self._faded(effort, (fluids, slips, further), exactly=exactly)
        for stage in stages_at(structure.dynamics, "effort"):
            q = [self.dynamics[number.name] for number in stage.parameters(1.0)]
            behind = stage.respond(array_as_in_c(effort), clock, q, slice(None))
            effort = np.asarray(behind)
        return effort

    def _faded(
        self,
        effort: Array,
        given: Sequence[Sequence[Array]],
        *,
        exactly: bool,
    ) -> Array:
        """The network's effort, and the law's where no training row was, shape (n,).

        Args:
            effort: of the network.
            given: fields in the fluid, slips and further inputs.
            exactly: with the bits of the exported C.
        """
        amid = np.asarray(self.nearness.amid(*given))
        away = np.flatnonzero(~amid)
        if not away.size:
            return effort
        operands = array_as_in_c if exactly else np.asarray
        rows: list[list[Any]] = []
        for group in given:
            rows.append([operands(signal[away]) for signal in group])
        share = np.asarray(self.nearness.share(*rows))
        law = np.asarray(self.law_beyond(*rows))
        mixed = effort.copy()
        # Where the share is zero the network is not asked: its effort may be anything there.
        fading = faded(effort[away], law, share)
        mixed[away] = np.where(share > 0.0, fading, law)
        return mixed

    def law_beyond(
        self,
        fluids: Sequence[Any],
        slips: Sequence[Any],
        extras: Sequence[Any],
    ) -> Any:
        """Effort of the law that takes the network's place where no training row was, elementwise on any operand.

        Args:
            fluids: field in the fluid of each element.
            slips: slip of each element.
            extras: further inputs of the network.
        """
        law = self.beyond
        assert law is not None
        commands = [law.command(fluid) for fluid in fluids]
        remembered = settled_memory(law, law.moved(commands, slips))
        further = dict(zip(self.structure.extras, extras, strict=True))
        return law.from_fluid(FluidSignals(commands, slips, remembered, further))

    def of_inputs(self, inputs: Array, *, exactly: bool = True) -> Array:
        """Effort from all inputs as they are (inputs, n), shape (n,)."""
        rows = _BLOCK // max(self.structure.hidden)
        parts: list[Array] = []
        for at in range(0, inputs.shape[1], rows):
            block = inputs[:, at : at + rows]
            if exactly:
                parts.append(self.as_exported(block))
            else:
                parts.append(self.forward(self.scaling.inputs(block)))
        return np.concatenate(parts) if parts else np.zeros(0)

    @cached_property
    def folded(self) -> NetworkModel:
        """The same network as C and `predict` compute it: its scales, but for an RBFN's inputs, lie in its weights."""
        scaling = self.scaling
        scale = scaling.scale
        weights = dict(self.weights)
        last, bias = "w", "b"
        if self.structure.kind == "fnn":
            last, bias = "W_out", "b_out"
            weights["W1"] = weights["W1"] / scale
            scale = np.ones_like(scale)
        weights[last] = weights[last] * scaling.effort_scale
        weights[bias] = weights[bias] * scaling.effort_scale + scaling.effort_offset
        folded = Scaling(scaling.offset, scale, effort_offset=0.0, effort_scale=1.0)
        return replace(self, scaling=folded, weights=weights)

    def forward(self, x: Array) -> Array:
        """Effort from normalised inputs (inputs, n), shape (n,), through BLAS and NumPy's own functions."""
        forward = forward_fnn if self.structure.kind == "fnn" else forward_rbfn
        y = forward(self.weights, x, exactly=False)
        return y * self.scaling.effort_scale + self.scaling.effort_offset

    def last_layer(self, x: Array) -> Array:
        """What the neurons of the last layer say to normalised inputs (inputs, n), shape (neurons, n), for fits."""
        if self.structure.kind == "rbfn":
            return gaussians(self.weights["centres"], self.weights["spreads"], x)
        return last_hidden(self.weights, x, exactly=False)

    def as_exported(self, inputs: NDArray[Any]) -> NDArray[Any]:
        """Effort from all inputs as they are (inputs, n), shape (n,), with the bits of the C in their precision."""
        folded = self.folded
        offset = folded.scaling.offset.astype(inputs.dtype)[:, None]
        moved = inputs - offset
        if self.structure.kind == "fnn":
            return forward_fnn(folded.weights, moved)
        scale = folded.scaling.scale.astype(inputs.dtype)[:, None]
        return forward_rbfn(folded.weights, moved / scale)

    def steady(
        self,
        fields: Sequence[Array],
        slips: Sequence[Array],
        extras: Sequence[Array] = (),
    ) -> Array:
        """Effort at rest, shape (n,): the fluid settled, all past rows as the present one."""
        # Memories settle on the exported C's own functions.
        fields_as_in_c = [array_as_in_c(field) for field in fields]
        slips_as_in_c = [array_as_in_c(slip) for slip in slips]
        remembered = settled_memory(self, self.moved(fields_as_in_c, slips_as_in_c))
        further = dict(zip(self.structure.extras, extras, strict=True))
        inputs = inputs_from(self.structure, FluidSignals(fields, slips, remembered, further))
        rows = np.array(np.broadcast_arrays(*inputs), np.float64)
        effort = self.of_inputs(rows)
        if self.beyond is None:
            return effort
        given: list[list[Array]] = []
        for group in (fields, slips, extras):
            given.append([np.broadcast_to(signal, effort.shape) for signal in group])
        return self._faded(effort, given, exactly=True)

    def scaled(self, factor: float, offset: float = 0.0) -> NetworkModel:
        """The same network with its effort times a factor, and a constant effort ``offset`` more, in the effort's unit.

        The law beyond the rows is multiplied too; a constant effort would be new to its structure, so it gets none.
        """
        beyond = self.beyond
        if beyond is not None:
            gains = {name: factor * gain for name, gain in beyond.gains.items()}
            beyond = replace(beyond, gains=gains)
        scaling = replace(
            self.scaling,
            effort_offset=factor * self.scaling.effort_offset + offset,
            effort_scale=factor * self.scaling.effort_scale,
        )
        return replace(self, beyond=beyond, scaling=scaling)

    def command(self, field: Any) -> Any:
        """What the stages work on: the field itself."""
        return field

    def moved(self, fluids: Iterable[Any], slips: Iterable[Any]) -> list[SlipAndStrength]:
        """What the stages on the slip of each element work on, elementwise on any operand."""
        return moved_of(self.structure, list(fluids), list(slips), self.dynamics)

    def from_fluid(self, signals: FluidSignals) -> Any:
        """Effort of operands that record: all of the network is one operation of the record."""
        inputs = inputs_from(self.structure, signals)
        return inputs[0].record("network", *inputs)

    def equation(self) -> list[str]:
        """The equation and its inputs, as lines of a comment."""
        structure = self.structure
        scaling = self.scaling
        sign = "-" if scaling.effort_offset < 0 else "+"
        effort = f"effort = y {scaling.effort_scale:.9g} {sign} {abs(scaling.effort_offset):.9g}"
        if structure.kind == "rbfn":
            formula = "y = b + sum_i w_i exp(-|x - c_i|^2 / (2 s_i^2))"
        else:
            layers: list[str] = []
            before = "x"
            for layer in range(1, len(structure.hidden) + 1):
                layers.append(f"a{layer} = tanh(W{layer} {before} + b{layer})")
                before = f"a{layer}"
            formula = f"{', '.join(layers)}, y = W_out {before} + b_out"
        lines = [f"{self.title}, x = (input - offset) / scale of each input, {effort}.", ""]
        lines += [
            f"  {formula}",
            "",
            f"Inputs: {', '.join(structure.inputs)}.",
            *stage_equations(structure.dynamics),
        ]
        if self.beyond is not None:
            lines += ["", _GIVES_WAY, "", *self.beyond.equation()]
        return lines

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """What the model needs of other packages; its file names them."""
        law = () if self.beyond is None else self.beyond.plugins
        return tuple(dict.fromkeys((*law, *outside_stages(self.structure.dynamics))))

    def to_dict(self) -> dict[str, Any]:
        """As plain JSON values, with a schema version and a digest over all of them."""
        s = self.structure
        body: dict[str, Any] = {
            "kind": KIND,
            "schema": model_file.SCHEMA,
            "device": s.device,
            "network": s.specification,
            "inputs": list(s.inputs),
            "past": list(s.past),
            "extras": list(s.extras),
            "dynamics": {"form": s.dynamics, **dict(self.dynamics)},
            "units": {
                "effort": self.units.effort,
                "field": self.units.field,
                "slip": self.units.slip,
            },
            "scaling": {
                "offset": self.scaling.offset.tolist(),
                "scale": self.scaling.scale.tolist(),
                "effort_offset": self.scaling.effort_offset,
                "effort_scale": self.scaling.effort_scale,
            },
            "weights": {name: table.tolist() for name, table in self.weights.items()},
            "input_range": self.input_range.tolist(),
            "trained_on": self.trained_on.to_dict(),
            "about": dict(self.about),
        }
        if self.period is not None:
            body["period_s"] = self.period
        if self.beyond is not None:
            body["beyond"] = self.beyond.to_dict()
        if self.near:
            body["near"] = [list(masks) for masks in self.near]
        if self.plugins:
            body["plugins"] = [plugin.to_dict() for plugin in self.plugins]
            # Beside a law the network has no strength of the field, and the law's efforts are kept.
            if "n_m" in self.dynamics or not slip_stages(s.dynamics):
                body[plugin_efforts.ENTRY] = plugin_efforts.efforts_of(self)
        return model_file.sealed(body, self.band)
