"""Of several columns that may be a signal one is chosen, where the other columns settle which it is; else it is asked.

The motion tells a torque from a force, and the effort tells the speed that makes a power with it. A circuit has one
field, a gear an effort on one side, and a coefficient of friction says which force rubs.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.alike import without_other_zeros, without_raw
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.circuits import one_of_a_circuit
from erclutch.logs.columns.joints import of_one_side, of_the_device
from erclutch.logs.columns.names import plain
from erclutch.logs.columns.of_a_model import with_estimates
from erclutch.logs.columns.quotients import rubbing_force
from erclutch.logs.columns.seen_columns import KINDS, UNITS_OF_KIND, SeenColumns
from erclutch.logs.columns.two_shafts import is_of_clutch

#: What the length between the marks of a specimen is called in the headers of testing machines.
_GAUGE_LENGTH = re.compile(
    r"ga(?:u)?ge length|\bL0\b|messl(?:ä|ae)nge|longueur (?:initiale|utile|entre rep(?:è|e)res)|base de mesure|"
    r"longitud (?:inicial|calibrada)|標点距離|标距",
    re.IGNORECASE,
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

    names = without_raw(seen, names)
    if signal != "field":
        names = of_the_device(seen, names)
    why = ""
    if len(names) > 1 and signal == "field":
        efforts, _ = candidates(seen, "effort", [*taken, *names])
        names = one_of_a_circuit(seen, names, efforts)
    elif len(names) > 1 and signal == "slip":
        names, why = _one_slip(seen, names, taken)
    elif len(names) > 1 and signal == "position":
        names, why = _one_position(seen, names, taken)
    elif len(names) > 1 and signal == "effort":
        names, why = _one_effort(seen, names, motion)
    names = with_estimates(seen, names)
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
    return of_one_side(seen, speeds, efforts), ""


def _one_position(seen: SeenColumns, positions: list[str], taken: Sequence[str]) -> tuple[list[str], str]:
    """The position whose gauge length the header gives, from which a specimen is stretched; else as for a slip."""
    positions = without_other_zeros(seen, positions)
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
    return of_one_side(seen, positions, efforts), ""


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
    efforts = of_one_side(seen, efforts, [motion])
    # A coefficient of friction says by its numbers which force is the friction and which presses.
    rubbing = rubbing_force(seen) if len(efforts) > 1 else ""
    if rubbing in efforts:
        return [rubbing], ", and a coefficient of friction is made of it"
    return efforts, ""
