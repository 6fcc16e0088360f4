"""What a log of several joints holds of each of them besides: positions, currents and commands of their drives.

None of them is the field. What is called like the field of a fluid, or like a coil, still may be.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np

from erclutch.logs.columns.machines_in_names import is_of_a_drive
from erclutch.logs.columns.names import SpokenName, spoken_name
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.vocabulary import CURRENTS, VOLTAGES, set_of
from erclutch.logs.planning.field_doubts import LARGEST_SUPPLY
from erclutch.signals import units

#: What tells a joint from the others: a number, or words.
OwnWords = tuple[str, ...]

#: Words of a device with a fluid, whose joints may each have a field.
_OF_FLUIDS = set_of(
    "field feld champ campo coil spule bobine bobina magnet magnetic electric brake bremse frein freno clutch "
    "kupplung embrayage damper dampfer mr er excitation b e"
)
#: Words of what a drive tells of itself, besides its current and its voltage.
_OF_DRIVES = set_of("pwm duty dutycycle command cmd")


def why_no_fields(
    seen: SeenColumns, words: dict[str, OwnWords], joints: Collection[OwnWords]
) -> dict[str, str]:
    """Why columns that each joint has are no field, by the column.

    Args:
        seen: the columns of the log.
        words: of each column.
        joints: what tells them apart.
    """
    families: dict[OwnWords, dict[OwnWords, str]] = {}  # shared words -> joint -> column
    for name, own in words.items():
        joint = _joint_in(own, joints)
        if joint is not None:
            (place,) = _places(own, joint)
            shared = own[:place] + own[place + len(joint) :]
            families.setdefault(shared, {})[joint] = name
    whys: dict[str, str] = {}
    for shared, family in families.items():
        columns = [seen.columns[name] for name in family.values()]
        why = _why_no_field(spoken_name(" ".join(shared)), columns)
        if why and len(family) == len(joints):
            whys |= dict.fromkeys(family.values(), why)
    return whys


def _joint_in(words: Sequence[str], joints: Iterable[OwnWords]) -> OwnWords | None:
    """The joint whose words stand in a name; of several the longest: ``left elbow`` beside ``elbow``."""
    within = [joint for joint in joints if _places(words, joint)]
    longest = max((len(joint) for joint in within), default=0)
    likely = [joint for joint in within if len(joint) == longest]
    return likely[0] if len(likely) == 1 and len(_places(words, likely[0])) == 1 else None


def _places(words: Sequence[str], joint: OwnWords) -> list[int]:
    """Where the words of a joint begin in a name."""
    ends = range(len(words) - len(joint) + 1)
    return [place for place in ends if tuple(words[place : place + len(joint)]) == joint]


def _why_no_field(said: SpokenName, columns: Sequence[SeenColumn]) -> str:
    """Why columns that each joint has are no field, by what they share in their names; "" where they may be."""
    if said.says(_OF_FLUIDS):
        return ""
    says = said.may_be | said.within
    if says & {"slip", "position"}:
        return "is a motion of a joint"
    if "effort" in says:
        return "is an effort of a joint"
    if said.is_accounted:
        return "is another quantity of a joint"
    if said.says(CURRENTS | VOLTAGES | _OF_DRIVES) or is_of_a_drive(said) or "field" in says:
        return "is what the drive of a joint gets" if _are_of_drives(columns) else ""
    return ""


def _are_of_drives(columns: Sequence[SeenColumn]) -> bool:
    """Whether what joints get makes them turn to either side, or is the supply of their drives.

    A coil that makes a fluid stiff gets a current of one sign, and a fluid in an electric field some kilovolts.
    """
    for column in columns:
        unit = column.unit_for(("V",)) if column.fits(("V",)) else None
        volts = units.parse(unit).factor if unit else 1.0
        if np.nanmax(np.abs(column.values), initial=0.0) * volts > LARGEST_SUPPLY and unit:
            return False
    turn_back = any(takes_both_signs(each.values) for each in columns)
    return turn_back or all(each.is_steady for each in columns)
