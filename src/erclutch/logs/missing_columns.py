"""What is said of a signal that no column was found for: what is missing, and an option that answers it."""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from itertools import permutations
from re import findall

from erclutch.errors import MappingError, shell_word
from erclutch.logs.clock_planning import stamps_of
from erclutch.logs.columns import candidates
from erclutch.logs.mapping import COUNTS
from erclutch.logs.names import NAMES, NEED_UNIT, spoken_name
from erclutch.logs.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.shapes import are_estimates, is_as_large, is_quotient, is_rate_of, is_set_point_of, same_course
from erclutch.signals.recording import SIGNALS

_EXAMPLES = {"field": "I [A]", "slip": "V [cm/s]", "position": "D [mm]", "effort": "F [N]", "T": "torque [N*m]"}
_MOST_PARTS = 12  # columns with a unit, among whose quotients none is by chance a column
#: What a number tells one of from another: none of them is switched to a level.
_NUMBERED = frozenset(("cell", "id", "label", "trial", "specimen", "station", "well", "slot", "axis", "group", "run"))
_NO_UNITS = ("", "-", "1", "%")


def missing(seen: SeenColumns, signal: str, taken: Iterable[str], alternatives: str = "") -> MappingError:
    """The error for a signal that no column was found for.

    Args:
        seen: the columns of the log.
        signal: its name.
        taken: columns that are something else.
        alternatives: how the message calls it, where other signals would do as well.
    """
    free = seen.without(taken)
    si_units = SIGNALS[signal].si_units
    example = _EXAMPLES.get(signal, f"NAME [{si_units[0] or '-'}]")
    doubt = ""

    doubtful = next((column for column in free if not column.unit and _is_short(column, signal)), None)
    if doubtful is not None:
        meaning = " (voltage or velocity)" if doubtful.spoken.plain == "v" else ""
        doubt = f"; {doubtful.name} may be it, but its name alone can mean several things{meaning}"
        example = _likely_label(seen, doubtful, signal)

    remedy = f"Give it with its unit, such as --{signal} {shell_word(example)}"
    if signal == "field":
        remedy += ", or --constant 'field=0.5 A' if it is the same all through the log, or --field none if not logged"
    if signal == "slip":
        in_lengths = (column for column in free if column.fits(SIGNALS["position"].si_units))
        position = next((column.name for column in in_lengths if not column.shape.constant), "")
        if position:
            remedy = f"Give a speed, or the position that it is the rate of: --position {shell_word(position)}"
        elif counted := _in_volts(free, "position"):
            remedy = f"Give a speed, or the position that it is the rate of: {counted}"
    volts = _in_volts(free, signal)
    if volts:
        remedy = f"Give what its sensor means, such as {volts}"

    misfits = (column for column in free if column.unit and column.fits(si_units) is False)
    refused = next((column for column in misfits if _is_called(column, signal)), None)
    if refused is not None:
        doubt += f"; column {refused.name} is called so, but its unit {refused.unit} does not fit"
    hollow = [name for name in seen.empty if len(spoken_name(name).forms[signal] or "") > 2]
    doubt += f"; column {hollow[0]} is called so, but holds no number in any row" if hollow else ""
    problem = f"no column for {alternatives or signal}{doubt}; the file has: {seen.table.listed}"
    return MappingError(problem, remedy=remedy)


