"""Rows in which a sensor measured nothing are told: codes that loggers write, spikes, ends of a range, stuck values.

A code that stands where nothing was measured (-999, 65535, ...) is the same to the last digit each time, and stands
apart from all other values of its column. The largest value of a saturated sensor does not stand apart, and a spike
is no code.

A fault is told by what only a fault does. A spike is one or two rows far beyond all others, with quiet rows on both
sides: a blow rings. A saturated effort is the same to the last digit whenever it is largest, in runs, far more often
than at any level beside it (the peak of a coarse sine is no end of a range), and comes near that end by many other
values: dry friction jumps there. A stuck effort keeps one value, met nowhere else, while the motion goes on.

Faults of the logger show in several columns at once: a row that holds one number in all of them, far from the rows
beside it in two or more, and a stretch in which all of them stand still and then jump.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from erclutch.logs.plan import Plan
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import stretches

#: Of tables and spreadsheets; ends of whole numbers of 16 and 32 bits; of instruments.
CODES = (
    *(
        sign * code
        for code in (99.0, 999.0, 9999.0, 99999.0, 999999.0, 999.9, 9999.9)
        for sign in (-1.0, 1.0)
    ),
    *(65535.0, 32767.0, -32768.0, 4294967295.0, 2147483647.0, -2147483648.0),
    *(sign * code for code in (1e30, 9.9e37, 9.91e37, 1e35, 1e38) for sign in (-1.0, 1.0)),
)
_FAR = 2.0  # ranges of all other values, by which a code stands apart
_APART = 0.5  # ranges, where the step to the code is larger than all other steps
_MOST = 0.5  # share of the rows: a code in more of them may be the signal

#: Rows, below which nothing is known of what is usual.
_FEWEST = 100

#: Share of the rows that may be spikes on either side.
_FEW_SPIKES = 0.0025
#: Ranges of all other rows, by which a spike is beyond them.
_BEYOND = 1.0
#: Rows of a spike at most.
_LONGEST_SPIKE = 2
#: How many rows from a spike, on either side, two rows are as usual.
_BESIDE_SPIKE = (3, 4)

#: Shares of the rows that a saturated effort stands at the end of its range.
_LEAST_SATURATED, _MOST_SATURATED = 0.005, 0.3
#: Rows that it stays there, in the mean.
_STAYS = 3.0
#: Distinct values: fewer are levels, of which the last is one.
_LEVELS = 64
#: Times the rows of any level beside the end, and how many such levels are looked at.
_PILE, _LEVELS_BESIDE = 20, 5
#: Share of the range below the end, and rows that are met there.
_NEAR, _APPROACHES = 0.1, 10

#: Runs of equal values, below which nothing is known of a usual run.
_FEWEST_RUNS = 20
#: Rows that an effort keeps its value where it may be stuck.
_STUCK_ROWS = 50
#: How many times longer that is than it usually keeps a value.
_STUCK_RUN = 20.0
#: Share of its range by which the motion goes on meanwhile.
_MOVES = 0.2

#: Times the usual largest step of a column, by which several columns jump at once.
_JUMPS = 8.0
#: Rows at most that hold one number in all columns.
_LONGEST_DROP = 20
#: Rows at least in which all columns stand still.
_SHORTEST_FREEZE = 5


def unmeasured_rows(plan: Plan, table: Table, notes: list[str]) -> Mask:
    """Rows that are left out since a signal holds no measurement there, shape (rows of the table,).

    ``notes`` gets what was seen, the column and the number of rows; a user may ask to keep them.
    """
    keep = plan.told.values == "keep"
    unmeasured = np.zeros(table.rows, dtype=np.bool_)
    columns: dict[str, None] = {}
    for each in (*plan.signals, *plan.inputs):
        if each.column:  # of a difference both columns: that of two codes is 0
            columns |= dict.fromkeys(table.parts_of(each.column) or (each.column,))
    for name in columns:
        for code, rows in sentinels(table.planned(name)).items():
            held = f"column {name} holds {code:g} in {_counted(rows)}, far from all other values"
            if keep:
                notes.append(f"{held}: kept, as asked")
            else:
                why = "what loggers write for no measurement, left out and the log cut there"
                notes.append(f"{held}: {why} (--keep-values keeps it)")
                unmeasured |= rows

    for name, fault, rows in _sensor_faults(plan, table, unmeasured):
        first = table.first_row + int(np.argmax(rows)) + 1
        done = (
            "kept, as asked"
            if keep
            else "left out and the log cut there (--keep-values keeps them)"
        )
        notes.append(f"{name} {fault} in {_counted(rows)}, the first in data row {first}: {done}")
        if not keep:
            unmeasured |= rows
    return unmeasured


def sentinels(values: Array) -> dict[float, Mask]:
    """Rows that hold a code in place of a measurement, by the code.

    Args:
        values: a column as logged, shape (n,); NaN where a cell was empty.

    Returns:
        code -> mask, shape (n,); empty for none.
    """
    with np.errstate(invalid="ignore"):
        least = np.fmin.reduce(values, initial=np.inf)
        most = np.fmax.reduce(values, initial=-np.inf)
    held: dict[float, Mask] = {}
    for code in CODES:
        if least <= code <= most:
            rows = np.equal(values, code)
            if rows.any():
                held[code] = rows
    if not held:
        return {}

    doubtful = np.logical_or.reduce(list(held.values()))
    measured = values[~doubtful & np.isfinite(values)]
    if measured.size < max(10, (1.0 - _MOST) * values.size):
        return {}
    low = float(measured.min())
    high = float(measured.max())
    largest = max(abs(low), abs(high))
    spread = max(high - low, 1e-12 * largest, np.finfo(float).tiny)
    largest_step = float(np.abs(np.diff(measured)).max())
    codes: dict[float, Mask] = {}
    for code, rows in held.items():
        beyond = max(code - high, low - code)
        jumps = beyond > _APART * spread and beyond > 3.0 * largest_step
        if beyond > _FAR * spread or jumps:
            codes[code] = rows
    return codes


def _counted(rows: Mask) -> str:
    many = int(rows.sum())
    return f"{many} row{'s' if many > 1 else ''}"


def _sensor_faults(
    plan: Plan,
    table: Table,
    unmeasured: Mask,
) -> Iterator[tuple[str, str, Mask]]:
    """The columns, what is wrong there, and the rows, for each fault of a sensor; rows without measurement are none."""
    columns = {each.signal: each.column for each in plan.signals if each.column}
    names = list(dict.fromkeys(columns.values()))
    together = f"columns {', '.join(names)}"
    measured = [np.where(unmeasured, np.nan, table.planned(name)) for name in names]
    lost = dropped(measured)
    if lost.any():
        yield together, f"all hold {measured[0][np.argmax(lost)]:.6g} and jump there and back", lost
    held = frozen([np.where(lost, np.nan, values) for values in measured])
    if held.any():
        yield (
            together,
            "stand still together and then jump, as where the logger repeats a row",
            held,
        )

    unmeasured = unmeasured | lost | held
    motion = columns.get("slip") or columns.get("position")
    for signal in ("slip", "effort", "T"):
        if signal not in columns:
            continue
        name = columns[signal]
        values = np.where(unmeasured, np.nan, table.planned(name))
        spiked = spikes(values)
        if spiked.any():
            yield f"column {name}", f"has spikes (up to {np.abs(values[spiked]).max():.4g})", spiked
            values = np.where(spiked, np.nan, values)
        if signal == "slip":
            continue

        ends = saturated(values)
        for end, rows in ends.items():
            yield f"column {name}", f"sits at an end of its sensor's range ({end:.6g})", rows
        if motion and not ends:
            held = stuck(values, table.planned(motion))
            if held.any():
                yield (
                    f"column {name}",
                    f"is stuck at {values[np.argmax(held)]:.6g} while column {motion} moves",
                    held,
                )


def spikes(values: Array) -> Mask:
    """One or two rows at a time that lie beyond all others by more than their range, shape (n,)."""
    marked = np.zeros(values.size, dtype=np.bool_)
    known = values[np.isfinite(values)]
    if known.size < _FEWEST:
        return marked
    few = max(1, int(_FEW_SPIKES * known.size))
    many = known.size - 1 - few
    ordered = np.partition(known, (few, many))
    low = float(ordered[few])
    high = float(ordered[many])
    reach = _BEYOND * (high - low)
    if reach <= 0.0:
        return marked

    with np.errstate(invalid="ignore"):
        beyond = (values > high + reach) | (values < low - reach)
    for start, stop in stretches(beyond):
        short = stop - start <= _LONGEST_SPIKE
        if not short or start == 0 or stop == values.size:
            continue
        before = [start - rows for rows in _BESIDE_SPIKE]
        after = [stop - 1 + rows for rows in _BESIDE_SPIKE]
        beside = values[[row for row in (*before, *after) if 0 <= row < values.size]]
        if np.all((beside >= low - 0.5 * reach) & (beside <= high + 0.5 * reach)):
            marked[start:stop] = True
    return marked


def saturated(effort: Array) -> dict[float, Mask]:
    """Rows where an effort sits at an end of its sensor's range, by that end; shape (n,) each."""
    known = effort[np.isfinite(effort)]
    ends: dict[float, Mask] = {}
    if known.size < _FEWEST:
        return ends
    # To look at so many rows is enough: a column of few levels shows that soon.
    if np.unique(known[: 20 * _LEVELS * _LEVELS]).size <= _LEVELS:
        return ends

    low = float(known.min())
    high = float(known.max())
    for end in (low, high):
        at_end = np.equal(effort, end)
        count = np.count_nonzero(at_end)
        if end == 0.0 or not _LEAST_SATURATED < count / effort.size < _MOST_SATURATED:
            continue
        if count < _STAYS * len(stretches(at_end)):
            continue
        with np.errstate(invalid="ignore"):
            near = (np.abs(effort - end) < _NEAR * (high - low)) & ~at_end
        if np.count_nonzero(near) < _APPROACHES:
            continue
        # Far more rows sit there than at any level beside it; a smooth peak has a few times more.
        levels, rows = np.unique(known, return_counts=True)
        at = int(np.flatnonzero(levels == end)[0])
        before = rows[max(0, at - _LEVELS_BESIDE) : at]
        after = rows[at + 1 : at + 1 + _LEVELS_BESIDE]
        if rows[at] >= _PILE * np.concatenate([before, after]).max():
            ends[end] = at_end
    return ends


