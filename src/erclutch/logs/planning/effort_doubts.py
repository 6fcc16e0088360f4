"""A guessed effort may be no effort of this motion: unit, name or header speak of an arm or another axis."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from erclutch.errors import UnitError, shell_word
from erclutch.logs.columns.arms_in_names import arm_in
from erclutch.logs.columns.labels import COUNTS
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.quotients import rubbing_force
from erclutch.logs.columns.rated_torque import share_of_rated_torque
from erclutch.logs.columns.two_courses import is_sum_of
from erclutch.logs.columns.vocabulary import DRIVES, set_of
from erclutch.logs.planning.draft import Draft
from erclutch.signals import units

_ARMS = set_of(
    "arm arms lever leverarm hebel hebelarm hebelarmlange bras levier brazo palanca braccio "
    "力臂 力臂长 力臂长度 杠杆臂 杠杆臂长 臂长 アーム アーム長 レバーアーム"
)
#: What the length of an arm is called behind a sensor of a force: ``Load cell at r = 0.15 m``.
_RADII = set_of("r radius rayon radio raggio 半径")
_OF_FORCES = set_of(
    "force load loadcell cell scale kraft kraftsensor kraftmessdose waegezelle wagezelle fuerza forza effort "
    "capteur 力 荷重"
)
#: A length at the front of a value, with a decimal comma too: ``0,15 m``, ``150 mm lever arm``.
_LENGTH = re.compile(r"(\d+)(?:[.,](\d+))? ?([^\W\d_]+)")
#: An option that makes a force of a weight: ``--effort "load cell [gf]"``.
_OF_A_WEIGHT = re.compile(r'--effort "[^"]*\[k?gf\]"')
#: A scale that makes a force of a weight: ``--scale "effort=1 gf/g"``.
_SCALE_OF_A_WEIGHT = re.compile(r"effort=1 (k?gf)/")
#: Names of efforts by the unit of their kind.
_EFFORTS_BY_NAME = {
    "N*m": ("torque", "moment", "drehmoment", "coppia"),
    "N": ("force", "kraft", "fuerza", "forza", "dampingforce"),
}
#: Words of a sensor of a force or a torque that name neither.
_OF_LOAD_CELLS = frozenset({"loadcell", "straingauge", "dms", "hx711", "ati", "transducer"})
#: Words for the force of the bench's own mass.
_OF_MASSES = frozenset({"inertia", "inertial", "traegheit", "tragheit", "tragheitskraft"})
#: Words for the part of a controller's output that its error makes; behind a drive it may be what was measured.
_FEEDBACKS = frozenset({"feedback", "fb", "fbk", "fdb", "pd", "pid"})
_LAST_DIGITS = 1e-3  # of the range, within which two forces make up a third
# Units of effort and slip. A stress makes a power with a shear rate, which the speed of a rotor is not.
_NO_POWER = (("N", "rad/s"), ("N*m", "m/s"), ("Pa", "rad/s"))


def doubt_a_force_at_a_stated_arm(draft: Draft) -> None:
    """Doubt a guessed force beside turns where the file states the arm of a lever: their product is the torque.

    Of a load cell without a unit nobody says whether its numbers are forces: they stay as logged.
    """
    effort = draft.guessed("effort")
    if effort is None or "effort" in draft.told.scales:
        return
    is_a_force = effort.si == "N"
    is_open = effort.unit is None and not _OF_FORCES.isdisjoint(words_of(effort.column))
    if not is_a_force and not is_open:
        return
    metres = arm_in(effort.column)
    arm = _stated_arm(draft) if metres is None else _Arm(metres, "")
    if arm is None or not _turns(draft):
        return
    label = shell_word(draft.table.label(effort.column))
    if is_a_force:
        says = f"and the file says {arm.said}" if arm.said else "and its name says an arm"
        doubt = f"which is a force beside turns, {says}"
        scale = f"effort={arm.metres:g} N*m/N"
    else:
        says = f"may be a force, for the file says {arm.said}"
        doubt = f"which has no unit beside turns and {says if arm.said else 'says an arm'}"
        scale = f"effort={arm.metres:g}"
    doubt += f": give --effort {label} alone if you want no torque"
    doubt += "" if is_a_force else ", or where it is a torque already"
    draft.doubt("effort", doubt, f"{label} --scale {shell_word(scale)}")


def add_a_stated_arm(draft: Draft) -> None:
    """Add the arm of a lever to an option that makes a force of the weight which a load cell shows beside turns."""
    question = draft.questions.get("effort")
    arm = _stated_arm(draft)
    if question is None or arm is None or not _turns(draft):
        return
    scale = shell_word(f"effort={arm.metres:g} N*m/N")
    at_the_arm = _OF_A_WEIGHT.sub(rf"\g<0> --scale {scale}", question.remedy)
    at_the_arm = _SCALE_OF_A_WEIGHT.sub(rf"effort={arm.metres:g} \1*m/", at_the_arm)
    if at_the_arm == question.remedy:
        return
    draft.questions["effort"] = replace(
        question.adding(f"; the file says {arm.said}"),
        remedy=at_the_arm,
        option=at_the_arm[at_the_arm.index("--effort") :],
    )


class _Arm(NamedTuple):
    """The length of a lever's arm, and the line of the file that says it; "" where a name does."""

    metres: float
    said: str


