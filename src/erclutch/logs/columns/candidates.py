"""Columns that may be a signal are found by what their names, their units and the shapes of their numbers say.

A column that says what another one says is left out: degrees beside radians, a travel beside a position. Where several
are left, the motion or a coefficient of friction may settle which it is (`guess`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.circuits import fields_among, one_of_a_circuit
from erclutch.logs.columns.joints import beside_a_gear, of_joints, of_one_side
from erclutch.logs.columns.labels import split_end
from erclutch.logs.columns.names import NEED_UNIT, OTHER, SINGLE, TOLD, headed, plain
from erclutch.logs.columns.quotients import (
    parts_of_a_model,
    pressing_loads,
    rubbing_force,
    speeds_of_machine,
    with_estimates,
)
from erclutch.logs.columns.seen_columns import KINDS, NO_UNITS, UNITS_OF_KIND, SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import follows, go_straight, is_rate_of, takes_both_signs
from erclutch.logs.columns.two_shafts import between_shafts, is_of_clutch
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS

#: Signals that a unit alone may tell.
_TOLD_BY_UNIT = ("field", "slip", "position", "effort", "T")
_LENGTHS = (
    "displacement",
    "disp",
    "extension",
    "elongation",
    "stroke",
    "crosshead",
    "weg",
    "deplacement",
    "desplazamiento",
)
#: What the length between the marks of a specimen is called in the headers of testing machines.
_GAUGE_LENGTH = re.compile(
    r"ga(?:u)?ge length|\bL0\b|messl(?:ä|ae)nge|longueur (?:initiale|utile|entre rep(?:è|e)res)|base de mesure|"
    r"longitud (?:inicial|calibrada)|標点距離|标距",
    re.IGNORECASE,
)
_SHEAR_RATES = frozenset({"gammadot", "shearrate"})
_WATT = "W"  # power is no signal
_DIGITS = 2e-3  # share of the largest number by which numbers written with some digits may differ


class Guess(NamedTuple):
    """A column that may be a signal, and what speaks for it: ``name``, ``unit``, with what settled it."""

    column: str
    reason: str


def guess(
    seen: SeenColumns, signal: str, taken: Iterable[str], units_of_sensor: tuple[str, ...] = (), motion: str = ""
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
    names, reason = candidates(seen, signal, taken, units_of_sensor)
    if len(names) > 1 and names[0] in seen.table.made:
        efforts, _ = candidates(seen, "effort", [*taken, *names])
        if is_of_clutch(seen, signal, names[0], efforts):
            return Guess(names[0], "names, as what two shafts or ends differ by")
    names = _without_raw(seen, names)
    if signal == "position":
        names = _one_motion(seen, names)
        measured = [name for name in names if len(names) > 1 and _has_gauge_length(seen, name)]
        if len(measured) == 1:
            names = measured
            reason += ", and the header gives the gauge length for it"
    if signal == "field" and len(names) > 1:
        efforts, _ = candidates(seen, "effort", [*taken, *names])
        names = one_of_a_circuit(seen, names, efforts)
    if signal == "effort" and len(names) > 1 and motion:
        kind = seen.columns[motion].kind
        kinds = {name: seen.columns[name].kind for name in names}
        alike = [name for name in names if kind and kinds[name] == kind]
        # Each of the others must be known to be of another kind.
        if len(alike) == 1 and all(kinds.values()):
            names = alike
            reason += f", and it is that of a {KINDS[kind]}"
    if signal == "slip" and len(names) > 1:
        efforts, _ = candidates(seen, "effort", [*taken, *names])
        # Only one of the speeds makes a power with the effort, whatever column that is.
        kinds_of_effort = {seen.columns[name].kind for name in efforts}
        kind = kinds_of_effort.pop() if len(kinds_of_effort) == 1 else ""
        if kind:
            fits = {name: seen.columns[name].fits(UNITS_OF_KIND[kind]) for name in names}
            alike = [name for name in names if fits[name]]
            if len(alike) == 1 and None not in fits.values():
                names = alike
                reason += f", and the effort is that of a {KINDS[kind]}"
    names = _beside_partners(seen, signal, names, taken, motion)
    if signal == "effort" and len(names) > 1:
        # A coefficient of friction says by its numbers which force is the friction and which presses.
        rubbing = rubbing_force(seen)
        if rubbing in names:
            names = [rubbing]
            reason += ", and a coefficient of friction is made of it"
    names = with_estimates(seen, names)
    if len(names) > 1:
        table = seen.table
        problem = f"{signal} may be any of the columns {', '.join(names)}; the file has: {table.listed}"
        remedy = f"Say which, such as --{signal} {shell_word(table.label(names[0]))}"
        if signal in ("effort", "T"):
            remedy += ", or --variable all if each is a log"
        raise MappingError(problem, remedy=remedy)
    return Guess(names[0], reason) if names else None


def _beside_partners(
    seen: SeenColumns, signal: str, names: Sequence[str], taken: Iterable[str], motion: str
) -> list[str]:
    """Of several columns the one on that side of a gear where the effort is, or the motion of an effort."""
    if len(names) < 2 or signal not in ("slip", "position", "effort"):
        return [*names]
    partners = [motion] if signal == "effort" else candidates(seen, "effort", [*taken, *names])[0]
    return of_one_side(seen, names, partners)


def candidates(
    seen: SeenColumns, signal: str, taken: Iterable[str], units_of_sensor: tuple[str, ...] = ()
) -> tuple[list[str], str]:
    """Columns that may be the signal, and what speaks for them: ``name`` or ``unit``.

    Args:
        seen: the columns of the log.
        signal: its name.
        taken: columns that are something else.
        units_of_sensor: units of the column where a scale makes the signal of it, such as V; then names alone speak.
    """
    of_two_shafts = between_shafts(seen, signal)
    if of_two_shafts:
        return of_two_shafts, "name"
    si_units = units_of_sensor or SIGNALS[signal].si_units
    free = seen.without([*taken, *pressing_loads(seen, signal)])
    fits = {column.name: column.fits(si_units) for column in free}

    if fits.get(signal, False) is not False:
        # A whole name with a unit speaks as loud as the bare word: a motor's slip is a share, beside its speed.
        bare = fits[signal] is None
        louder = [column.name for column in free if bare and fits[column.name] and column.spoken.forms[signal]]
        speeds = speeds_of_machine(seen.columns[signal], free) if signal == "slip" else []
        if speeds:
            return distinct(seen, speeds), "name, and column slip is the share by which a machine lags"
        return [signal, *louder], "name"

    told = frozenset[str]() if signal == "field" else TOLD
    free = [column for column in free if fits[column.name] or column.name.strip() != _WATT]
    fitting = [column for column in free if fits[column.name] is not False]
    if signal == "effort":
        parts = parts_of_a_model(fitting)
        free = [column for column in free if column.name not in parts]
        fitting = [column for column in fitting if column.name not in parts]
    forms = {column.name: column.spoken.forms[signal] for column in fitting}

    named: list[SeenColumn] = []
    for column in fitting:
        form = forms[column.name]
        speaks = form and (fits[column.name] or form not in NEED_UNIT)
        speaks = speaks or (signal == "field" and _is_v_of_a_voltage(seen, column))
        if speaks and told.isdisjoint(column.spoken.words):
            named.append(column)
    exact = [column for column in named if column.spoken.plain_stem == forms[column.name]]
    if named or units_of_sensor:
        names = [column.name for column in exact or named]
        if signal == "field":
            names = fields_among(seen, free, names, forms)
        names += beside_a_gear(signal, [] if exact else named, fitting)
        return distinct(seen, names), "name"

    # No whole name speaks. A short name may, where its numbers go with another column.
    heads = _heads(seen, fitting, signal)
    joints = of_joints(seen, signal, fitting)
    if joints:
        return joints, "name, of several joints"
    shaped = _shaped(seen, signal, fitting, heads)
    if shaped:
        return distinct(seen, shaped), "name and the shape of its numbers"

    by_unit = [column.name for column in free if fits[column.name] and _unit_speaks(column, signal, si_units)]
    headed_so = [name for name, head in heads.items() if head and (fits[name] or head not in NEED_UNIT)]
    if not headed_so:
        return distinct(seen, by_unit), "unit"

    # A head is no whole name: another column with such a unit may be the signal as well. Where all but the words that
    # most columns share is the head (C_1_Displacement), it is a whole one.
    whole: list[str] = []
    for name in headed_so:
        words = seen.columns[name].spoken.stem_words
        own = "".join(word for word in words if word not in seen.shared_words)
        if len(words) > 1 and own == heads[name]:
            whole.append(name)
    names = whole or [*headed_so, *(name for name in by_unit if name not in headed_so)]
    if signal == "field":
        names = fields_among(seen, free, names, heads)
    return distinct(seen, names), "name"


def _heads(seen: SeenColumns, columns: Iterable[SeenColumn], signal: str) -> dict[str, str | None]:
    """The heads of names, without words that most columns share; with them where these are the heads themselves.

    Of first encoder, second encoder and third encoder each is headed by what all share.
    """
    heads: dict[str, str | None] = {}
    with_shared: dict[str, str | None] = {}
    for column in columns:
        stem, _ = split_end(column.name)
        heads[column.name] = headed(stem, signal, seen.shared_words)
        with_shared[column.name] = column.spoken.heads.get(signal)
    return heads if any(heads.values()) else with_shared


def _is_v_of_a_voltage(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a bare V is a voltage: it keeps a few levels, and the velocity has a name of its own (xdot, speed)."""
    if column.spoken.plain != "v" or column.unit or not column.shape.keeps_levels:
        return False
    names = [other.spoken.forms["slip"] for other in seen.without([column.name])]
    return any(name and len(name) > 2 for name in names)


