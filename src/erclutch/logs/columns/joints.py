"""Columns of several joints or motors: families of names that differ by a number, such as ``qd_1`` .. ``qd_7``.

A device is one of them. Which one, only the user knows; the file's name or the motion itself tells which is likely.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from erclutch.logs.columns.names import NAMES, TOLD, headed
from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns

_MOTIONS = ("slip", "position")
_ESTIMATED = frozenset(("est", "estimate", "estimated"))
#: Words for the sides of a gear or a spring, each of which has a motion and a torque of its own.
_SIDES = frozenset(("motor", "rotor", "joint", "link", "load", "output", "input", "spring", "arm"))
#: The number of a joint in the name of a file.
_IN_FILE = re.compile(r"(?:joint|axis|achse|gelenk|motor|axe|eje|关节|軸|轴|関節)[ _-]?0*(\d+)", re.IGNORECASE)


def of_joints(seen: SeenColumns, signal: str, fitting: Iterable[SeenColumn]) -> list[str]:
    """Columns of a signal that has one for each joint, the likely joint first; none where no other signal has so many.

    Args:
        seen: the columns of the log.
        signal: its name.
        fitting: columns whose unit may be that of the signal.
    """
    if signal not in (*_MOTIONS, "effort"):
        return []
    families = _families(seen, signal, fitting)
    partners = ("effort",) if signal in _MOTIONS else _MOTIONS
    numbers = {frozenset(family) for other in partners for family in _families(seen, other, seen.columns.values())}
    names: list[str] = []
    for family in families:
        if frozenset(family) in numbers:
            names += [family[number] for number in _likely_first(seen, family)]
    return names if len(names) > 1 else []


def joint_of_file(seen: SeenColumns) -> str:
    """The number of a joint in the name of the log's file, "" for none or several."""
    numbers = {*_IN_FILE.findall(seen.table.name)}
    return numbers.pop() if len(numbers) == 1 else ""


def _families(seen: SeenColumns, signal: str, columns: Iterable[SeenColumn]) -> list[dict[str, str]]:
    """Names by the number behind them, of each family of two and more that speaks for the signal by its name.

    Of a robot without sensors of torque those are meant that its drives estimate (``tau_est_0``).
    """
    seen_ones = [*columns]
    found = _named_families(seen, signal, seen_ones, frozenset())
    if found or signal != "effort":
        return found
    return _named_families(seen, signal, seen_ones, _ESTIMATED)


def _named_families(
    seen: SeenColumns, signal: str, columns: Iterable[SeenColumn], passed_over: frozenset[str]
) -> list[dict[str, str]]:
    """The families of `_families`; the words that are passed over say nothing against a name."""
    families: dict[str, dict[str, str]] = {}
    for column in columns:
        stem = column.spoken.plain_stem
        bare = stem.rstrip("0123456789")
        number = stem.removeprefix(bare).lstrip("0") or "0"
        words = {*column.spoken.stem_words}
        is_estimated = not words.isdisjoint(passed_over)
        if bare == stem or not TOLD.isdisjoint(words) or (signal in column.spoken.turned and not is_estimated):
            continue
        name = " ".join(word for word in column.spoken.stem_words if word not in passed_over)
        own = headed(name if is_estimated else column.spoken.stem, signal, seen.shared_words)
        if signal in column.spoken.numbered or own or column.spoken.heads.get(signal):
            families.setdefault(bare, {})[number] = column.name
    several = [bare for bare, family in families.items() if len(family) > 1]
    # The torques of a compensation that is switched off never change, and are not those that were measured.
    moving: list[str] = []
    for bare in several:
        if not all(seen.columns[name].shape.constant for name in families[bare].values()):
            moving.append(bare)
    several = moving or several
    # A whole name goes before one with further words: qd before ee_qd.
    whole = [bare for bare in several if bare in NAMES[signal].split()]
    return [families[bare] for bare in whole or several]


def _likely_first(seen: SeenColumns, family: dict[str, str]) -> Sequence[str]:
    """The numbers of a family: that of the file's name first, then the joints that move most."""
    of_file = joint_of_file(seen)
    moved = {number: seen.columns[name].moved for number, name in family.items()}
    return sorted(family, key=lambda number: (number != of_file, -moved[number]))


def beside_a_gear(signal: str, named: Iterable[SeenColumn], fitting: Iterable[SeenColumn]) -> list[str]:
    """Columns of another side of a gear than those whose names speak: ``joint_vel`` beside ``motor_vel``."""
    own = {side_of(column) for column in named}
    if not own or "" in own or signal not in (*_MOTIONS, "effort"):
        return []
    others: list[str] = []
    for column in fitting:
        side = side_of(column)
        speaks = signal in column.spoken.may_be and TOLD.isdisjoint(column.spoken.stem_words)
        if speaks and side and side not in own:
            others.append(column.name)
    return others


def of_one_side(seen: SeenColumns, names: Sequence[str], partners: Iterable[str]) -> list[str]:
    """The one column on the side of the gear where all of its partners are; all of the columns where it is not one."""
    sides = {side_of(seen.columns[name]) for name in partners if name in seen.columns}
    if len(sides) != 1 or "" in sides:
        return [*names]
    alike = [name for name in names if name in seen.columns and side_of(seen.columns[name]) in sides]
    return alike if len(alike) == 1 else [*names]


def side_of(column: SeenColumn) -> str:
    """The word in a name for a side of a gear; "" for none and several."""
    words = {*column.spoken.stem_words}
    sides = words & _SIDES - ({"load"} if "cell" in words else set())
    return sides.pop() if len(sides) == 1 else ""
