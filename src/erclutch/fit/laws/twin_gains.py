"""Two gains of a stage are one where no field changes the yield effort: without the field, and with it."""

from __future__ import annotations

from erclutch.models.laws.yield_stress import CONSTANT
from erclutch.models.stages import slip_stages
from erclutch.models.structure import Structure


def twin_gains(structure: Structure) -> frozenset[str]:
    """Names of gains whose column is that of another gain: such a gain stays at zero, or no fit could tell the two."""
    if structure.law.yield_form is not CONSTANT:
        return frozenset()
    names: set[str] = set()
    for stage in slip_stages(structure.dynamics):
        marks = [float(place) for place, _ in enumerate(stage.outputs, start=1)]
        columns = stage.columns(marks, 1.0)
        for place, gain in enumerate(stage.gains):
            if columns[place] in columns[:place]:
                names.update(structure.names_of(gain.name))
    return frozenset(names)
