"""A guess is doubted where the log speaks against it, by its numbers or its words: the user is asked to confirm it."""

from __future__ import annotations

import re

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.names import CURRENTS, NAMES, NOT_MEASURED, SENSES, TOLD, VOLTAGES, words_of
from erclutch.logs.columns.quotients import rubbing_force
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.senses import DIRECTIONS
from erclutch.logs.columns.shapes import FEW, LOOKED_AT, takes_both_signs, turns_back
from erclutch.logs.columns.two_courses import go_straight, goes_along
from erclutch.logs.mapping import NONE
from erclutch.logs.plan import SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.guesses import OF_A_SUPPLY, faintness
from erclutch.logs.planning.missing_columns import missing
from erclutch.logs.planning.no_field import LARGEST_SUPPLY, OF_DRIVES, is_current_of_a_drive
from erclutch.signals import units
from erclutch.signals.array import Array

_COMMANDS = ("command", "cmd")
_SI_OF_A_SUPPLY = ("A", "V")
#: Words in the name of a voltage that an amplifier shows of its output.
_MONITORS = frozenset({"monitor", "mon", "vmon", "imon", "hv", "highvoltage", "hochspannung", "trek"})
# Of the largest speed: a device moves, and comes near rest. Of the largest effort, and of the rows that move.
_FAST, _RESTS, _LARGE, _OFTEN = 0.3, 0.02, 0.2, 0.2
_OUTPUT = 12.0  # V, of an amplifier's monitor at most
_ARMS = frozenset({"arm", "arms", "lever", "leverarm", "hebel", "hebelarm", "bras", "levier", "brazo", "braccio"})
#: Names of efforts by the unit of their kind.
_EFFORTS_BY_NAME = {
    "N*m": ("torque", "moment", "drehmoment", "coppia"),
    "N": ("force", "kraft", "fuerza", "forza", "dampingforce"),
}
#: A unit with a plain number in front of it.
_RANGE = re.compile(r"\s*(\d{1,6}(?:\.\d+)?)\s*([^\W\d_].*?)\s*")
_NO_POWER = (("N", "rad/s"), ("N*m", "m/s"))  # units of effort and slip


def leave_out_the_sensor_of_the_effort(draft: Draft) -> None:
    """Take a guessed voltage back that is too faint for a coil and goes straight with the effort: its sensor's output.

    A faint current may be what leaks through an electrorheological fluid, and tells the field.
    """
    field = draft.signals.get("field")
    effort = draft.signals.get("effort")
    if field is None or effort is None or not effort.column or not _is_guessed_voltage(draft, field):
        return
    output = draft.table.columns[field.column]
    measured = draft.table.columns[effort.column]
    strongest = faintness(field, output)
    if strongest is None or not go_straight(output, measured):
        return
    course = f"never exceeds {strongest:.3g} and goes straight with {effort.column}"
    _leave_out_field(draft, f"{course}: taken for the output of its sensor, left out")


def doubt_the_current_of_a_drive(draft: Draft) -> None:
    """Doubt a guessed field with the sign and the course of the effort: the current of the motor that makes it."""
    field = draft.signals.get("field")
    effort = draft.signals.get("effort")
    if field is None or field.si not in OF_A_SUPPLY or not field.reason.startswith("guessed"):
        return
    if effort is None:
        _doubt_by_name(draft, field)
        return
    current = draft.table.columns.get(field.column)
    measured = draft.table.columns.get(effort.column)
    if current is None or measured is None or not goes_along(current, measured):
        return
    course = f"takes the sign of {effort.column} and goes along with it"
    coils = [column for column in draft.seen.without(draft.taken) if _may_drive_a_coil(column)]
    if len(coils) == 1:
        _take_back(draft, "field")
        why = f"guessed from its name, beside {field.column}, which {course} as that of a motor"
        draft.take("field", coils[0].name, coils[0].unit_for(_SI_OF_A_SUPPLY), 1.0, why, "likely")
        return
    if is_current_of_a_drive(draft.seen.columns[field.column], [measured]):
        _leave_out_field(draft, f"{course}: taken for the current of the drive, left out")
        return
    spoken = draft.seen.columns[field.column].spoken
    if spoken.forms["field"] or "field" in spoken.within:
        doubt = f"which {course}, as the current of a motor does: no field then, --field {shell_word(field.column)} if "
        doubt += "it drives the coil of a brake or damper"
        draft.doubt("field", doubt, NONE)
        return

    # A spare input of the bench, whose name says nothing of a coil, is more likely an output of the same sensor.
    _take_back(draft, "field")
    label = shell_word(draft.table.label(field.column))
    problem = f"column {field.column} may be the field by its unit, but {course}, as another output of its sensor does"
    remedy = f"Say which: --field none, or --field {label}"
    draft.ask("field", MappingError(problem, remedy=remedy), option="--field none")