def _turns(draft: Draft) -> bool:
    motion = draft.signals.get("slip") or draft.signals.get("position")
    return motion is not None and motion.si in ("rad/s", "rad")


def _stated_arm(draft: Draft) -> _Arm | None:
    """The arm that a line above the rows states, or a column of its own that never changes; None where none does."""
    for key, text in draft.table.metadata.items():
        words = {*words_of(key), *words_of(text)}
        is_of_an_arm = not _ARMS.isdisjoint(words)
        is_of_a_sensor = not _RADII.isdisjoint(words) and not _OF_FORCES.isdisjoint(words)
        length = _LENGTH.match(text.strip())
        if length is None or not (is_of_an_arm or is_of_a_sensor):
            continue
        whole, decimals, unit = length.groups()
        try:
            metres = units.in_unit(f"{whole}.{decimals or 0} {unit}", "m")
        except UnitError:
            continue
        return _Arm(metres, f"{key} = {text}")
    for column in draft.seen.without(draft.taken):
        unit = column.unit or column.spoken.end
        is_of_an_arm = column.shape.constant and column.spoken.says(_ARMS)
        fitting = (
            units.fits(unit, ("m",)) if is_of_an_arm and unit and units.is_unit(unit) else None
        )
        if fitting is not None:
            length = float(column.values[0])
            return _Arm(length * fitting[0], f"{column.name} = {length:g} {unit}")
    return None


def doubt_a_share_of_a_rated_torque(draft: Draft) -> None:
    """Doubt a guessed effort without a unit that a drive tells in thousandths of its rated torque."""
    effort = draft.guessed("effort")
    if effort is None or effort.unit or "effort" in draft.told.scales:
        return
    share = share_of_rated_torque(draft.seen.columns[effort.column])
    if share is not None:
        doubt = f"in which a 1 is {share.words}, by its name, and no N m"
        draft.doubt("effort", doubt, share.option.removeprefix("--effort "))


def doubt_the_torque_of_a_drive(draft: Draft) -> None:
    """Doubt a guessed effort of a drive beside the output of a sensor of an effort: a drive computes its own."""
    effort = draft.guessed("effort")
    if effort is None or effort.sureness == "doubtful":
        return
    guessed = draft.seen.columns[effort.column]
    if not guessed.spoken.says(DRIVES | {"drives", "motors"}):
        return
    for other in draft.seen.without(draft.taken):
        says_effort = "effort" in other.spoken.may_be | other.spoken.within
        is_called_so = says_effort or not _OF_LOAD_CELLS.isdisjoint(other.spoken.stem_words)
        is_output = bool(other.fits(("V",))) or other.written_unit in COUNTS
        if not is_called_so or not is_output or other.shape.constant:
            continue
        label = shell_word(draft.table.label(other.name))
        scale = f"effort=NUMBER {effort.si or 'N*m'}/{other.unit_for(('V',)) or 'V'}"
        doubt = f"which a drive may compute, beside {other.name}, the output of a sensor: give --effort {label}"
        draft.doubt("effort", f"{doubt} --scale {shell_word(scale)} to take that")
        return


