"""What is left out of the training rows in turn, as a model is asked for it later: fields, motions, logs or blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.fit.choice.points_left_out import fields_left_out, points_left_out
from erclutch.fit.choice.stretches_left_out import stretches_left_out
from erclutch.fit.log_groups import FEWEST_GROUPS, STEADY, groups_of
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import FEWEST_ROWS_OF_A_BLOCK, time_folds
from erclutch.signals.array import Mask

_BLOCKS = 4  # of one log in time
_GROUPS = 4  # fields, motions or logs, at most
_ENOUGH_ROWS = 50  # of a block, where blocks of another motion could be left out in its place
_LEFT = 0.2  # of the rows: that many are left at least where one of two logs is left out
#: Of blocks of one log in time a freer model may lose so much on some, as a share of what it gains on others.
_LOST = 0.25


@dataclass(frozen=True)
class LeftOut:
    """Parts of the training rows that are left out in turn.

    Attributes:
        words: what they are, for people.
        masks: one a part, over the training rows.
        further: whether they go beyond the rows that are left: other fields, other motions.
        fields: how many of the parts, the first ones, are whole fields.
        lowest: how many of the parts, the first ones, are at no field. They make bands and choose no model: no log can
            have less than no field, so nothing like a fit without these rows will be asked for.
        in_time: whether they are blocks of one log in time, which are alike but for how much happens in each.
        of_points: whether they are points all over a table.
        stretches: how many of the parts, the last ones, are sets of stretches, beside blocks in time that go beyond one
            another: errors on both are of their own size.
    """

    words: str
    masks: Sequence[Mask]
    further: bool
    fields: int = 0
    lowest: int = 0
    in_time: bool = False
    of_points: bool = False
    stretches: int = 0

    @property
    def in_a_row(self) -> int:
        """How many of the parts, the first ones, are no sets of stretches."""
        return len(self.masks) - self.stretches

    @property
    def alike(self) -> bool:
        """Whether a part is like the rows that are left: points all over, or blocks of one log in time."""
        return self.in_time or self.of_points

    @property
    def never_without_field(self) -> bool:
        """Whether there are whole fields, and none of them is no field."""
        return self.fields > 0 and not self.lowest

    @property
    def may_lose(self) -> float:
        """What a freer model may lose on some parts, as a share of what it gains on others."""
        return _LOST if self.in_time else 0.0


def parts_of_training(train: Dataset) -> LeftOut | None:
    """What is left out in turn; None for rows too few to leave any out."""
    if train.in_no_time:
        at_fields, lowest = fields_left_out(train)
        if at_fields:
            fields = len(at_fields)
            return LeftOut("whole fields", at_fields, further=True, fields=fields, lowest=lowest)
        return LeftOut("points all over", points_left_out(train), further=False, of_points=True)
    logs = groups_of(train)
    masks: list[Mask] = []
    words: list[str] = []
    fields = lowest = 0
    if len(set(logs.field)) >= FEWEST_GROUPS:
        # Rows without a field come first and stand alone: a mask that they shared with others would choose a model.
        at_no_field = [has_no_field(train, start, stop) for start, stop in logs.rows]
        for wanted in (True, False):
            of_kind = [log for log, is_at_none in enumerate(at_no_field) if is_at_none == wanted]
            rows = [logs.rows[log] for log in of_kind]
            fields_of_rows = [logs.field[log] for log in of_kind]
            if of_kind:
                masks += _masks(train, rows, fields_of_rows)
        lowest = int(any(at_no_field))
        words.append("whole fields")
        fields = len(masks)
    if len(set(logs.motion)) >= FEWEST_GROUPS:
        masks += _masks(train, logs.rows, logs.motion)
        words.append("whole motions")
    if masks:
        return LeftOut(" and ".join(words), masks, further=True, fields=fields, lowest=lowest)
    # Of two logs of two motions, neither too short to be fitted alone, a further log is asked for. Two logs at a field
    # each say nothing of each other's field, so blocks in time are left out there.
    count = len(logs.rows)
    two_motions = count == 2 and len(set(logs.motion)) == 2 and len(set(logs.field)) == 1
    if two_motions:
        shorter = min(stop - start for start, stop in logs.rows)
        two_motions = shorter >= max(_LEFT * train.rows, _BLOCKS * _ENOUGH_ROWS)
    if count >= FEWEST_GROUPS or two_motions:
        of_logs = _masks(train, logs.rows, range(count))
        return LeftOut("whole logs", list(of_logs), further=False)
    # Of few rows fewer blocks: without any, the rows held out would choose what they are to judge.
    blocks = min(_BLOCKS, train.rows // FEWEST_ROWS_OF_A_BLOCK)
    if blocks < 2:
        return None
    in_time = time_folds(train, blocks)
    named = f"{blocks} blocks in time"
    sources = sum(stop > start for start, stop in train.source_rows)
    stretches = stretches_left_out(train, in_time) if sources == 1 else []
    if stretches:
        named += f" and {len(stretches)} sets of stretches all over"
    return LeftOut(
        named,
        [*in_time, *stretches],
        further=False,
        in_time=count == 1,
        stretches=len(stretches),
    )


def has_no_field(train: Dataset, start: int, stop: int) -> bool:
    """Whether some rows have no field, in any element."""
    fields = [np.abs(element.field) for element in train.elements]
    largest = max(float(field.max()) for field in fields)
    largest_of_rows = max(float(field[start:stop].max()) for field in fields)
    return largest_of_rows <= STEADY * largest


def _masks(
    train: Dataset, rows: Sequence[tuple[int, int]], numbers: Sequence[int]
) -> Iterator[Mask]:
    """Masks of groups of logs by their numbers; neighbours share a mask where there are many."""
    different = np.array(sorted(set(numbers)))
    count = min(different.size, _GROUPS)
    for neighbours in np.array_split(different, count):
        mask = np.zeros(train.rows, np.bool_)
        for (start, stop), number in zip(rows, numbers, strict=True):
            mask[start:stop] |= number in neighbours
        yield mask
