"""Columns are found by the labels that users give, or by what their names and units say; a bet is an error."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Container, Iterable, Sequence

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.labels import own_unit, split_end
from erclutch.logs.mapping import COUNTS, ColumnChoice
from erclutch.logs.names import (
    NAMES,
    NEED_UNIT,
    OTHER,
    SINGLE,
    TOLD,
    VOLTAGES,
    called_as,
    ends_in_time,
    headed,
    is_accounted,
    is_turned,
    numbered,
    plain,
    words_of,
)
from erclutch.logs.shapes import (
    follows,
    is_constant,
    is_counter,
    is_rate_of,
    keeps_levels,
    moves_alike,
    rises,
    same_thing,
)
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS

_TIME = re.compile(
    r"t|time|zeit|uhrzeit|tijd|temps|tiempo|tempo|timestamps?|elapsed(?:time)?|steptime|seconds|sec|tsec|times|"
    r"(?:ros|bag|rosbag|test|run|total|sample|relative|local|system|log|rec|elapsed|unix|epoch)?time(?:stamp)?s?|"
    r"stamp|zeitstempel|messzeit|tempsecoule|tiempotranscurrido|.{0,4}时间戳?|时刻|.{0,4}時間|時刻|millis|micros",
    re.IGNORECASE,
)
_LENGTHS = ("displacement", "disp", "extension", "stroke", "crosshead", "weg", "deplacement", "desplazamiento")
# A turning motion goes with a torque, one along a line with a force, a shear rate with a stress.
_KINDS = {"Pa": "shear rate", "N*m": "turning motion", "N": "motion along a line"}
_CONJUGATES = {"N*m": ("N*m", "rad/s", "rad"), "N": ("N", "m/s", "m"), "Pa": ("Pa", "1/s")}
_SAYS = {
    "Pa": ("shearrate", "shearstress", "gammadot"),
    "N*m": ("torque", "rpm", "omega", "angle", "angular", "theta", "drehzahl", "drehmoment", "扭矩", "转速", "角"),
    "N": ("force", "displacement", "stroke", "kraft", "weg", "位移"),
}
_EXAMPLES = {"field": "I [A]", "slip": "V [cm/s]", "position": "D [mm]", "effort": "F [N]", "T": "torque [N*m]"}


def _fits(table: Table, name: str, si_units: tuple[str, ...]) -> bool | None:
    """Whether the column's unit is one for these; None where it has no unit."""
    unit = own_unit(name, table.units.get(name), si_units)
    if not unit:
        return False if split_end(name)[1] else None
    try:
        return units.fits(unit, si_units) is not None
    except UnitError:
        return False


def meant_by(name: str, signals: Iterable[str], *, time: bool) -> str:
    """The signal that a column's name speaks for, ``time`` among them where that is looked for; "" for none.

    Short names that mean several things speak for none.
    """
    if time and is_time(name):
        return "time"
    words = set(words_of(split_end(name)[0]))
    for signal in sorted(signals):
        form = called_as(name, signal) if signal in NAMES else None
        if form and form not in NEED_UNIT and not (words & (TOLD | OTHER) and signal != "field"):
            return signal
    return ""


