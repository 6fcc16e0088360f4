"""A network's inputs are made from the rows of a data set: equations (18), (20), past samples, further signals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws.smooth import power
from erclutch.models.laws.yield_stress import SQUARE
from erclutch.models.model import FluidSignals, further_inputs
from erclutch.models.networks import NetworkStructure
from erclutch.models.parameter_units import in_user_units
from erclutch.models.stages import slip_stages, stages_at, stages_of
from erclutch.models.stages.stage import SlipAndStrength, Stage
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import Element, speeds_of

#: Numbers of the strength of the field in the memory: its exponent, and the field at which it is one.
STRENGTH = ("n_m", "E_m")


def inputs_of(
    structure: NetworkStructure,
    elements: Sequence[Element],
    clock: Clock,
    extras: Mapping[str, Array],
    dynamics: Mapping[str, float],
) -> Array:
    """Inputs in the data's units, shape (inputs, n).

    Args:
        structure: which inputs.
        elements: field and slip of each element.
        clock: time and spans.
        extras: further logged inputs by name.
        dynamics: numbers of the stages by name; empty for none.

    Raises:
        MappingError: a further input is not there.
    """
    fields = [field_in_fluid(e.field, structure, clock, dynamics) for e in elements]
    slips = [e.slip for e in elements]
    moved = moved_of(structure, [array_as_in_c(f) for f in fields], [array_as_in_c(w) for w in slips], dynamics)
    remembered = [[_respond(stage, m, clock, dynamics) for stage in slip_stages(structure.dynamics)] for m in moved]
    further = further_inputs(structure.extras, extras)
    signals = FluidSignals(fields, slips, remembered, further, lambda x, k: rows_before(x, clock, k))
    return np.array(inputs_from(structure, signals), np.float64)


def inputs_from(structure: NetworkStructure, signals: FluidSignals) -> list[Any]:
    """All inputs in their order, elementwise on any operand."""
    base = base_of(structure, signals.fluids, signals.slips)
    extras = [signals.extras[name] for name in structure.extras]
    memory = (x for element in signals.remembered for outputs in element for x in outputs)
    recalled = recalled_of(structure, base, extras)
    return [*base, *(signals.past(x, k) for k in structure.past for x in recalled), *memory, *extras]


def _respond(stage: Stage, signal: Any, clock: Clock, numbers: Mapping[str, float]) -> Any:
    return stage.respond(signal, clock, [numbers[p.name] for p in stage.parameters(1.0)], slice(None))


def field_in_fluid(field: Array, structure: NetworkStructure, clock: Clock, numbers: Mapping[str, float]) -> Array:
    """The field of an element behind the network's stages on the command, shape (n,)."""
    signal: Any = field
    for stage in stages_at(structure.dynamics, "command"):
        signal = _respond(stage, array_as_in_c(signal), clock, numbers)
    return np.asarray(signal, np.float64)


def moved_of(
    structure: NetworkStructure, fluids: Sequence[Any], slips: Sequence[Any], numbers: Mapping[str, float]
) -> list[SlipAndStrength]:
    """What the stages on the slip work on: the slip in its unit, the field over `STRENGTH`'s reference to its power.

    A network without the field as an input has a strength of one.
    """
    if not slip_stages(structure.dynamics):
        return []
    ways = (1.0,) if structure.device == "single" else (1.0, -1.0)
    if not structure.field:
        # One field in all rows, or none: its strength is a constant of the device, which the weights hold.
        return [SlipAndStrength(way * slip, 1.0) for way, slip in zip(ways, slips, strict=True)]
    exponent, reference = (numbers[name] for name in STRENGTH)
    return [
        SlipAndStrength(way * slip, power(np.abs(fluid) / reference, exponent))
        for way, fluid, slip in zip(ways, fluids, slips, strict=True)
    ]


def stage_numbers_in_user_units(model: TorqueModel, dynamics: str) -> dict[str, float]:
    """Numbers of a law's stages as a network with some of these stages has them: in s and in the unit of the slip."""
    structure, reference = model.structure, model.reference
    numbers = {
        p.name: in_user_units(model.shape[p.name], p.dimension, reference)
        for stage in stages_of(dynamics)
        for p in stage.parameters(reference.period)
    }
    if not slip_stages(dynamics):
        return numbers
    form = structure.law.yield_form
    exponent = 2.0 if form is SQUARE else model.shape.get("n", model.shape.get("n_m", 1.5))
    return {**numbers, **dict(zip(STRENGTH, (exponent, reference.field), strict=True))}


def base_of(structure: NetworkStructure, fields: Sequence[Any], slips: Sequence[Any]) -> list[Any]:
    """A network's inputs of the present row, in the order of `base_inputs`; elementwise on any operand."""
    if structure.device == "single":
        return [fields[0], slips[0]] if structure.field else [slips[0]]
    speeds = slips if structure.kind == "rbfn" else speeds_of(structure.device, slips)
    return [fields[0] - fields[1], *speeds] if structure.field else [*speeds]


def recalled_of(structure: NetworkStructure, base: Sequence[Any], extras: Sequence[Any]) -> list[Any]:
    """The present inputs whose past samples are inputs too."""
    return [*base, *(extras if structure.past_extras else ())]


def rows_before(x: Array, clock: Clock, rows: int) -> Array:
    """The signal some rows earlier; at a stretch's start its first value."""
    out = x.copy()
    for span in clock.spans:
        part = x[span.start : span.stop]
        k = min(rows, part.size)
        out[span.start : span.start + k] = part[0]
        out[span.start + k : span.stop] = part[: part.size - k]
    return out