def _doubt_by_name(draft: Draft, field: SignalPlan) -> None:
    """Doubt a guessed field that is called like the current of a drive and turns its sign, where no effort is known."""
    current = draft.seen.columns[field.column]
    if not OF_DRIVES.isdisjoint(current.spoken.stem_words) and takes_both_signs(current.values):
        doubt = "which is called like the current of a drive and takes both signs: no field then, "
        doubt += f"--field {shell_word(field.column)} if it drives the coil of a brake or damper"
        draft.doubt("field", doubt, NONE)


def leave_out_the_supply_of_a_drive(draft: Draft) -> None:
    """Take a guessed voltage back that keeps one level, too low for a fluid, beside the current of a drive."""
    field = draft.signals.get("field")
    effort = draft.signals.get("effort")
    if field is None or effort is None or not effort.column or not _is_guessed_voltage(draft, field):
        return
    voltage = draft.seen.columns[field.column]
    largest = float(np.nanmax(np.abs(voltage.values), initial=0.0)) * abs(field.factor)
    if not voltage.is_steady or largest > LARGEST_SUPPLY:
        return
    measured = draft.table.columns[effort.column]
    for other in draft.seen.without(draft.taken):
        if is_current_of_a_drive(other, [measured]):
            why = f"keeps near one level, and {other.name} is the current of a drive: taken for its supply, left out"
            _leave_out_field(draft, why)
            return


def _leave_out_field(draft: Draft, why: str) -> None:
    """Take a guessed field back with a word; the question after it stays open for other columns."""
    column = draft.signals["field"].column
    _take_back(draft, "field")
    draft.no_signals.append(column)
    draft.notes.append(f"column {column} {why}")
    draft.ask("field", missing(draft.seen, "field", draft.taken))
    draft.missing.append("field")


def _may_drive_a_coil(column: SeenColumn) -> bool:
    """Whether a column is called like a field and is that of a supply by its unit, and keeps its sign."""
    if "field" not in column.spoken.may_be or column.fits(_SI_OF_A_SUPPLY) is False:
        return False
    is_told = not (TOLD | NOT_MEASURED).isdisjoint(column.spoken.stem_words)
    return not (is_told or column.shape.constant or column.is_steady or takes_both_signs(column.values))


def ask_about_ranges_of_sensors(draft: Draft) -> None:
    """Ask about a guessed signal whose unit begins with a number: ``Load [40 N]`` may name the range of its cell.

    A number below 1 is what a count of a converter is worth, and a power in ten is a factor.
    """
    for signal, guessed in [*draft.signals.items()]:
        unit = guessed.unit or ""
        match = _RANGE.fullmatch(unit)
        if not guessed.reason.startswith("guessed") or match is None or float(match.group(1)) <= 1.0:
            continue
        plain_unit = match.group(2)
        _take_back(draft, signal)
        bare = f"--{signal} {shell_word(f'{guessed.column} [{plain_unit}]')}"
        multiple = f"--{signal} {shell_word(f'{guessed.column} [{unit}]')}"
        problem = (
            f"the unit of column {guessed.column} is {unit}: {plain_unit} with the range of its sensor, or steps of it"
        )
        draft.ask(signal, MappingError(problem, remedy=f"Say which: {bare}, or {multiple}"), option=bare)


def _take_back(draft: Draft, signal: str) -> None:
    """Take a guess back, and what was noted of it."""
    del draft.signals[signal]
    draft.notes[:] = [note for note in draft.notes if not note.startswith(f"{signal} <- ")]