def candidates(
    table: Table, signal: str, taken: Iterable[str], units_of_sensor: tuple[str, ...] = ()
) -> tuple[list[str], str]:
    """Columns that may be the signal, and what speaks for them: ``name`` or ``unit``.

    Args:
        table: the log.
        signal: its name.
        taken: columns that are something else.
        units_of_sensor: units of the column where a scale makes the signal of it, such as V; then names alone speak.
    """
    si_units = units_of_sensor or SIGNALS[signal].si_units
    fit = {name: _fits(table, name, si_units) for name in table.columns if name not in set(taken)}
    if signal in fit and fit[signal] is not False:
        # A whole name with a unit speaks as loud as the bare word: a motor's slip is a share, beside its speed.
        louder = [name for name, fits in fit.items() if fits and fit[signal] is None and called_as(name, signal)]
        return [signal, *louder], "name"
    told = TOLD if signal != "field" else frozenset[str]()
    # A large W is the watt: power is no signal.
    fit = {name: fits for name, fits in fit.items() if name.strip() != "W" or fits}
    forms = {name: called_as(name, signal) for name, fits in fit.items() if fits is not False}
    named = [
        name
        for name, form in forms.items()
        if form and (fit[name] or form not in NEED_UNIT) and not told.intersection(words_of(name))
    ]
    exact = [name for name in named if plain(split_end(name)[0]) == forms[name]]
    if named or units_of_sensor:
        chosen = exact or named
        if signal == "field" and {forms[name] for name in chosen} <= VOLTAGES:
            chosen = [*chosen, *_currents(table, fit, chosen)]
        return _distinct(table, chosen), "name"
    shared = _shared_words(table)
    heads = {name: headed(name, signal, shared) for name, fits in fit.items() if fits is not False}
    short = [name for name, form in forms.items() if form or numbered(name, signal) or heads[name] in NEED_UNIT]
    short = [name for name in short if not told.intersection(words_of(name))]
    if shaped := [name for name in short if _goes_with(table, name, signal)]:
        return shaped, "name and the shape of its numbers"
    headed_so = [name for name, head in heads.items() if head and (fit[name] or head not in NEED_UNIT)]
    by_unit = [
        name
        for name, fits in fit.items()
        if fits and own_unit(name, table.units.get(name), si_units) not in {None, "", "-", "1", "%"}
        if not (told | OTHER).intersection(words_of(split_end(name)[0])) and not _another(name, signal)
        if not is_turned(name, signal) and (signal == "field" or not is_constant(table.columns[name]))
    ]
    by_unit = by_unit if signal in _EXAMPLES else []
    if headed_so:
        # A head is no whole name: another column with such a unit may be the signal as well.
        found = [*headed_so, *(name for name in by_unit if name not in headed_so)]
        if signal == "field" and {heads.get(name) for name in found} <= VOLTAGES:
            found = [*found, *_currents(table, fit, found)]
        return _distinct(table, found), "name"
    return _distinct(table, by_unit), "unit"


def _distinct(table: Table, found: Sequence[str]) -> list[str]:
    """Columns without those that never change beside some that do, and without the same numbers in another unit."""
    moving = [name for name in found if not is_constant(table.columns[name])]
    kept: list[str] = []
    for name in moving or found:
        if not any(_same(table, name, other) for other in kept):
            kept.append(name)
    return kept


def _one_motion(table: Table, found: Sequence[str]) -> list[str]:
    """Positions without those that say the same from another zero: a travel beside an absolute one."""
    kept: list[str] = []
    for name in found:
        alike = (table.units.get(name) == table.units.get(other) for other in kept)
        moved = (moves_alike(table.columns[name], table.columns[other]) for other in kept)
        if not any(unit and motion for unit, motion in zip(alike, moved, strict=True)):
            kept.append(name)
    return kept


def _same(table: Table, name: str, other: str) -> bool:
    """Whether two columns with units are one quantity: degrees beside radians."""
    given = [table.units.get(each) or split_end(each)[1] for each in (name, other)]
    if not all(unit and units.is_unit(unit) for unit in given):
        return False
    first, second = (units.parse(unit or "") for unit in given)
    if first.dimension != second.dimension or first.factor == second.factor:
        return False
    return same_thing(table.columns[name] * first.factor, table.columns[other] * second.factor)


def _shared_words(table: Table) -> set[str]:
    """Words in the names of at least half of the columns, and of three: the name of a joint or of a topic."""
    counted = Counter(word for name in table.columns for word in set(words_of(split_end(name)[0])))
    return {word for word, count in counted.items() if count >= max(3, len(table.columns) / 2)}


