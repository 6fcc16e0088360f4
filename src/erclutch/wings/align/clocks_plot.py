"""This plot shows a signal of two logs before and after their clocks were matched, and what offset is left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.report.plots.plot_description import Axis, Dots, Line, Panel, Plot, PlotTable, ReferenceLine
from erclutch.signals.array import Array
from erclutch.wings.align.clock_match import ClockMatch
from erclutch.wings.align.track import Track

_ROWS = 150  # of the slower log in the section that is shown


def describe_clocks(
    matches: Sequence[ClockMatch], traces: tuple[Track, tuple[Track, ...]], title: str, badge: str = ""
) -> Plot:
    """Three panels: both signals on their own clocks, on A's clock, and the offset that is left over time."""
    a, match = traces[0], matches[0]
    b = traces[1][0]
    x = _section(a, b, match)
    curves = [
        (a.time, _scaled(a)),
        (b.time, _scaled(b) * np.sign(match.gain)),
        (match.on_a(b.time), _scaled(b) * np.sign(match.gain)),
    ]
    lines = [
        Line(time[rows], values[rows], style, label)
        for (time, values), style, label in zip(
            curves, ("measured", "recommended", "recommended"), ("A", "B", "B"), strict=True
        )
        for rows in [(time >= x[0]) & (time <= x[1])]
    ]
    time = Axis("time on the clock of A", "s", *x)
    centres = np.concatenate([m.centres for m in matches])
    left = 1e3 * np.concatenate([m.residuals for m in matches])
    rows = [("offset left", float(t), float(v)) for t, v in zip(centres, left, strict=True)]
    names = ("A", "B before", "B after")
    for name, line in zip(names, lines, strict=True):
        rows += [(name, float(t), float(v)) for t, v in zip(line.x, line.y, strict=True)]
    signal = Axis(f"{title}, scaled")
    return Plot(
        [
            Panel(time, signal, [lines[0], lines[1]], f"{title} by both logs, each on its own clock.", "before"),
            Panel(time, signal, [lines[0], lines[2]], f"{title} by both logs on the clock of A.", "after"),
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


def _section(a: Track, b: Track, match: ClockMatch) -> tuple[float, float]:
    """The liveliest of some sections that show the offset, if it is short enough to be seen, and single rows."""
    low, high = match.overlap
    length = min(max(_ROWS * max(a.period, b.period), min(8.0 * abs(match.offset), 5.0)), high - low)
    starts = np.linspace(low, high - length, 40)
    inside = [a.values[(a.time >= start) & (a.time <= start + length)] for start in starts]
    lively = [float(np.std(values)) if values.size else 0.0 for values in inside]
    start = float(starts[int(np.argmax(lively))])
    return start, start + length
