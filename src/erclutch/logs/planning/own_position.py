"""The position beside a speed is of the same joint or shaft: what turns elsewhere is no position of that speed."""

from __future__ import annotations

from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.two_courses import goes_along, is_rate_of
from erclutch.logs.planning.draft import Draft


def own_position(draft: Draft, speed: str, guessed: str) -> str:
    """The position of the part that a speed is of; "" where the guess is of another part and no other is known.

    The numbers go first: a speed that is the rate of the guess is of one part with it. Then the names:
    ``ankle_angle`` goes with ``ankle_velocity``, and not ``motor_angle``.

    Args:
        draft: the plan so far.
        speed: the column that is taken for the slip.
        guessed: the column that would be taken for the position.
    """
    columns = draft.seen.columns
    stamps = draft.seen.stamps
    position = columns[guessed].values
    if speed not in columns or is_rate_of(columns[speed].values, position, stamps):
        return guessed
    part = _part_of(speed)
    by_numbers: list[str] = []
    by_name: list[str] = []
    for column in draft.seen.without(draft.taken):
        if "position" not in column.spoken.may_be | column.spoken.within:
            continue
        if is_rate_of(columns[speed].values, column.values, stamps):
            by_numbers.append(column.name)
        if part and _part_of(column.name) == part:
            by_name.append(column.name)
    for own in (by_numbers, by_name):
        if len(own) == 1:
            return own[0]
    for other in draft.seen.without([*draft.taken, guessed]):
        if "slip" not in other.spoken.may_be | other.spoken.within and other.unit:
            continue
        # A speed of the same motion may be filtered, and no rate then.
        if goes_along(columns[speed].values, other.values):
            continue
        is_of_its_part = part != _part_of(guessed) == _part_of(other.name) != ()
        is_a_speed = "slip" in other.spoken.may_be
        if is_rate_of(other.values, position, stamps) or (is_a_speed and is_of_its_part):
            return ""
    return guessed


def _part_of(name: str) -> tuple[str, ...]:
    """What a name says besides the motion: the words of a joint or a shaft, in order."""
    words: list[str] = []
    for word in spoken_name(name).stem_words:
        forms = spoken_name(word).forms
        if not (forms["slip"] or forms["position"]):
            words.append(word)
    return tuple(words)
