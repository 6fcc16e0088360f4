"""The tests of drift are recorded here: they bet on rows outside the band, to one side, or too large or small.

`models.alarms` says what the tests ask, and how seldom they raise an alarm by chance.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.record import Record
from erclutch.models.alarms import LONG, Alarms, in_half_widths, part_of


def drifted(
    record: Record,
    alarms: Alarms,
    ends: tuple[Any, Any, Any],
    side: Any,
    measured: Any,
    good: Any,
) -> Any:
    """Whether measured efforts have been outside the band, to one side, or a part too large or small, for too long.

    Args:
        record: of the step.
        alarms: numbers of the tests.
        ends: low end of the band, estimated effort, high end.
        side: the sign of the slip.
        measured: effort.
        good: whether the row may count.
    """
    low, effort, high = ends
    is_measured = record.both(good, record.finite(measured))
    counts = record.both(is_measured, record.less(low, high))
    outside = record.either(record.less(measured, low), record.less(high, measured))
    miss = record.both(counts, outside)
    residual, estimate = in_half_widths(
        (measured - effort) * side, effort * side, 0.5 * (high - low)
    )

    block = alarms.block
    row = record.choose(counts, 1.0, 0.0)
    missed = record.choose(miss, 1.0, 0.0)
    lean = record.choose(counts, residual, 0.0)
    of_row = {"rows": row, "misses": missed, "lean": lean}
    still_open, (_, misses, leaned) = _gathered(record, block, of_row)
    share_missed = misses * (1.0 / block)
    mean_lean = leaned * (1.0 / block)
    other_way = -mean_lean
    above = less_select(alarms.lean, mean_lean, 1.0, 0.0)
    below = less_select(alarms.lean, other_way, 1.0, 0.0)
    tests = [
        ("missing", still_open, share_missed, alarms.missing),
        ("above", still_open, above, alarms.leaning),
        ("below", still_open, below, alarms.leaning),
    ]

    if alarms.part is not None:
        long = LONG * block
        size = record.choose(counts, estimate, 0.0)
        added = {"long_rows": row, "along": lean * size, "own": size * size}
        long_open, (_, along, own) = _gathered(record, long, added)
        part = part_of(along, own, float(long))
        less = -part
        larger = less_select(alarms.part, part, 1.0, 0.0)
        smaller = less_select(alarms.part, less, 1.0, 0.0)
        tests.append(("larger", long_open, larger, alarms.following))
        tests.append(("smaller", long_open, smaller, alarms.following))

    raised: Any = False
    for name, is_open, share, tolerated in tests:
        before = record.state(f"drift_{name}")
        after_block = alarms.wealth(before, share, tolerated)
        now = record.choose(is_open, before, after_block)
        record.keep(f"drift_{name}", record.label(now, f"drift_{name}"))
        reached = record.opposite(record.less(now, alarms.goal))
        raised = record.either(raised, reached)
    return raised


def _gathered(
    record: Record,
    block: int,
    added: Mapping[str, Any],
) -> tuple[Any, list[Any]]:
    """Whether a block of rows is still open, and sums over its rows so far; a full block begins anew.

    Args:
        record: of the step.
        block: its rows.
        added: by the row, by name; the first says whether it counts.
    """
    sums = [record.state(f"drift_{name}") + of_row for name, of_row in added.items()]
    counted = next(iter(added))
    still_open = record.label(record.less(sums[0], float(block)), f"{counted}_open")
    for name, total in zip(added, sums, strict=True):
        record.keep(f"drift_{name}", record.choose(still_open, total, 0.0))
    return still_open, sums
