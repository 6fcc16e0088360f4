"""Of several columns that may be a signal one is chosen, where the other columns settle which it is; else it is asked.

Each signal has a file of what settles it: `field_of_a_circuit`, `one_motion`, `one_effort`. Counts beside volts are no
second column of any.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from erclutch.errors import SeveralColumnsError, shell_word
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.labels import without_copy_number
from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.columns.two_courses import go_straight
from erclutch.logs.columns.two_shafts import is_of_clutch
from erclutch.logs.columns.vocabulary import DRIVES, NOT_MEASURED
from erclutch.logs.planning.field_of_a_circuit import one_of_a_circuit
from erclutch.logs.planning.one_effort import one_effort
from erclutch.logs.planning.one_motion import one_position, one_slip
from erclutch.logs.planning.two_ends import motion_between

#: Words for the device itself. A clutch is driven too: its motor's speed is that of one of its sides.
_DEVICES = frozenset(
    ("brake", "bremse", "frein", "freno", "damper", "dampfer", "daempfer", "amortisseur")
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
    names = _with_namesakes(seen, names, taken)
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
        names = one_of_a_circuit(seen, names, efforts)
    elif len(names) > 1 and signal == "slip":
        names, why = one_slip(seen, names, taken)
    elif len(names) > 1 and signal == "position":
        names, why = one_position(seen, names, taken)
    elif len(names) > 1 and signal == "effort":
        names, why = one_effort(seen, names, motion)
    names = _with_estimates(seen, names)
    if not names:
        return None
    if len(names) == 1:
        return Guess(names[0], f"{reason}{why}")

    table = seen.table
    problem = f"{signal} may be any of the columns {', '.join(names)}; the file has: {table.listed}"
    between = ""
    if signal in ("slip", "position"):
        efforts, _ = candidates(seen, "effort", [*taken, *names])
        between = motion_between(seen, names, efforts)
    if between:
        problem = problem.replace("; the file has", ", or what they differ by; the file has")
    first = f"--{signal} {shell_word(between or table.label(names[0]))}"
    remedy = f"Say which, such as {first}"
    option = ""
    if signal in ("effort", "T"):
        option = "--variable all"
        remedy += f", or {option} if each is a log"
    # A position answers for the slip that is missing; which column is proposed for other signals is told later.
    answers = [first] if signal == "position" else []
    raise SeveralColumnsError(problem, remedy=remedy, answers=answers, option=option)


def _with_namesakes(seen: SeenColumns, names: Sequence[str], taken: Sequence[str]) -> list[str]:
    """The names, and each further column that the file calls the same: ``Force (2)`` beside ``Force``.

    A column that repeats the numbers of the first one is none.
    """
    every: list[str] = []
    for name in names:
        every.append(name)
        for other in seen.without([*taken, *names]):
            is_a_copy = np.array_equal(other.values, seen.columns[name].values, equal_nan=True)
            if without_copy_number(other.name) == name and not is_a_copy:
                every.append(other.name)
    return every


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