def stuck(effort: Array, motion: Array) -> Mask:
    """Rows of the longest run in which an effort keeps a value hardly met elsewhere, while the motion goes on."""
    marked = np.zeros(effort.size, dtype=np.bool_)
    changes = np.concatenate(([True], np.diff(effort) != 0.0, [True]))
    edges = np.flatnonzero(changes)
    lengths = np.diff(edges)
    if effort.size < _FEWEST or lengths.size < _FEWEST_RUNS:
        return marked

    longest = int(np.argmax(lengths))
    start = int(edges[longest])
    stop = int(edges[longest + 1])
    count = stop - start
    usual = float(np.quantile(np.delete(lengths, longest), 0.99, method="lower"))
    if count < max(_STUCK_ROWS, _STUCK_RUN * usual):
        return marked

    known = motion[np.isfinite(motion)]
    meanwhile = motion[start:stop]
    meanwhile = meanwhile[np.isfinite(meanwhile)]
    if not meanwhile.size:
        return marked
    # A motion that ends in the first rows does not go on.
    low, high = np.quantile(meanwhile, (0.1, 0.9))
    moves = float(high - low) > _MOVES * float(np.ptp(known)) > 0.0
    elsewhere = int(np.count_nonzero(effort == effort[start])) - count
    marked[start:stop] = moves and 10 * elsewhere < count
    return marked


