"""Of several columns that may be the field one is chosen: the current of a coil where it is measured.

The voltage that drives it, the duty that a supply was told, and the current of the motor are none. Across an
electrorheological fluid the voltage is the field, and the current leaks.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.two_courses import go_straight, goes_along
from erclutch.logs.columns.vocabulary import CURRENTS, EASTERN_TOLD, VOLTAGES
from erclutch.signals import units

_OHMS_OF_A_COIL = 1000.0  # at most; an electrorheological fluid has megohms
_COMMANDS = ("pwm", "duty", "command", "cmd", "excitation")  # what a supply is told


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
    columns = [column for column in columns if column.name not in driving]

    # Nor is a command (a duty, say) that a measured current goes straight with.
    currents = [column for column in columns if column.fits(("A",))]
    without_commands: list[SeenColumn] = []
    for column in columns:
        is_command = column.spoken.forms["field"] in _COMMANDS and not column.unit
        is_followed = is_command and any(
            go_straight(current.values, column.values) for current in currents
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
    return [column.name for column in left]


def _circuit(column: SeenColumn, quantity: Collection[str]) -> frozenset[str]:
    """The words of a name without the quantity, such as ``coil`` of ``coil voltage``, and 3 of ``V3``."""
    rest: set[str] = set()
    for word in column.spoken.stem_words:
        letters = word.rstrip("0123456789")
        number = word.removeprefix(letters)
        rest.add(number if letters in quantity else word)
    return frozenset(rest - {""})


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
