"""A guessed slip may be one of two speeds whose names differ in their last letter: ``omega_e``, ``omega_v``.

A clutch between an engine and a vehicle slips by what they differ; one of them alone is no slip.
"""

from __future__ import annotations

from erclutch.errors import shell_word
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.two_courses import is_same_course, is_set_point_of
from erclutch.logs.columns.two_shafts import MINUS
from erclutch.logs.planning.draft import Draft


def doubt_one_of_twin_speeds(draft: Draft) -> None:
    """Doubt a guessed slip beside a speed of the same name but for its last letter, in the same unit."""
    slip = draft.guessed("slip")
    if slip is None or slip.column in draft.table.made:
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


def _parted(column: SeenColumn) -> tuple[str, str]:
    """The name of a column without the letter behind its last underscore, and the letter; "" where it has none."""
    stem, _, letter = column.name.rpartition("_")  # a v would be read as a unit
    is_letter = len(letter) == 1 and letter.isalpha()
    return (stem.lower(), letter.lower()) if stem and is_letter else (column.name, "")