def _is_v_of_a_velocity(column: SeenColumn, others: Sequence[SeenColumn]) -> bool:
    """Whether a bare v turns back, an effort follows it, and the field is another column, which keeps its sign."""
    if column.spoken.plain != "v" or not takes_both_signs(column.values):
        return False
    fields = [other for other in others if other.spoken.forms["field"] and not takes_both_signs(other.values)]
    efforts = [other for other in others if other.spoken.forms["effort"]]
    return bool(fields) and any(follows(effort.values, column.values) for effort in efforts)


def _shaped(
    seen: SeenColumns, signal: str, fitting: Sequence[SeenColumn], heads: Mapping[str, str | None]
) -> list[str]:
    """Columns with a short name for the signal whose numbers go with another column, and those called like them.

    Args:
        seen: the columns of the log.
        signal: its name.
        fitting: columns whose unit may be that of the signal.
        heads: what speaks for the signal in their names.
    """
    told = frozenset[str]() if signal == "field" else TOLD
    shaped: list[str] = []
    for column in fitting:
        form = column.spoken.forms[signal]
        short = form or signal in column.spoken.numbered or heads[column.name] in NEED_UNIT
        if short and told.isdisjoint(column.spoken.words) and _goes_with(seen, column, signal):
            shaped.append(column.name)

    # Of joints or motors with numbers each may be meant, though one alone goes with another column.
    stems = {_unnumbered(seen.columns[name]) for name in shaped} - {""}
    alike = [column.name for column in fitting if _unnumbered(column) in stems]
    return [*shaped, *(name for name in alike if name not in shaped)]


