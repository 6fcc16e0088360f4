"""A guessed field may be something else of the bench: the user is asked, or the column is left out with a word.

It may be the output of a sensor, the current, the supply or the command of a drive, or the monitor of an amplifier: the
numbers tell, or a word of the name.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.machines_in_names import is_of_a_drive, is_of_a_machine
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.shapes import FEW, LOOKED_AT, takes_both_signs
from erclutch.logs.columns.two_courses import correlation_of, go_straight, goes_along
from erclutch.logs.columns.vocabulary import CURRENTS, NAMES, NOT_MEASURED, TOLD, VOLTAGES
from erclutch.logs.mapping import NONE
from erclutch.logs.plan import SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.guesses import OF_A_SUPPLY, faintness
from erclutch.logs.planning.missing_columns import missing
from erclutch.logs.planning.stated_scales import scales_stated
from erclutch.logs.planning.told_motions import has_a_told_motion
from erclutch.signals.array import Array

#: What is computed of a motor under test alone.
_OF_TESTS_OF_MOTORS = frozenset(
    {"efficiency", "wirkungsgrad", "rendement", "eficiencia", "esc", "throttle", "propeller"}
)
#: What a propeller gives; beside a voltage, for a thrust bearing has a thrust too.
_THRUSTS = frozenset({"thrust", "schub", "schubkraft", "poussee", "empuje", "spinta"})
#: Words of a coil that makes a field.
_OF_COILS = frozenset(
    {"coil", "spule", "spulenstrom", "brake", "bremse", "damper", "clutch", "magnet", "excitation"}
)
LARGEST_SUPPLY = 100.0  # V, or as logged, above which a voltage is that across a fluid
_COMMANDS = ("command", "cmd")
_SI_OF_A_SUPPLY = ("A", "V")
_A_COIL_OF_A_DEVICE = "the coil of a brake or damper"
#: Words in the name of a voltage that an amplifier shows of its output.
_MONITORS = frozenset(
    {"monitor", "mon", "vmon", "imon", "hv", "highvoltage", "hochspannung", "trek"}
)
_OUTPUT = 12.0  # V, of an amplifier's monitor at most
_GOES_WITH = 0.5  # correlation of a servo's current with the load that it tells
_NOISE_AT_REST = 0.05  # of the largest number
_CROSSINGS = 4  # of the middle of its range, by a motion to and fro


def leave_out_the_sensor_of_the_effort(draft: Draft) -> None:
    """Take a guessed voltage back that is too faint for a coil and goes straight with the effort: its sensor's output.

    A faint current may be what leaks through an electrorheological fluid, and tells the field.
    """
    field = _guessed_voltage(draft)
    effort = draft.signals.get("effort")
    if field is None or effort is None or not effort.column:
        return
    output = draft.table.columns[field.column]
    measured = draft.table.columns[effort.column]
    strongest = faintness(field, output)
    if strongest is None or not go_straight(output, measured):
        return
    # The same output may be logged in other units.
    for other in draft.seen.without([*draft.taken, field.column]):
        if other.fits(("V",)) and go_straight(other.values, output):
            draft.no_signals.append(other.name)
    course = f"never exceeds {strongest:.3g} and goes straight with {effort.column}"
    leave_out_field(draft, f"{course}: taken for the output of its sensor, left out")


def leave_out_the_number_of_a_motor(draft: Draft) -> None:
    """Take a guessed field back that is called like a drive's current and keeps one whole number: ``curr_motor`` is 2.

    A current of a drive goes with its torque, and others of the log change: the current motor is the second one.
    """
    field = draft.guessed("field")
    if field is None or field.si not in OF_A_SUPPLY:
        return
    column = draft.seen.columns[field.column]
    level = float(column.values[0]) if column.values.size else 0.5
    is_a_number = column.shape.constant and level.is_integer() and not column.written_unit
    if not is_a_number or not is_of_a_drive(column.spoken):
        return
    for other in draft.seen.without([*draft.taken, field.column]):
        is_a_current = other.fits(("A",)) and not CURRENTS.isdisjoint(other.spoken.stem_words)
        if is_a_current and not other.shape.constant:
            why = f"is {level:g} all through while {other.name} changes: taken for the number of a motor, left out"
            leave_out_field(draft, why)
            return


def doubt_the_current_of_a_drive(draft: Draft) -> None:
    """Doubt a guessed field with the sign and the course of the effort: the current of the motor that makes it."""
    field = draft.guessed("field")
    effort = draft.signals.get("effort")
    if field is None or field.si not in OF_A_SUPPLY:
        return
    seen = draft.seen.columns[field.column]
    if effort is None:
        if is_of_a_drive(seen.spoken) and takes_both_signs(seen.values):
            doubt = "which is called like the current of a drive and takes both signs"
            draft.doubt("field", f"{doubt}: {_unless_it_drives(_A_COIL_OF_A_DEVICE, field)}", NONE)
        return
    current = seen.values
    measured = draft.table.columns.get(effort.column)
    if measured is None:
        return
    if is_of_a_machine(seen.spoken):
        doubt = "which is called like the current of a machine that loads or is tested"
        answer = NONE if go_straight(current, measured) else ""
        draft.doubt("field", f"{doubt}: {_unless_it_drives(_A_COIL_OF_A_DEVICE, field)}", answer)
        return
    keeps_its_sign = not takes_both_signs(current) and not seen.shape.keeps_levels
    if keeps_its_sign and is_of_a_drive(seen.spoken) and go_straight(current, measured):
        doubt = f"which is called like that of a drive and goes straight with {effort.column}"
        draft.doubt("field", f"{doubt}: {_unless_it_drives(_A_COIL_OF_A_DEVICE, field)}", NONE)
        return
    is_told_to_move = takes_both_signs(current) and has_a_told_motion(draft.seen)
    # With it or against it: a field makes an effort as large either way.
    goes_with_it = abs(correlation_of(current, measured)) > _GOES_WITH
    if is_told_to_move and not goes_along(current, measured) and goes_with_it:
        doubt = f"which takes both signs and goes with {effort.column}, beside a motion that a drive was told"
        draft.doubt("field", f"{doubt}: {_unless_it_drives(_A_COIL_OF_A_DEVICE, field)}", NONE)
        return
    if not goes_along(current, measured):
        return
    course = f"takes the sign of {effort.column} and goes along with it"
    # Currents and voltages that are called like a field and keep their sign may drive a coil.
    coils: list[SeenColumn] = []
    for column in draft.seen.without(draft.taken):
        if "field" not in column.spoken.may_be or column.fits(_SI_OF_A_SUPPLY) is False:
            continue
        is_told = column.spoken.says(TOLD | NOT_MEASURED)
        keeps_a_level = column.shape.constant or column.is_steady
        if not is_told and not keeps_a_level and not takes_both_signs(column.values):
            coils.append(column)
    if len(coils) == 1:
        draft.take_back("field")
        why = f"guessed from its name, beside {field.column}, which {course} as that of a motor"
        draft.take("field", coils[0].name, coils[0].unit_for(_SI_OF_A_SUPPLY), 1.0, why, "likely")
        return
    if is_current_of_a_drive(seen, [measured]):
        leave_out_field(draft, f"{course}: taken for the current of the drive, left out")
        return
    _doubt_what_takes_the_sign_of_the_effort(draft, field, measured, course)


def _doubt_what_takes_the_sign_of_the_effort(
    draft: Draft, field: SignalPlan, measured: Array, course: str
) -> None:
    """Leave a guessed field out that surely makes or measures the effort, with whose sign it goes; else doubt it."""
    seen = draft.seen.columns[field.column]
    # Columns of one sign that are called like a field and are a share, as ``PWM brake [%]`` is.
    shares: list[str] = []
    for column in draft.seen.without(draft.taken):
        is_one = "field" in column.spoken.may_be and column.written_unit in (None, "%")
        if is_one and not column.shape.constant and not takes_both_signs(column.values):
            shares.append(column.name)
    told = shares[0] if len(shares) == 1 else ""
    label = shell_word(draft.table.label(field.column))
    # A fluid is as stiff in a field of either sign: what takes the sign of the effort makes or measures the effort.
    is_called_a_field = bool(seen.spoken.forms["field"]) or "field" in seen.spoken.within
    lowest = float(np.nanmin(seen.values))
    highest = float(np.nanmax(seen.values))
    swings = min(-lowest, highest) > _NOISE_AT_REST * max(-lowest, highest)  # about zero
    is_of_a_told_drive = has_a_told_motion(draft.seen) and not told and swings
    is_of_a_sensor = go_straight(seen.values, measured)
    if is_of_a_told_drive if is_called_a_field else is_of_a_sensor:
        what = "the current of the drive" if is_called_a_field else "another output of its sensor"
        remedy = f"--field {label} if it drives {_A_COIL_OF_A_DEVICE}"
        leave_out_field(draft, f"{course}: taken for {what}, left out ({remedy})")
        return
    if is_called_a_field:
        doubt = f"which {course}, as the current of a motor does"
        answer = shell_word(draft.table.label(told)) if told else NONE
        draft.doubt("field", f"{doubt}: {_unless_it_drives(_A_COIL_OF_A_DEVICE, field)}", answer)
        return

    # A spare input of the bench, whose name says nothing of a coil, is more likely an output of the same sensor.
    draft.take_back("field")
    problem = f"column {field.column} may be the field by its unit, but {course}, as another output of its sensor does"
    remedy = f"Say which: --field none, or --field {label}"
    draft.ask("field", MappingError(problem, remedy=remedy), option="--field none")


def doubt_the_current_of_a_motor_under_test(draft: Draft) -> None:
    """Doubt a guessed field beside an efficiency or a thrust: a motor's current makes them, and no field of a fluid."""
    field = draft.guessed("field")
    if field is None or field.si not in OF_A_SUPPLY or field.sureness == "doubtful":
        return
    if draft.seen.columns[field.column].spoken.says(_OF_COILS):
        return
    others = draft.seen.without([*draft.taken, field.column])
    has_a_supply = any(other.spoken.says(VOLTAGES) or other.fits(("V",)) for other in others)
    for other in others:
        is_of_a_propeller = has_a_supply and other.spoken.says(_THRUSTS)
        if is_of_a_propeller or other.spoken.says(_OF_TESTS_OF_MOTORS):
            doubt = f"which stands beside {other.name}, as that of a motor under test"
            draft.doubt("field", f"{doubt}: {_unless_it_drives(_A_COIL_OF_A_DEVICE, field)}", NONE)
            return


