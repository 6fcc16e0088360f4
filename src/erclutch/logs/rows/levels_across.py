"""A bench sheet may have a column for each level that was set: ``Torque @ 0.5 A``, ``Torque @ 100 rpm``, ``4 clicks``.

Each level gets rows of its own. Force over speed of a damper is written so at some currents or clicks of its valve, and
the torque of a brake over its current at some speeds. Each level may have a time of its own: ``t (1 A), F (1 A)``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from erclutch.errors import listed
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.levels_in_names import (
    CALLED_BY_LEVEL,
    StatedLevel,
    open_field_in,
    setting_in,
    speed_in,
    stated_in,
    with_lost_points,
    without_field,
    without_setting,
    without_speed,
)
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.columns.senses import says_a_sense
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_A_FIELD_ALONE = frozenset({"field"})
_A_SLIP_ALONE = frozenset({"slip"})
_MOTIONS = frozenset({"slip", "position"})
#: What `erclutch flowcurve` takes as it stands.
_OF_A_RHEOMETER = ("rate", "stress", "viscosity")
_AT_ITS_END = re.compile(
    r"[\s@,;:_(\[=-]+(?:(?:at|for|bei|a|@)|[^\W\d_]{1,10}\s*=)?[\s@)\]_-]*$", re.IGNORECASE
)
_COUNTED_LEVEL = "level"
_COUNTED = re.compile(r"[1-9]\d?[AVT]")  # the first specimen of batch A, or 1 A


class _Across(NamedTuple):
    """A quantity whose levels stand in names of columns.

    Attributes:
        signal: what it is; "" where the level says what it is called.
        stated_in: the level that a name holds.
        without: a name without it.
        fits: whether a sheet with these columns beside those of the levels may be one: quantities, and shared columns.
    """

    signal: str
    stated_in: Callable[[str], StatedLevel | None]
    without: Callable[[str], str]
    fits: Callable[[Table, Sequence[str], Sequence[str]], bool]


#: The columns of each quantity, by its name without a level, and by the level.
_Sheet = Mapping[str, Mapping[StatedLevel, str]]


def with_rows_for_each_level(table: Table) -> Table:
    """The table with rows for each level that the names of its columns tell, one after another; else as it is.

    Several efforts in one time stay columns: each of them is a log, and the user is asked.
    """
    return _with_rows(table, own_times=False)


def with_rows_for_each_timed_level(table: Table) -> Table:
    """The same where each level has a time of its own: such times are of no channels."""
    return _with_rows(table, own_times=True)


def _with_rows(table: Table, *, own_times: bool) -> Table:
    if table.clock is not None or table.words:
        return table
    numbers = with_lost_points(table.columns)
    for across in _ACROSS:
        sheet: dict[str, dict[StatedLevel, str]] = {}
        shared: list[str] = []
        called: set[str] = set()
        for name in table.columns:
            level = across.stated_in(name)
            if level is None:
                shared.append(name)
                continue
            if name in numbers:
                level = level._replace(number=numbers[name])
            called.add(across.signal or level.name)
            by_level = sheet.setdefault(across.without(name), {})
            by_level[level._replace(name="")] = name
        quantities = [_quantity(bare, across.signal)[0] for bare in sheet]
        has_own_times = any(spoken_name(name).is_time for name in quantities)
        if own_times and (shared or not has_own_times):
            continue
        is_a_sheet = len(called) == 1 and _is_a_sheet(table, sheet, quantities, shared)
        if is_a_sheet and across.fits(table, quantities, shared):
            return _stacked(table, called.pop(), sheet, shared)
    return table


def _stacked(table: Table, signal: str, sheet: _Sheet, shared: Sequence[str]) -> Table:
    """The rows of all levels, one level after another, with a column for the level."""
    levels, *_ = (list(by_level) for by_level in sheet.values())
    columns: dict[str, list[Array]] = {}
    rows_of_levels: list[int] = []
    units = {name: table.units.get(name) for name in shared}
    for level in levels:
        of_level = {name: table.columns[name] for name in shared}
        filled = np.zeros(table.rows, np.bool_)
        for bare, by_level in sheet.items():
            values = table.columns[by_level[level]]
            filled |= np.isfinite(values)
            quantity, unit = _quantity(bare, signal)
            of_level[quantity] = values
            units[quantity] = table.units.get(by_level[level]) or unit
        of_level[signal] = np.full(table.rows, level.number)
        rows_of_levels.append(int(np.count_nonzero(filled)))
        for name, values in of_level.items():
            columns.setdefault(name, []).append(values[filled])
    units[signal] = levels[0].unit
    of_levels: list[str] = []
    for level in levels:
        number = f"{level.number:g} {level.unit or ''}".strip()
        of_levels.append(f"{level.word} ({number})" if level.word else number)
    said = listed(of_levels)
    note = f"the names of the columns tell the {signal}: the rows at {said} stand one after another"
    return replace(
        table,
        columns={name: np.concatenate(parts) for name, parts in columns.items()},
        units=units,
        numbers={},
        row_names=(),
        breaks=(),
        sweeps=np.repeat(np.arange(len(levels)), rows_of_levels),
        notes=(*table.notes, note),
    )


def _is_a_sheet(
    table: Table, sheet: _Sheet, quantities: Sequence[str], shared: Sequence[str]
) -> bool:
    """Whether each quantity has a column at each of the same levels, in one unit, and none is of a rheometer."""
    if not sheet or any(map(open_field_in, shared)):
        return False
    levels = [set(by_level) for by_level in sheet.values()]
    are_alike = all(own == levels[0] for own in levels)
    if len(levels[0]) < 2 or not are_alike or len({level.unit for level in levels[0]}) > 1:
        return False
    if len({level.number for level in levels[0]}) < len(levels[0]):
        return False  # two words for one place
    if len({*quantities, *shared}) < len(quantities) + len(shared):
        return False
    for by_level in sheet.values():
        if len({table.units.get(name) for name in by_level.values()}) > 1:
            return False
    return not any(said_by_name(name) in _OF_A_RHEOMETER for name in (*shared, *quantities))


def _fits_fields(table: Table, quantities: Sequence[str], shared: Sequence[str]) -> bool:
    """Whether something moves, nothing else may be a field, and one effort alone is in no time."""
    every = (*shared, *quantities)
    names = [name for name in table.columns if name not in shared]
    if all(_COUNTED.search(name) for name in names):
        return False
    moves = any(spoken_name(name).may_be & _MOTIONS for name in every)
    has_a_field = any(spoken_name(name).may_be == _A_FIELD_ALONE for name in every)
    return moves and not has_a_field and not (_has_time(table, shared) and len(quantities) < 2)


def _fits_speeds(table: Table, quantities: Sequence[str], shared: Sequence[str]) -> bool:
    """Whether one effort stands beside a field, or alone, and nothing else moves."""
    has_a_motion = any(spoken_name(name).may_be & _MOTIONS for name in shared)
    if has_a_motion or len(quantities) > 1 or _has_time(table, shared):
        return False
    may_be = spoken_name(quantities[0]).may_be
    is_beside_a_field = any(spoken_name(name).may_be == _A_FIELD_ALONE for name in shared)
    return "effort" in may_be or (quantities[0] == CALLED_BY_LEVEL and is_beside_a_field)


def _fits_settings(table: Table, quantities: Sequence[str], shared: Sequence[str]) -> bool:
    """Whether a quantity is an effort, has no name or is called by its sense, where a sheet of fields would fit."""
    may_be_efforts = [
        name == CALLED_BY_LEVEL or says_a_sense(name) or "effort" in spoken_name(name).may_be
        for name in quantities
    ]
    return any(may_be_efforts) and _fits_fields(table, quantities, shared)


def _counted_in(name: str) -> StatedLevel | None:
    """A level such as 1A, which may be a current, or the first specimen of a batch; None for no such."""
    level = stated_in(name) if _COUNTED.search(name) else None
    return None if level is None else level._replace(name=_COUNTED_LEVEL, unit=None)


def _fits_counted(table: Table, quantities: Sequence[str], shared: Sequence[str]) -> bool:
    """Whether each level has a motion and an effort of its own: who asks about the level hears which it is."""
    may_be = [spoken_name(name).may_be | spoken_name(name).within for name in quantities]
    have_both = any(each & _MOTIONS for each in may_be) and any("effort" in each for each in may_be)
    return have_both and not any(each == _A_FIELD_ALONE for each in may_be)


_ACROSS = (
    _Across("field", stated_in, without_field, _fits_fields),
    _Across("", _counted_in, without_field, _fits_counted),
    _Across("", setting_in, without_setting, _fits_settings),
    _Across("slip", speed_in, without_speed, _fits_speeds),
)


def _has_time(table: Table, shared: Sequence[str]) -> bool:
    return table.sample_period is not None or any(spoken_name(name).is_time for name in shared)


def _quantity(bare: str, signal: str) -> tuple[str, str | None]:
    """Name and unit of a quantity, of its name without the level: ``Torque (Nm) at`` is a torque in N m.

    A name that was the level alone says nothing, as I of ``I=0.5A``, or n of ``n 100 rpm``.
    """
    stem = _AT_ITS_END.sub("", bare).strip(" _-@:")
    stem = re.sub("_{2,}", "_", stem)  # torque_0.5A_Nm
    name, unit = split_label(stem)
    level_alone = _A_SLIP_ALONE if signal == "slip" else _A_FIELD_ALONE
    is_the_level = bool(name) and spoken_name(name).may_be == level_alone
    return (CALLED_BY_LEVEL, None) if is_the_level or not name else (name, unit)
