"""Columns of several joints or motors: families of names that differ by a number, such as ``qd_1`` .. ``qd_7``.

A device is one of them. Which one, only the user knows; the file's name or the motion itself tells which is likely.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from erclutch.logs.columns.measured_names import beside_measured_names
from erclutch.logs.columns.names import headed, spoken_name, words_of
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.vocabulary import NAMES, OF_SEVERAL, TOLD

_MOTIONS = ("slip", "position")
#: What a drive says of a torque or a motion that it does not measure itself.
ESTIMATED = frozenset(("est", "estimate", "estimated"))
#: A joint's number in front of what was measured, as in lists of messages.
_WITHIN = re.compile(r"(.+?)\[(\d+)\][._/](\D+)")
#: The number of a joint in the name of a file.
_IN_FILE = re.compile(
    r"(?:joint|axis|achse|gelenk|motor|axe|eje|关节|軸|轴|関節)[ _-]?0*(\d+)", re.IGNORECASE
)

#: Columns of one family: number of the joint -> name of its column.
Family = dict[str, str]


def of_joints(seen: SeenColumns, signal: str, fitting: Iterable[SeenColumn]) -> list[str]:
    """Columns of a signal that has one for each joint, the likely joint first; none where no other signal has so many.

    Where the effort of one joint alone changes it is that joint: nothing was measured of the others.

    Args:
        seen: the columns of the log.
        signal: its name.
        fitting: columns whose unit may be that of the signal.
    """
    if signal not in (*_MOTIONS, "effort"):
        return []
    partners = ("effort",) if signal in _MOTIONS else _MOTIONS
    joints_of_partners: set[frozenset[str]] = set()
    for partner in partners:
        for family in _families(seen, partner, seen.columns.values()):
            joints_of_partners.add(frozenset(family))

    # All joints are at rest but the one whose effort changes, such as the free joint of an acrobot; none are where
    # several efforts change.
    moves: dict[str, bool] = {}  # joint -> whether one of its efforts changes
    for family in _families(seen, "effort", seen.columns.values()):
        for joint, name in family.items():
            moves[joint] = moves.get(joint, False) or not seen.columns[name].shape.constant
    at_rest = {joint for joint, changes in moves.items() if not changes}
    if len(moves) - len(at_rest) != 1:
        at_rest = set[str]()

    # The joint in the name of the file is likely, then those that move most.
    joint_of_file = joint_in_name(seen.table.name)
    names: list[str] = []
    for family in _families(seen, signal, fitting):
        if frozenset(family) not in joints_of_partners:
            continue
        moved = {joint: seen.columns[name].moved for joint, name in family.items()}
        likely_first = sorted(family, key=lambda joint: (joint != joint_of_file, -moved[joint]))
        names += [family[joint] for joint in likely_first if joint not in at_rest]
    return names if len(names) > 1 or at_rest else []


def joint_in_name(name: str) -> str:
    """The number of the one joint that the name of a file says; "" where it says none, or several."""
    numbers = {*_IN_FILE.findall(name)}
    return numbers.pop() if len(numbers) == 1 else ""


def _families(seen: SeenColumns, signal: str, columns: Iterable[SeenColumn]) -> list[Family]:
    """The families of two and more columns whose names speak for a signal.

    Of a robot without sensors of torque those are meant that its drives estimate (``tau_est_0``).
    """
    considered = [*columns]
    families = _named_families(seen, signal, considered, frozenset())
    if not families and signal == "effort":
        families = _named_families(seen, signal, considered, ESTIMATED)
    return families


def _named_families(
    seen: SeenColumns,
    signal: str,
    columns: Iterable[SeenColumn],
    passed_over: frozenset[str],
) -> list[Family]:
    """The families of `_families`; the words that are passed over say nothing against a name."""
    families: dict[str, Family] = {}  # by the name without a number
    for column in columns:
        spoken = column.spoken
        within = _WITHIN.fullmatch(spoken.stem)
        if within is not None:  # motor_state[0].dq: the number stands before the name
            before, number, last = within.groups()
            said = spoken_name(" ".join(word for word in words_of(last) if word not in passed_over))
            speaks = signal in said.may_be or said.plain_stem in NAMES[signal].split()
            if speaks and not said.says(TOLD):
                family = families.setdefault(f"{before}.{last}", {})
                family[number] = column.name
            continue
        bare = spoken.bare_stem
        if bare == spoken.plain_stem:
            continue
        is_estimated = spoken.says(passed_over)
        is_turned = signal in spoken.turned and not is_estimated
        if is_turned or spoken.says(TOLD):
            continue

        stem = spoken.stem
        if is_estimated:
            stem = " ".join(word for word in spoken.stem_words if word not in passed_over)
        head = headed(stem, signal, seen.shared_words) or spoken.heads.get(signal)
        if signal in spoken.numbered or head:
            joint = spoken.plain_stem.removeprefix(bare).lstrip("0") or "0"
            family = families.setdefault(bare, {})
            family[joint] = column.name

    several = [bare for bare, family in families.items() if len(family) > 1]
    # The torques of a compensation that is switched off never change, and are not those that were measured.
    moving: list[str] = []
    for bare in several:
        rests = all(seen.columns[name].shape.constant for name in families[bare].values())
        if not rests:
            moving.append(bare)
    several = moving or several
    # Beside torques that are said to be measured, those of the bare name are what the joints were told.
    names = {bare: next(iter(families[bare].values())) for bare in several}
    beside_measured = beside_measured_names(names.values())
    several = [bare for bare in several if names[bare] not in beside_measured]
    # A whole name goes before one with further words: qd before ee_qd.
    whole_names = NAMES[signal].split()
    whole = [bare for bare in several if OF_SEVERAL.get(bare, bare) in whole_names]
    return [families[bare] for bare in whole or several]