def _unless_it_drives(what: str, field: SignalPlan) -> str:
    """What to do about a column that looks like no field: none was logged, or it is given by its name."""
    return f"no field then, --field {shell_word(field.column)} if it drives {what}"


def is_current_of_a_drive(column: SeenColumn, efforts: Iterable[Array]) -> bool:
    """Whether a column is called like the current of a drive, takes the sign of an effort and goes along with it."""
    if not is_of_a_drive(column.spoken) or column.fits(("A",)) is False:
        return False
    return any(goes_along(column.values, effort) for effort in efforts)


def leave_out_the_supply_of_a_drive(draft: Draft) -> None:
    """Take a guessed voltage back that keeps one level, too low for a fluid, beside the current of a drive."""
    field = _guessed_voltage(draft)
    effort = draft.signals.get("effort")
    if field is None or effort is None or not effort.column:
        return
    voltage = draft.seen.columns[field.column]
    largest = float(np.nanmax(np.abs(voltage.values), initial=0.0)) * abs(field.factor)
    if not voltage.is_steady or largest > LARGEST_SUPPLY:
        return
    measured = draft.table.columns[effort.column]
    for other in draft.seen.without(draft.taken):
        if is_current_of_a_drive(other, [measured]):
            why = f"keeps near one level, and {other.name} is the current of a drive: taken for its supply, left out"
            leave_out_field(draft, why)
            return


