"""Where no field is logged, a field may have been set anew in each part of a test that a column numbers.

A bench counts its tests, runs and cycles, and the field of each stands in somebody's notes. Without it the rows of all
fields are mixed in one fit. That the effort differs between parts of one motion tells that something was set.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.plan import SignalPlan
from erclutch.logs.planning.draft import Draft
from erclutch.signals.array import Array
from erclutch.signals.recording import NO_FIELD

_DIFFERS = 1.5  # between the mean sizes of the effort in two parts
_FEWEST_ROWS = 20  # of a part
#: Sizes of the slip at which parts are held against each other, as shares of the largest of the slowest part.
_AT_SLIPS = (0.3, 0.9)
_IS_ALIKE = 1.25  # between the mean sizes of a position in two parts


def ask_about_parts_of_a_test(draft: Draft) -> None:
    """Ask which field each part had, where the effort differs between parts of one motion and no field is logged."""
    field = draft.signals.get("field")
    effort = draft.signals.get("effort")
    motion = draft.signals.get("slip") or draft.signals.get("position")
    is_open = field is not None and field.reason == NO_FIELD and not draft.told.declines("field")
    logged = draft.table.columns
    if not is_open or effort is None or effort.column not in logged:
        return
    if motion is None or motion.column not in logged:
        return
    for column in draft.seen.without(draft.taken):
        if not _numbers_parts(column):
            continue
        efforts = _efforts(column, motion, logged[motion.column], logged[effort.column])
        if efforts and max(efforts.values()) > _DIFFERS * min(efforts.values()):
            _ask(draft, column, efforts)
            return


def _numbers_parts(column: SeenColumn) -> bool:
    """Whether whole numbers rise part by part, each of them for many rows."""
    is_number = not column.unit and are_whole(column.values)
    return is_number and column.shape.keeps_levels and column.shape.rises


def _efforts(
    parts: SeenColumn, motion: SignalPlan, moved: Array, effort: Array
) -> dict[float, float]:
    """Mean size of the effort in each part, by its number, at one size of the motion; none where no two can be held so.

    Args:
        parts: the number of each row's part.
        motion: the slip or the position.
        moved: its numbers.
        effort: the effort's numbers.
    """
    known = np.isfinite(moved) & np.isfinite(effort)
    sizes = {
        float(part): np.abs(moved[known & (parts.values == part)])
        for part in np.unique(parts.values)
    }
    sizes = {part: size for part, size in sizes.items() if size.size >= _FEWEST_ROWS}
    if len(sizes) < 2:
        return {}
    if motion.signal == "position":
        means = [float(size.mean()) for size in sizes.values()]
        if max(means) > _IS_ALIKE * min(means):
            return {}
        is_compared = known
    else:
        slowest = min(float(size.max()) for size in sizes.values())
        low, high = (share * slowest for share in _AT_SLIPS)
        is_compared = known & (np.abs(moved) > low) & (np.abs(moved) < high)
    efforts: dict[float, float] = {}
    for part in sizes:
        of_part = effort[is_compared & (parts.values == part)]
        if of_part.size >= _FEWEST_ROWS:
            efforts[part] = float(np.abs(of_part).mean())
    return efforts if len(efforts) > 1 else {}


def _ask(draft: Draft, column: SeenColumn, efforts: dict[float, float]) -> None:
    label = draft.table.label(column.name)
    least = min(efforts, key=efforts.__getitem__)
    most = max(efforts, key=efforts.__getitem__)
    option = f'--field {shell_word(label)} --scale "field=STEP A" --zero field={min(efforts):g}'
    problem = (
        f"no column for field, and the effort goes with the parts that {label} numbers: its mean size is "
        f"{efforts[least]:.3g} in {least:g} and {efforts[most]:.3g} in {most:g}"
    )
    remedy = (
        f"If a field was set for each part, in even steps from none, give {option}; in other steps, give a log for "
        "each part; if none was set, give --field none"
    )
    draft.ask("field", MappingError(problem, remedy=remedy), option)
    del draft.signals["field"]
