"""A guessed slip may be one of two speeds whose names differ in their last letter: ``omega_e``, ``omega_v``.

A clutch between an engine and a vehicle slips by what they differ; one of them alone is no slip.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.candidates import DRIVES
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.two_courses import (
    is_course_times_a_number,
    is_same_course,
    is_set_point_of,
)
from erclutch.logs.columns.two_shafts import MINUS
from erclutch.logs.planning.draft import Draft

#: Words of the side of a gear that a device is on.
_BEHIND_A_GEAR = frozenset(
    {"load", "link", "output", "joint", "shaft", "wheel", "brake", "last", "abtrieb", "arm"}
)
_ONE_SPEED = 0.01  # share of a speed by which two sensors of one shaft differ


def doubt_one_of_twin_speeds(draft: Draft) -> None:
    """Doubt a guessed slip beside a speed of the same name but for its last letter, in the same unit."""
    slip = draft.guessed("slip")
    # Joints were told from the sides of a clutch.
    if slip is None or slip.column in draft.table.made or draft.joints:
        return
    own = draft.seen.columns[slip.column]
    stem, letter = _parted(own)
    if not letter:
        return
    for other in draft.seen.without(draft.taken):
        its_stem, its_letter = _parted(other)
        is_twin = its_stem == stem and its_letter not in ("", letter) and other.unit == own.unit
        if not is_twin or "slip" in other.spoken.turned:
            continue
        is_told = is_set_point_of(other.values, own.values)
        if is_told or is_same_course(other.values, own.values):
            continue
        difference = shell_word(f"{other.name}{MINUS}{own.name}")
        alone = shell_word(own.name)
        doubt = f"beside {other.name}: of a clutch their difference is the slip, {alone} of a brake"
        draft.doubt("slip", doubt, difference)
        return


def doubt_a_speed_before_a_gear(draft: Draft) -> None:
    """Doubt a guessed slip that is called like that of a motor, beside the same speed times a number at the load."""
    slip = draft.guessed("slip")
    effort = draft.signals.get("effort")
    if slip is None or slip.column not in draft.seen.columns:
        return
    own = draft.seen.columns[slip.column]
    words = {*words_of(own.name)}
    is_of_the_motor = effort is not None and not DRIVES.isdisjoint(words_of(effort.column))
    if words.isdisjoint(DRIVES) or is_of_the_motor:
        return
    for other in draft.seen.without(draft.taken):
        its_words = {*words_of(other.name)}
        is_of_the_load = not its_words.isdisjoint(_BEHIND_A_GEAR) and other.unit == own.unit
        if not is_of_the_load or its_words - _BEHIND_A_GEAR != words - DRIVES:
            continue
        if not is_course_times_a_number(other.values, own.values):
            continue
        known = np.isfinite(own.values) & np.isfinite(other.values)
        largest = float(np.abs(own.values[known]).max())
        ratio = float(np.abs(other.values[known]).max()) / largest if largest else 1.0
        if abs(ratio - 1.0) < _ONE_SPEED:
            continue
        label = shell_word(draft.table.label(other.name))
        alone = shell_word(draft.table.label(own.name))
        doubt = f"beside {other.name}, which is {ratio:.3g} times as fast, as behind a gear"
        draft.doubt(
            "slip", f"{doubt}: give --slip {alone} if the effort is that of the motor", label
        )
        return


def _parted(column: SeenColumn) -> tuple[str, str]:
    """The name of a column without the letter behind its last underscore, and the letter; "" where it has none."""
    stem, _, letter = column.name.rpartition("_")  # a v would be read as a unit
    is_letter = len(letter) == 1 and letter.isalpha()
    return (stem.lower(), letter.lower()) if stem and is_letter else (column.name, "")