def dropped(columns: Sequence[Array]) -> Mask:
    """Rows that hold one and the same number in all columns, where two or more jump there and back, shape (n,)."""
    marked = np.zeros(columns[0].size if columns else 0, dtype=np.bool_)
    if len(columns) < 2 or marked.size < _FEWEST:
        return marked
    first, *others = columns
    alike = np.logical_and.reduce([np.equal(other, first) for other in others])
    for start, stop in stretches(alike):
        inside = start > 0 and stop < marked.size
        if not inside or stop - start > _LONGEST_DROP:
            continue
        if _jumps(columns, start) >= 2 and _jumps(columns, stop) >= 2:
            marked[start:stop] = True
    return marked


def frozen(columns: Sequence[Array]) -> Mask:
    """Rows that repeat the row before in all columns, in stretches that two enter in motion and one leaves by a jump.

    A device at rest stands still too; it comes to rest slowly and starts without a jump. The first row of a stretch was
    measured. Shape (n,).
    """
    marked = np.zeros(columns[0].size if columns else 0, dtype=np.bool_)
    if len(columns) < 2 or marked.size < _FEWEST:
        return marked
    still = np.zeros(marked.size, dtype=np.bool_)
    repeats = [np.equal(column[1:], column[:-1]) for column in columns]
    still[1:] = np.logical_and.reduce(repeats)
    for start, stop in stretches(still):
        inside = start > 1 and stop < marked.size
        if not inside or stop - start < _SHORTEST_FREEZE:
            continue
        last_measured = start - 1
        before = slice(max(0, last_measured - 10), start)
        moving = 0  # columns that move by no less than a tenth of their largest usual step, within ten rows
        for column in columns:
            moving += bool(np.ptp(column[before]) >= 0.1 * _usual_step(column))
        comes_in_motion = moving >= 2 and not _jumps(columns, last_measured)
        if comes_in_motion and _jumps(columns, stop):
            marked[start:stop] = True
    return marked


def _jumps(columns: Sequence[Array], row: int) -> int:
    """How many columns come to a row by far more than their usual step."""
    jumps = 0
    for column in columns:
        step = abs(column[row] - column[row - 1])
        jumps += bool(step > _JUMPS * _usual_step(column))
    return jumps


def _usual_step(values: Array) -> float:
    """The step that 1 % of all steps exceed, of those that are none; infinite for a column that keeps levels."""
    steps = np.abs(np.diff(values))
    moving = steps[steps > 0.0]
    if moving.size <= 0.1 * steps.size:
        return np.inf
    return float(np.quantile(moving, 0.99))
