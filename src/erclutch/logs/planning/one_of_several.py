"""Of several columns that may be a signal one is chosen, where the other columns settle which it is; else it is asked.

The motion tells a torque from a force, and the effort tells the speed that makes a power with it. A circuit has one
field, the current of a coil where it is measured: the voltage that drives it, the duty that a supply was told, and the
current of the motor are none. Across an electrorheological fluid the voltage is the field, and the current leaks. A
gear has an effort on one side, and a coefficient of friction says which force rubs. Counts beside volts, and a
travel beside a position, are no second column.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.candidates import DIGITS, DRIVES, candidates
from erclutch.logs.columns.names import plain
from erclutch.logs.columns.quotients import rubbing_force
from erclutch.logs.columns.seen_columns import KINDS, UNITS_OF_KIND, SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.two_courses import go_straight, goes_along, is_multiple_of, move_alike
from erclutch.logs.columns.two_shafts import is_of_clutch
from erclutch.logs.columns.vocabulary import CURRENTS, EASTERN_TOLD, NOT_MEASURED, VOLTAGES
from erclutch.signals import units

_OHMS_OF_A_COIL = 1000.0  # at most; an electrorheological fluid has megohms
_COMMANDS = ("pwm", "duty", "command", "cmd", "excitation")  # what a supply is told
#: Words for the device itself. A clutch is driven too: its motor's speed is that of one of its sides.
_DEVICES = frozenset(
    ("brake", "bremse", "frein", "freno", "damper", "dampfer", "daempfer", "amortisseur")
)
#: What the length between the marks of a specimen is called in the headers of testing machines.
_GAUGE_LENGTH = re.compile(
    r"ga(?:u)?ge length|\bL0\b|messl(?:ä|ae)nge|longueur (?:initiale|utile|entre rep(?:è|e)res)|base de mesure|"
    r"longitud (?:inicial|calibrada)|標点距離|标距",
    re.IGNORECASE,
)


#: Words for a sensor of a torque or a force.
_CELLS = frozenset(
    {"sensor", "adc", "transducer", "cell", "loadcell", "futek", "flange", "messwelle", "daq"}
)
_LAST_DIGITS = 1e-5  # of the largest number
_FEW = 3  # speeds: of more, a robot's rest and are asked about with its efforts
_ALIKE = 0.03  # of the largest speed, by which two sensors of one motion differ at most
#: What a speed is called by that was measured in one way of several.
_SENSORS = frozenset(
    {
        "electrical",
        "optical",
        "encoder",
        "hall",
        "laser",
        "tacho",
        "magnetic",
        "resolver",
        "sensor",
        "gyro",
        "esc",
        "el",
    }
)


class Guess(NamedTuple):
    """A column that may be a signal, and what speaks for it: ``name``, ``unit``, with what settled it."""

    column: str
    reason: str


def guess(
    seen: SeenColumns,
    signal: str,
    taken: Iterable[str],
    units_of_sensor: tuple[str, ...] = (),
    motion: str = "",
) -> Guess | None:
    """The one column that a signal's name or unit points to, or None; see `candidates`.

    Args:
        seen: the columns of the log.
        signal: its name.
        taken: columns that are something else.
        units_of_sensor: see `candidates`.
        motion: the column of the slip or position, whose kind decides between a torque and a force.

    Raises:
        MappingError: several columns would do.
    """
    taken = [*taken]
    names, reason = candidates(seen, signal, taken, units_of_sensor)
    if len(names) > 1 and names[0] in seen.table.made:
        efforts, _ = candidates(seen, "effort", [*taken, *names])
        if is_of_clutch(seen, signal, names[0], efforts):
            return Guess(names[0], "names, as what two shafts or ends differ by")

    # The counts of a converter have no unit, and go straight with a column that has one.
    columns = [seen.columns[name] for name in names]
    with_unit = [column for column in columns if column.written_unit]
    measured: list[str] = []
    for column in columns:
        beside = [] if column.written_unit else with_unit
        if not any(go_straight(column.values, other.values) for other in beside):
            measured.append(column.name)
    names = measured
    if signal != "field":
        names = _of_the_device(seen, names)
    why = ""
    if len(names) > 1 and signal == "field":
        efforts, _ = candidates(seen, "effort", [*taken, *names])
        names = _one_of_a_circuit(seen, names, efforts)
    elif len(names) > 1 and signal == "slip":
        names, why = _one_slip(seen, names, taken)
    elif len(names) > 1 and signal == "position":
        names, why = _one_position(seen, names, taken)
    elif len(names) > 1 and signal == "effort":
        names, why = _one_effort(seen, names, motion)
    names = _with_estimates(seen, names)
    if not names:
        return None
    if len(names) == 1:
        return Guess(names[0], f"{reason}{why}")

    table = seen.table
    problem = f"{signal} may be any of the columns {', '.join(names)}; the file has: {table.listed}"
    remedy = f"Say which, such as --{signal} {shell_word(table.label(names[0]))}"
    if signal in ("effort", "T"):
        remedy += ", or --variable all if each is a log"
    raise MappingError(problem, remedy=remedy)


def _of_the_device(seen: SeenColumns, names: Sequence[str]) -> list[str]:
    """The one column that is called like the brake or damper, where all others are called like what drives it."""
    devices: list[str] = []
    for name in names:
        words = {*seen.columns[name].spoken.stem_words} if name in seen.columns else set[str]()
        if words & _DEVICES:
            devices.append(name)
        elif not words & DRIVES:
            return [*names]
    return devices if len(devices) == 1 else [*names]


def _one_of_a_circuit(
    seen: SeenColumns, fields: Sequence[str], efforts: Sequence[str]
) -> list[str]:
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


def _one_slip(seen: SeenColumns, speeds: list[str], taken: Sequence[str]) -> tuple[list[str], str]:
    """The speed that makes a power with the effort, whatever column that is; else all, or that on the effort's side."""
    efforts, _ = candidates(seen, "effort", [*taken, *speeds])
    kinds = {seen.columns[name].kind for name in efforts}
    kind = kinds.pop() if len(kinds) == 1 else ""
    if kind:
        fits = {name: seen.columns[name].fits(UNITS_OF_KIND[kind]) for name in speeds}
        of_that_kind = [name for name in speeds if fits[name]]
        if len(of_that_kind) == 1 and None not in fits.values():
            return of_that_kind, f", and the effort is that of a {KINDS[kind]}"
    # The speeds of axes that were not used never change.
    resting = [name for name in speeds if seen.columns[name].shape.constant]
    if len(speeds) <= _FEW and len(resting) == len(speeds) - 1:
        moving = [name for name in speeds if name not in resting]
        return _of_one_side(seen, moving, efforts), f", and {', '.join(resting)} never changes"
    if len(speeds) > 1 and _are_of_sensors(seen, speeds):
        first, *others = speeds
        return _of_one_side(
            seen, [first], efforts
        ), f", and {', '.join(others)} agrees with it to {_ALIKE:.0%}"
    return _of_one_side(seen, speeds, efforts), ""