def _unnumbered(column: SeenColumn) -> str:
    """A name without the number of the joint or motor behind it; "" where none stands there."""
    stem = column.spoken.plain_stem
    bare = stem.rstrip("0123456789")
    return bare if bare != stem else ""


def _unit_speaks(column: SeenColumn, signal: str, si_units: tuple[str, ...]) -> bool:
    """Whether a fitting unit alone tells the signal, since the name speaks for nothing else."""
    told = frozenset[str]() if signal == "field" else TOLD
    if signal not in _TOLD_BY_UNIT or column.unit_for(si_units) in (None, *NO_UNITS):
        return False
    if not (told | OTHER).isdisjoint(column.spoken.stem_words) or signal in column.spoken.turned:
        return False
    if signal in ("effort", "T") and column.spoken.is_primed:
        return False  # a modulus; the fluctuation of another quantity speaks, and is asked about beside its mean
    own = "effort" if signal == "T" else signal
    for other in SINGLE:
        form = column.spoken.forms[other] or ""
        if other != own and len(form) > 2:
            return False  # a force sensor in volts is no field
    return signal == "field" or not column.shape.constant


def _goes_with(seen: SeenColumns, column: SeenColumn, signal: str) -> bool:
    """Whether a short name that means several things is the signal by its numbers: the rate of a position, say."""
    if signal not in ("slip", "position", "effort") or column.written_unit:
        return False
    others = seen.without([column.name])
    positions = [other for other in others if "position" in other.spoken.may_be]
    speeds = [other for other in others if "slip" in other.spoken.may_be]
    if signal == "effort" and column.spoken.plain_stem == "tau" and any(map(_is_shear_rate, speeds)):
        return True  # the stress of a rheometer, beside whose shear rate a T is a temperature
    if signal == "slip":
        is_rate = any(is_rate_of(column.values, position.values, seen.stamps) for position in positions)
        return is_rate or _is_v_of_a_velocity(column, others)
    if signal == "position" and speeds:
        return any(is_rate_of(speed.values, column.values, seen.stamps) for speed in speeds)
    if signal == "position":  # no other motion is there
        efforts = [other for other in others if (other.spoken.forms["effort"] or "t") not in NEED_UNIT]
        return any(follows(effort.values, column.values) for effort in efforts)

    # A load beside a displacement is that of a testing machine.
    if column.spoken.forms["effort"] == "load":
        for other in others:
            named_so = other.spoken.forms["position"] in _LENGTHS
            if named_so or other.spoken.heads["position"] in _LENGTHS:
                return True
    return any(follows(column.values, motion.values) for motion in (*positions, *speeds))


