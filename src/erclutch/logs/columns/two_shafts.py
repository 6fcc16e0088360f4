"""The slip of a clutch between two shafts is the difference of their speeds, and stands in no column of the file.

So is the stroke of a damper whose both ends move. A gear has two shafts too, and what these differ by is no slip: where
neither a word nor the signs of the effort tell, the user is asked. ``A - B`` in place of a column names any difference.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np

from erclutch.errors import MappingError
from erclutch.logs.columns.labels import own_unit, split_label
from erclutch.logs.columns.names import NAMES, NEED_UNIT, plain, spoken_name, words_of
from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.columns.shapes import FEW, go_straight, takes_both_signs
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.table import MINUS, Table
from erclutch.signals import units
from erclutch.signals.array import Array

#: Words of the shaft that drives a clutch, and of the shaft that is driven.
_SHAFTS = (
    frozenset(
        {"in", "input", "drive", "driving", "driver", "primary", "motor", "antrieb", "entree", "entrada", "eingang"}
    ),
    frozenset({"out", "output", "driven", "load", "secondary", "abtrieb", "sortie", "salida", "ausgang"}),
)
_EASTERN_SHAFTS = (("输入", "输出"), ("主动", "从动"), ("入力", "出力"), ("駆動", "従動"))
_CLUTCH = (
    *("clutch", "kupplung", "embrayage", "embrague", "embreagem", "frizione"),
    *("离合器", "離合器", "クラッチ", "муфт"),
)
_UNITS_OF_MOTION = {"slip": ("rad/s", "m/s"), "position": ("rad", "m")}
_APART = 0.01  # of the largest speed, by which the shafts of a clutch differ at least
_USUAL = (0.01, 0.99)  # quantiles
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
        parts = None if label in table.columns else _named_difference(table, label.removeprefix("-"))
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
            driving, driven = (_speed_of(table.columns[end], signal) for end in ends)
            if not _turn_as_one(driving, driven):
                made[MINUS.join(ends)] = ends
    if not made:
        return table, told
    values = {name: table.columns[minuend] - table.columns[subtrahend] for name, (minuend, subtrahend) in made.items()}
    units_of = {name: table.units.get(minuend) for name, (minuend, _) in made.items()}
    with_made = replace(
        table,
        columns={**table.columns, **values},
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
    file has one effort at most: of two joints each has its own. No other column may be called like that motion.
    """
    short_names = NAMES[signal].split()
    driving: dict[tuple[str, str | None], list[str]] = {}  # by what the name says besides, and the unit
    driven: dict[tuple[str, str | None], list[str]] = {}
    numbered: dict[tuple[str, str | None], list[str]] = {}
    whole: set[str] = set()  # columns whose whole name says that they are such a motion
    efforts = 0
    for name in table.columns:
        said = spoken_name(name)
        unit = table.units.get(name)
        is_motion = signal in said.may_be | said.within or _fits(name, unit, _UNITS_OF_MOTION[signal])
        for place, shafts in enumerate((driving, driven)):
            rest = _without_shaft(said.stem, place)
            if rest and (is_motion or rest in short_names):
                shafts.setdefault((rest, unit), []).append(name)
        if said.forms[signal] and (said.forms[signal] not in NEED_UNIT or unit or said.end):
            whole.add(name)
        bare = said.plain_stem.rstrip("0123456789")
        if is_motion and bare and bare != said.plain_stem:
            numbered.setdefault((bare, unit), []).append(name)
        is_effort = "effort" in said.may_be or _fits(name, unit, ("N*m", "N"))
        efforts += is_effort and not said.is_time

    pairs: list[tuple[str, str]] = []
    for what in driving.keys() & driven.keys():
        pairs += product(driving[what], driven[what])
    if not pairs and efforts <= 1:
        for family in numbered.values():
            first, *others = sorted(family)
            if len(others) == 1 and first.endswith("1") and others[0].endswith("2"):
                pairs.append((first, others[0]))
    if len(pairs) != 1 or whole - {*pairs[0]}:  # a slip that is logged needs no difference
        return None
    return pairs[0]


