"""A network's inputs are made from the rows of a data set: equations (18), (20), past samples, further signals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.arithmetic.dual import rows_before
from erclutch.models.given_rows import further_inputs
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws.smooth import power
from erclutch.models.laws.yield_stress import SQUARE
from erclutch.models.model import FluidSignals
from erclutch.models.networks import NetworkStructure
from erclutch.models.parameter_units import in_user_units
from erclutch.models.stages import slip_stages, stages_at, stages_of
from erclutch.models.stages.stage import SlipAndStrength, Stage
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock
from erclutch.signals.device import WAYS_OF, Element, speeds_of

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
    fields = [field_in_fluid(element.field, structure, clock, dynamics) for element in elements]
    slips = [element.slip for element in elements]

    # Memories run on the exported C's own functions, so that inputs have its bits.
    fluids_as_in_c = [array_as_in_c(field) for field in fields]
    slips_as_in_c = [array_as_in_c(slip) for slip in slips]
    stages = slip_stages(structure.dynamics)
    remembered: list[list[Sequence[Any]]] = []  # of each element, of each stage, its outputs
    for moved in moved_of(structure, fluids_as_in_c, slips_as_in_c, dynamics):
        remembered.append([_respond(stage, moved, clock, dynamics) for stage in stages])

    further = further_inputs(structure.extras, extras)
    signals = FluidSignals(
        fields, slips, remembered, further, lambda x, k: rows_before(x, clock, k)
    )
    return np.array(inputs_from(structure, signals), np.float64)


def inputs_from(structure: NetworkStructure, signals: FluidSignals) -> list[Any]:
    """All inputs in their order, elementwise on any operand."""
    inputs = base_of(structure, signals.fluids, signals.slips)
    extras = [signals.extras[name] for name in structure.extras]
    recalled = recalled_of(structure, inputs, extras)
    for rows in structure.past:
        inputs += [signals.past(x, rows) for x in recalled]
    for of_element in signals.remembered:
        for outputs in of_element:
            inputs += outputs
    return inputs + extras


def _respond(
    stage: Stage,
    signal: Any,
    clock: Clock,
    numbers: Mapping[str, float],
) -> Any:
    """The output of a stage over all rows, its numbers by name."""
    q = [numbers[number.name] for number in stage.parameters(1.0)]
    return stage.respond(signal, clock, q, slice(None))


def field_in_fluid(
    field: Array,
    structure: NetworkStructure,
    clock: Clock,
    numbers: Mapping[str, float],
) -> Array:
    """The field of an element behind the network's stages on the command, shape (n,)."""
    signal: Any = field
    for stage in stages_at(structure.dynamics, "command"):
        signal = _respond(stage, array_as_in_c(signal), clock, numbers)
    return np.asarray(signal, np.float64)


def moved_of(
    structure: NetworkStructure,
    fluids: Sequence[Any],
    slips: Sequence[Any],
    numbers: Mapping[str, float],
) -> list[SlipAndStrength]:
    """What the stages on the slip work on: the slip in its unit, the field over `STRENGTH`'s reference to its power.

    A network without the field as an input has a strength of one.
    """
    if not slip_stages(structure.dynamics):
        return []
    moved: list[SlipAndStrength] = []
    for way, fluid, slip in zip(WAYS_OF[structure.device], fluids, slips, strict=True):
        driven = way * slip
        # One field in all rows, or none: its strength is a constant of the device, which the weights hold.
        strength: Any = 1.0
        if structure.field:
            exponent, reference = (numbers[name] for name in STRENGTH)
            strength = power(np.abs(fluid) / reference, exponent)
        moved.append(SlipAndStrength(driven, strength))
    return moved


def stage_numbers_in_user_units(model: TorqueModel, dynamics: str) -> dict[str, float]:
    """Numbers of a law's stages as a network with some of these stages has them: in s and in the unit of the slip."""
    reference = model.reference
    numbers: dict[str, float] = {}
    for stage in stages_of(dynamics):
        for number in stage.parameters(reference.period):
            normalised = model.shape[number.name]
            numbers[number.name] = in_user_units(normalised, number.dimension, reference)
    if slip_stages(dynamics):
        # The exponent of the law's yield effort, or of its memory; 1.5 where the law has neither.
        exponent = model.shape.get("n", model.shape.get("n_m", 1.5))
        if model.structure.law.yield_form is SQUARE:
            exponent = 2.0
        numbers |= zip(STRENGTH, (exponent, reference.field), strict=True)
    return numbers


def base_of(
    structure: NetworkStructure,
    fields: Sequence[Any],
    slips: Sequence[Any],
) -> list[Any]:
    """A network's inputs of the present row, in the order of `base_inputs`; elementwise on any operand."""
    if structure.device == "single":
        return [fields[0], slips[0]] if structure.field else [slips[0]]
    # Equation (18) has the slips as inputs of an RBFN, equation (20) the speeds as inputs of an FNN.
    speeds = slips if structure.kind == "rbfn" else speeds_of(structure.device, slips)
    if not structure.field:
        return list(speeds)
    field = fields[0] - fields[1]
    return [field, *speeds]


def recalled_of(
    structure: NetworkStructure,
    base: Sequence[Any],
    extras: Sequence[Any],
) -> list[Any]:
    """The present inputs whose past samples are inputs too."""
    return [*base, *extras] if structure.past_extras else list(base)