def _goes_with(table: Table, name: str, signal: str) -> bool:
    """Whether a short name that means several things is the signal by its numbers: the rate of a position, say."""
    if signal not in ("slip", "position", "effort") or table.units.get(name) or split_end(name)[1]:
        return False
    values = table.columns[name]
    others = {each: column for each, column in table.columns.items() if each != name}
    if signal == "effort":
        lengths = any(
            called_as(each, "position") in _LENGTHS or headed(each, "position") in _LENGTHS for each in others
        )
        if called_as(name, "effort") == "load" and lengths:
            return True
        motions = [column for each, column in others.items() if _may_move(each)]
        return any(follows(values, motion) for motion in motions)
    stamps = stamps_of(table)
    if signal == "slip":
        pairs = [(values, column) for each, column in others.items() if _may_be(each, "position")]
    else:
        pairs = [(column, values) for each, column in others.items() if _may_be(each, "slip")]
    return any(is_rate_of(speed, position, stamps) for speed, position in pairs)


def _may_be(name: str, signal: str) -> bool:
    return (called_as(name, signal) or headed(name, signal) or numbered(name, signal)) is not None


def _may_move(name: str) -> bool:
    return _may_be(name, "slip") or _may_be(name, "position")


def stamps_of(table: Table) -> Array | None:
    """The time in s, or in what the file has, shape (n,); None for a table without a clock."""
    if table.clock is not None:
        return table.clock
    if table.sample_period is not None:
        return np.arange(table.rows, dtype=np.float64) * table.sample_period
    name = time_column(table, ())
    return None if name is None else table.columns[name]


def _currents(table: Table, fit: Iterable[str], named: Sequence[str]) -> list[str]:
    """Columns in amperes beside voltages: the current of a coil is its field as much as its voltage is."""
    return [
        name
        for name in fit
        if name not in named and _fits(table, name, ("A",)) and not is_constant(table.columns[name])
        if not (TOLD | OTHER).intersection(words_of(split_end(name)[0]))
    ]


def _another(name: str, signal: str) -> bool:
    """Whether the name speaks for another signal of a single device: a force sensor in volts is no field."""
    own = "effort" if signal == "T" else signal
    return any(len(called_as(name, other) or "") > 2 for other in SINGLE if other != own)


def guess(
    table: Table, signal: str, taken: Iterable[str], units_of_sensor: tuple[str, ...] = (), motion: str = ""
) -> ColumnChoice | None:
    """The one column that a signal's name or unit points to, or None; see `candidates`.

    Args:
        table: the log.
        signal: its name.
        taken: columns that are something else.
        units_of_sensor: see `candidates`.
        motion: the column of the slip or position, whose kind decides between a torque and a force.

    Raises:
        MappingError: several columns would do.
    """
    found, reason = candidates(table, signal, taken, units_of_sensor)
    found = _one_motion(table, found) if signal == "position" else found
    if signal == "effort" and len(found) > 1 and motion:
        turns = _kind(table, motion)
        alike = [name for name in found if turns and _kind(table, name) == turns]
        others = [_kind(table, name) for name in found if name not in alike]
        if len(alike) == 1 and all(others):
            found, reason = alike, f"{reason}, and it is that of a {_KINDS[turns]}"
    if len(found) > 1:
        problem = f"{signal} may be any of the columns {', '.join(found)}; the file has: {table.listed}"
        remedy = f"Say which, such as --{signal} {shell_word(table.label(found[0]))}"
        remedy += ", or --variable all if each is a log" if signal in ("effort", "T") else ""
        raise MappingError(problem, remedy=remedy)
    return ColumnChoice(found[0], source=f"guessed from its {reason}") if found else None


def _kind(table: Table, name: str) -> str:
    """Whether a motion or an effort is that of turning, of a line or of shear, as its SI unit; "" for untold."""
    for kind in _KINDS:
        if _fits(table, name, _CONJUGATES[kind]):
            return kind
    if table.units.get(name) or split_end(name)[1]:
        return ""
    spoken = "".join(words_of(name))
    return next((kind for kind, said in _SAYS.items() if any(word in spoken for word in said)), "")