def _are_of_sensors(seen: SeenColumns, speeds: list[str]) -> bool:
    """Whether speeds are of sensors of one motion: their names differ by a word for the sensor, and the numbers agree.

    Numbers alone do not suffice: two shafts that are coupled turn alike, and slip by what they differ.
    """
    words = [{*seen.columns[name].spoken.stem_words} for name in speeds]
    shared = set[str].intersection(*words)
    if any(not own - shared or not own - shared <= _SENSORS for own in words):
        return False
    first, *others = (seen.columns[name] for name in speeds)
    largest = np.nanmax(np.abs(first.values))
    for other in others:
        gap = np.abs(other.values - first.values)
        if other.unit != first.unit or not np.nanmax(gap) <= _ALIKE * largest:
            return False
    return True


def _of_one_side(seen: SeenColumns, names: Sequence[str], partners: Iterable[str]) -> list[str]:
    """The one column on the side of the gear where all of its partners are; all of the columns where it is not one."""
    sides = {seen.columns[name].side for name in partners if name in seen.columns}
    if len(sides) != 1 or "" in sides:
        return [*names]
    beside_partners: list[str] = []
    for name in names:
        if name in seen.columns and seen.columns[name].side in sides:
            beside_partners.append(name)
    return beside_partners if len(beside_partners) == 1 else [*names]


