"""A column may be made of others: a coefficient of friction of two forces, the slip of an electric machine of a speed.

The coefficient tells which force rubs and which presses. A machine that would turn at n0 and turns at n has the slip
1 - n / n0: the number of a table, and no speed of a fluid. The slip of a clutch between two shafts is made of their
speeds, and stands in no column of the file: it is made here.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import permutations, product

import numpy as np

from erclutch.errors import MappingError
from erclutch.logs.labels import own_unit, split_label
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.names import NAMES, plain, spoken_name, words_of
from erclutch.logs.seen_columns import NO_UNITS, SeenColumn, SeenColumns
from erclutch.logs.shapes import FEW, LOOKED_AT, takes_both_signs
from erclutch.logs.table import MINUS, Table
from erclutch.signals import units
from erclutch.signals.array import Array

_FRICTION = frozenset({"cof", "friction", "traction", "mu"})
_COEFFICIENT = frozenset({"cof", "mu", "coefficient", "reibwert", "reibungszahl"})
_MOST_PARTS = 12  # columns with a unit, among whose quotients none is by chance a column
_DIGITS = 0.05  # of its spread, by which a quotient that was written with some digits is off
_QUARTERS = (0.25, 0.5, 0.75)
_WHOLE_SLIPS = (1.0, 100.0)  # at rest, as a share and in percent
#: Words of the shaft that drives a clutch, and of the shaft that is driven.
_SHAFTS = (
    frozenset(
        {"in", "input", "drive", "driving", "driver", "primary", "motor", "antrieb", "entree", "entrada", "eingang"}
    ),
    frozenset({"out", "output", "driven", "load", "secondary", "abtrieb", "sortie", "salida", "ausgang"}),
)
_EASTERN_SHAFTS = (("输入", "输出"), ("主动", "从动"), ("入力", "出力"), ("駆動", "従動"))
_CLUTCH = (
    "clutch",
    "kupplung",
    "embrayage",
    "embrague",
    "embreagem",
    "frizione",
    "离合器",
    "離合器",
    "クラッチ",
    "муфт",
)
_TRANSMITS = 0.95  # share of the rows in which the effort keeps to the sign of the slip
_LARGE = 0.05  # of the largest slip and effort, from which on their signs tell
_DIGITS_OF_SPEED = 2e-3  # of the speed without load, by which speeds written with some digits are off
_ABOUT = 0.1  # of a smoothed quotient, by which it differs from the quotient at its quartiles


def rubbing_force(seen: SeenColumns) -> str:
    """The force over the normal force in a column that is called a coefficient of friction; "" where there is none.

    A smoothed coefficient is no quotient row by row, but it is as large as that of one pair of forces, and of no other.
    """
    forces = [column for column in seen.columns.values() if column.unit and column.fits(("N",))]
    for column in seen.columns.values():
        has_its_name = not _FRICTION.isdisjoint(column.spoken.stem_words)
        if not has_its_name or column.unit not in (None, *NO_UNITS):
            continue
        parts = quotient_of(seen, column)
        if parts is not None:
            return parts[0]
        if len(forces) > _MOST_PARTS:
            continue
        pairs = permutations(forces, 2)
        alike = [top.name for top, bottom in pairs if _is_as_large(column.values, top.values, bottom.values)]
        if len(alike) == 1:
            return alike[0]
    return ""


def pressing_loads(seen: SeenColumns, signal: str) -> list[str]:
    """Loads that press: beside a coefficient of friction that is made of no force of the file, they are no effort."""
    if signal != "effort":
        return []
    coefficients = [column for column in seen.columns.values() if _is_a_coefficient(column)]
    if not coefficients or rubbing_force(seen):
        return []
    forces = [column for column in seen.columns.values() if column.fits(("N",))]
    return [column.name for column in forces if column.unit and "load" in column.spoken.stem_words]


def _is_a_coefficient(column: SeenColumn) -> bool:
    """Whether a column is called a coefficient of friction, and has no unit."""
    return not _COEFFICIENT.isdisjoint(column.spoken.stem_words) and column.unit in (None, *NO_UNITS)


def quotient_of(seen: SeenColumns, column: SeenColumn) -> tuple[str, str] | None:
    """The two columns of one kind whose quotient a column is, as a coefficient of friction is; None: it is none."""
    others = [other for other in seen.without([column.name]) if other.written_unit and not other.shape.constant]
    if len(others) > _MOST_PARTS:
        return None
    for top, bottom in permutations(others, 2):
        if top.written_unit == bottom.written_unit and _is_quotient(column.values, top.values, bottom.values):
            return top.name, bottom.name
    return None


def _is_quotient(column: Array, top: Array, bottom: Array) -> bool:
    """Whether a column is one column over another, as a share or in percent, in each row up to its digits.

    Signs are passed over: a coefficient of friction has none.
    """
    known = np.isfinite(column) & np.isfinite(top) & np.isfinite(bottom) & (bottom != 0.0)
    share = np.abs(column[known][:LOOKED_AT])
    above = np.abs(top[known][:LOOKED_AT])
    below = np.abs(bottom[known][:LOOKED_AT])
    if share.size < FEW or np.std(share) == 0.0:
        return False
    with np.errstate(over="ignore"):
        off_as_share = float(np.median(np.abs(share - 1.0 * above / below)))
        off_in_percent = float(np.median(np.abs(share - 100.0 * above / below)))
    return bool(min(off_as_share, off_in_percent) <= _DIGITS * np.std(share))


def _is_as_large(column: Array, top: Array, bottom: Array) -> bool:
    """Whether a column is about as large as one column over another: in the median, and where it is large and small."""
    known = np.isfinite(column) & np.isfinite(top) & np.isfinite(bottom) & (bottom != 0.0)
    if np.count_nonzero(known) < FEW:
        return False
    with np.errstate(over="ignore"):
        share = np.quantile(np.abs(column[known]), _QUARTERS)
        made = np.quantile(np.abs(top[known] / bottom[known]), _QUARTERS)
    about_alike = np.abs(made - share) <= _ABOUT * share
    return bool(np.all(share > 0.0) and np.all(about_alike))


def speeds_of_machine(slip: SeenColumn, columns: Iterable[SeenColumn]) -> list[str]:
    """The columns of speeds whose share a column called slip is; none where it is a speed of its own."""
    if slip.unit not in (None, *NO_UNITS):
        return []
    speeds = (column for column in columns if column is not slip and column.spoken.forms["slip"])
    return [speed.name for speed in speeds if _is_share_of(slip.values, speed.values)]


def _is_share_of(slip: Array, speed: Array) -> bool:
    """Whether a slip is what a speed lacks of some speed without load, in every row."""
    known = np.isfinite(slip) & np.isfinite(speed)
    share = slip[known][:LOOKED_AT]
    turns = speed[known][:LOOKED_AT]
    if share.size < FEW or np.ptp(share) == 0.0:
        return False
    for whole in _WHOLE_SLIPS:
        left = 1.0 - share / whole
        square = float(left @ left)
        if square == 0.0:
            continue
        without_load = float(left @ turns) / square
        if abs(without_load - whole) <= _ABOUT * whole:
            continue  # of a shaft at 100 rad/s a clutch that slips by s turns at 100 - s: share and slip are one number
        off = float(np.abs(turns - without_load * left).max())
        digits = _DIGITS_OF_SPEED * abs(without_load)
        # A speed that changes by no more than its digits is any share's.
        if np.ptp(turns) > 10.0 * digits and off <= digits:
            return True
    return False


# --- two shafts ------------------------------------------------------------------------------------------------------


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
    if told.columns.keys().isdisjoint({"slip", "position"}):
        shafts = _shafts(table)
        if shafts is not None:
            made[MINUS.join(shafts)] = shafts
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


def _shafts(table: Table) -> tuple[str, str] | None:
    """The speeds of a driving and a driven shaft, whose names are the same otherwise; None for no or several pairs."""
    names_of_speeds = NAMES["slip"].split()
    driving: dict[tuple[str, str | None], list[str]] = {}  # by what the name says besides, and the unit
    driven: dict[tuple[str, str | None], list[str]] = {}
    for name in table.columns:
        said = spoken_name(name)
        is_speed = "slip" in said.may_be | said.within or _is_in_turns(table, name)
        for place, shafts in enumerate((driving, driven)):
            rest = _without_shaft(said.stem, place)
            if rest and (is_speed or rest in names_of_speeds):
                shafts.setdefault((rest, table.units.get(name)), []).append(name)
    pairs: list[tuple[str, str]] = []
    for what in driving.keys() & driven.keys():
        pairs += product(driving[what], driven[what])
    return pairs[0] if len(pairs) == 1 else None


def _is_in_turns(table: Table, name: str) -> bool:
    """Whether a column is in a unit of turning speed."""
    unit = own_unit(name, table.units.get(name), ("rad/s",))
    return bool(unit) and units.is_unit(unit or "") and units.fits(unit or "", ("rad/s",)) is not None


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


def slips_of_shafts(seen: SeenColumns) -> list[str]:
    """What may be the slip where the file has two shafts: the difference of their speeds, then each of them."""
    shafts = _shafts(seen.table)
    return [name for name in seen.table.made if seen.table.parts_of(name) == shafts] + [*(shafts or ())]


def is_slip_of_clutch(seen: SeenColumns, slip: str, efforts: Iterable[str]) -> bool:
    """Whether a difference of speeds is the slip: the file says clutch, or an effort keeps to its sign and no shaft's.

    A gear has two shafts too, and what its speeds differ by is no slip.
    """
    table = seen.table
    said = " ".join([table.name, *table.columns, *table.metadata, *table.metadata.values()]).lower()
    if any(word in said for word in _CLUTCH):
        return True
    parts = table.parts_of(slip) or ()
    for effort in efforts:
        values = seen.columns[effort].values
        if not takes_both_signs(seen.columns[slip].values):
            continue
        kept = _keeps_sign(values, seen.columns[slip].values)
        if kept and not any(_keeps_sign(values, seen.columns[shaft].values) for shaft in parts):
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
