"""A command that answers all questions about a log at once is proposed: with columns that may be what is asked for."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import listed, shell_word
from erclutch.logs.columns import name_pattern
from erclutch.logs.columns.candidates import candidates, slips_in_percent
from erclutch.logs.columns.labels import is_given_by_place, split_label, without_copy_number
from erclutch.logs.columns.levels_in_names import CALLED_BY_LEVEL, are_at_fields
from erclutch.logs.columns.names import plain, spoken_name
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.two_courses import follows, go_straight
from erclutch.logs.columns.vocabulary import NAMES, NEED_UNIT, NOT_MEASURED, TOLD
from erclutch.logs.plan import Question
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.field_of_a_circuit import COILS, of_a_coil, one_of_a_circuit
from erclutch.logs.planning.field_of_words import levels_of_efforts, slip_and_effort
from erclutch.logs.planning.missing_columns import (
    has_short_name,
    not_measured,
    sensor_options,
    usual_unit,
    with_an_unreadable_unit,
    with_what_is_left_over,
)
from erclutch.logs.planning.missing_values import must_be_said
from erclutch.logs.planning.no_field import is_a_mark, maybe_field
from erclutch.logs.planning.points import IN_NO_ORDER
from erclutch.logs.planning.strength_of_efforts import strengths_of_efforts
from erclutch.logs.planning.two_ends import motion_between
from erclutch.logs.planning.units_in_options import with_unit_of_name
from erclutch.logs.table import MINUS
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS

_COMPONENT = re.compile(r"[fmtv][xyz]")
_NUMBER_BEHIND = re.compile(r"\d*$")
_NUMBER = re.compile(r"\d+")
#: What a number tells one of from another: none of them is switched to a level.
_NUMBERED = frozenset("cell id label trial specimen station well slot axis group run order".split())
#: What a column of 0 and 1 may say of a coil; a mark of anything else is no field.
_SWITCHES = frozenset(
    (
        "on off mode state switch enable enabled energized active power powered magnet coil "
        "clutch brake relay step level excited ein aus zustand schalter"
    ).split()
)
#: Words for an event: what it marks is switched by no supply, though a foot is called toe off.
_EVENTS = frozenset({"did", "toe", "heel", "strike", "stance", "gait", "contact"})
#: What the share is called that a supply, a valve or a brake is told.
_COMMANDS = frozenset({"cmd", "command", "duty", "pwm", "valve", "brake", "excitation", "control"})
_ESTIMATED = frozenset({"est", "estimate", "estimated"})
#: Words of what was told, and of a drive: such a column stands behind others that would do.
_NOT_FIRST = TOLD | _COMMANDS - {"brake"} | {"motor", "drive", "antrieb", "moteur"}
#: What a column is called whose zero or noise is still in it: such a column stands behind its like.
_RAW = frozenset({"raw", "roh", "brut", "crudo"})
#: Units of what is not in the file, where what is there turns.
_OF_TURNING = {"slip": "rpm", "position": "deg", "effort": "N*m"}
_USUAL = {
    "lead": '--lead "10 mm"',
    "input": '--input "COLUMN"',
    "temperature": '--temperature "COLUMN [°C]"',
}


def propose_answers(draft: Draft) -> None:
    """Give an option for each question, with what is likely or with a place to fill in; then what the rows need."""
    seen = draft.seen
    questions = draft.questions
    if not questions:
        return
    motions = _motions(draft)
    options: dict[str, str] = {}
    proposed: list[str] = []  # the columns in these options, and their labels

    # The field comes last, since a log may have none: it gets no column that another question needs more.
    for signal in sorted(questions, key=lambda signal: signal == "field"):
        question = questions[signal]
        others = [*draft.taken, *proposed]
        if question.option:
            option = question.option
        elif signal == "field":
            has_a_place = any("COLUMN" in each for each in options.values())
            option = _field_option(draft, question, proposed, may_be_none=not has_a_place)
        elif len(question.answers) == 1:
            (option,) = question.answers
        elif signal == "time":
            option = _clock_option(draft, others)
        elif signal in _USUAL:
            option = _USUAL[signal]
        else:
            efforts = _efforts(draft, others) if signal in ("slip", "position") else []
            option = _column_option(seen, signal, others, [*motions, *proposed], efforts)
            if signal == "effort":
                questions[signal] = with_what_is_left_over(question, option, seen)
        is_open = draft.supply is None and ("COLUMN" in option or "none" in option)
        if signal == "field" and is_open:
            pattern = name_pattern.proposed(Path(seen.table.path).name)
            if pattern:
                option = f"--name-pattern {shlex.quote(pattern)}"
        options[signal] = option = with_unit_of_name(seen, option)
        if signal != "time" or option.startswith("--time"):
            label = shlex.split(option)[1]
            name, _ = split_label(label)
            proposed += [label, name, *name.split(MINUS)]  # of a difference both its columns

    examples = [options[signal] for signal in questions]
    in_no_order = draft.clock is not None and draft.clock.reason.endswith(IN_NO_ORDER)
    if in_no_order and any("--variable" in each for each in examples):
        examples.append("--time none")  # the rows of one part may be too few to tell it
    if draft.told.invalid != "drop" and "invalid" not in questions:
        needed = [*draft.taken, *(name for name in proposed if name in seen.columns)]
        if must_be_said(seen, needed):
            examples.append("--invalid drop")
    draft.examples = examples


def _motions(draft: Draft) -> list[str]:
    """Columns of the motion, as far as it is known."""
    return [each.column for signal, each in draft.signals.items() if signal in ("slip", "position")]


def _efforts(draft: Draft, others: Sequence[str]) -> list[str]:
    """The column of the effort, where it is known; those that may be it, where it is asked about."""
    if "effort" in draft.questions:
        return candidates(draft.seen, "effort", others)[0]
    effort = draft.signals.get("effort")
    return [effort.column] if effort is not None and effort.column in draft.seen.columns else []


def _field_option(
    draft: Draft, question: Question, proposed: Sequence[str], *, may_be_none: bool
) -> str:
    """The option for a field that was not found: a column that may be it, or none.

    Args:
        draft: the plan so far.
        question: about the field.
        proposed: columns that are proposed for other signals, and their labels.
        may_be_none: whether none of the other options has a place to fill in, which the field may be needed for.
    """
    seen = draft.seen
    taken = [*draft.taken, *proposed]
    # One for each joint, as the efforts are: these are of the joints' drives.
    fields, _ = candidates(seen, "field", taken)
    efforts, _ = candidates(seen, "effort", ())
    joints_of_fields = {_joint_of(name) for name in fields}
    joints_of_efforts = {_joint_of(name) for name in efforts}
    if len(joints_of_fields) > 1 and joints_of_fields == joints_of_efforts:
        return "--field none"

    # Each of several currents goes straight with the effort, and none keeps levels: those of machines.
    effort = draft.signals.get("effort")
    were_set = any(seen.columns[name].shape.keeps_levels for name in fields)
    if len(fields) > 1 and not were_set and effort is not None and effort.column in seen.columns:
        measured = seen.columns[effort.column].values
        if all(go_straight(seen.columns[name].values, measured) for name in fields):
            return f"--field {of_a_coil(seen, fields) or 'none'}"
    # What drives a coil's current, and the current of a drive, are not proposed.
    if len(fields) > 1:
        left = one_of_a_circuit(seen, fields, efforts)
        taken += [name for name in fields if left and name not in left]

    # A column with a name of several meanings may be the field, and is proposed for no other signal.
    _, _, named = question.problem.partition("; ")
    column_of_question, may_be_it, _ = named.partition(" may be it")
    is_open = bool(may_be_it) and column_of_question not in proposed
    if is_open or not may_be_none or "--field none" not in question.remedy:
        return _column_option(seen, "field", taken, [*_motions(draft), *proposed], [])

    # No name tells the field: it is a share that a valve or a supply is told, a column that keeps a few levels, or one
    # with a word for a field; or there is none.
    commands: list[str] = []
    leveled: list[str] = []
    worded: list[str] = []
    lettered: list[str] = []
    open_ones: dict[str, Array] = {}
    # What is numbered as a motion or an effort is (vela5 beside vela2) is that of another joint.
    numbered = {_NUMBER.sub("#", each.column) for each in draft.signals.values() if each.column}
    numbered |= {_NUMBER.sub("#", name) for name in proposed}
    of_joints = [name for name in seen.columns if _NUMBER.sub("#", name) in numbered]
    for column in maybe_field(seen, [*taken, *of_joints]):
        words = column.spoken.stem_words
        if not is_given_by_place(column.name):
            open_ones[column.name] = column.values
        if column.written_unit == "%" and not (_COMMANDS | {"load"}).isdisjoint(words):
            commands.append(column.name)
        is_an_event = not _EVENTS.isdisjoint(words)
        marks_something = is_a_mark(column) and (is_an_event or _SWITCHES.isdisjoint(words))
        # T is a time or a temperature: a short name of several meanings, none of which is a field.
        means_no_field = (
            column.spoken.plain in NEED_UNIT and column.spoken.plain not in NAMES["field"].split()
        )
        # Numbers that stand beside a table, without a name, were copied there.
        means_no_field |= is_given_by_place(column.name)
        # The angle of another joint (q2) may rest at a few levels too.
        means_no_field |= bool(column.spoken.may_be) and "field" not in column.spoken.may_be
        is_level = column.shape.keeps_levels and _NUMBERED.isdisjoint(words)
        if is_level and not marks_something and not means_no_field:
            leveled.append(column.name)
        if "field" in column.spoken.within:
            worded.append(column.name)
        if "field" in column.spoken.lettered:
            lettered.append(column.name)
    # Of several devices in one table (v1, F1, I1, v2, F2, I2) each has its own.
    joints = {_joint_of(name) for name in proposed if name in efforts}
    if len(leveled) > 1:
        leveled = [name for name in leveled if _joint_of(name) in joints - {""}]
    likely = next((each for each in (commands, leveled) if len(each) == 1), worded or lettered)
    likely = likely or levels_of_efforts(draft, [*taken, *of_joints])
    slip, effort_beside = slip_and_effort(draft)
    if not likely and slip is not None and effort_beside is not None:
        likely = strengths_of_efforts(open_ones, slip, effort_beside)
        because = f"; at the same slip the effort is larger where {listed(likely)} is"
        draft.questions["field"] = question.adding(because) if likely else question
    if not likely:
        return "--field none"
    return f"--field {shell_word(seen.table.label(likely[0]))}"


def _joint_of(name: str) -> str:
    """The number at the end of a name, which tells a joint; "" for none."""
    number = _NUMBER_BEHIND.search(name)
    return number[0] if number else ""


def _clock_option(draft: Draft, others: Sequence[str]) -> str:
    """The option for a clock that was not found: a column that may be it, points, or a place to fill in."""
    seen = draft.seen
    questions = draft.questions
    for column in seen.without(others):
        if column.spoken.plain != "t":
            continue
        # Seconds of a log go on by equal steps below 1; a torque T, counts and ms do not.
        steps = np.diff(column.values)
        usual = float(np.median(steps)) if steps.size else 0.0
        if 0.0 < usual < 1.0 and np.all(steps > 0.0) and np.ptp(steps) <= usual:
            return f"--time {shell_word(f'{column.name} [s]')}"
    has_speed = "slip" in draft.signals
    if "slip" in questions and not has_speed:
        speeds, _ = candidates(seen, "slip", ())
        has_speed = len(speeds) > 1 or any(
            has_short_name(column, "slip") for column in seen.without(others)
        )
    if has_speed:
        return "--time none"  # a law without memory needs no clock where the speed is logged; a position needs it

    # Cycles and other quantities rise too, and are no time by their name or unit.
    free = seen.without(others)
    if "slip" in questions and not free:
        return "--time none"  # nothing that moves: points at rest, whose slip stands elsewhere
    may_rise = False
    for column in free:
        is_open = column.fits(("s",)) is not False and not column.spoken.is_accounted
        is_a_count = column.shape.counts_rows or column.shape.keeps_levels
        if is_open and column.shape.rises and not is_a_count:
            may_rise = True
    # A time never falls: where no open column does so, none of them is the time.
    return '--time "COLUMN [s]"' if free and may_rise else '--rate "RATE Hz"'


def _column_option(
    seen: SeenColumns,
    signal: str,
    taken: Sequence[str],
    beside: Sequence[str],
    partners: Sequence[str],
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
    named, _ = candidates(seen, signal, taken)
    unreadable = "" if named else with_an_unreadable_unit(free, signal)
    in_other_words = f"--{signal} {shell_word(unreadable)}" if unreadable else ""
    of_a_sensor = sensor_options(free, signal) or in_other_words
    if of_a_sensor and len(named) < 2:  # the load of a bus in % is none of several torques
        return of_a_sensor

    if signal == "effort" and are_at_fields(named):
        return "--variable all"  # each is a log at its field
    likely = named or _less_likely(free, signal)
    # What never changes is none of several: a joint that rests, an axis that nothing moves along.
    likely = [name for name in likely if not seen.columns[name].shape.constant] or likely
    if signal == "slip":
        # A letter that keeps levels and has one sign is a field that was switched; the motion is a position then.
        likely = [name for name in likely if name in named or not _is_switched(seen.columns[name])]
        position = _position_instead(seen, taken, likely, partners)
        if position:
            return f"--position {shell_word(seen.table.label(position))}"
    nameless = [column for column in free if is_given_by_place(column.name)]
    left_over = nameless if len(nameless) == 1 else free
    if not likely and signal == "effort" and len(left_over) == 1:
        # The column that is left over, where neither its name nor its unit tells what it is.
        (last,) = left_over
        spoken = last.spoken
        is_named = spoken.may_be or spoken.within or spoken.is_accounted or spoken.says(_NOT_FIRST)
        is_something = last.unit or is_named or not_measured(last, "effort")
        likely = [] if is_something else [last.name]
    if not likely:
        beside_it = partners if signal == "slip" else [*beside[:1]]
        turns = {seen.columns[name].kind for name in beside_it if name in seen.columns} == {"N*m"}
        unit = _OF_TURNING.get(signal) if turns else usual_unit(signal)
        hole = f"COLUMN [{unit or '-'}]"
        return f"--{signal} {shell_word(hole)}"

    # Behind the names of joints: elbow.velocity.
    ends = {re.split(r"[./]", name)[-1] for name in likely}
    share_one_name = len(ends) == 1 and ends.isdisjoint(likely)
    parts_beside: set[str] = set()  # of the names of columns that are known
    for name in beside:
        parts_beside |= _parts(spoken_name(name).stem)
    motion = seen.columns.get(beside[0]) if signal == "effort" and beside else None

    def speaks_against(name: str) -> list[Any]:
        """What speaks against a column, the weightiest first."""
        column = seen.columns[name]
        parts = _parts(name)
        against: list[Any] = []
        if signal == "field":
            against.append(not column.spoken.says(COILS))
        if partners:
            # How far a motion is from an effort: of another kind, then by the parts of the names that both share.
            apart: list[tuple[bool, int]] = []
            for partner in partners:
                is_of_one_kind = bool(column.kind) and column.kind == seen.columns[partner].kind
                apart.append((not is_of_one_kind, -len(parts & _parts(partner))))
            against.append(min(apart))
        if motion is not None:
            # The torque of another joint may follow the motion better than its own, under a weight.
            numbers = {part for part in _parts(motion.name) if part.isdecimal()}
            against.append(numbers.isdisjoint(parts))
            # Of six components that of the motion's kind which goes along with it is likely.
            is_of_its_kind = column.kind == motion.kind
            goes_along = is_of_its_kind and follows(column.values, motion.values)
            against += [not goes_along, not is_of_its_kind]
            if is_of_its_kind and _COMPONENT.fullmatch(column.spoken.plain):
                against.append(-column.moved)  # the others are what the sensor takes up by the way
        # Most words and numbers in the names of one joint's columns are the same.
        against.append(-len(parts_beside & parts))
        if signal in ("slip", "position") and share_one_name:
            against.append(-column.moved)
        against.append(column.spoken.says(_RAW))
        against.append(column.spoken.says(_NOT_FIRST) and name not in seen.table.made)
        return against

    # A unit that nobody wrote is no answer: a column without one is taken as logged.
    likeliest = seen.table.label(min(likely, key=speaks_against))
    return f"--{signal} {shell_word(motion_between(seen, likely, partners) or likeliest)}"


def _is_switched(column: SeenColumn) -> bool:
    """Whether the numbers of a column keep levels of one sign."""
    return column.shape.keeps_levels and not takes_both_signs(column.values)


def _position_instead(
    seen: SeenColumns, taken: Sequence[str], slips: Sequence[str], efforts: Sequence[str]
) -> str:
    """A position that may be meant rather than any of some speeds; "" where none is.

    It is the only motion, or that of the joint that the first effort has the number of, which no speed has.
    """
    positions, _ = candidates(seen, "position", taken)
    positions = positions or _less_likely(seen.without(taken), "position")
    if not slips:
        # The axes along which something moves under a force of their own: z beside F_z.
        moved: dict[str, str] = {}
        for column in seen.without(taken):
            if not column.shape.constant:
                moved[column.spoken.plain] = column.name
        forces = [name for name in moved if _COMPONENT.fullmatch(name) and name[0] == "f"]
        along = [moved[name[1]] for name in forces if name[1] in moved]
        if along:
            return along[0] if len(along) == 1 else ""
        moving: list[str] = []
        for name in positions:
            shape = seen.columns[name].shape
            returns = (
                not shape.rises and not shape.constant and not _is_switched(seen.columns[name])
            )
            is_short = has_short_name(seen.columns[name], "position")
            if returns and is_short and plain(name) != "y":  # an output, of anything
                moving.append(name)
        return moving[0] if len(moving) == 1 else ""
    numbers = {part for effort in efforts[:1] for part in _parts(effort) if part.isdecimal()}
    if not numbers or any(numbers & _parts(name) for name in slips):
        return ""
    return next((name for name in positions if numbers & _parts(name)), "")


def _less_likely(free: Sequence[SeenColumn], signal: str) -> list[str]:
    """Columns that a short name, a word in it or a letter in front of it proposes for a signal: the likelier kind."""
    short: list[str] = []
    within: list[str] = []
    lettered: list[str] = []
    in_one_meaning: list[str] = []
    estimated: list[str] = []
    shares = slips_in_percent(free) if signal == "slip" else []
    for column in free:
        spoken = column.spoken
        if column.fits(SIGNALS[signal].si_units) is False or column.name in shares:
            continue
        if signal == "effort" and not_measured(column, signal):
            continue
        is_numbered = signal in spoken.numbered and spoken.bare_stem in NEED_UNIT
        if has_short_name(column, signal) or is_numbered:
            short.append(column.name)
        if signal in spoken.within:
            within.append(column.name)
        # ``v Dyno`` may be a speed: a short name of the signal with a word behind.
        letter, *words_behind = spoken.stem_words or ("",)
        is_short = letter in NEED_UNIT or len(letter) == 1
        is_lettered = bool(words_behind) and is_short and letter in NAMES[signal].split()
        if is_lettered and not spoken.is_accounted:
            lettered.append(column.name)
            if letter not in NEED_UNIT:
                in_one_meaning.append(column.name)
        # What the observer of a drive makes of its encoder is called an estimate.
        words = {*spoken.stem_words}
        is_estimated = bool(words & _ESTIMATED) and not words & (NOT_MEASURED - _ESTIMATED)
        is_a_motion = signal in ("slip", "position") and bool(words & {*NAMES[signal].split()})
        if is_estimated and is_a_motion:
            estimated.append(column.name)
    called_by_level = [each.name for each in free if each.name == CALLED_BY_LEVEL]
    left_over = called_by_level if signal == "effort" else []
    return short or within or in_one_meaning or lettered or estimated or left_over


def _parts(name: str) -> set[str]:
    """Words and numbers of a name, and the direction of a component: x of ``Fx``."""
    parts = {*re.findall(r"\d+|[^\W\d_]+", without_copy_number(name).lower())}
    return parts | {part[1] for part in parts if _COMPONENT.fullmatch(part)}
