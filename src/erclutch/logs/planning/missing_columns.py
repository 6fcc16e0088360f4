"""What is said of a signal that no column was found for: what is missing, and an option that answers it."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable

import numpy as np

from erclutch.errors import MissingColumnError, shell_word
from erclutch.logs.columns.candidates import slips_in_percent
from erclutch.logs.columns.labels import COUNTS
from erclutch.logs.columns.names import plain, spoken_name
from erclutch.logs.columns.quotients import pressing_loads
from erclutch.logs.columns.rated_torque import share_of_rated_torque
from erclutch.logs.columns.seen_columns import UNITS_OF_KIND, SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import reads_about_a_zero
from erclutch.logs.columns.two_courses import is_rate_of
from erclutch.logs.columns.vocabulary import MEASURED, NAMES, NEED_UNIT, NOT_MEASURED, TOLD
from erclutch.logs.plan import Question
from erclutch.signals.recording import SIGNALS
from erclutch.signals.units import fits, in_other_words, is_unit

#: Words for counts at the end of a name; a step there may be one of a test.
_COUNTED = ("count", "counts", "tick", "ticks")
#: Words for the numbers of a converter or an encoder, which are counts in a scale.
_RAW = ("raw", "adc", "pulse", "pulses", "impulse", "impulses", "inc", "increments", "inkremente")
#: The speed of a motor's field, which is that of its shaft times the pairs of poles.
ELECTRICAL = ("erpm", "electricalrpm", "rpmelectrical")
#: Of a scale or load cell that shows a mass: the force that pulls at it. A pound is read as a force already.
_WEIGHTS = {"g": "gf", "kg": "kgf", "Kg": "kgf", "KG": "kgf", "grams": "gf"}
_SCALES = frozenset({"weight", "loadcellweight", "gewicht", "poids", "peso"})
#: What a sensor is called whose output is logged as it is.
_SENSORS = {
    "position": frozenset({"lvdt", "potentiometer", "poti", "pot", "laser", "linearencoder"}),
    "slip": frozenset({"tacho", "tachometer", "tachogenerator", "dynamo"}),
    "effort": frozenset(
        {
            "loadcell",
            "hx711",
            "straingauge",
            "straingage",
            "dms",
            "forcesensor",
            "torquesensor",
            "kraftmessdose",
        }
    ),
}
_AXES = frozenset("xyz")
#: Letters for a height, a depth or a length.
_LENGTHS = frozenset({*"hdzl", "delta", "δ"})
_COUNTS_A_SECOND = re.compile(
    r"(?:count|ct|cnt|tick|pulse|step|inc|increment|imp|impulse|inkrement)s?e?(?:/| per )s(?:ec)?",
    re.IGNORECASE,
)
#: Units of what a sensor gives, besides volts and amperes.
_OUTPUTS = ("%", *COUNTS)
_FRACTION_IN_BRACKETS = re.compile(
    r"(?P<name>[^(]{1,60}?)\s*\((?P<unit>[^()/\s]{1,20}/[^()/\s]{1,20})\)"
)
_SPEEDS_WITHOUT_A_STROKE = ("rads", "degs", "ms", "mms", "cms")
#: How a signal's column may be written, where nothing in the log looks like it.
EXAMPLES = {
    "field": "I [A]",
    "slip": "V [cm/s]",
    "position": "D [mm]",
    "effort": "F [N]",
    "T": "torque [N*m]",
}


def missing(
    seen: SeenColumns, signal: str, taken: Iterable[str], alternatives: str = ""
) -> MissingColumnError:
    """The error for a signal that no column was found for.

    Args:
        seen: the columns of the log.
        signal: its name.
        taken: columns that are something else.
        alternatives: how the message calls it, where other signals would do as well.
    """
    free = seen.without(taken)
    si_units = SIGNALS[signal].si_units
    example = EXAMPLES.get(signal, f"NAME [{si_units[0] or '-'}]")
    doubt = ""

    short = _short_named(seen, free, signal)
    if short is not None:
        is_v = short.spoken.plain == "v"
        meaning = " (voltage or velocity)" if is_v else ""
        doubt = f"; {short.name} may be it, but its name alone can mean several things{meaning}"
        likely = "V" if signal == "field" and is_v else usual_unit(signal) or "-"
        example = short.name if short.spoken.end else seen.table.label(short.name, likely)

    remedy = f"Give it with its unit, such as --{signal} {shell_word(example)}"
    if signal == "field":
        remedy += ", or --constant 'field=0.5 A' if it is the same all through the log, or --field none if not logged"
    answers: list[str] = []
    instead = _position_options(free) if signal == "slip" else ""
    if instead:
        remedy = f"Give a speed, or the position that it is the rate of: {instead}"
        answers = [instead]
    # Volts, amperes, % and counts may be of the sensor of an effort.
    outputs = [each for each in free if each.fits(("V", "A")) or each.written_unit in _OUTPUTS]
    fitting = [each for each in free if each.fits(si_units) is not False]
    if signal == "effort" and not fitting and not outputs:
        # No option can be right. Of a rotor that coasts the torque can be had all the same.
        remedy = (
            "No other column can be a force or a torque: log it. Where a rotor coasts down, the torque is its moment "
            "of inertia times the rate at which its speed falls: write it into a column of its own"
        )
    of_a_sensor = sensor_options(free, signal)
    if of_a_sensor:
        remedy = f"Give what its sensor means, such as {of_a_sensor}"
        answers = []
    doubt += _said_of_shares(free, signal)

    misfits = [column for column in free if column.unit and column.fits(si_units) is False]
    refused = next((column for column in misfits if _is_called(column, signal)), None)
    unreadable = "" if of_a_sensor else with_an_unreadable_unit(free, signal)
    if unreadable:
        doubt += "; a column is called so, but erclutch does not know its unit"
        remedy = f"Give the unit in other words: --{signal} {shell_word(unreadable)}"
        answers = []
    elif refused is not None:
        doubt += f"; column {refused.name} is called so, but its unit {refused.unit} does not fit"
        a_second = _a_second(refused.unit or "") if signal == "slip" else ""
        if a_second:
            answers = [f"--slip {shell_word(f'{refused.name} [{a_second}]')}"]
            remedy = f"If it is a speed, give its unit: {answers[0]}"
    presses = pressing_loads(seen, signal)
    if presses:
        doubt += (
            f"; column {presses[0]} is a load beside a coefficient of friction: their product "
            "rubs, the load presses"
        )
    if signal != "field":
        for column in called_and_not_measured(free, signal):
            doubt += f"; column {column.name} was not measured, by its name"
            say_so = f"--{signal} {shell_word(seen.table.label(column.name))}"
            remedy = (
                f"Log the measured {signal}; or, if that column was measured after all: {say_so}"
            )
            answers = []
    for name in seen.empty:
        form = spoken_name(name).forms[signal] or ""
        if len(form) > 2:
            doubt += f"; column {name} is called so, but holds no number in any row"
            break
    problem = f"no column for {alternatives or signal}{doubt}; the file has: {seen.table.listed}"
    return MissingColumnError(problem, remedy=remedy, answers=answers)


def with_what_is_left_over(question: Question, option: str, seen: SeenColumns) -> Question:
    """A question about an effort whose option names a column that nothing speaks for, with a word of that column."""
    _, *labels = shlex.split(option)
    name = labels[0] if labels else ""
    is_missing = question.short.startswith(
        "no column for "
    )  # a name given wrongly is answered elsewhere
    if not is_missing or name not in seen.columns or name in question.short:
        return question
    more = f"; {name} may be it, as the column that is left over: give another answer if it is no force or torque"
    return question.adding(more)


def _position_options(free: Iterable[SeenColumn]) -> str:
    """An option for a column of lengths or angles that moves, else of a sensor for one; "" where there is none."""
    for column in free:
        is_travel = column.fits(SIGNALS["position"].si_units) and not column.is_called_time
        if is_travel and not column.shape.constant:
            return f"--position {shell_word(column.name)}"
    # Columns called by an axis and a word for measuring (``z_meas``) that go and return: the only one.
    along_an_axis: list[str] = []
    for column in free:
        axis, *others = column.spoken.stem_words or ("",)
        is_measured = axis in _AXES and bool(others) and MEASURED.issuperset(others)
        returns = not column.shape.rises and not column.shape.constant
        if is_measured and returns and not column.written_unit:
            along_an_axis.append(column.name)
    if len(along_an_axis) == 1:
        return f"--position {shell_word(along_an_axis[0])}"
    # Of an effort, a time and one more column that is called by a letter for a length: ``F, h, t``.
    others = [column for column in free if "effort" not in column.spoken.may_be]
    lettered = [column for column in others if column.spoken.plain in _LENGTHS]
    if len(others) == len(lettered) == 1 and not lettered[0].written_unit:
        (left_over,) = lettered
        if not left_over.shape.constant:
            return f"--position {shell_word(left_over.name)}"
    of_a_sensor = sensor_options(free, "position")
    for column in free:
        is_counted = column.spoken.plain in (*_COUNTED, *_RAW) and not column.unit
        counts_rows = bool(np.all(np.diff(column.values) == 1.0))
        if not of_a_sensor and is_counted and not column.shape.constant and not counts_rows:
            scale = shell_word("position=NUMBER rad/count")
            return f"--position {shell_word(column.name)} --scale {scale}"
    return of_a_sensor


def _said_of_shares(free: Iterable[SeenColumn], signal: str) -> str:
    """What is said of the first effort that is a share of a rated torque, or of a slip in per cent; "" for none."""
    for column in free if signal == "effort" else ():
        share = share_of_rated_torque(column)
        if share is not None:
            return f"; a 1 in column {column.name} is {share.words}"
    for name in slips_in_percent(free) if signal == "slip" else ():
        say_so = shell_word(f"{name} [rad/s]")
        return f"; column {name} is a share in per cent (--slip {say_so} if it is a speed)"
    return ""


def _short_named(seen: SeenColumns, free: Iterable[SeenColumn], signal: str) -> SeenColumn | None:
    """The first column without a unit that a short name may call the signal; a v that is a rate is no voltage."""
    for column in free:
        if column.unit or not has_short_name(column, signal):
            continue
        if signal == "field":
            others = [other for other in seen.columns.values() if other.name != column.name]
            if any(is_rate_of(column.values, other.values, seen.stamps) for other in others):
                continue
        return column
    return None


def _a_second(unit: str) -> str:
    """The unit of a speed that the unit of an angle or a length lacks a stroke for: ``rads``, ``deg``, ``ms``."""
    if unit in _SPEEDS_WITHOUT_A_STROKE:
        return f"{unit.removesuffix('s')}/s"
    return f"{unit}/s" if is_unit(unit) and fits(unit, ("rad", "m")) is not None else ""


def with_an_unreadable_unit(free: Iterable[SeenColumn], signal: str) -> str:
    """The first column called like a signal whose unit nobody can read, with a unit to be given; "" where none is.

    In round brackets a fraction is such a unit, ``Hız (dev/dak)``: a remark has no line of a fraction.
    """
    for column in free:
        in_brackets = _FRACTION_IN_BRACKETS.fullmatch(column.name)
        if column.unit and not is_unit(column.unit) and _is_called(column, signal):
            return f"{column.name} [{in_other_words(column.unit)}]"
        if in_brackets and len(spoken_name(in_brackets["name"]).forms[signal] or "") > 2:
            return f"{column.name} [{in_other_words(in_brackets['unit'])}]"
    return ""


def called_and_not_measured(free: Iterable[SeenColumn], signal: str) -> list[SeenColumn]:
    """Columns that a word calls the signal and that were told, computed or modelled by another word."""
    columns: list[SeenColumn] = []
    for column in free:
        # A letter speaks for a signal in front of other words only: F_pred.
        first, *others = column.spoken.stem_words or ("",)
        words = [first, *(word for word in others if len(word) > 2)]
        speaks = any(spoken_name(word).forms[signal] for word in words)
        speaks = speaks and not (signal == "effort" and share_of_rated_torque(column))
        if speaks and not_measured(column, signal):
            columns.append(column)
    return columns


def not_measured(column: SeenColumn, signal: str) -> bool:
    """Whether a name says of a motion or an effort that it was told, computed or modelled."""
    is_of_a_model = column.spoken.is_of_a_model and signal == "effort"
    return is_of_a_model or column.spoken.says(NOT_MEASURED | TOLD)


def has_short_name(column: SeenColumn, signal: str) -> bool:
    """Whether the name is a short one of the signal that can mean several things."""
    return column.spoken.plain in NEED_UNIT and column.spoken.plain in NAMES[signal].split()


def usual_unit(signal: str) -> str:
    """The unit that a signal is usually logged in."""
    if signal in EXAMPLES:
        _, _, unit = EXAMPLES[signal].partition("[")
        return unit.removesuffix("]")
    return SIGNALS[signal].si_units[0]


def sensor_options(free: Iterable[SeenColumn], signal: str) -> str:
    """Options for a column that has the signal's name and the unit of a sensor's output; "" where there is none.

    A force in grams is the weight that a load cell shows.
    """
    si_units = SIGNALS[signal].si_units
    for column in free:
        share = share_of_rated_torque(column) if signal == "effort" else None
        if share is not None:
            return share.option
        weight = _WEIGHTS.get(column.unit or column.spoken.end or "")
        # A scale or a load cell shows a weight that changes while it is pulled: ``Weight_g``.
        front, _, end = column.name.rpartition("_")
        called = column.spoken.plain_stem if column.unit else plain(front)
        shown = _WEIGHTS.get(column.unit or end)
        is_of_a_scale = (
            called in _SCALES | _SENSORS["effort"]
            and shown is not None
            and not column.shape.constant
        )
        if signal == "effort" and is_of_a_scale:
            return f"--effort {shell_word(f'{column.name} [{shown}]')}"
        if signal == "effort" and weight and _is_called(column, signal):
            if column.spoken.end:  # a unit that ends a name is none to be given another
                scale = shell_word(f"effort=1 {weight}/{column.spoken.end}")
                return f"--effort {shell_word(column.name)} --scale {scale}"
            return f"--effort {shell_word(f'{column.name} [{weight}]')}"
        if signal == "slip" and column.spoken.plain in ELECTRICAL:
            return f"--slip {shell_word(column.name)} --scale {shell_word('slip=NUMBER rpm/count')}"
        written = column.written_unit
        is_headed = len(column.spoken.heads.get(signal) or "") > 2  # CH2 Force
        if signal == "slip" and written == "Hz" and (is_headed or _is_called(column, signal)):
            if column.spoken.end:
                scale = shell_word("slip=1 turn/s/Hz")
                return f"--slip {shell_word(column.name)} --scale {scale}"
            return f"--slip {shell_word(f'{column.name} [turn/s]')}"
        is_rate_of_counts = signal == "slip" and _COUNTS_A_SECOND.fullmatch(written or "")
        if is_rate_of_counts and _is_called(column, signal):
            label = shell_word(f"{column.name} [count]")
            return f"--slip {label} --scale {shell_word('slip=NUMBER rad/s/count')}"
        from_sensor = written in ("V", "mV", "%") or written in COUNTS
        is_called_so = is_headed or _is_called(column, signal)
        unit_of_sensor = _counted(column, signal)
        if from_sensor and is_called_so and column.fits(si_units) is False:
            unit_of_sensor = written
        if unit_of_sensor:
            measured = next(
                (unit for unit in UNITS_OF_KIND.get(column.kind_by_name, ()) if unit in si_units),
                si_units[0],
            )
            scale = shell_word(f"{signal}=NUMBER {measured or '1'}/{unit_of_sensor}")
            option = f"--{signal} {shell_word(column.name)} --scale {scale}"
            reads_counts = unit_of_sensor in COUNTS and signal == "effort"
            if reads_counts and reads_about_a_zero(column.values, is_of_a_converter=True):
                option += f" --zero {shell_word(f'{signal}=NUMBER')}"
            return option
    return ""


def _counted(column: SeenColumn, signal: str) -> str:
    """The word for counts at the end of a name that speaks for the signal (``pos_counts``); "" for other names.

    In a scale the pulses of an encoder and the numbers of a converter are counts.
    """
    front, _, last = column.name.rpartition("_")
    word = last.lower()
    if not front or column.unit or word not in (*_COUNTED, *_RAW):
        return ""
    said = spoken_name(front)
    is_called = len(said.forms[signal] or "") > 1 or said.plain_stem in _SENSORS.get(signal, ())
    if not is_called:
        return ""
    return "count" if word in _RAW else word


def _is_called(column: SeenColumn, signal: str) -> bool:
    """Whether the whole name speaks for the signal, or is that of a sensor for it."""
    is_of_a_sensor = column.spoken.plain_stem in _SENSORS.get(signal, ())
    return is_of_a_sensor or len(column.spoken.forms[signal] or "") > 2