def example_of(
    seen: SeenColumns, signal: str, taken: Iterable[str], beside: Sequence[str] = (), partners: Sequence[str] = ()
) -> str:
    """An option for a signal that was not found: with a column that may be it, or with a place to fill in.

    Args:
        seen: the columns of the log.
        signal: its name.
        taken: columns that are something else.
        beside: columns of the motion; of several efforts the one that is called like them goes first.
        partners: columns that may be the effort; of several motions the one that makes a power with one of them, and is
            called like it, goes first.
    """
    free = seen.without(taken)
    volts = _in_volts(free, signal)
    if volts:
        return volts

    si_units = SIGNALS[signal].si_units
    short = [column.name for column in free if _is_short(column, signal) and column.fits(si_units) is not False]
    found, _ = candidates(seen, signal, taken)
    within = [column.name for column in free if signal in column.spoken.within and column.fits(si_units) is not False]
    likely = _of_one_part(found or short or within, beside)
    if partners:
        likely = sorted(likely, key=lambda name: min(_apart(seen, name, partner) for partner in partners))
    if not likely:
        usual = _EXAMPLES.get(signal, "").partition("[")[2].removesuffix("]")
        hole = f"COLUMN [{usual or si_units[0] or '-'}]"
        return f"--{signal} {shell_word(hole)}"

    # A unit that nobody wrote is no answer: a column without one is taken as logged.
    return f"--{signal} {shell_word(seen.table.label(likely[0]))}"


def _of_one_part(names: Sequence[str], beside: Sequence[str]) -> list[str]:
    """Columns, first those that have the most words and numbers in common with other columns: those of one joint."""
    known: set[str] = set()
    for name in beside:
        known |= _parts(spoken_name(name).stem)
    return sorted(names, key=lambda name: -len(known & _parts(name)))


def _apart(seen: SeenColumns, motion: str, effort: str) -> tuple[bool, int]:
    """How far a motion is from an effort: of another kind, then by the parts of their names that they share."""
    kinds = seen.columns[motion].kind, seen.columns[effort].kind
    return kinds[0] != kinds[1] or not kinds[0], -len(_parts(motion) & _parts(effort))


def _parts(name: str) -> set[str]:
    return {*findall(r"\d+|[^\W\d_]+", name.lower())}


def has_speed(seen: SeenColumns, found: Container[str], asked: Container[str]) -> bool:
    """Whether a speed was found, or one of several columns is it; a position needs a clock to have one."""
    return "slip" in found or ("slip" in asked and len(candidates(seen, "slip", ())[0]) > 1)


def maybe_field(seen: SeenColumns, taken: Iterable[str]) -> list[SeenColumn]:
    """Columns that nobody took and that may hold the field: its unit fits or is unknown, its name is open.

    Only where there is none, a log without a field is read as such.
    """
    si_units = SIGNALS["field"].si_units
    known = set(taken)
    free = [column for column in seen.without(known) if column.fits(si_units) is not False]
    return [column for column in free if not why_no_field(seen, column, known)]


def field_or_none(seen: SeenColumns, taken: Iterable[str]) -> str:
    """The option for a field that no name tells: a column that keeps a few levels, or none."""
    open_ones = [column for column in maybe_field(seen, taken) if not {*column.spoken.stem_words} & _NUMBERED]
    leveled = [column.name for column in open_ones if column.shape.keeps_levels]
    return f"--field {shell_word(seen.table.label(leveled[0])) if len(leveled) == 1 else 'none'}"


def why_no_field(seen: SeenColumns, column: SeenColumn, taken: Iterable[str]) -> str:
    """Why a column is not the field, beside columns that are something else; "" where it may be."""
    if column.unit not in _NO_UNITS and column.fits(SIGNALS["field"].si_units):
        return ""
    if column.shape.constant:
        return "never changes"
    if column.shape.counts_rows:
        return "counts rows"
    if column.spoken.is_time:
        return "is a time"
    if column.spoken.is_accounted:
        return "is another quantity by its name"
    if _is_of_models(seen, column):
        return "is what a model says of the effort"
    measured = [seen.columns[name] for name in sorted(taken) if name in seen.columns]
    twins = [other.name for other in measured if same_course(column.values, other.values)]
    if twins:
        return f"is {twins[0]} in other numbers"
    followers = [other.name for other in measured if is_set_point_of(column.values, other.values)]
    if followers:
        return f"is the set point that {followers[0]} follows"
    stamps = stamps_of(seen) if measured else None
    moved = [other.name for other in measured if is_rate_of(column.values, other.values, stamps)]
    if moved:
        return f"is the rate of {moved[0]}"
    parts = quotient_of(seen, column)
    return f"is {parts[0]} over {parts[1]}" if parts else ""