def has_speed(table: Table, found: Container[str], asked: Container[str]) -> bool:
    """Whether a speed was found, or one of several columns is it; a position needs a clock to have one."""
    return "slip" in found or ("slip" in asked and len(candidates(table, "slip", ())[0]) > 1)


def _of_one_part(names: Sequence[str], beside: Sequence[str]) -> list[str]:
    """Columns, first those that have the most words and numbers in common with other columns: those of one joint."""
    known = {part for name in beside for part in re.findall(r"\d+|[^\W\d_]+", split_end(name)[0].lower())}
    shared = {name: len(known & {*re.findall(r"\d+|[^\W\d_]+", name.lower())}) for name in names}
    return sorted(names, key=lambda name: -shared[name])


def example(table: Table, signal: str, taken: Iterable[str], beside: Sequence[str] = ()) -> str:
    """An option for a signal that was not found: with a column that may be it, or with a place to fill in.

    Args:
        table: the log.
        signal: its name.
        taken: columns that are something else.
        beside: columns of the motion; of several efforts the one that is called like them goes first.
    """
    free = [name for name in table.columns if name not in set(taken)]
    short = NEED_UNIT & set(NAMES[signal].split())
    si_units = SIGNALS[signal].si_units
    open_ones = [name for name in free if plain(name) in short and _fits(table, name, si_units) is not False]
    likely = _of_one_part(candidates(table, signal, taken)[0] or open_ones, beside)
    if volts := _in_volts(table, signal, free):
        return volts
    unit = (_EXAMPLES.get(signal, "").partition("[")[2] or f"{SIGNALS[signal].si_units[0] or '-'}]")[:-1]
    if not likely:
        return f"--{signal} {shell_word(f'COLUMN [{unit}]')}"
    # A unit that nobody wrote is no answer: a column without one is taken as logged.
    label = _label(table, likely[0], signal) if likely == open_ones else table.label(likely[0])
    return f"--{signal} {shell_word(label)}"


def has_fitting_unit(table: Table, name: str, signal: str) -> bool:
    """Whether the column's unit is known and is one of the signal's."""
    return _fits(table, name, SIGNALS[signal].si_units) is True


def of_fitting_unit(table: Table, signal: str, taken: Iterable[str]) -> tuple[str, ...]:
    """Columns whose unit is one of the signal's."""
    free = [name for name in table.columns if name not in set(taken)]
    return tuple(name for name in free if has_fitting_unit(table, name, signal))


def maybe_field(table: Table, taken: Iterable[str]) -> list[str]:
    """Columns that nobody took and that may hold the field: its unit fits or is unknown, its name is open.

    Only where there is none, a log without a field is read as such.
    """
    free = [name for name in table.columns if name not in set(taken)]
    free = [name for name in free if _fits(table, name, SIGNALS["field"].si_units) is not False]
    return [name for name in free if not why_no_field(table, name)]


def field_or_none(table: Table, taken: Iterable[str]) -> str:
    """The option for a field that no name tells: a column that keeps a few levels, or none."""
    open_ones = [name for name in maybe_field(table, taken) if keeps_levels(table.columns[name])]
    return f"--field {shell_word(table.label(open_ones[0])) if len(open_ones) == 1 else 'none'}"


def why_no_field(table: Table, name: str) -> str:
    """Why a column without a unit is not the field; "" where it may be."""
    if has_fitting_unit(table, name, "field") and table.units.get(name) not in ("", "-", "1", "%"):
        return ""
    if is_constant(table.columns[name]):
        return "never changes"
    if is_counter(table.columns[name]):
        return "counts rows"
    if is_time(name):
        return "is a time"
    return "is another quantity by its name" if is_accounted(name) else ""


