"""A sheet may have an effort for each of two opposite senses beside a speed: each sense gets rows of its own.

So are force over speed of a shock absorber in compression and in rebound, and torque over speed, clockwise and back.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from erclutch.errors import UnitError
from erclutch.logs.columns.names import spoken_name, words_of
from erclutch.logs.columns.senses import opposite_signs, says_a_sense, without_sense
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.table import Table
from erclutch.signals import units

#: What an effort is called whose name was its sense alone, by its unit.
_CALLED = (("N", "force"), ("N*m", "torque"))
#: Words that tell one device from another rather than a sense.
_SIDES = frozenset("left right links rechts gauche droite izquierda derecha".split())


def with_a_row_for_each_sense(table: Table) -> Table:
    """The table with rows for each sense of an effort, the speed and the effort with their signs; else as it is.

    The device is passive: in either sense the effort has the sign of the speed.
    """
    has_time = table.clock is not None or table.sample_period is not None
    if has_time or table.words or any(spoken_name(name).is_time for name in table.columns):
        return table  # at one time a device moves in one sense
    speeds = [name for name in table.columns if "slip" in spoken_name(name).may_be]
    if len(speeds) != 1 or takes_both_signs(table.columns[speeds[0]]):
        return table
    # Pairs of columns for the positive and the negative sense, and what both are called.
    pairs: list[tuple[str, str, str]] = []
    others = [name for name in table.columns if name != speeds[0] and says_a_sense(name)]
    for first, second in combinations(others, 2):
        signs = opposite_signs((first, second))
        if signs is None or not _SIDES.isdisjoint(words_of(first)):
            continue
        if without_sense(first) != without_sense(second):
            continue
        unit = table.units.get(first)
        either_way = any(takes_both_signs(table.columns[name]) for name in (first, second))
        name = without_sense(first) or _called(unit)
        may_be_an_effort = "effort" in spoken_name(name).may_be
        if unit == table.units.get(second) and not either_way and may_be_an_effort:
            forth, back = (first, second) if signs[0] > 0.0 else (second, first)
            pairs.append((forth, back, name))
    if len(pairs) != 1:
        return table

    ((forth, back, name),) = pairs
    shared = [each for each in table.columns if each not in (forth, back)]
    filled_forth = np.isfinite(table.columns[forth])
    filled_back = np.isfinite(table.columns[back])
    columns = {
        each: np.concatenate([table.columns[each][filled_forth], table.columns[each][filled_back]])
        for each in shared
    }
    sweeps = np.zeros(table.rows, np.intp) if table.sweeps is None else table.sweeps
    sweeps_back = sweeps + int(sweeps.max()) + 1
    sign = np.repeat([1.0, -1.0], [np.count_nonzero(filled_forth), np.count_nonzero(filled_back)])
    efforts = [table.columns[forth][filled_forth], table.columns[back][filled_back]]
    columns[speeds[0]] = sign * np.abs(columns[speeds[0]])
    columns[name] = sign * np.abs(np.concatenate(efforts))
    note = (
        f"columns {forth} and {back} are two senses of one motion: speed and effort are positive in {forth} and "
        f"negative in {back}"
    )
    return replace(
        table,
        columns=columns,
        units={**{each: table.units.get(each) for each in shared}, name: table.units.get(forth)},
        numbers={},
        row_names=(),
        breaks=(),
        sweeps=np.concatenate([sweeps[filled_forth], sweeps_back[filled_back]]),
        notes=(*table.notes, note),
    )


def _called(unit: str | None) -> str:
    """What an effort of a unit is called; "" for other units."""
    for si, name in _CALLED:
        try:
            if unit and units.fits(unit, (si,)) is not None:
                return name
        except UnitError:
            continue
    return ""
