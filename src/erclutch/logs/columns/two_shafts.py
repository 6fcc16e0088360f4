"""The slip of a clutch between two shafts is the difference of their speeds, and stands in no column of the file.

So is the stroke of a damper whose both ends move, such as that of a suspension. A gear has two shafts too, and what
these differ by is no slip: where neither a word nor the signs of the effort tell, the user is asked. ``A - B`` in place
of a column names any difference.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from itertools import product

import numpy as np

from erclutch.errors import MappingError
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.names import plain, spoken_name, words_of
from erclutch.logs.columns.seen_columns import SeenColumns, unit_fits
from erclutch.logs.columns.shapes import FEW, takes_both_signs
from erclutch.logs.columns.suspensions import ends_of_a_suspension
from erclutch.logs.columns.two_courses import go_straight
from erclutch.logs.columns.vocabulary import NAMES, NEED_UNIT
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.table import MINUS, Table
from erclutch.signals.array import Array

#: Words of the shaft that drives a clutch, and of the shaft that is driven.
_SHAFTS = (
    frozenset(
        (
            "in input drive driving driver primary motor inner inside upper disc disk antrieb an "
            "eingang entree entrada"
        ).split()
    ),
    frozenset(
        (
            *("out", "output", "driven", "load", "secondary", "outer", "outside", "lower", "ball"),
            *("abtrieb", "ab", "ausgang", "sortie", "salida"),
        )
    ),
)
_EASTERN_SHAFTS = (("输入", "输出"), ("主动", "从动"), ("入力", "出力"), ("駆動", "従動"))
_CLUTCH = (
    *("clutch", "kupplung", "embrayage", "embrague", "embreagem", "frizione"),
    *("离合器", "離合器", "クラッチ", "муфт"),
)
_UNITS_OF_MOTION = {"slip": ("rad/s", "m/s"), "position": ("rad", "m")}
_FRICTION = 0.1  # of the largest effort, which bearings between two sensors take away at most
_APART = 0.01  # of the largest speed, by which the shafts of a clutch differ at least
_USUAL = (0.01, 0.99)  # quantiles
#: Part of the largest share by which shares that are written with some digits are off.
_IN_PERCENT = 0.02
_TRANSMITS = 0.95  # share of the rows in which the effort keeps to the sign of the slip
_LARGE = 0.05  # of the largest slip and effort, from which on their signs tell


def with_differences(table: Table, told: ColumnMap) -> tuple[Table, ColumnMap]:
    """The table with each difference of columns that the user named, and that of two shafts by their names.

    Returns:
        The table, and what the user said with the names that these columns have in it.
    """
    made: dict[str, tuple[str, str]] = {}
    columns = dict(told.columns)
    for signal, choice in told.columns.items():
        label = str(choice.column)
        parts = (
            None if label in table.columns else _named_difference(table, label.removeprefix("-"))
        )
        if parts is None:
            continue
        minuend, subtrahend, unit = parts
        name = f"{minuend}{MINUS}{subtrahend}"
        made[name] = minuend, subtrahend
        sign = "-" if label.startswith("-") else ""
        columns[signal] = replace(choice, column=f"{sign}{name}", unit=choice.unit or unit)
    if told.columns.keys().isdisjoint(_UNITS_OF_MOTION):
        for signal in _UNITS_OF_MOTION:
            ends = _ends_of_clutch(table, signal)
            if ends is None:
                continue
            driving, driven = ends
            speed = _speed_of(table.columns[driving], signal)
            driven_speed = _speed_of(table.columns[driven], signal)
            if not _turn_as_one(speed, driven_speed):
                made[MINUS.join(ends)] = ends
    if not made:
        return table, told

    differences: dict[str, Array] = {}
    units_of: dict[str, str | None] = {}
    for name, (minuend, subtrahend) in made.items():
        differences[name] = table.columns[minuend] - table.columns[subtrahend]
        units_of[name] = table.units.get(minuend)
    with_made = replace(
        table,
        columns={**table.columns, **differences},
        units={**table.units, **units_of},
        made=tuple(made),
    )
    return with_made, replace(told, columns=columns)


def _named_difference(table: Table, label: str) -> tuple[str, str, str | None] | None:
    """The two columns of ``n_in [rpm] - n_out [rpm]`` or ``n_in - n_out [rpm]``, and the unit; None for one column.

    Raises:
        MappingError: columns in two units.
    """
    words = label.split(MINUS)
    for count in range(1, len(words)):
        minuend, unit = split_label(MINUS.join(words[:count]))
        subtrahend, other_unit = split_label(MINUS.join(words[count:]))
        if not table.columns.keys() >= {minuend, subtrahend}:
            continue
        unit = unit or table.units.get(minuend)
        other_unit = other_unit or table.units.get(subtrahend)
        if unit and other_unit and unit != other_unit:
            problem = f"'{label}' is a difference of two units, {unit} and {other_unit}"
            raise MappingError(problem, remedy="Give two columns in one unit")
        return minuend, subtrahend, other_unit or unit
    return None


def _ends_of_clutch(table: Table, signal: str) -> tuple[str, str] | None:
    """The speeds, or the positions, of both ends of a clutch or damper; None for no or several pairs.

    Their names are the same but for a word for the driving and the driven shaft; or for the numbers 1 and 2, where the
    file has one effort at most, or two that are nearly the same: of two joints each has its own. No other column may be
    called like that motion.
    """
    short_names = NAMES[signal].split()
    si_units = _UNITS_OF_MOTION[signal]
    # By what the name says besides, and the unit.
    driving: dict[tuple[str, str | None], list[str]] = {}
    driven: dict[tuple[str, str | None], list[str]] = {}
    numbered: dict[tuple[str, str | None], list[str]] = {}
    called_so: set[str] = set()  # columns whose whole name says that they are such a motion
    efforts: list[str] = []
    for name in table.columns:
        if name in table.made:
            continue
        said = spoken_name(name)
        unit = table.units.get(name)
        is_motion = signal in said.may_be | said.within or bool(unit_fits(name, unit, si_units))
        for place, shafts in enumerate((driving, driven)):
            besides = _without_shaft(said.stem, place)
            is_bare = said.plain_stem in _SHAFTS[place] and bool(unit_fits(name, unit, si_units))
            if is_bare or (besides and (is_motion or besides in short_names)):
                shafts.setdefault((besides, unit), []).append(name)
        bare = said.bare_stem
        if is_motion and bare and bare != said.plain_stem:
            numbered.setdefault((bare, unit), []).append(name)

        form = said.forms[signal]
        is_share = (unit or said.end) == "%"  # by which the shafts differ
        if form and (form not in NEED_UNIT or unit or said.end) and not is_share:
            called_so.add(name)
        is_effort = "effort" in said.may_be or bool(unit_fits(name, unit, ("N*m", "N")))
        if is_effort and not said.is_time:
            efforts.append(name)

    pairs: list[tuple[str, str]] = []
    for what in driving.keys() & driven.keys():
        pairs += product(driving[what], driven[what])
    if not pairs and (len(efforts) <= 1 or _carry_one_effort(table, efforts)):
        for family in numbered.values():
            first, *others = sorted(family)
            if len(others) == 1 and first.endswith("1") and others[0].endswith("2"):
                pairs.append((first, others[0]))
    if not pairs:
        suspension = ends_of_a_suspension(table, signal, si_units)
        pairs = [suspension] if suspension else []
    if len(pairs) != 1:
        return None
    ends = pairs[0]
    slip_is_logged = bool(called_so.difference(ends))  # then it needs no difference
    return None if slip_is_logged else ends


def _carry_one_effort(table: Table, efforts: list[str]) -> bool:
    """Whether two efforts are those of both ends of one device: they differ by its friction alone."""
    if len(efforts) != 2:
        return False
    first, second = (table.columns[name] for name in efforts)
    known = np.isfinite(first) & np.isfinite(second)
    largest = float(np.abs(first[known]).max(initial=0.0))
    apart = np.abs(np.abs(first[known]) - np.abs(second[known]))
    is_alike = float(np.median(apart)) <= _FRICTION * largest if known.any() else False
    return largest > 0.0 and is_alike and not bool(np.ptp(second[known]) == 0.0)


@lru_cache(maxsize=4096)
def _without_shaft(name: str, place: int) -> str:
    """A name without the one word that says that it is of a shaft; "" where no or several words say so.

    Args:
        name: without its unit.
        place: of the shaft: 0 drives, 1 is driven.
    """
    words = words_of(name)
    of_shaft = [word for word in words if word in _SHAFTS[place]]
    if len(of_shaft) == 1:
        return " ".join(word for word in words if word not in of_shaft)
    letters = plain(name)
    for pair in _EASTERN_SHAFTS:
        if pair[place] in letters:
            return letters.replace(pair[place], "")
    longest_first = sorted(_SHAFTS[place], key=len, reverse=True)
    for word in longest_first:
        begins_a_compound = len(word) > 4 and letters.startswith(word) and letters != word
        if begins_a_compound:  # Antriebsdrehzahl
            return letters.removeprefix(word).removeprefix("s")
    return ""


def between_shafts(seen: SeenColumns, signal: str) -> list[str]:
    """What may be the slip, or the position, where the file has two shafts: their difference, then each of them.

    The driven shaft stands first where the effort keeps to its sign and not to that of the difference: what the other
    one was told may be called an input. So it does where the shafts turn against each other, as no clutch lets them:
    one of the speeds is counted the other way round.
    """
    table = seen.table
    if not table.made or signal not in _UNITS_OF_MOTION:
        return []
    ends = _ends_of_clutch(table, signal)
    if ends is None:
        return []
    differences = [name for name in table.made if table.parts_of(name) == ends]
    if not differences:
        return []
    driving, driven = ends
    apart = _speed_of(seen.columns[differences[0]].values, signal)
    speed = _speed_of(seen.columns[driven].values, signal)
    if signal == "slip" and _turn_against(seen.columns[driving].values, speed):
        return [driven, *differences, driving]
    for column in seen.columns.values():
        is_effort = "effort" in column.spoken.may_be and takes_both_signs(speed)
        if not is_effort or not _keeps_sign(column.values, speed):
            continue
        if not _keeps_sign(column.values, apart):
            return [driven, *differences, driving]
    return [*differences, *ends]


def _turn_as_one(driving: Array, driven: Array) -> bool:
    """Whether two shafts go with each other at all times: a gear is between them, or one is what the other was told."""
    known = np.isfinite(driving) & np.isfinite(driven)
    if not known.any():
        return True
    usual = known.copy()
    # Codes for no measurement, far from all other numbers, go together too.
    for speed in (driving, driven):
        low, high = np.quantile(speed[known], _USUAL)
        usual &= (speed >= low) & (speed <= high)
    first = driving[usual]
    second = driven[usual]
    if go_straight(first, second):
        return True
    apart = float(np.abs(first - second).max(initial=0.0))
    largest = float(np.abs(first).max(initial=0.0))
    return apart <= _APART * largest


def _turn_against(driving: Array, driven: Array) -> bool:
    """Whether two shafts turn against each other wherever both turn."""
    along = _share_of_one_sign(driving, driven)
    return along is not None and 1.0 - along >= _TRANSMITS


def _speed_of(motion: Array, signal: str) -> Array:
    """A speed, or what a position changes by from row to row, shape (n,)."""
    return np.gradient(motion) if signal == "position" and motion.size > 1 else motion


def is_of_clutch(seen: SeenColumns, signal: str, difference: str, efforts: Iterable[str]) -> bool:
    """Whether a difference of two shafts is the slip or position: the file says clutch, or an effort keeps to its sign.

    A gear has two shafts too; what its speeds differ by is no slip, and its effort keeps to the sign of each.
    """
    table = seen.table
    texts_of_file = [table.name, *table.columns, *table.metadata, *table.metadata.values()]
    words_of_file = " ".join(texts_of_file).lower()
    shafts = table.parts_of(difference) or ()
    speeds = [_speed_of(seen.columns[shaft].values, signal) for shaft in shafts]
    is_called_so = any(word in words_of_file for word in _CLUTCH)
    if is_called_so and not (signal == "slip" and speeds and _turn_against(*speeds)):
        return True
    if shafts and _is_told_in_percent(seen, difference, shafts[0]):
        return True
    slip = _speed_of(seen.columns[difference].values, signal)
    if not takes_both_signs(slip):
        return False
    for name in efforts:
        effort = seen.columns[name].values
        if _keeps_sign(effort, slip) and not any(_keeps_sign(effort, speed) for speed in speeds):
            return True
    return False


def _is_told_in_percent(seen: SeenColumns, difference: str, driving: str) -> bool:
    """Whether a column that is called a slip is the difference over the speed of the driving shaft, in percent."""
    apart = seen.columns[difference].values
    speed = seen.columns[driving].values
    for column in seen.columns.values():
        if "slip" not in column.spoken.words or column.written_unit != "%":
            continue
        known = (
            np.isfinite(column.values) & np.isfinite(apart) & np.isfinite(speed) & (speed != 0.0)
        )
        if np.count_nonzero(known) < FEW:
            continue
        share = 100.0 * apart[known] / speed[known]
        off = np.abs(column.values[known] - share)
        if np.quantile(off, _USUAL[1]) <= _IN_PERCENT * np.abs(share).max():
            return True
    return False


def _keeps_sign(effort: Array, speed: Array) -> bool:
    """Whether an effort takes the sign of a speed, or the other sign, wherever both are large."""
    along = _share_of_one_sign(effort, speed)
    return along is not None and max(along, 1.0 - along) >= _TRANSMITS


def _share_of_one_sign(first: Array, second: Array) -> float | None:
    """The share of the rows in which both are large that has one sign for both; None for a few such rows."""
    known = np.isfinite(first) & np.isfinite(second)
    first = first[known]
    second = second[known]
    if first.size < FEW:
        return None
    large = np.abs(first) > _LARGE * np.abs(first).max()
    large &= np.abs(second) > _LARGE * np.abs(second).max()
    rows = np.count_nonzero(large)
    if rows < FEW:
        return None
    return np.count_nonzero(np.sign(first[large]) == np.sign(second[large])) / rows
