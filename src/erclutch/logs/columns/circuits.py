"""Of the voltages, currents and commands of one circuit one is the field: the current of a coil, where it is measured.

The voltage that drives it, the duty that a supply was told, and the current of the motor are no fields. Across an
electrorheological fluid the voltage is the field, and the current leaks.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from erclutch.logs.columns.names import CURRENTS, OTHER, TOLD, VOLTAGES
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import go_straight, goes_along, takes_both_signs
from erclutch.signals import units

_OHMS_OF_A_COIL = 1000.0  # at most; an electrorheological fluid has megohms
_COMMANDS = ("pwm", "duty", "command", "cmd", "excitation")  # what a supply is told


def fields_among(
    seen: SeenColumns,
    free: Iterable[SeenColumn],
    named: Sequence[str],
    forms: Mapping[str, str | None],
) -> list[str]:
    """Columns that may be the field: beside voltages the currents too, and none that is the voltage of a supply.

    Args:
        seen: the columns of the log.
        free: columns that are nothing else.
        named: those of them that are called like the field.
        forms: what speaks for the field in their names.
    """
    fields = [*named]
    if {forms.get(name) for name in named} <= VOLTAGES:
        # The current of a coil is its field as much as its voltage is.
        for column in free:
            is_current = column.fits(("A",)) and not column.shape.constant
            is_other = "field" in column.spoken.turned or not (TOLD | OTHER).isdisjoint(column.spoken.stem_words)
            if column.name not in named and is_current and not is_other:
                fields.append(column.name)

    # A column that hardly changes while another one does is that of a supply.
    if not any(seen.columns[name].varies for name in fields):
        return fields
    return [name for name in fields if not seen.columns[name].is_steady]


def one_of_a_circuit(seen: SeenColumns, fields: Sequence[str], efforts: Sequence[str]) -> list[str]:
    """The fields without what drives them: the voltage or the command of a coil's current, the current of a motor."""
    fields = _without_driving_voltages(seen, fields)
    fields = _without_commands(seen, fields)
    return _without_currents_of_drives(seen, fields, efforts)


def _without_driving_voltages(seen: SeenColumns, fields: Sequence[str]) -> list[str]:
    """The fields without each voltage that drives a current of the same circuit, by the rest of both names."""
    columns = [seen.columns[name] for name in fields]
    driving: set[str] = set()
    for voltage in columns:
        for current in columns:
            circuit = _circuit(voltage, VOLTAGES)
            of_an_inverter = "dc" in circuit  # its supply, whose current is that of no coil
            if circuit == _circuit(current, CURRENTS) and not of_an_inverter and _drives(voltage, current):
                driving.add(voltage.name)
    return [name for name in fields if name not in driving]


def _without_commands(seen: SeenColumns, fields: Sequence[str]) -> list[str]:
    """The fields without each command (a duty, say) that a measured current goes straight with."""
    columns = [seen.columns[name] for name in fields]
    currents = [column for column in columns if column.fits(("A",))]
    kept: list[str] = []
    for column in columns:
        is_command = column.spoken.forms["field"] in _COMMANDS and not column.unit
        if not (is_command and any(go_straight(current.values, column.values) for current in currents)):
            kept.append(column.name)
    return kept


def _without_currents_of_drives(seen: SeenColumns, fields: Sequence[str], efforts: Sequence[str]) -> list[str]:
    """The fields without each that takes the sign of the effort and goes along with it: the current of the drive.

    A coil beside it keeps its sign, whichever way the device turns.
    """
    kept: list[str] = []
    for name in fields:
        values = seen.columns[name].values
        if not any(goes_along(values, seen.columns[effort].values) for effort in efforts):
            kept.append(name)
    keep_their_sign = [name for name in kept if not takes_both_signs(seen.columns[name].values)]
    return kept if keep_their_sign else [*fields]


def _circuit(column: SeenColumn, quantity: Collection[str]) -> frozenset[str]:
    """The words of a name without the quantity, such as ``coil`` of ``coil voltage``, and 3 of ``V3``."""
    rest: set[str] = set()
    for word in column.spoken.stem_words:
        letters = word.rstrip("0123456789")
        rest.add(word.removeprefix(letters) if letters in quantity else word)
    return frozenset(rest - {""})


def _drives(voltage: SeenColumn, current: SeenColumn) -> bool:
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
    most = _OHMS_OF_A_COIL * np.max(amperes[known])  # V
    return bool(np.max(volts[known]) < most)
