"""Of several columns that may be the slip, or the position, one is chosen: the effort tells it, or the columns do.

The effort tells the speed that makes a power with it. A travel beside a position is no second column.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from erclutch.logs.columns.candidates import DIGITS, candidates
from erclutch.logs.columns.names import plain
from erclutch.logs.columns.seen_columns import KINDS, UNITS_OF_KIND, SeenColumn, SeenColumns
from erclutch.logs.columns.two_courses import is_course_times_a_number, move_alike
from erclutch.logs.columns.vocabulary import set_of

#: What the length between the marks of a specimen is called in the headers of testing machines.
_GAUGE_LENGTH = re.compile(
    r"ga(?:u)?ge length|\bL0\b|messl(?:ä|ae)nge|longueur (?:initiale|utile|entre rep(?:è|e)res)|base de mesure|"
    r"longitud (?:inicial|calibrada)|標点距離|标距",
    re.IGNORECASE,
)
_FEW = 3  # speeds: of more, a robot's rest and are asked about with its efforts
_ALIKE = 0.03  # of the largest speed, by which two sensors of one motion differ at most
#: What a speed is called by that was measured in one way of several.
_SENSORS = frozenset(
    ("electrical optical encoder hall laser tacho magnetic resolver sensor gyro esc el").split()
)
#: What the speed of one surface over another is called, which is the slip itself.
_SLIDING = set_of(
    "sliding rubbing gleitgeschwindigkeit glissement deslizamiento scorrimento скольжения "
    "滑动速度 滑り速度 すべり速度 摺動速度"
)
#: The same, or the share that a speed is of the rated one.
_RELATIVE = set_of(
    "relative relativa relativo relativgeschwindigkeit relativdrehzahl differenzdrehzahl относительная "
    "相对速度 相对转速 相対速度"
)
#: What tells a turning motion from a motion along a line, where no unit does.
_WAYS = {
    "N*m": set_of("angular rotational rotary rotatory winkelgeschwindigkeit angulaire angulare"),
    "N": set_of("linear translational translatory tangential peripheral lineaire lineare"),
}


def one_slip(seen: SeenColumns, speeds: list[str], taken: Sequence[str]) -> tuple[list[str], str]:
    """The speed that makes a power with the effort, whatever column that is; else all, or that on the effort's side."""
    efforts, _ = candidates(seen, "effort", [*taken, *speeds])
    kind = _kind_of(seen, efforts)
    of_that_kind = _only_one_of_kind(seen, speeds, kind)
    if of_that_kind:
        return of_that_kind, f", and the effort is that of a {KINDS[kind]}"
    between = _between_surfaces(seen, speeds, kind)
    if between:
        return [between], ", and it is the speed of one surface over the other"
    # The speeds of axes that were not used never change. Where none does, nobody filled them in.
    resting = [name for name in speeds if seen.columns[name].shape.constant]
    if len(resting) == len(speeds):
        positions, _ = candidates(seen, "position", [*taken, *speeds])
        if any(not seen.columns[name].shape.constant for name in positions):
            return [], ""
    if len(speeds) <= _FEW and len(resting) == len(speeds) - 1:
        moving = [name for name in speeds if name not in resting]
        return seen.of_one_side(moving, efforts), f", and {', '.join(resting)} never changes"
    if len(speeds) > 1 and _are_of_sensors(seen, speeds):
        first, *others = speeds
        why = f", and {', '.join(others)} agrees with it to {_ALIKE:.0%}"
        return seen.of_one_side([first], efforts), why
    return seen.of_one_side(speeds, efforts), ""


def _between_surfaces(seen: SeenColumns, speeds: Sequence[str], kind: str) -> str:
    """The only speed that is called that of one surface over the other, beside an effort of a kind; else ""."""
    called = [name for name in speeds if seen.columns[name].spoken.says(_SLIDING | _RELATIVE)]
    if len(called) != 1:
        return ""
    slip = seen.columns[called[0]]
    others = [seen.columns[name] for name in speeds if name != slip.name]
    # A torque makes no power with the speed of a pin along its track.
    makes_no_power = bool(kind) and slip.kind not in ("", kind)
    is_a_share = not slip.spoken.says(_SLIDING) and any(
        is_course_times_a_number(slip.values, other.values) for other in others
    )
    return "" if makes_no_power or is_a_share else slip.name


