"""Columns that are parts of an effort: what a model adds up, or what makes up a column called the whole."""

from __future__ import annotations

from collections.abc import Sequence

from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.two_courses import is_sum_of
from erclutch.logs.columns.vocabulary import MEASURED, PARTS_OF_A_MODEL, TOLD, set_of

#: Words of a whole: beside ``Feedback_Torque`` and ``Feedforward_Torque`` stands ``Total_Torque``.
_WHOLE = MEASURED | set_of("total sum summe gesamt overall totale suma somme")


def parts_of_efforts(columns: Sequence[SeenColumn]) -> set[str]:
    """Columns that are parts of an effort beside them, and none themselves.

    Args:
        columns: those that may be the effort by their units.
    """
    # A model adds up two and more kinds of parts to an effort; another effort stands beside them.
    kinds: set[str] = set()
    parts_of_a_model: set[str] = set()
    has_another = False
    for column in columns:
        if "effort" not in column.spoken.may_be:
            continue
        words = PARTS_OF_A_MODEL.intersection(column.spoken.stem_words)
        if words:
            parts_of_a_model.add(column.name)
            kinds |= words
        elif not column.spoken.says(TOLD):
            has_another = True
    parts = parts_of_a_model if len(kinds) > 1 and has_another else set[str]()

    # The sum of two columns, in all rows, is a column of their kind that is called a whole.
    moving: list[SeenColumn] = []
    for column in columns:
        is_effort = "effort" in column.spoken.may_be or "effort" in column.spoken.within
        if (is_effort or column.spoken.says(TOLD)) and not column.shape.constant:
            moving.append(column)
    wholes = [column for column in moving if column.spoken.says(_WHOLE)]
    others = [column for column in moving if not column.spoken.says(_WHOLE)]
    for whole in wholes:
        for place, first in enumerate(others):
            for second in others[place + 1 :]:
                if first.kind == second.kind == whole.kind and is_sum_of(
                    whole.values, first.values, second.values
                ):
                    parts |= {first.name, second.name}
    return parts