def _is_shear_rate(column: SeenColumn) -> bool:
    """Whether a column is called like a shear rate."""
    return column.spoken.plain_stem in _SHEAR_RATES


# --- columns that say the same ---------------------------------------------------------------------------------------


def distinct(seen: SeenColumns, names: Iterable[str]) -> list[str]:
    """Columns without those that never change beside some that do, and without the same numbers in another unit."""
    columns = [seen.columns[name] for name in names]
    moving = [column for column in columns if not column.shape.constant]
    kept: list[SeenColumn] = []
    for column in moving or columns:
        if not any(_one_quantity(column, other) for other in kept):
            kept.append(column)
    return [column.name for column in kept]


def _without_raw(seen: SeenColumns, names: Sequence[str]) -> list[str]:
    """Columns without each that has no unit and goes straight with one that has: the counts of its converter."""
    columns = [seen.columns[name] for name in names]
    with_unit = [column for column in columns if column.written_unit]
    kept: list[str] = []
    for column in columns:
        is_raw = not column.written_unit and any(go_straight(column.values, other.values) for other in with_unit)
        if not is_raw:
            kept.append(column.name)
    return kept


def _one_motion(seen: SeenColumns, names: Iterable[str]) -> list[str]:
    """Positions without those that say the same from another zero: a travel beside an absolute one."""
    kept: list[SeenColumn] = []
    for name in names:
        column = seen.columns[name]
        alike = (other for other in kept if other.unit == column.unit)
        if not any(_move_alike(column.values, other.values) for other in alike):
            kept.append(column)
    return [column.name for column in kept]


def _has_gauge_length(seen: SeenColumns, name: str) -> bool:
    """Whether the header gives the length of a specimen, from which it is stretched, for a column by its name."""
    keys = (key for key, text in seen.table.metadata.items() if text and _GAUGE_LENGTH.search(key))
    return any(plain(name) in plain(key) for key in keys)


def _one_quantity(column: SeenColumn, other: SeenColumn) -> bool:
    """Whether two columns with units hold one quantity: degrees beside radians."""
    unit = column.written_unit
    other_unit = other.written_unit
    if not unit or not other_unit:
        return False
    if not units.is_unit(unit) or not units.is_unit(other_unit):
        return False
    first = units.parse(unit)
    second = units.parse(other_unit)
    if first.dimension != second.dimension or first.factor == second.factor:
        return False

    one = column.values * first.factor
    two = other.values * second.factor
    known = np.isfinite(one) & np.isfinite(two)
    largest = float(np.abs(one[known]).max(initial=0.0))
    if not largest > 0.0:
        return False
    off = np.abs(one - two)[known]
    return bool(off.max() <= _DIGITS * largest)


def _move_alike(first: Array, second: Array) -> bool:
    """Whether two positions in one unit differ in where they count from, and in nothing else."""
    known = np.isfinite(first) & np.isfinite(second)
    if not known.any():
        return False
    moved = float(np.ptp(first[known]))
    apart = (first - second)[known]
    return bool(moved > 0.0 and np.ptp(apart) <= _DIGITS * moved)