def _are_of_sensors(seen: SeenColumns, speeds: list[str]) -> bool:
    """Whether speeds are of sensors of one motion: their names differ by a word for the sensor, and the numbers agree.

    Numbers alone do not suffice: two shafts that are coupled turn alike, and slip by what they differ.
    """
    words = [{*seen.columns[name].spoken.stem_words} for name in speeds]
    shared = set[str].intersection(*words)
    if any(not own - shared or not own - shared <= _SENSORS for own in words):
        return False
    first, *others = (seen.columns[name] for name in speeds)
    largest = np.nanmax(np.abs(first.values))
    if not largest > 0.0:  # none of them turned, or none was plugged in
        return False
    for other in others:
        gap = np.abs(other.values - first.values)
        if other.unit != first.unit or not np.nanmax(gap) <= _ALIKE * largest:
            return False
    return True


def one_position(
    seen: SeenColumns, positions: list[str], taken: Sequence[str]
) -> tuple[list[str], str]:
    """The position whose gauge length the header gives, from which a specimen is stretched; else as for a slip."""
    # A travel beside an absolute position says the same from another zero.
    kept: list[SeenColumn] = []
    for name in positions:
        position = seen.columns[name]
        in_that_unit = [other for other in kept if other.unit == position.unit]
        if not any(move_alike(position.values, other.values, DIGITS) for other in in_that_unit):
            kept.append(position)
    positions = [position.name for position in kept]
    if len(positions) == 1:
        return positions, ""
    resting = [position.name for position in kept if position.shape.constant]
    if len(kept) <= _FEW and len(resting) == len(kept) - 1:
        moving = [name for name in positions if name not in resting]
        return moving, f", and {', '.join(resting)} never changes"
    keys: list[str] = []
    for key, text in seen.table.metadata.items():
        if text and _GAUGE_LENGTH.search(key):
            keys.append(plain(key))
    with_a_length = [name for name in positions if any(plain(name) in key for key in keys)]
    if len(with_a_length) == 1:
        return with_a_length, ", and the header gives the gauge length for it"
    efforts, _ = candidates(seen, "effort", [*taken, *positions])
    kind = _kind_of(seen, efforts)
    of_that_kind = _only_one_of_kind(seen, positions, kind)
    if of_that_kind:
        return of_that_kind, f", and the effort is that of a {KINDS[kind]}"
    if kind:
        # An angle goes first beside a torque: the first is what the question proposes.
        fits = {name: seen.columns[name].fits(UNITS_OF_KIND[kind]) for name in positions}
        positions.sort(key=lambda name: (fits[name] is False, fits[name] is None))
    return seen.of_one_side(positions, efforts), ""


def _kind_of(seen: SeenColumns, efforts: Sequence[str]) -> str:
    """The kind of all efforts by their units and names, see `KINDS`; "" where they are of several, or untold."""
    kinds = {seen.columns[name].kind for name in efforts}
    return kinds.pop() if len(kinds) == 1 else ""


def _only_one_of_kind(seen: SeenColumns, names: Sequence[str], kind: str) -> list[str]:
    """The only motion that makes a power with an effort of a kind, where all units tell, or all names; else none."""
    if not kind:
        return []
    fits = {name: seen.columns[name].fits(UNITS_OF_KIND[kind]) for name in names}
    if {*fits.values()} == {None}:
        own_ways = _WAYS.get(kind, frozenset())
        of_that_kind = [name for name in names if seen.columns[name].spoken.says(own_ways)]
        other_ways = frozenset[str]().union(*_WAYS.values()) - own_ways
        others = [name for name in names if seen.columns[name].spoken.says(other_ways)]
        are_told = len(of_that_kind) + len(others) == len(names)
        return of_that_kind if len(of_that_kind) == 1 and are_told else []
    of_that_kind = [name for name in names if fits[name]]
    return of_that_kind if len(of_that_kind) == 1 and None not in fits.values() else []