def doubt_the_sensor_of_the_motion(draft: Draft) -> None:
    """Doubt a guessed voltage that goes straight with a motion to and fro: the output of its sensor.

    A field may be raised while a device moves one way, so a motion that never turns back tells nothing.
    """
    field = draft.signals.get("field")
    if field is None or field.sureness == "doubtful" or not _is_guessed_voltage(draft, field):
        return
    if draft.seen.columns[field.column].spoken.forms["field"] == "field":
        return  # its name says it
    output = draft.table.columns[field.column]
    for signal in ("position", "slip"):
        motion = draft.signals.get(signal)
        if motion is None or not motion.column:
            continue
        measured = draft.table.columns[motion.column]
        if turns_back(measured) and go_straight(output, measured):
            doubt = f"which goes straight with {motion.column}, as the output of its sensor does"
            doubt += f": no field then, --field {shell_word(field.column)} if it drives a coil"
            draft.doubt("field", doubt, NONE)
            return


def doubt_the_command_of_a_drive(draft: Draft) -> None:
    """Doubt a column that is just called a command, beside commands of a motion: a drive's, which drives no coil."""
    field = draft.signals.get("field")
    if field is None or not field.reason.startswith("guessed"):
        return
    if draft.seen.columns[field.column].spoken.forms["field"] not in _COMMANDS:
        return
    names_of_motions = f"{NAMES['slip']} {NAMES['position']} {NAMES['effort']}".split()
    for other in draft.seen.without([field.column]):
        words = {re.sub(r"\d+$", "", word) for word in other.spoken.stem_words}
        is_told = not TOLD.isdisjoint(words)
        if is_told and not words.isdisjoint(names_of_motions):
            doubt = f"which stands beside {other.name}, as what a drive was told: no field then, "
            doubt += f"--field {shell_word(field.column)} if it drives a coil"
            draft.doubt("field", doubt, NONE)
            return


def doubt_the_monitor_of_an_amplifier(draft: Draft) -> None:
    """Doubt a guessed voltage of some volts that is called a monitor or a high voltage: 1 V of it stands for more."""
    field = draft.signals.get("field")
    if field is None or field.sureness == "doubtful" or not _is_guessed_voltage(draft, field):
        return
    column = draft.seen.columns[field.column]
    largest = float(np.nanmax(np.abs(column.values), initial=0.0))
    words = {*column.spoken.words}
    if column.written_unit != "V" or largest > _OUTPUT or words.isdisjoint(_MONITORS):
        return
    output = "1 A" if words & CURRENTS else "1 kV"
    label = shell_word(draft.table.label(field.column))
    doubt = f"which ends at {largest:.3g} V, as the monitor of an amplifier does, of which 1 V may mean {output}"
    doubt += f": put its number in place of the {output}, or give --field {label} if it is the voltage itself"
    draft.doubt("field", doubt, f"{label} --scale {shell_word(f'field={output}/V')}")


def doubt_a_force_at_a_stated_arm(draft: Draft) -> None:
    """Doubt a guessed force beside turns where the header states the arm of a lever: their product is the torque."""
    effort = draft.signals.get("effort")
    motion = draft.signals.get("slip") or draft.signals.get("position")
    if effort is None or motion is None or not effort.column or not effort.reason.startswith("guessed"):
        return
    if effort.si != "N" or motion.si not in ("rad/s", "rad"):
        return
    for key, text in draft.table.metadata.items():
        if _ARMS.isdisjoint(words_of(key)):
            continue
        try:
            arm = units.in_unit(text, "m")
        except UnitError:
            continue
        label = shell_word(draft.table.label(effort.column))
        doubt = f"which is a force beside turns, and the file says {key} = {text}"
        doubt += f": give --effort {label} alone if you want no torque"
        draft.doubt("effort", doubt, f"{label} --scale {shell_word(f'effort={arm:g} N*m/N')}")
        return


def _is_guessed_voltage(draft: Draft, field: SignalPlan) -> bool:
    """Whether the field was guessed, and is a voltage by its unit or, without a unit, by its name."""
    if not field.reason.startswith("guessed"):
        return False
    column = draft.seen.columns[field.column]
    if column.fits(("V",)):
        return True
    return not column.unit and column.spoken.forms["field"] in VOLTAGES


