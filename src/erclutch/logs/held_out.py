"""Rows are kept from fitting: the last share in time, stretches all over, whole logs, or blocks in time."""

from __future__ import annotations

import fnmatch
import itertools
from collections.abc import Sequence
from numbers import Real
from pathlib import PurePath
from typing import cast

import numpy as np

from erclutch.errors import SettingError
from erclutch.logs.covering_stretches import STRETCHES, USUAL_SHARE, covering, spread_points
from erclutch.logs.dataset import STEADY, Dataset
from erclutch.logs.rows.field_plateaus import plateaus
from erclutch.signals.array import Mask

#: Of blocks in time: an error over fewer rows says next to nothing.
FEWEST_ROWS_OF_A_BLOCK = 20


def hold_out(dataset: Dataset, test: float | str | Sequence[str]) -> Mask:
    """Rows that are kept from fitting: the last share in time, stretches all over, or whole logs by their names.

    Args:
        dataset: the rows.
        test: a share above 0 and below 0.9 (of each log: its last rows; of a log that was taken at one field after
            another, of each stretch, or its middle or beginning where the field steps without a gap; of points in no
            time: points all over), "stretches" (`covering_stretches`), or shell patterns such as ``*0x5A.txt``.

    Returns:
        Mask (n,), true for test rows.

    Raises:
        SettingError: the share is out of range, a pattern matches no log, or nothing is left to train on.
    """
    mask = np.zeros(dataset.rows, np.bool_)
    if isinstance(test, Real):
        share = float(test)
        if not 0 < share < 0.9:
            example = f"for example {USUAL_SHARE:g}, or a pattern of logs' names: 'run7*'"
            remedy = f"Give a share above 0 and below 0.9, {example}"
            raise SettingError(f"a test share of {share}", where="--test", remedy=remedy)
        return _share_of_each_log(dataset, share)

    patterns = (test,) if isinstance(test, str) else tuple(cast(Sequence[str], test))
    if patterns == (STRETCHES,):
        for log in dataset.source_rows:
            for start, stop in constant_stretches(dataset, *log) or [log]:
                mask |= covering(dataset.elements, start, stop)
        return mask
    for pattern in patterns:
        matches = False
        for log, (start, stop) in zip(dataset.sources, dataset.source_rows, strict=True):
            names = (log, PurePath(log).name)  # with its folder, where two logs have one name
            if any(fnmatch.fnmatchcase(name, pattern) for name in names):
                matches = True
                mask[start:stop] = True
        if not matches:
            problem = f"the test pattern {pattern!r} matches none of {len(dataset.sources)} logs"
            remedy = f"Logs are called for example {dataset.sources[0]!r}"
            raise SettingError(problem, remedy=remedy)
    if mask.all():
        problem = "all logs are held out, none is left to train on"
        raise SettingError(problem, remedy="Narrow the test patterns")
    return mask


def held_out_as_told(test: tuple[str, ...]) -> float | tuple[str, ...]:
    """A share as a number, also where it is written in per cent; patterns of names as they are."""
    if len(test) != 1:
        return test
    (word,) = test
    try:
        number = float(word.removesuffix("%"))
    except ValueError:
        return test
    return number / 100.0 if word.endswith("%") else number


def _share_of_each_log(dataset: Dataset, share: float) -> Mask:
    """The last rows of each log or of its levels; of levels without a gap a part of each; of points some all over."""
    mask = np.zeros(dataset.rows, np.bool_)
    for log in dataset.source_rows:
        if log[1] == log[0]:  # none of its rows is among these
            continue
        if dataset.in_no_time:
            mask |= spread_points(dataset.elements, *log, share)
            continue
        levels = constant_stretches(dataset, *log)
        if steps_without_a_gap(dataset, *log):
            # The middle of two levels, the beginning of the next two, and so on: so some steps lie in rows that are
            # fitted and others in rows held out, ups and downs alike. With the end of each level held out, no step
            # would have its rows on both sides, and no lag could be told.
            for place, (start, stop) in enumerate(levels):
                rows = stop - start
                held = round(share * rows)
                begins_with_step = place // 2 % 2 == 1
                first = start if begins_with_step else start + (rows - held) // 2
                mask[first : first + held] = True
        else:
            for start, stop in levels or [log]:
                trained = round((1 - share) * (stop - start))
                mask[start + trained : stop] = True
    return mask


def steps_without_a_gap(dataset: Dataset, start: int, stop: int) -> bool:
    """Whether a log was taken at one field after another, and its field steps somewhere without a gap."""
    begins_anew = {span.start for span in dataset.clock.spans}
    levels = constant_stretches(dataset, start, stop)
    steps = [begin for (_, end), (begin, _) in itertools.pairwise(levels) if begin == end]
    return not begins_anew.issuperset(steps)


def constant_stretches(dataset: Dataset, start: int, stop: int) -> list[tuple[int, int]]:
    """Stretches of a log that was taken at one constant field after another; empty for any other log.

    Between them there is a gap, or the field goes from level to level. The end of such a log is a field that no earlier
    row has, so a share of it is held out of each stretch.
    """
    spans: list[tuple[int, int]] = []
    for span in dataset.clock.spans:
        if start <= span.start and span.stop <= stop:
            spans.append((span.start, span.stop))
    fields = [element.field for element in dataset.elements]
    reach = STEADY * max(float(np.abs(field).max()) for field in fields)

    def constant(first: int, last: int) -> bool:
        """Whether no field changes in some rows."""
        return all(np.ptp(field[first:last]) <= reach for field in fields)

    if constant(start, stop):
        return []
    if all(constant(first, last) for first, last in spans):
        return spans

    # No gap from field to field: plateaus are sought, and cut where the log has a gap.
    stretches: list[tuple[int, int]] = []
    levels = plateaus([field[start:stop] for field in fields])
    for first, last in spans:
        for level_begins, level_ends in levels:
            begin = max(first, start + level_begins)
            end = min(last, start + level_ends)
            if begin < end:
                stretches.append((begin, end))
    return stretches


def time_folds(dataset: Dataset, count: int) -> list[Mask]:
    """Masks of ``count`` contiguous stretches of rows, for cross-validation over time; each row is in one of them.

    Raises:
        SettingError: fewer than 2 blocks, or blocks of fewer than 20 rows.
    """
    if count < 2 or dataset.rows // count < FEWEST_ROWS_OF_A_BLOCK:
        problem = f"{count} blocks of {dataset.rows} rows"
        remedy = f"Give 2 blocks or more, of at least {FEWEST_ROWS_OF_A_BLOCK} rows each"
        raise SettingError(problem, remedy=remedy)
    edges = np.linspace(0, dataset.rows, count + 1).round().astype(int)
    row = np.arange(dataset.rows)
    return [(row >= first) & (row < last) for first, last in itertools.pairwise(edges)]
