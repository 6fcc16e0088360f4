"""These plots show a log: a section with inputs above and torque below, and where in field and slip it has rows."""

from __future__ import annotations

import numpy as np

from erclutch.errors import printable
from erclutch.logs.dataset import Dataset
from erclutch.report.numbers.error_map import even_edges
from erclutch.report.numbers.number_text import unit_text
from erclutch.report.plots.plot_description import Axis, Cells, Line, Panel, Plot, PlotTable
from erclutch.signals.recording import Recording

_BINS = 40
#: Signals of each panel above that of the effort.
_INPUTS = {
    "field": ("field", "E1", "E2", "E"),
    "motor torque": ("motor_torque",),
    "speed": ("theta_dot", "alpha_dot"),
    "slip": ("slip",),
    "position": ("position",),
}


def describe_section(recording: Recording, *, start: float | None = None, seconds: float = 1.0) -> Plot:
    """A panel for the fields, the motor torque or the speeds, and the effort.

    Args:
        recording: the log.
        start: first time shown, in s on the log's clock; None: where the effort varies most evenly (the median
            section).
        seconds: length.
    """
    signals, at = recording.signals, _rows(recording, start, seconds)
    effort = _effort(recording)
    word = {"N": "force", "N*m": "torque"}.get(recording.units[effort], "effort")
    time = recording.time[at] - recording.time[at.start]
    x = Axis(f"time from {recording.time[at.start]:.2f} s", "s", 0.0, float(time[-1]))
    panels: list[Panel] = []
    columns = {"time": time}
    for title, names in {**_INPUTS, word: (effort,)}.items():
        found = [name for name in names if name in signals]
        columns |= {name: signals[name][at] for name in found}
        styles = ("measured",) if title == word else ("series0", "series1", "series3")
        lines = [Line(time, columns[n], style, n, steps=True) for n, style in zip(found, styles, strict=False)]
        if lines:
            y = Axis(title, unit_text(recording.units[found[0]]))
            panels.append(Panel(x, y, lines, f"{title} over time."))
    table = PlotTable(list(columns), np.column_stack(list(columns.values())).tolist())
    return Plot(panels, table, 0.45 + 0.95 * len(panels), title=titled(recording), legend="above")


def _effort(recording: Recording) -> str:
    return "effort" if "effort" in recording.signals else "T"


def titled(recording: Recording) -> str:
    """Name of a log with the label that a computer-made one carries."""
    return printable(f"{recording.name} ({recording.origin})" if recording.origin else recording.name)


def _rows(recording: Recording, start: float | None, seconds: float) -> slice:
    width = min(max(2, round(seconds / recording.period)), recording.rows)
    if start is not None:
        first = int(np.count_nonzero(recording.time < start))
        return slice(min(first, recording.rows - width), min(first, recording.rows - width) + width)
    effort = recording.signals[_effort(recording)]
    starts = range(0, recording.rows - width + 1, max(1, width // 2))
    spread = [float(effort[s : s + width].std()) for s in starts]
    first = starts[sorted(range(len(spread)), key=spread.__getitem__)[len(spread) // 2]]
    return slice(first, first + width)


def describe_coverage(data: Dataset, name: str = "") -> Plot:
    """Rows a cell, a panel an element, under the name of the log."""
    maps = [(even_edges(e.field, _BINS), even_edges(e.slip, _BINS)) for e in data.elements]
    counts = [np.histogram2d(e.field, e.slip, bins=at)[0] for e, at in zip(data.elements, maps, strict=True)]
    most = max(float(c.max()) for c in counts)
    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    for k, ((field, slip), count) in enumerate(zip(maps, counts, strict=True)):
        cells = Cells(field, slip, np.where(count > 0, count, np.nan), most, "mass", "rows a cell", log=True)
        label = f"CH{k + 1}: " if len(maps) > 1 else ""
        title = f"{label}{np.count_nonzero(count == 0) / count.size:.0%} empty"
        x, y = (
            Axis(what, unit_text(unit), float(edges[0]), float(edges[-1]))
            for what, unit, edges in (("field", data.units.field, field), ("slip", data.units.slip, slip))
        )
        panels.append(Panel(x, y, [cells], f"Rows over field and slip, {title}.", title))
        across, up = (0.5 * (edges[1:] + edges[:-1]) for edges in (field, slip))
        rows += [(k + 1, float(across[i]), float(up[j]), int(count[i, j])) for i, j in np.argwhere(count > 0)]
    return Plot(panels, PlotTable(("element", "field", "slip", "rows"), rows), 2.9, columns=len(panels), title=name)
