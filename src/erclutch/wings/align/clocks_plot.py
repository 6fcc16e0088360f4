"""This plot shows a signal of two logs before and after their clocks were matched, and what offset is left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.report.plots.plot_description import (
    Axis,
    Dots,
    Line,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
)
from erclutch.signals.array import Array
from erclutch.wings.align.clock_match import ClockMatch
from erclutch.wings.align.track import Track

_ROWS = 150  # of the slower log in the section that is shown


def describe_clocks(
    matches: Sequence[ClockMatch],
    traces: tuple[Track, tuple[Track, ...]],
    title: str,
    badge: str = "",
) -> Plot:
    """Three panels: both signals on their own clocks, on A's clock, and the offset that is left over time."""
    a, all_b = traces
    b = all_b[0]
    match = matches[0]

    # The liveliest of some sections that show the offset, if it is short enough to be seen, and single rows.
    first, last = match.overlap
    rows_seen = _ROWS * max(a.period, b.period)  # [s]
    offset_seen = min(8.0 * abs(match.offset), 5.0)  # [s]
    length = min(max(rows_seen, offset_seen), last - first)
    starts = np.linspace(first, last - length, 40)
    spreads: list[float] = []
    for start in starts:
        values = a.values[(a.time >= start) & (a.time <= start + length)]
        spreads.append(float(np.std(values)) if values.size else 0.0)
    low = float(starts[int(np.argmax(spreads))])
    high = low + length
    # A signal of the other sign is turned, so that both curves can lie on each other.
    sign = np.sign(match.gain)

    def line(
        time: Array,
        values: Array,
        style: str,
        label: str,
    ) -> Line:
        rows = (time >= low) & (time <= high)
        return Line(time[rows], values[rows], style, label)

    line_a = line(a.time, _scaled(a), "measured", "A")
    before = line(b.time, _scaled(b) * sign, "recommended", "B")
    after = line(match.on_a(b.time), _scaled(b) * sign, "recommended", "B")
    centres = np.concatenate([each.centres for each in matches])  # [s]
    left = 1e3 * np.concatenate([each.residuals for each in matches])  # [ms]

    rows: list[tuple[str, float, float]] = []

    def tabulate(name: str, times: Array, values: Array) -> None:
        for moment, value in zip(times.tolist(), values.tolist(), strict=True):
            rows.append((name, moment, value))

    tabulate("offset left", centres, left)
    tabulate("A", line_a.x, line_a.y)
    tabulate("B before", before.x, before.y)
    tabulate("B after", after.x, after.y)
    time = Axis("time on the clock of A", "s", low, high)
    signal = Axis(f"{title}, scaled")
    return Plot(
        [
            Panel(
                time,
                signal,
                [line_a, before],
                f"{title} by both logs, each on its own clock.",
                "before",
            ),
            Panel(
                time, signal, [line_a, after], f"{title} by both logs on the clock of A.", "after"
            ),
            Panel(
                Axis("time on the clock of A", "s"),
                Axis("offset left", "ms"),
                [ReferenceLine(0.0), Dots(centres, left, "recommended", size=3.0)],
                "Offset of each window less the line.",
            ),
        ],
        PlotTable(("curve", "time_s", "value"), rows),
        4.2,
        badge=badge,
    )


def _scaled(track: Track) -> Array:
    """The values over their spread, around their median."""
    return (track.values - np.median(track.values)) / float(np.std(track.values))