def _fits(name: str, unit: str | None, si_units: tuple[str, ...]) -> bool:
    """Whether the unit of a column is one for some SI units."""
    known = own_unit(name, unit, si_units) or ""
    return bool(known) and units.is_unit(known) and units.fits(known, si_units) is not None


def _without_shaft(name: str, place: int) -> str:
    """A name without the one word that says that it is of a shaft; "" where no or several words say so.

    Args:
        name: without its unit.
        place: of the shaft: 0 drives, 1 is driven.
    """
    words = words_of(name)
    said = [word for word in words if word in _SHAFTS[place]]
    if len(said) == 1:
        return " ".join(word for word in words if word not in said)
    letters = plain(name)
    for pair in _EASTERN_SHAFTS:
        if pair[place] in letters:
            return letters.replace(pair[place], "")
    for word in sorted(_SHAFTS[place], key=len, reverse=True):
        if len(word) > 4 and letters.startswith(word) and len(letters) > len(word):  # Antriebsdrehzahl
            return letters.removeprefix(word).removeprefix("s")
    return ""


def between_shafts(seen: SeenColumns, signal: str) -> list[str]:
    """What may be the slip, or the position, where the file has two shafts: their difference, then each of them."""
    if not seen.table.made or signal not in _UNITS_OF_MOTION:
        return []
    ends = _ends_of_clutch(seen.table, signal)
    made = [name for name in seen.table.made if seen.table.parts_of(name) == ends]
    return [*made, *ends] if made and ends else []


def _turn_as_one(driving: Array, driven: Array) -> bool:
    """Whether two shafts go with each other at all times: a gear is between them, or one is what the other was told."""
    usual = np.isfinite(driving) & np.isfinite(driven)
    if not usual.any():
        return True
    bounds = [np.quantile(speed[usual], _USUAL) for speed in (driving, driven)]
    for speed, (low, high) in zip((driving, driven), bounds, strict=True):  # codes for no measurement go together too
        usual &= (speed >= low) & (speed <= high)
    if go_straight(driving[usual], driven[usual]):
        return True
    apart = float(np.abs(driving - driven)[usual].max(initial=0.0))
    return apart <= _APART * float(np.abs(driving[usual]).max(initial=0.0))


def _speed_of(motion: Array, signal: str) -> Array:
    """A speed, or what a position changes by from row to row, shape (n,)."""
    return np.gradient(motion) if signal == "position" and motion.size > 1 else motion


def is_of_clutch(seen: SeenColumns, signal: str, difference: str, efforts: Iterable[str]) -> bool:
    """Whether a difference of two shafts is the slip or position: the file says clutch, or an effort keeps to its sign.

    A gear has two shafts too; what its speeds differ by is no slip, and its effort keeps to the sign of each.
    """
    table = seen.table
    said = " ".join([table.name, *table.columns, *table.metadata, *table.metadata.values()]).lower()
    if any(word in said for word in _CLUTCH):
        return True
    motions = [difference, *(table.parts_of(difference) or ())]
    slip, *shafts = [_speed_of(seen.columns[name].values, signal) for name in motions]
    if not takes_both_signs(slip):
        return False
    for effort in efforts:
        values = seen.columns[effort].values
        if _keeps_sign(values, slip) and not any(_keeps_sign(values, speed) for speed in shafts):
            return True
    return False


def _keeps_sign(effort: Array, speed: Array) -> bool:
    """Whether an effort takes the sign of a speed, or the other sign, wherever both are large."""
    known = np.isfinite(effort) & np.isfinite(speed)
    f = effort[known]
    v = speed[known]
    if f.size < FEW:
        return False
    large = (np.abs(f) > _LARGE * np.abs(f).max()) & (np.abs(v) > _LARGE * np.abs(v).max())
    if np.count_nonzero(large) < FEW:
        return False
    along = np.count_nonzero(np.sign(f[large]) == np.sign(v[large])) / np.count_nonzero(large)
    return max(along, 1.0 - along) >= _TRANSMITS
