"""A command that answers all questions about a log at once is proposed: with columns that may be what is asked for."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from erclutch.errors import shell_word
from erclutch.logs.columns import name_pattern
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.names import NAMES, NEED_UNIT, spoken_name
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.plan import Question, SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.missing_columns import has_short_name, sensor_options, usual_unit
from erclutch.logs.planning.no_field import is_a_mark, maybe_field
from erclutch.logs.planning.row_order import must_be_said
from erclutch.logs.planning.stated_field import differ_by_field
from erclutch.signals.recording import SIGNALS

#: What a number tells one of from another: none of them is switched to a level.
_NUMBERED = frozenset(("cell", "id", "label", "trial", "specimen", "station", "well", "slot", "axis", "group", "run"))
#: What a column of 0 and 1 may say of a coil; a mark of anything else is no field.
_SWITCHES = frozenset(
    (
        *("on", "off", "mode", "state", "switch", "enable", "enabled", "energized", "active", "power", "powered"),
        *(
            "magnet",
            "coil",
            "clutch",
            "brake",
            "relay",
            "step",
            "level",
            "excited",
            "ein",
            "aus",
            "zustand",
            "schalter",
        ),
    )
)
#: What the share is called that a supply, a valve or a brake is told.
_COMMANDS = frozenset({"cmd", "command", "duty", "pwm", "valve", "brake", "excitation", "control"})
_USUAL = {"lead": '--lead "10 mm"', "input": '--input "COLUMN"', "temperature": '--temperature "COLUMN [°C]"'}


def proposals(draft: Draft) -> list[str]:
    """An option for each question: with what is most likely, or with a place to fill in; then what the rows need."""
    seen = draft.seen
    taken = draft.taken
    signals = draft.signals
    questions = draft.questions
    motions = [each.column for signal, each in signals.items() if signal in ("slip", "position")]
    options: dict[str, str] = {}
    proposed: list[str] = []  # the columns in these options, and their labels

    # The field comes last, since a log may have none: it gets no column that another question needs more.
    for signal, question in sorted(questions.items(), key=lambda item: item[0] == "field"):
        others = [*taken, *proposed]
        filled_in = not any("COLUMN" in option for option in options.values())
        may_be_unlogged = "--field none" in question.remedy and not _may_be_a_column(question, proposed)
        if question.option:
            option = question.option
        elif signal == "field" and _are_of_drives(seen, others):
            option = "--field none"
        elif signal == "field" and may_be_unlogged and filled_in:
            # No name tells the field: it is a column that keeps a few levels, or one with a word for a field, or none.
            leveled: list[str] = []
            worded = [column.name for column in maybe_field(seen, others) if "field" in column.spoken.within]
            for column in maybe_field(seen, others):
                is_level = column.shape.keeps_levels and _NUMBERED.isdisjoint(column.spoken.stem_words)
                if is_level and not _is_a_mark(column) and not _is_short_for_another(column):
                    leveled.append(column.name)
            commands = [column.name for column in maybe_field(seen, others) if _is_a_command(column)]
            likely = commands if len(commands) == 1 else leveled if len(leveled) == 1 else worded
            option = f"--field {shell_word(seen.table.label(likely[0])) if likely else 'none'}"
        elif signal == "time":
            option = _clock_option(seen, signals, questions, others)
        elif signal == "slip" and "--position" in question.remedy:
            _, _, position = question.remedy.partition("--position ")
            option = f"--position {position}"
        elif signal in _USUAL:
            option = _USUAL[signal]
        else:
            asks_for_both = signal in ("slip", "position") and "effort" in questions
            efforts = candidates(seen, "effort", others)[0] if asks_for_both else []
            option = _column_option(seen, signal, others, [*motions, *proposed], efforts)
        if signal == "field" and ("COLUMN" in option or "none" in option):
            pattern = name_pattern.proposed(Path(seen.table.path).name)
            if pattern:
                option = f"--name-pattern {shlex.quote(pattern)}"
        options[signal] = option
        if signal != "time" or option.startswith("--time"):
            label = shlex.split(option)[1]
            name_of, _ = split_label(label)
            proposed += [label, name_of]

    examples = [options[signal] for signal in questions]
    if draft.told.invalid != "drop":
        needed = [*taken, *(name for name in proposed if name in seen.columns)]
        if must_be_said(seen, needed):
            examples.append("--invalid drop")
    return examples


def _are_of_drives(seen: SeenColumns, taken: Sequence[str]) -> bool:
    """Whether the columns that may be the field are one for each joint, as the efforts are: those of its drives."""
    fields, _ = candidates(seen, "field", taken)
    efforts, _ = candidates(seen, "effort", ())
    of_fields = {re.sub(r".*?(\d*)$", r"\1", name) for name in fields}
    of_efforts = {re.sub(r".*?(\d*)$", r"\1", name) for name in efforts}
    return len(of_fields) > 1 and of_fields == of_efforts


def _is_a_mark(column: SeenColumn) -> bool:
    """Whether a column marks rows by 0 and 1, and no word of its name says that it switches something."""
    return is_a_mark(column) and _SWITCHES.isdisjoint(column.spoken.stem_words)


def _is_a_command(column: SeenColumn) -> bool:
    """Whether a column tells a valve or a supply what to do: it is called so and is a share."""
    return column.written_unit == "%" and not _COMMANDS.isdisjoint(column.spoken.stem_words)


def _is_short_for_another(column: SeenColumn) -> bool:
    """Whether the name is a short one that means several things, none of them a field: T is a time or a temperature."""
    return column.spoken.plain in NEED_UNIT and column.spoken.plain not in NAMES["field"].split()


def _may_be_a_column(question: Question, proposed: Sequence[str]) -> bool:
    """Whether a column with a name of several meanings may be the field, and is proposed for no other signal."""
    _, _, named = question.problem.partition("; ")
    column, may_be, _ = named.partition(" may be it")
    return bool(may_be) and column not in proposed


def _clock_option(
    seen: SeenColumns, signals: Mapping[str, SignalPlan], questions: Mapping[str, Question], others: Sequence[str]
) -> str:
    """The option for a clock that was not found: a column that the question names, a rate, or a place to fill in."""
    _, named, column = questions["time"].remedy.partition("--time ")
    if named and "NAME" not in column:
        return f"--time {column}"
    has_speed = "slip" in signals
    if "slip" in questions:
        speeds, _ = candidates(seen, "slip", ())
        short = any(has_short_name(column, "slip") for column in seen.without(others))
        has_speed = has_speed or len(speeds) > 1 or short
    if has_speed:
        return "--time none"  # a law without memory needs no clock where the speed is logged; a position needs it

    free = seen.without(others)
    # Cycles and other quantities rise too, and are no time by their name or unit.
    nameless = [column for column in free if column.fits(("s",)) is not False and not column.spoken.is_accounted]
    moving = not questions.keys() - {"time", "field"}  # else a column of the time may be among the open ones
    timeless = moving and not any(column.shape.rises and not column.shape.counts_rows for column in nameless)
    return '--rate "RATE Hz"' if timeless or not free else '--time "COLUMN [s]"'


def _column_option(
    seen: SeenColumns, signal: str, taken: Sequence[str], beside: Sequence[str], partners: Sequence[str]
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
    of_a_sensor = sensor_options(free, signal)
    if of_a_sensor:
        return of_a_sensor

    si_units = SIGNALS[signal].si_units
    fitting = [column for column in free if column.fits(si_units) is not False]
    short = [column.name for column in fitting if has_short_name(column, signal)]
    within = [column.name for column in fitting if signal in column.spoken.within]
    named, _ = candidates(seen, signal, taken)
    lettered = [column for column in fitting if _is_lettered(column, signal)]
    in_one_meaning = [column.name for column in lettered if column.spoken.stem_words[0] not in NEED_UNIT]
    if signal == "effort" and differ_by_field(named):
        return "--variable all"  # each is a log at its field
    likely = named or short or within or in_one_meaning or [column.name for column in lettered]
    if not likely:
        hole = f"COLUMN [{usual_unit(signal) or '-'}]"
        return f"--{signal} {shell_word(hole)}"

    # Of joints that stand in front of one name (elbow.velocity) the one that moves most is likely.
    ends = {re.split(r"[./]", name)[-1] for name in likely}
    if signal in ("slip", "position") and len(ends) == 1 and ends.isdisjoint(likely):
        likely = sorted(likely, key=lambda name: -seen.columns[name].moved)

    # First the columns of the joint that the other columns are of: most words and numbers of their names are the same.
    known: set[str] = set()
    for name in beside:
        known |= _parts(spoken_name(name).stem)
    likely = sorted(likely, key=lambda name: -len(known & _parts(name)))
    if partners:
        likely = sorted(likely, key=lambda name: min(_apart(seen, name, partner) for partner in partners))

    # A unit that nobody wrote is no answer: a column without one is taken as logged.
    return f"--{signal} {shell_word(seen.table.label(likely[0]))}"


def _is_lettered(column: SeenColumn, signal: str) -> bool:
    """Whether the name is a short one of the signal with a word behind: ``v Dyno`` may be a speed."""
    letter, *rest = column.spoken.stem_words or ("",)
    is_short = letter in NEED_UNIT or len(letter) == 1
    return bool(rest) and is_short and letter in NAMES[signal].split() and not column.spoken.is_accounted


def _parts(name: str) -> set[str]:
    """Words and numbers of a name."""
    return {*re.findall(r"\d+|[^\W\d_]+", name.lower())}


def _apart(seen: SeenColumns, motion: str, effort: str) -> tuple[bool, int]:
    """How far a motion is from an effort: of another kind, then by the parts of their names that they share."""
    kind = seen.columns[motion].kind
    other_kind = seen.columns[effort].kind
    return kind != other_kind or not kind, -len(_parts(motion) & _parts(effort))