def _one_position(
    seen: SeenColumns, positions: list[str], taken: Sequence[str]
) -> tuple[list[str], str]:
    """The position whose gauge length the header gives, from which a specimen is stretched; else as for a slip."""
    # A travel beside an absolute position says the same from another zero.
    kept: list[SeenColumn] = []
    for name in positions:
        position = seen.columns[name]
        in_that_unit = [other for other in kept if other.unit == position.unit]
        if not any(move_alike(position.values, other.values, DIGITS) for other in in_that_unit):
            kept.append(position)
    positions = [position.name for position in kept]
    if len(positions) == 1:
        return positions, ""
    keys: list[str] = []
    for key, text in seen.table.metadata.items():
        if text and _GAUGE_LENGTH.search(key):
            keys.append(plain(key))
    with_a_length = [name for name in positions if any(plain(name) in key for key in keys)]
    if len(with_a_length) == 1:
        return with_a_length, ", and the header gives the gauge length for it"
    efforts, _ = candidates(seen, "effort", [*taken, *positions])
    return _of_one_side(seen, positions, efforts), ""


def _one_effort(seen: SeenColumns, efforts: list[str], motion: str) -> tuple[list[str], str]:
    """The effort of the motion's kind, or that on its side of a gear; or the friction by its coefficient; else all.

    What a model says of the effort is none of them.
    """
    efforts = [name for name in efforts if not seen.columns[name].spoken.is_of_a_model] or efforts
    if motion:
        kind = seen.columns[motion].kind
        kinds = {name: seen.columns[name].kind for name in efforts}
        of_that_kind = [name for name in efforts if kind and kinds[name] == kind]
        # Each of the others must be known to be of another kind.
        if len(of_that_kind) == 1 and all(kinds.values()):
            return of_that_kind, f", and it is that of a {KINDS[kind]}"
    # An effort that is called like a drive's may be one of the currents times a number, in each row.
    currents = [column for column in seen.columns.values() if column.spoken.says(CURRENTS)]
    computed: list[str] = []
    for name in efforts:
        effort = seen.columns[name]
        beside = currents if effort.spoken.says(DRIVES) else []
        if any(is_multiple_of(effort.values, each.values, _LAST_DIGITS) for each in beside):
            computed.append(name)
    sensed = [name for name in efforts if seen.columns[name].spoken.says(_CELLS)]
    if len(efforts) == 2 and len(computed) == len(sensed) == 1 and computed != sensed:
        return sensed, f", and {computed[0]} is a current of its drive times a number"
    efforts = _of_one_side(seen, efforts, [motion])
    # A coefficient of friction says by its numbers which force is the friction and which presses.
    rubbing = rubbing_force(seen) if len(efforts) > 1 else ""
    if rubbing in efforts:
        return [rubbing], ", and a coefficient of friction is made of it"
    return efforts, ""


def _with_estimates(seen: SeenColumns, names: list[str]) -> list[str]:
    """A column that was calculated or calibrated and the estimates beside it: ``tau_cal`` and ``tau_est``."""
    if len(names) != 1:
        return names
    words = {*seen.columns[names[0]].spoken.stem_words}
    if "cal" not in words:
        return names
    words_besides = words - {"cal"}
    estimates: list[str] = []
    for column in seen.without(names):
        own_words = {*column.spoken.stem_words}
        own_besides = own_words - NOT_MEASURED
        if own_besides == words_besides and own_besides != own_words:
            estimates.append(column.name)
    return [*names, *estimates]
