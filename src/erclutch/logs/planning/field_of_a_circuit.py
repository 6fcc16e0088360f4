"""Of several columns that may be the field one is chosen: the current of a coil where it is measured.

The voltage that drives it, the duty that a supply was told, and the current of the motor are none. Across an
electrorheological fluid the voltage is the field, and the current leaks.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.machines_in_names import is_of_a_drive
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.two_courses import (
    correlation_of,
    go_straight,
    goes_along,
    is_course_times_a_number,
)
from erclutch.logs.columns.vocabulary import COMMANDS, CURRENTS, EASTERN_TOLD, VOLTAGES, set_of
from erclutch.signals import units

_OHMS_OF_A_COIL = 1000.0  # at most; an electrorheological fluid has megohms
#: What a current is called that makes the field.
COILS = set_of(
    "coil magnet electromagnet em solenoid brake clutch damper mr er mrf erf spule bobine bobina field excitation exc"
)
#: The same inside words that are written together.
_INCOILS = re.compile(
    "bremsstrom|bremsenstrom|spulenstrom|erregerstrom|kupplungsstrom|制动|制動|励磁|线圈|線圈|电磁|電磁"
    "|ブレーキ|コイル|브레이크|코일|тормоз|катушк|возбужд"
)
#: What a measured current of zero lies below it, as a share of the largest.
_NOISE = 0.05
#: How far at least a measured current goes with the current that was told, which it lags behind.
_FOLLOWS = 0.8


def one_of_a_circuit(seen: SeenColumns, fields: Sequence[str], efforts: Sequence[str]) -> list[str]:
    """The fields without what drives them: the voltage or the command of a coil's current, the current of a motor."""
    measured = [name for name in fields if not any(word in name for word in EASTERN_TOLD)]
    columns = [seen.columns[name] for name in measured or fields]

    # A voltage that drives a current of the same circuit is no field.
    driving: set[str] = set()
    for voltage in columns:
        circuit = _circuit(voltage, VOLTAGES)
        if "dc" in circuit:
            continue  # the supply of an inverter, whose current is that of no coil
        for current in columns:
            if circuit == _circuit(current, CURRENTS) and _drives_a_coil(voltage, current):
                driving.add(voltage.name)
    # Nor is the voltage across a gap, where the strength of the field in that gap is logged as well.
    strengths = [column for column in columns if column.fits(("V/m",))]
    for voltage in columns:
        is_across = voltage.fits(("V",)) and len(strengths) == 1
        if is_across and is_course_times_a_number(voltage.values, strengths[0].values):
            driving.add(voltage.name)
    columns = [column for column in columns if column.name not in driving]

    # Nor is a command (a duty, say) that a measured current goes straight with, or follows where both are in A.
    currents = [column for column in columns if column.fits(("A",))]
    without_commands: list[SeenColumn] = []
    for column in columns:
        is_command = column.spoken.forms["field"] in COMMANDS
        is_a_number = is_command and column.written_unit in (None, "%")
        is_told_in_amperes = is_command and column.fits(("A",))
        is_followed = any(
            (is_a_number and go_straight(current.values, column.values))
            or (is_told_in_amperes and correlation_of(current.values, column.values) >= _FOLLOWS)
            for current in currents
            if current is not column
        )
        if not is_followed:
            without_commands.append(column)

    # What takes the sign of the effort and goes along with it is the current of the drive. A coil beside it keeps its
    # sign, whichever way the device turns.
    of_no_drive: list[SeenColumn] = []
    for column in without_commands:
        if not any(goes_along(column.values, seen.columns[effort].values) for effort in efforts):
            of_no_drive.append(column)
    coil_is_there = any(not takes_both_signs(column.values) for column in of_no_drive)
    left = of_no_drive if coil_is_there else without_commands

    # Of a device that turns one way both keep their sign: what was set keeps levels, and a drive's current wanders with
    # the effort.
    were_set = [column for column in left if column.shape.keeps_levels]
    wander: set[str] = set()
    for column in left if were_set else []:
        if column.shape.keeps_levels or takes_both_signs(column.values):
            continue
        if any(go_straight(column.values, seen.columns[each].values) for each in efforts):
            wander.add(column.name)
    left = [column for column in left if column.name not in wander]

    # Beside the current of a coil that was set, the current of a motor is none.
    amperes = [column for column in left if column.fits(("A",)) or _is_called_a_current(column)]
    of_no_motor = [column for column in amperes if not is_of_a_drive(column.spoken)]
    are_all_currents = len(amperes) == len(left)
    if are_all_currents and len(of_no_motor) == 1 and _was_set_in_a_coil(of_no_motor[0]):
        return [of_no_motor[0].name]
    return [column.name for column in left]


def _is_called_a_current(column: SeenColumn) -> bool:
    return column.unit is None and column.spoken.says(CURRENTS)


def _was_set_in_a_coil(column: SeenColumn) -> bool:
    keeps_its_sign = not takes_both_signs(column.values)
    return _is_of_a_coil(column) and column.shape.keeps_levels and keeps_its_sign


def _is_of_a_coil(column: SeenColumn) -> bool:
    return column.spoken.says(COILS) or _INCOILS.search(column.name.lower()) is not None


def _circuit(column: SeenColumn, quantity: Collection[str]) -> frozenset[str]:
    """The words of a name without the quantity, such as ``coil`` of ``coil voltage``, and 3 of ``V3``."""
    rest: set[str] = set()
    for word in column.spoken.stem_words:
        letters = word.rstrip("0123456789")
        number = word.removeprefix(letters)
        rest.add(number if letters in quantity else word)
    return frozenset(rest - {"", "a"})  # CH1 (A)


def _drives_a_coil(voltage: SeenColumn, current: SeenColumn) -> bool:
    """Whether a voltage drives a current through a coil: many times as many volts are those across a fluid.

    There the voltage is the field, and the current is what leaks.
    """
    if not voltage.fits(("V",)) or not current.fits(("A",)) or current.shape.constant:
        return False
    volt = units.parse("V").factor
    unit_of_voltage = units.parse(voltage.unit_for(("V",)) or "V")
    unit_of_current = units.parse(current.unit_for(("A",)) or "A")
    volts = np.abs(voltage.values) * unit_of_voltage.factor / volt
    amperes = np.abs(current.values) * unit_of_current.factor
    known = np.isfinite(volts) & np.isfinite(amperes)
    if not known.any():
        return False
    most_volts = _OHMS_OF_A_COIL * np.max(amperes[known])
    return bool(np.max(volts[known]) < most_volts)


def of_a_coil(seen: SeenColumns, names: Sequence[str]) -> str:
    """The one of several currents that is named after a coil or a brake and never turns its sign, as a word; or ""."""
    coils: list[str] = []
    for name in names:
        column = seen.columns[name]
        if not _is_of_a_coil(column):
            continue
        # A machine's current turns its sign with the torque, whatever the machine is called.
        ends = sorted((abs(np.nanmin(column.values)), abs(np.nanmax(column.values))))
        if not takes_both_signs(column.values) or ends[0] <= _NOISE * ends[1]:
            coils.append(name)
    return shell_word(seen.table.label(coils[0])) if len(coils) == 1 else ""