def missing(table: Table, signal: str, taken: Iterable[str], alternatives: str = "") -> MappingError:
    """The error for a signal that no column was found for."""
    free = [name for name in table.columns if name not in set(taken)]
    short = NEED_UNIT & set(NAMES[signal].split())
    doubtful = [name for name in free if not table.units.get(name) and plain(name) in short]
    doubt, example = "", _EXAMPLES.get(signal, f"NAME [{SIGNALS[signal].si_units[0] or '-'}]")
    if doubtful:
        meaning = " (voltage or velocity)" if plain(doubtful[0]) == "v" else ""
        doubt = f"; {doubtful[0]} may be it, but its name alone can mean several things{meaning}"
        example = _label(table, doubtful[0], signal)
    remedy = f"Give it with its unit, such as --{signal} {shell_word(example)}"
    if signal == "field":
        remedy += ", or --constant 'field=0.5 A' if it is the same all through the log, or --field none if not logged"
    lengths = [name for name in free if signal == "slip" and _fits(table, name, SIGNALS["position"].si_units)]
    lengths = [name for name in lengths if not is_constant(table.columns[name])]
    if lengths:
        remedy = f"Give a speed, or the position that it is the rate of: --position {shell_word(lengths[0])}"
    if volts := _in_volts(table, signal, free):
        remedy = f"Give what a volt of its sensor is, such as {volts}"
    called = (name for name in free if table.units.get(name) and len(called_as(name, signal) or "") > 2)
    refused = next((name for name in called if _fits(table, name, SIGNALS[signal].si_units) is False), None)
    doubt += f"; column {refused} is called so, but its unit {table.units[refused]} does not fit" if refused else ""
    problem = f"no column for {alternatives or signal}{doubt}; the file has: {table.listed}"
    return MappingError(problem, remedy=remedy)


def _in_volts(table: Table, signal: str, free: Iterable[str]) -> str:
    """Options for a column that has the signal's name and the unit of a sensor's output; "" where there is none."""
    for name in free:
        unit = table.units.get(name)
        volts = (unit in ("V", "mV") or unit in COUNTS) and _fits(table, name, SIGNALS[signal].si_units) is False
        if volts and len(called_as(name, signal) or "") > 2:
            scale = shell_word(f"{signal}=2.5 {SIGNALS[signal].si_units[0] or '1'}/{unit}")
            return f"--{signal} {shell_word(name)} --scale {scale}"
    return ""


def _label(table: Table, name: str, signal: str) -> str:
    """The column with its unit, or with a likely one."""
    example = "V [V]" if signal == "field" and plain(name) == "v" else _EXAMPLES.get(signal, "")
    likely = example[example.find("[") + 1 : -1] if example else SIGNALS[signal].si_units[0] or "-"
    _, end = split_end(name)
    return name if end and not table.units.get(name) else table.label(name, likely)


def is_time(name: str) -> bool:
    """Whether a column is called like the time."""
    return name != "T" and any(map(_TIME.fullmatch, (plain(name), plain(split_end(name)[0]))))


def time_column(table: Table, taken: Iterable[str]) -> str | None:
    """The column that is the time by its name, with a unit of time or none; or the only one with a unit of time.

    Where no whole name is, the only column whose name ends in a time and whose numbers rise (``Machine_Time``).
    """
    timed = {name: _fits(table, name, ("s",)) for name in table.columns if name not in set(taken)}
    named = [name for name, fits in timed.items() if fits is not False and is_time(name)]
    if named:
        return named[0]
    by_unit = [name for name, fits in timed.items() if fits and not OTHER.intersection(words_of(name))]
    if len(by_unit) == 1:
        return by_unit[0]
    rising = [name for name, fits in timed.items() if fits is not False and ends_in_time(name)]
    rising = [name for name in rising if rises(table.columns[name])]
    return rising[0] if len(rising) == 1 else None
