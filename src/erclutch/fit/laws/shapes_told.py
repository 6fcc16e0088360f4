"""The rows tell where to look for the period of a wave over the position.

Its minimum is sharp: a scan of decades does not meet it. A second wave is looked for in what the first leaves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.logs.dataset import Dataset
from erclutch.models.laws import ShapeParameter
from erclutch.models.stages import position_stages
from erclutch.models.structure import Reference, Structure
from erclutch.signals.recording import POSITION

#: Share of the reference slip at which the sign of the slip has turned.
_TURNED = 0.05


def shapes_told(
    data: Dataset,
    structure: Structure,
    reference: Reference,
) -> tuple[ShapeParameter, ...]:
    """The nonlinear parameters of a structure; those of stages on the position with the range that the rows suggest."""
    shapes = structure.shapes(reference.period)
    stages = position_stages(structure.dynamics)
    if not stages:
        return shapes
    # The effort less the best friction, viscosity, stiffness and constant, shape (n,).
    position = data.extras[POSITION] / reference.slip
    columns = [np.ones(data.rows), position, position**2]
    for element in data.elements:
        slip = element.slip / reference.slip
        turned = np.tanh(slip / _TURNED)
        columns += [slip, turned, np.abs(element.field) / reference.field * turned]
    smooth = np.column_stack(columns)
    gains, *_ = np.linalg.lstsq(smooth, data.effort, rcond=None)
    left = data.effort - smooth @ gains

    ranges: dict[str, tuple[float, float]] = {}
    for stage in stages:
        told = stage.usual(position, left)
        if told is None:
            continue
        ranges |= {shape.name: told for shape in stage.parameters(reference.period)}
        if stage is not stages[-1]:  # nobody looks at what the last one leaves
            left = stage.without(position, left, *told)
    narrowed: list[ShapeParameter] = []
    for shape in shapes:
        usual = ranges.get(shape.name, shape.usual)
        narrowed.append(replace(shape, usual=usual))
    return tuple(narrowed)
