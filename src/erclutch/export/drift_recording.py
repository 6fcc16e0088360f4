"""The tests of drift are recorded here: they bet on rows outside the band, and on rows to one side of the estimate."""

from __future__ import annotations

from typing import Any

from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.record import Record
from erclutch.models.alarms import Alarms
from erclutch.models.covered_cells import within


def drifted(record: Record, alarms: Alarms, ends: tuple[Any, Any, Any], side: Any, measured: Any, good: Any) -> Any:
    """Whether measured efforts have been outside the band, or to one side of the estimate, for too long.

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
    # In half widths of the band.
    off = within((measured - effort) * side / (0.5 * (high - low)), -1.0, 1.0)

    # Gathered over a block of rows, and begun anew when the block is full.
    row = record.choose(counts, 1.0, 0.0)
    missed = record.choose(miss, 1.0, 0.0)
    rows = record.state("drift_rows") + row
    misses = record.state("drift_misses") + missed
    lean = record.state("drift_lean") + record.choose(counts, off, 0.0)
    block = float(alarms.block)
    block_open = record.label(record.less(rows, block), "block_open")
    record.keep("drift_rows", record.choose(block_open, rows, 0.0))
    record.keep("drift_misses", record.choose(block_open, misses, 0.0))
    record.keep("drift_lean", record.choose(block_open, lean, 0.0))

    share_missed = misses * (1.0 / block)
    mean_lean = lean * (1.0 / block)
    other_way = -mean_lean
    above = less_select(alarms.lean, mean_lean, 1.0, 0.0)
    below = less_select(alarms.lean, other_way, 1.0, 0.0)
    tests = (
        ("missing", share_missed, alarms.missing),
        ("above", above, alarms.leaning),
        ("below", below, alarms.leaning),
    )
    raised: Any = False
    for name, share, tolerated in tests:
        before = record.state(f"drift_{name}")
        after_block = alarms.wealth(before, share, tolerated)
        now = record.choose(block_open, before, after_block)
        record.keep(f"drift_{name}", record.label(now, f"drift_{name}"))
        reached = record.opposite(record.less(now, alarms.goal))
        raised = record.either(raised, reached)
    return raised
