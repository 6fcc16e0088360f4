"""Columns that may be a signal are found by what their names, their units and the shapes of their numbers say.

A whole name speaks first. Where none does, a joint's or a short name may, and then a unit or the head of a name. A
column that says what another one says is left out: degrees beside radians, a travel beside a position.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from erclutch.logs.columns.joints import ESTIMATED, of_joints
from erclutch.logs.columns.machines_in_names import is_of_a_drive
from erclutch.logs.columns.measured_names import (
    measured_beside_frictions,
    of_whole_names,
    planned_beside_measured,
)
from erclutch.logs.columns.names import headed, spoken_name
from erclutch.logs.columns.parts_of_efforts import parts_of_efforts
from erclutch.logs.columns.phases import is_of_phases
from erclutch.logs.columns.quotients import pressing_loads, speeds_of_machine
from erclutch.logs.columns.rated_torque import is_rating
from erclutch.logs.columns.seen_columns import NO_UNITS, SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.two_courses import follows, is_rate_of
from erclutch.logs.columns.two_shafts import between_shafts
from erclutch.logs.columns.vocabulary import (
    COMMANDS,
    CURRENTS,
    DRIVES,
    NEED_UNIT,
    OTHER,
    SINGLE,
    TOLD,
    VOLTAGES,
)
from erclutch.signals import units
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
_SHEAR_RATES = ("gammadot", "shearrate")
#: Share of the largest number by which numbers written with some digits may differ.
DIGITS = 2e-3
_LAGS = ("slip", "schlupf")
_WATT = "W"  # power is no signal

#: Columns that may be a signal, and what speaks for them.
Candidates = tuple[list[str], str]


def candidates(
    seen: SeenColumns,
    signal: str,
    taken: Iterable[str],
    units_of_sensor: tuple[str, ...] = (),
) -> Candidates:
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
    if signal == "field":
        free = [column for column in free if not is_of_phases(seen, column)]
    if signal == "slip":
        shares = slips_in_percent(free)
        free = [column for column in free if column.name not in shares]
    free = _without_plans(signal, free, si_units)
    fits = {column.name: column.fits(si_units) for column in free}

    if fits.get(signal, False) is not False:  # a column has the bare name of the signal
        speeds = speeds_of_machine(seen.columns[signal], free) if signal == "slip" else []
        if speeds:
            why = "name, and column slip is the share by which a machine lags"
            return _distinct(seen, speeds), why
        # A whole name with a unit speaks as loud as the bare word: a motor's slip is a share, beside its speed.
        louder: list[str] = []
        for column in free:
            if fits[signal] is None and fits[column.name] and column.spoken.forms[signal]:
                louder.append(column.name)
        return [signal, *louder], "name"

    free = [column for column in free if fits[column.name] or column.name.strip() != _WATT]
    if signal == "effort":
        parts = parts_of_efforts([each for each in free if fits[each.name] is not False])
        free = [each for each in free if each.name not in parts and not is_rating(each)]
    fitting = [column for column in free if fits[column.name] is not False]
    forms = {column.name: column.spoken.forms[signal] for column in fitting}

    named: list[SeenColumn] = []  # their whole names speak
    for column in fitting:
        form = forms[column.name]
        speaks = bool(form and (fits[column.name] or form not in NEED_UNIT))
        is_bare_v = signal == "field" and column.spoken.plain == "v" and not column.unit
        if is_bare_v and column.shape.keeps_levels:
            # A voltage, where the velocity has a name of its own (xdot, speed). Beside turns it may be that of a rim.
            others = seen.without([column.name])
            named_speeds = [other for other in others if len(other.spoken.forms["slip"] or "") > 2]
            speaks = speaks or (
                bool(named_speeds) and all(other.kind != "N*m" for other in named_speeds)
            )
        if speaks and _told_of(signal).isdisjoint(column.spoken.words):
            named.append(column)
    if not named and not units_of_sensor:
        return _without_a_whole_name(seen, signal, free, si_units)

    exact = of_whole_names(named, forms)
    names = measured_beside_frictions(signal, exact or named, fitting)
    if signal == "field":
        names = _fields_among(seen, free, names, forms)
    if not exact:
        names += _beside_a_gear(signal, named, fitting)
    names += [
        name for name in _beside_a_drive(signal, exact or named, fitting) if name not in names
    ]
    return _distinct(seen, names), "name"


def slips_in_percent(columns: Iterable[SeenColumn]) -> list[str]:
    """Names of slips in per cent: no speeds, but the share by which a belt, a tyre, a filament or a machine lags.

    A slip without a unit that ends at 100 tells itself: whoever measures a speed to some digits meets no such end.
    """
    shares: list[str] = []
    for column in columns:
        if column.spoken.forms["slip"] not in _LAGS:
            continue
        is_said = "%" in column.name or column.unit == "%"
        known = column.values[np.isfinite(column.values)]
        are_levels = bool(np.all(known % 1.0 == 0.0))
        ends_at_100 = not are_levels and known.max() == 100.0 and known.min() >= -100.0
        if is_said or (column.written_unit is None and ends_at_100):
            shares.append(column.name)
    return shares


def _without_plans(
    signal: str, columns: Sequence[SeenColumn], si_units: tuple[str, ...]
) -> list[SeenColumn]:
    """The columns without what was planned and stands beside its measurement; a field may be what a supply was told."""
    if signal == "field":
        return [*columns]
    fitting = [column for column in columns if column.fits(si_units) is not False]
    planned = planned_beside_measured(fitting)
    return [column for column in columns if column.name not in planned]


def _told_of(signal: str) -> frozenset[str]:
    """Words that say that a column is what a drive was told; a field is what a supply was told."""
    return frozenset() if signal == "field" else TOLD


def _without_a_whole_name(
    seen: SeenColumns,
    signal: str,
    free: Sequence[SeenColumn],
    si_units: tuple[str, ...],
) -> Candidates:
    """Columns that may be a signal though no whole name says so: by a joint, a short name, a unit or a head.

    Args:
        seen: the columns of the log.
        signal: its name.
        free: columns that are nothing else.
        si_units: of the signal.
    """
    if signal == "effort":  # what a model says of the effort is none
        free = [column for column in free if not column.spoken.is_of_a_model]
    fits = {column.name: column.fits(si_units) for column in free}
    fitting = [column for column in free if fits[column.name] is not False]
    joints = of_joints(seen, signal, fitting)
    if joints:
        only = "name, of the only joint whose effort changes"
        return joints, "name, of several joints" if len(joints) > 1 else only

    # The heads of names, without words that most columns share; with them where these are the heads themselves: of
    # first encoder, second encoder and third encoder each is headed by what all share.
    heads: dict[str, str | None] = {}
    for column in fitting:
        heads[column.name] = headed(column.spoken.stem, signal, seen.shared_words)
    if not any(heads.values()):
        heads = {column.name: column.spoken.heads.get(signal) for column in fitting}

    shaped = _shaped(seen, signal, fitting, heads)
    if shaped:
        return _distinct(seen, shaped), "name and the shape of its numbers"

    by_unit: list[str] = []
    for column in free:
        if fits[column.name] and _unit_speaks(column, signal, si_units):
            by_unit.append(column.name)
    headed_so: list[str] = []
    for name, head in heads.items():
        if head and (fits[name] or head not in NEED_UNIT):
            headed_so.append(name)
    if not headed_so:
        estimated = [] if by_unit else _estimated(signal, fitting)
        why = "name, as the drive estimates it" if estimated else "unit"
        return _distinct(seen, by_unit or estimated), why

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
        names = _fields_among(seen, free, names, heads)
    return _distinct(seen, names), "name"


def _estimated(signal: str, columns: Iterable[SeenColumn]) -> list[str]:
    """Columns called like a motion that a drive estimates by its encoder, such as ``vel_estimate``."""
    names: list[str] = []
    for column in columns:
        if signal not in ("slip", "position") or not column.spoken.says(ESTIMATED):
            continue
        words = column.spoken.stem_words
        said = spoken_name(" ".join(word for word in words if word not in ESTIMATED))
        if signal in said.may_be and len(said.plain_stem) > 1:  # y_est may be of anything
            names.append(column.name)
    return names


def _shaped(
    seen: SeenColumns,
    signal: str,
    fitting: Sequence[SeenColumn],
    heads: Mapping[str, str | None],
) -> list[str]:
    """Columns with a short name for the signal whose numbers go with another column, and those called like them.

    Args:
        seen: the columns of the log.
        signal: its name.
        fitting: columns whose unit may be that of the signal.
        heads: what speaks for the signal in their names.
    """
    shaped: list[str] = []
    stems: set[str] = set()  # of those with the number of a joint or motor behind the name
    for column in fitting:
        spoken = column.spoken
        of_letters = spoken.numbered | spoken.lettered
        is_short = spoken.forms[signal] or signal in of_letters or heads[column.name] in NEED_UNIT
        is_told = not _told_of(signal).isdisjoint(spoken.words)
        if is_short and not is_told and _goes_with(seen, column, signal):
            shaped.append(column.name)
            if spoken.bare_stem not in ("", spoken.plain_stem):
                stems.add(spoken.bare_stem)

    # Of joints or motors with numbers each may be meant, though one alone goes with another column.
    for column in fitting:
        spoken = column.spoken
        is_numbered = spoken.bare_stem != spoken.plain_stem
        if is_numbered and spoken.bare_stem in stems and column.name not in shaped:
            shaped.append(column.name)
    return shaped


def _goes_with(seen: SeenColumns, column: SeenColumn, signal: str) -> bool:
    """Whether a short name that means several things is the signal by its numbers: the rate of a position, say."""
    if signal not in ("slip", "position", "effort") or column.written_unit:
        return False
    others = seen.without([column.name])
    positions = [
        other for other in others if "position" in other.spoken.may_be | other.spoken.lettered
    ]
    speeds = [other for other in others if "slip" in other.spoken.may_be | other.spoken.lettered]
    efforts = [other for other in others if other.spoken.forms["effort"]]
    if signal == "slip":
        if any(is_rate_of(column.values, position.values, seen.stamps) for position in positions):
            return True
        # A bare v that turns back is a velocity, where an effort follows it and the field, which keeps its sign, is
        # another column.
        if column.spoken.plain != "v" or not takes_both_signs(column.values):
            return False
        fields = [
            other
            for other in others
            if other.spoken.forms["field"] and not takes_both_signs(other.values)
        ]
        return bool(fields) and any(follows(effort.values, column.values) for effort in efforts)
    if signal == "position":
        if speeds:
            return any(is_rate_of(speed.values, column.values, seen.stamps) for speed in speeds)
        # No other motion is there.
        efforts = [effort for effort in efforts if effort.spoken.forms["effort"] not in NEED_UNIT]
        return any(follows(effort.values, column.values) for effort in efforts)

    # The tau of a joint beside a motion of the same joint is its torque, whatever its numbers do: elbow_tau, elbow_pos.
    is_tau = column.spoken.stem_words[-1:] == ("tau",) and not column.shape.constant
    if is_tau and column.limb and any(each.limb == column.limb for each in (*positions, *speeds)):
        return True
    # The stress of a rheometer, beside whose shear rate a T is a temperature.
    if column.spoken.plain_stem == "tau" and any(
        speed.spoken.plain_stem in _SHEAR_RATES for speed in speeds
    ):
        return True
    # A load beside a displacement is that of a testing machine.
    if column.spoken.forms["effort"] == "load":
        for other in others:
            called = (other.spoken.forms["position"], other.spoken.heads["position"])
            if any(name in _LENGTHS for name in called):
                return True
    return any(follows(column.values, motion.values) for motion in (*positions, *speeds))


def _unit_speaks(column: SeenColumn, signal: str, si_units: tuple[str, ...]) -> bool:
    """Whether a fitting unit alone tells the signal, since the name speaks for nothing else."""
    if signal not in _TOLD_BY_UNIT or column.unit_for(si_units) in (None, *NO_UNITS):
        return False
    is_told_or_other = column.spoken.says(_told_of(signal) | OTHER)
    is_a_time = column.is_called_time and len(column.name) > 1
    if is_told_or_other or is_a_time or signal in column.spoken.turned:
        return False
    if signal in ("effort", "T") and column.spoken.is_primed:
        return False  # a modulus; the fluctuation of another quantity speaks, and is asked about beside its mean
    own = "effort" if signal == "T" else signal
    for other in SINGLE:
        form = column.spoken.forms[other] or ""
        if other != own and len(form) > 2:
            return False  # a force sensor in volts is no field
    return signal == "field" or not column.shape.constant


def _fields_among(
    seen: SeenColumns,
    free: Iterable[SeenColumn],
    named: Sequence[str],
    forms: Mapping[str, str | None],
) -> list[str]:
    """Columns that may be the field: beside voltages the currents too, and none that is the voltage of a supply.

    Args:
        seen: the columns of the log.
        free: columns that are nothing else.
        named: those of them that are called like the field.
        forms: what speaks for the field in their names.
    """
    fields = [*named]
    if {forms.get(name) for name in named} <= VOLTAGES | COMMANDS:
        # The current of a coil is its field as much as its voltage is, or what its supply was told.
        for column in free:
            if column.name in named or column.shape.constant or not column.fits(("A",)):
                continue
            is_told_or_other = column.spoken.says(TOLD | OTHER)
            if "field" not in column.spoken.turned and not is_told_or_other:
                fields.append(column.name)

    # A column that hardly changes while another one does is that of a supply.
    if not any(seen.columns[name].varies for name in fields):
        return fields
    return [name for name in fields if not seen.columns[name].is_steady]


def _beside_a_gear(
    signal: str, named: Iterable[SeenColumn], fitting: Iterable[SeenColumn]
) -> list[str]:
    """Columns of another side of a gear than those whose names speak: ``joint_vel`` beside ``motor_vel``."""
    sides_of_named = {column.side for column in named}
    if not sides_of_named or "" in sides_of_named or signal not in ("slip", "position", "effort"):
        return []
    of_other_sides: list[str] = []
    for column in fitting:
        side = column.side
        speaks = signal in column.spoken.may_be and not column.spoken.says(TOLD)
        if speaks and side and side not in sides_of_named:
            of_other_sides.append(column.name)
    return of_other_sides


def _beside_a_drive(
    signal: str, named: Iterable[SeenColumn], fitting: Iterable[SeenColumn]
) -> list[str]:
    """Columns that may be the device's, where all whole names are a drive's: ``flange torque``, ``magnet current``."""
    own = [*named]
    names = {column.name for column in own}
    are_of_drives = bool(own) and all(
        is_of_a_drive(each.spoken) or not DRIVES.isdisjoint(each.spoken.words) for each in own
    )
    if signal not in ("slip", "effort", "field") or not are_of_drives:
        return []
    others: list[str] = []
    for column in fitting:
        speaks = signal in column.spoken.may_be and signal not in column.spoken.turned
        is_no_current = not column.spoken.says(CURRENTS) or column.fits(("A",)) is False
        if column.name in names or (signal == "field" and is_no_current):
            continue
        if speaks and not column.spoken.says(TOLD):
            others.append(column.name)
    return others


def _distinct(seen: SeenColumns, names: Iterable[str]) -> list[str]:
    """Columns without those that never change beside some that do, and without the same numbers in another unit."""
    columns = [seen.columns[name] for name in names]
    moving = [column for column in columns if not column.shape.constant]
    kept: list[SeenColumn] = []
    for column in moving or columns:
        if not any(_are_one_quantity(column, other) for other in kept):
            kept.append(column)
    return [column.name for column in kept]


def _are_one_quantity(column: SeenColumn, other: SeenColumn) -> bool:
    """Whether two columns with units hold one quantity: degrees beside radians."""
    unit = column.written_unit
    other_unit = other.written_unit
    if not unit or not other_unit:
        return False
    if not units.is_unit(unit) or not units.is_unit(other_unit):
        return False
    meaning = units.parse(unit)
    other_meaning = units.parse(other_unit)
    if meaning.dimension != other_meaning.dimension or meaning.factor == other_meaning.factor:
        return False

    in_si = column.values * meaning.factor
    other_in_si = other.values * other_meaning.factor
    known = np.isfinite(in_si) & np.isfinite(other_in_si)
    largest = float(np.abs(in_si[known]).max(initial=0.0))
    if not largest > 0.0:
        return False
    off = np.abs(in_si - other_in_si)[known]
    return bool(off.max() <= DIGITS * largest)