def doubt_an_effort_with_inertia(draft: Draft) -> None:
    """Doubt a guessed effort that another column and an inertia make up: the other column is the device's own."""
    effort = draft.guessed("effort")
    if effort is None:
        return
    measured = draft.table.columns[effort.column]
    moved = float(np.ptp(measured[np.isfinite(measured)])) if np.isfinite(measured).any() else 0.0
    others = draft.seen.without([effort.column])
    for inertia in others:
        if not inertia.spoken.says(_OF_MASSES):
            continue
        for own in others:
            parts = (own.values + inertia.values, own.values - inertia.values)
            off = [np.nanmax(np.abs(part - measured), initial=0.0) for part in parts]
            if own is not inertia and own.kind == inertia.kind and min(off) <= _LAST_DIGITS * moved:
                label = shell_word(draft.table.label(own.name))
                doubt = f"which is {own.name} and {inertia.name} together: a mass of the bench moves, too"
                draft.doubt("effort", doubt, label)
                return


def doubt_an_effort_of_a_controller(draft: Draft) -> None:
    """Doubt a guessed effort that a feedforward is a part of, or a feedback beside it: a controller's output."""
    effort = draft.guessed("effort")
    if effort is None:
        return
    guessed = draft.seen.columns[effort.column]
    beside = draft.seen.without([effort.column])
    alike = [column for column in beside if column.kind == guessed.kind]
    for told in alike:
        if "feedforward" not in told.spoken.stem_words:
            continue
        others = [other for other in alike if other is not told]
        is_output = any(is_sum_of(guessed.values, told.values, each.values) for each in others)
        if is_output or guessed.spoken.says(_FEEDBACKS):
            doubt = f"which goes with {told.name} as the output of a controller does: no sensor may have measured it"
            draft.doubt("effort", doubt)
            return


def doubt_effort_without_power(draft: Draft) -> None:
    """Doubt a guess where effort and slip make no power together: a force beside turns is of some arm or another axis.

    Whoever names both is believed, and so is a whole name: the check before a fit warns of it. A force that a
    coefficient of friction is made of is the friction of this motion, at an arm that the file need not say.
    """
    effort = draft.signals.get("effort")
    slip = draft.signals.get("slip")
    if effort is None or slip is None or (effort.si, slip.si) not in _NO_POWER:
        return
    if not effort.column:  # a number stands for it where a model estimates it
        return
    if effort.si == "N" and effort.column == rubbing_force(draft.seen):
        return
    for guessed, other in ((effort, slip), (slip, effort)):
        if not guessed.column or guessed.sureness not in ("sure", "likely"):
            continue
        if draft.seen.columns[guessed.column].spoken.forms[guessed.signal]:
            continue  # its whole name says it
        why = f"in {guessed.si}, which makes no power with the {other.signal} in {other.si}"
        # A rheometer's rotor turns at another speed than its fluid shears: nobody confirms such a pair by a word.
        answer = ""
        if effort.si == "Pa":
            answer = shell_word("COLUMN [1/s]" if guessed is slip else "COLUMN [N*m]")
        draft.doubt(guessed.signal, why, answer)
        return


def doubt_a_torque_in_a_unit_of_force(draft: Draft) -> None:
    """Doubt a guessed effort whose name is that of a torque and whose unit is one of force, or the other way round."""
    effort = draft.guessed("effort")
    if effort is None:
        return
    form = draft.seen.columns[effort.column].spoken.forms["effort"]
    if effort.si not in _EFFORTS_BY_NAME:
        return
    for kind, names in _EFFORTS_BY_NAME.items():
        if form in names and effort.si != kind:
            doubt = f"which is called {form} and is in {effort.unit}, a unit of another kind"
            # Pounds may be those of a torque at a foot or at an inch: as a force they would be read wrong.
            draft.doubt("effort", doubt, shell_word(f"{effort.column} [UNIT]"))