def doubt_a_speed_without_its_sense(draft: Draft) -> None:
    """Doubt a guessed slip that never turns, where a column of words says in which sense the device moves."""
    slip = draft.signals.get("slip")
    effort = draft.signals.get("effort")
    if slip is None or effort is None or not slip.reason.startswith("guessed"):
        return
    speed = draft.table.columns.get(slip.column)
    measured = draft.table.columns.get(effort.column)
    if speed is None or measured is None:
        return
    if takes_both_signs(speed) or not takes_both_signs(measured):
        return
    for name, values in draft.table.columns.items():
        if DIRECTIONS.isdisjoint(words_of(name)) or np.unique(values[:LOOKED_AT]).size not in (2, 3):
            continue
        draft.doubt("slip", f"which has no sign, while {name} tells the direction: give a column whose sign turns")
        return
    for name, column in draft.table.words.items():
        senses = [word for word in column.words if not SENSES.isdisjoint(words_of(word))]
        if len(senses) < 2:
            continue
        first, second, *_ = senses
        of_one_sense = shell_word(f"{name}={first}")
        doubt = f"which has no sign, while {name} says {first} and {second}: give a column whose sign turns, or "
        doubt += f"--variable {of_one_sense} for the rows of one sense"
        draft.doubt("slip", doubt)
        return
    is_of_one_sense = any(note.startswith("rows where ") for note in draft.table.notes)  # the user chose them by a word
    if not is_of_one_sense and _resists_both_ways(speed, measured):
        doubt = (
            f"which has no sign and comes to rest, while {effort.column} takes both signs: give a column whose sign "
        )
        draft.doubt("slip", f"{doubt}turns, or the position")


def _resists_both_ways(speed: Array, effort: Array) -> bool:
    """Whether an effort is large both ways, and a speed without a sign comes near rest, as in a motion to and fro."""
    known = np.isfinite(speed) & np.isfinite(effort)
    v = np.abs(speed[known][:LOOKED_AT])
    f = effort[known][:LOOKED_AT]
    if f.size < FEW or not np.any(v):
        return False
    fast = v > _FAST * v.max()
    forth = np.count_nonzero(fast & (f > _LARGE * np.abs(f).max()))
    back = np.count_nonzero(fast & (f < -_LARGE * np.abs(f).max()))
    rests = bool(v.min() <= _RESTS * v.max())
    return rests and bool(min(forth, back) >= _OFTEN * np.count_nonzero(fast))


def doubt_a_shear_rate_beside_a_torque(draft: Draft) -> None:
    """Doubt a guessed slip that is a shear rate beside a torque or a force, which make no power together."""
    effort = draft.signals.get("effort")
    slip = draft.signals.get("slip")
    if effort is None or slip is None or not slip.column or not slip.reason.startswith("guessed"):
        return
    is_called_a_rate = said_by_name(slip.column) == "rate"
    is_rate = is_called_a_rate and draft.seen.columns[slip.column].fits(("1/s",))
    if is_rate and effort.si in ("N*m", "N"):
        doubt = f"which is a shear rate, beside a torque or a force in {effort.si}"
        draft.doubt("slip", doubt)


def doubt_a_torque_in_a_unit_of_force(draft: Draft) -> None:
    """Doubt a guessed effort whose name is that of a torque and whose unit is one of force, or the other way round."""
    effort = draft.signals.get("effort")
    if effort is None or not effort.column or not effort.reason.startswith("guessed"):
        return
    form = draft.seen.columns[effort.column].spoken.forms["effort"]
    if effort.si not in _EFFORTS_BY_NAME:
        return
    for kind, names in _EFFORTS_BY_NAME.items():
        if form in names and effort.si != kind:
            doubt = f"which is called {form} and is in {effort.unit}, a unit of another kind"
            draft.doubt("effort", doubt)


def doubt_effort_without_power(draft: Draft) -> None:
    """Doubt a guess where effort and slip make no power together: a force beside turns is of some arm or another axis.

    Whoever names both is believed, and so is a whole name: the check before a fit warns of it. A force that a
    coefficient of friction is made of is the friction of this motion, at an arm that the file need not say.
    """
    effort = draft.signals.get("effort")
    slip = draft.signals.get("slip")
    if effort is None or slip is None or (effort.si, slip.si) not in _NO_POWER:
        return
    if effort.si == "N" and effort.column and effort.column == rubbing_force(draft.seen):
        return
    for guessed, other in ((effort, slip), (slip, effort)):
        if not guessed.column or guessed.sureness not in ("sure", "likely"):
            continue
        if draft.seen.columns[guessed.column].spoken.forms[guessed.signal]:
            continue  # its whole name says it
        why = f"in {guessed.si}, which makes no power with the {other.signal} in {other.si}"
        draft.doubt(guessed.signal, why)
        return
