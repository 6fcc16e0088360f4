"""Where no field is logged, a field may have been set anew in each part of a test that a column numbers.

A bench counts its tests, runs and cycles, and the field of each stands in somebody's notes. Without it the rows of all
fields are mixed in one fit. That the effort differs between parts at the same slip tells that something was set.
"""

from __future__ import annotations

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.field_between_logs import efforts_of_two_words
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.no_field import tells_heat_of_a_drive


def ask_about_parts_of_a_test(draft: Draft) -> None:
    """Ask which field each part had, where the effort differs between parts at the same slip and no field is logged."""
    effort = draft.signals.get("effort")
    motion = draft.signals.get("slip") or draft.signals.get("position")
    logged = draft.table.columns
    if not draft.field_is_open or effort is None or effort.column not in logged:
        return
    if motion is None or motion.column not in logged:
        return
    slip = logged[motion.column]
    if motion.signal == "position":
        slip = np.gradient(slip) if slip.size > 1 else slip
    for column in draft.seen.without(draft.taken):
        is_number = not column.unit and are_whole(column.values)
        rises_by_parts = column.shape.keeps_levels and column.shape.rises
        if tells_heat_of_a_drive(column) or not is_number or not rises_by_parts:
            continue
        parts, of_row = np.unique(column.values, return_inverse=True)
        apart = efforts_of_two_words(slip, logged[effort.column], of_row.astype(np.int32))
        if apart is None:
            continue
        label = draft.table.label(column.name)
        option = f'--field {shell_word(label)} --scale "field=STEP A" --zero field={parts[0]:g}'
        problem = (
            f"no column for field, and at the same slip part {parts[apart.more]:g} has {apart.times:.2g} times the "
            f"effort of part {parts[apart.less]:g}, by column {label}"
        )
        remedy = (
            f"If a field was set for each part, in even steps from none, give {option}; in other steps, give a log "
            "for each part; if none was set, give --field none"
        )
        draft.ask("field", MappingError(problem, remedy=remedy), option)
        del draft.signals["field"]
        return