def doubt_the_voltage_of_a_machine(draft: Draft) -> None:
    """Doubt a guessed voltage beside the current of an armature or a generator that goes straight with the effort."""
    field = _guessed_voltage(draft)
    effort = draft.signals.get("effort")
    if field is None or field.sureness == "doubtful" or effort is None or not effort.column:
        return
    voltage = draft.seen.columns[field.column]
    largest = float(np.nanmax(np.abs(voltage.values), initial=0.0)) * abs(field.factor)
    if largest > LARGEST_SUPPLY or voltage.spoken.says(_OF_COILS):
        return
    measured = draft.table.columns[effort.column]
    for other in draft.seen.without([*draft.taken, field.column]):
        is_a_current = other.fits(("A",)) is not False and "field" in other.spoken.may_be
        if is_a_current and is_of_a_machine(other.spoken) and go_straight(other.values, measured):
            doubt = f"which stands beside {other.name}, as the voltage of that machine"
            draft.doubt("field", f"{doubt}: {_unless_it_drives('a coil', field)}", NONE)
            return


def leave_out_field(draft: Draft, why: str) -> None:
    """Take a guessed field back with a word; the question after it stays open for other columns."""
    column = draft.signals["field"].column
    draft.take_back("field")
    draft.no_signals.append(column)
    draft.notes.append(f"column {column} {why}")
    draft.ask("field", missing(draft.seen, "field", draft.taken))
    draft.missing.append("field")