def quotient_of(seen: SeenColumns, column: SeenColumn) -> tuple[str, str] | None:
    """The two columns of one kind whose quotient a column is, as a coefficient of friction is; None: it is none."""
    others = [other for other in seen.without([column.name]) if other.written_unit and not other.shape.constant]
    if len(others) > _MOST_PARTS:
        return None
    for top, bottom in permutations(others, 2):
        if top.written_unit == bottom.written_unit and is_quotient(column.values, top.values, bottom.values):
            return top.name, bottom.name
    return None


def rubbing_force(seen: SeenColumns) -> str:
    """The force over the normal force in a column that is called a coefficient of friction; "" where there is none.

    A smoothed coefficient is no quotient row by row, but it is as large as that of one pair of forces, and of no other.
    """
    forces = [column for column in seen.columns.values() if column.unit and column.fits(("N",))]
    for column in seen.columns.values():
        called = {"cof", "friction", "traction", "mu"} & {*column.spoken.stem_words}
        if not called or column.unit not in (None, *_NO_UNITS):
            continue
        parts = quotient_of(seen, column)
        if parts is not None:
            return parts[0]
        alike = [
            top.name
            for top, bottom in permutations(forces, 2)
            if len(forces) <= _MOST_PARTS and is_as_large(column.values, top.values, bottom.values)
        ]
        if len(alike) == 1:
            return alike[0]
    return ""


def _is_of_models(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a column is called like a model, or goes with such columns: a table of models beside a measured effort.

    One name alone may be that of a device; two are a comparison of models.
    """
    models = [other for other in seen.columns.values() if other.spoken.is_of_a_model]
    if len(models) < 2:
        return False
    return column.spoken.is_of_a_model or any(are_estimates(column.values, model.values) for model in models)


def _is_short(column: SeenColumn, signal: str) -> bool:
    """Whether the name is a short one of the signal that can mean several things."""
    return column.spoken.plain in NEED_UNIT and column.spoken.plain in NAMES[signal].split()


def _is_called(column: SeenColumn, signal: str) -> bool:
    """Whether the whole name speaks for the signal."""
    return len(column.spoken.forms[signal] or "") > 2


def _in_volts(free: Iterable[SeenColumn], signal: str) -> str:
    """Options for a column that has the signal's name and the unit of a sensor's output; "" where there is none."""
    for column in free:
        from_sensor = column.unit in ("V", "mV", "%") or column.unit in COUNTS
        misfits = column.fits(SIGNALS[signal].si_units) is False
        per = column.unit if from_sensor and misfits and _is_called(column, signal) else _counted(column, signal)
        if per:
            scale = shell_word(f"{signal}=NUMBER {SIGNALS[signal].si_units[0] or '1'}/{per}")
            return f"--{signal} {shell_word(column.name)} --scale {scale}"
    return ""


def _counted(column: SeenColumn, signal: str) -> str:
    """The word for counts at the end of a name that speaks for the signal (``pos_counts``); "" for other names."""
    front, _, last = column.name.rpartition("_")
    counted = front and not column.unit and last.lower() in COUNTS
    return last.lower() if counted and len(spoken_name(front).forms[signal] or "") > 1 else ""


def _likely_label(seen: SeenColumns, column: SeenColumn, signal: str) -> str:
    """The column with its unit, or with a likely one."""
    if column.spoken.end and not column.unit:
        return column.name
    if signal == "field" and column.spoken.plain == "v":
        likely = "V"
    elif signal in _EXAMPLES:
        likely = _EXAMPLES[signal].partition("[")[2].removesuffix("]")
    else:
        likely = SIGNALS[signal].si_units[0] or "-"
    return seen.table.label(column.name, likely)
