"""A guess is doubted where the log speaks against it, by its numbers or its words: the user is asked to confirm it."""

from __future__ import annotations

import re

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.names import SENSES, words_of
from erclutch.logs.columns.powers_of_ten import both_ways, power_beside
from erclutch.logs.columns.quotients import rubbing_force
from erclutch.logs.columns.rheometer_names import of_oscillation, said_by_name
from erclutch.logs.columns.senses import DIRECTIONS
from erclutch.logs.columns.shapes import FEW, LOOKED_AT, known_rows, takes_both_signs
from erclutch.logs.planning.draft import Draft
from erclutch.signals import units
from erclutch.signals.array import Array

_FAST = 0.3  # of the largest speed, above which a device moves
_RESTS = 0.02  # of the largest speed, below which it comes near rest
_LARGE = 0.2  # of the largest effort
_OFTEN = 0.2  # of the rows that move
_ARMS = frozenset(
    {"arm", "arms", "lever", "leverarm", "hebel", "hebelarm", "bras", "levier", "brazo", "braccio"}
)
#: Names of efforts by the unit of their kind.
_EFFORTS_BY_NAME = {
    "N*m": ("torque", "moment", "drehmoment", "coppia"),
    "N": ("force", "kraft", "fuerza", "forza", "dampingforce"),
}
#: A unit with a plain number in front of it.
_RANGE = re.compile(r"\s*(\d{1,6}(?:\.\d+)?)\s*([^\W\d_].*?)\s*")
_NO_POWER = (("N", "rad/s"), ("N*m", "m/s"))  # units of effort and slip


def ask_about_ranges_of_sensors(draft: Draft) -> None:
    """Ask about a guessed signal whose unit begins with a number: ``Load [40 N]`` may name the range of its cell.

    A number below 1 is what a count of a converter is worth, and a power in ten is a factor.
    """
    for signal, guessed in [*draft.signals.items()]:
        unit = guessed.unit or ""
        match = _RANGE.fullmatch(unit)
        if (
            not guessed.reason.startswith("guessed")
            or match is None
            or float(match.group(1)) <= 1.0
        ):
            continue
        plain_unit = match.group(2)
        draft.take_back(signal)
        bare = f"--{signal} {shell_word(f'{guessed.column} [{plain_unit}]')}"
        multiple = f"--{signal} {shell_word(f'{guessed.column} [{unit}]')}"
        may_be = f"{plain_unit} with the range of its sensor, or steps of it"
        problem = f"the unit of column {guessed.column} is {unit}: {may_be}"
        draft.ask(
            signal, MappingError(problem, remedy=f"Say which: {bare}, or {multiple}"), option=bare
        )


def ask_about_powers_of_ten(draft: Draft) -> None:
    """Ask about a guessed signal with a power of ten beside its name: its numbers may be times it, or over it."""
    for signal, guessed in [*draft.signals.items()]:
        factor = power_beside(guessed.column or "")
        if factor is None or not guessed.reason.startswith("guessed"):
            continue
        draft.take_back(signal)
        unit = guessed.unit or guessed.si
        multiplied, over = both_ways(f"--{signal}", guessed.column, unit, factor)
        problem = f"the name of column {guessed.column} has a power of ten: its numbers may be times it, or over it"
        remedy = f"Say which: {multiplied} if they were multiplied by it, or {over}"
        draft.ask(signal, MappingError(problem, remedy=remedy), option=multiplied)


def doubt_a_force_at_a_stated_arm(draft: Draft) -> None:
    """Doubt a guessed force beside turns where the header states the arm of a lever: their product is the torque."""
    effort = draft.signals.get("effort")
    motion = draft.signals.get("slip") or draft.signals.get("position")
    if (
        effort is None
        or motion is None
        or not effort.column
        or not effort.reason.startswith("guessed")
    ):
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
        if DIRECTIONS.isdisjoint(words_of(name)) or np.unique(values[:LOOKED_AT]).size not in (
            2,
            3,
        ):
            continue
        draft.doubt(
            "slip",
            f"which has no sign, while {name} tells the direction: give a column whose sign turns",
        )
        return
    for name, column in draft.table.words.items():
        senses = [word for word in column.words if not SENSES.isdisjoint(words_of(word))]
        if len(senses) < 2:
            continue
        first, second, *_ = senses
        of_one_sense = shell_word(f"{name}={first}")
        says = f"which has no sign, while {name} says {first} and {second}"
        remedy = f"give a column whose sign turns, or --variable {of_one_sense} for the rows of one sense"
        draft.doubt("slip", f"{says}: {remedy}")
        return
    is_of_one_sense = any(
        note.startswith("rows where ") for note in draft.table.notes
    )  # the user chose them by a word
    if not is_of_one_sense and _resists_both_ways(speed, measured):
        doubt = f"which has no sign and comes to rest, while {effort.column} takes both signs"
        draft.doubt("slip", f"{doubt}: give a column whose sign turns, or the position")


def _resists_both_ways(speed: Array, effort: Array) -> bool:
    """Whether an effort is large both ways, and a speed without a sign comes near rest, as in a motion to and fro."""
    v, f = known_rows(speed, effort)
    v = np.abs(v)
    if f.size < FEW or not np.any(v):
        return False
    fast = v > _FAST * v.max()
    large = _LARGE * np.abs(f).max()
    forth = np.count_nonzero(fast & (f > large))
    back = np.count_nonzero(fast & (f < -large))
    is_often = min(forth, back) >= _OFTEN * np.count_nonzero(fast)
    comes_to_rest = v.min() <= _RESTS * v.max()
    return bool(comes_to_rest and is_often)


def doubt_what_a_rheometer_gives(draft: Draft) -> None:
    """Doubt a shear rate beside a torque, and the sizes of an oscillation."""
    _doubt_a_shear_rate_beside_a_torque(draft)
    _doubt_an_oscillation(draft)


def _doubt_a_shear_rate_beside_a_torque(draft: Draft) -> None:
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


def _doubt_an_oscillation(draft: Draft) -> None:
    """Doubt a guessed effort beside the moduli of an oscillation: a rheometer gives the sizes of its sines."""
    effort = draft.signals.get("effort")
    swings = of_oscillation(draft.seen.columns)
    if (
        effort is not None
        and effort.column
        and effort.reason.startswith("guessed")
        and len(swings) > 1
    ):
        draft.doubt(
            "effort", f"which is of an oscillation of a rheometer, beside {', '.join(swings[:3])}"
        )


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