def doubt_the_sensor_of_the_motion(draft: Draft) -> None:
    """Doubt a guessed voltage that goes straight with a motion to and fro: the output of its sensor.

    A field may be raised while a device moves one way, so a motion that never turns back tells nothing.
    """
    field = _guessed_voltage(draft)
    if field is None or field.sureness == "doubtful":
        return
    if draft.seen.columns[field.column].spoken.forms["field"] == "field":
        return  # its name says it
    output = draft.table.columns[field.column]
    for signal in ("position", "slip"):
        motion = draft.signals.get(signal)
        if motion is None or not motion.column:
            continue
        measured = draft.table.columns[motion.column]
        known = measured[np.isfinite(measured)][:LOOKED_AT]
        if known.size < FEW:
            continue
        # A motion to and fro comes back by half of its range and goes forth again.
        middle = 0.5 * (known.min() + known.max())
        crossings = np.flatnonzero(np.diff(known > middle))
        if crossings.size >= _CROSSINGS and go_straight(output, measured):
            doubt = f"which goes straight with {motion.column}, as the output of its sensor does"
            draft.doubt("field", f"{doubt}: {_unless_it_drives('a coil', field)}", NONE)
            return


def doubt_the_command_of_a_drive(draft: Draft) -> None:
    """Doubt a column that is just called a command, beside commands of a motion: a drive's, which drives no coil."""
    field = draft.guessed("field")
    if field is None:
        return
    if draft.seen.columns[field.column].spoken.forms["field"] not in _COMMANDS:
        return
    names_of_motions = f"{NAMES['slip']} {NAMES['position']} {NAMES['effort']}".split()
    for other in draft.seen.without([field.column]):
        words = {re.sub(r"\d+$", "", word) for word in other.spoken.stem_words}
        is_told = not TOLD.isdisjoint(words)
        if is_told and not words.isdisjoint(names_of_motions):
            doubt = f"which stands beside {other.name}, as what a drive was told"
            draft.doubt("field", f"{doubt}: {_unless_it_drives('a coil', field)}", NONE)
            return


def doubt_the_monitor_of_an_amplifier(draft: Draft) -> None:
    """Doubt a guessed voltage of some volts that is called a monitor or a high voltage: 1 V of it stands for more."""
    field = _guessed_voltage(draft)
    if field is None or field.sureness == "doubtful":
        return
    column = draft.seen.columns[field.column]
    largest = float(np.nanmax(np.abs(column.values), initial=0.0))
    words = {*column.spoken.words}
    if column.written_unit != "V" or largest > _OUTPUT or words.isdisjoint(_MONITORS):
        return
    label = shell_word(draft.table.label(field.column))
    stated = [each for each in scales_stated(draft, "field") if each.is_over("V")]
    if len(stated) == 1:
        doubt = f"in volts, and the file says {stated[0].said}"
        scale = shell_word(f"field={stated[0].over('V')}")
        draft.doubt("field", doubt, f"{label} --scale {scale}")
        return
    output = "1 A" if words & CURRENTS else "1 kV"
    doubt = f"which ends at {largest:.3g} V, as the monitor of an amplifier does, of which 1 V may mean {output}"
    doubt += f": put its number in place of the {output}, or give --field {label} if it is the voltage itself"
    draft.doubt("field", doubt, f"{label} --scale {shell_word(f'field={output}/V')}")


def _guessed_voltage(draft: Draft) -> SignalPlan | None:
    """The field that was guessed, if it is a voltage by its unit or, without a unit, by its name."""
    field = draft.guessed("field")
    if field is None:
        return None
    column = draft.seen.columns[field.column]
    is_called_so = not column.unit and column.spoken.forms["field"] in VOLTAGES
    return field if column.fits(("V",)) or is_called_so else None
