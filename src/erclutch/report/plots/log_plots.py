"""These plots show a log: a section with inputs above and torque below, and where in field and slip it has rows."""

from __future__ import annotations

import numpy as np

from erclutch.errors import printable
from erclutch.logs.dataset import Dataset
from erclutch.report.numbers.error_map import even_edges
from erclutch.report.numbers.number_text import unit_text
from erclutch.report.plots.plot_description import Axis, Cells, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array
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
    at = _rows(recording, start, seconds)
    begin = recording.time[at.start]
    time = recording.time[at] - begin
    x = Axis(f"time from {begin:.2f} s", "s", 0.0, float(time[-1]))

    effort = _effort(recording)
    word = {"N": "force", "N*m": "torque"}.get(recording.units[effort], "effort")
    columns = {"time": time}
    panels: list[Panel] = []
    for title, names in {**_INPUTS, word: (effort,)}.items():
        logged = [name for name in names if name in recording.signals]
        if not logged:
            continue
        styles = ("measured",) if title == word else ("series0", "series1", "series3")
        lines: list[Line] = []
        for name, style in zip(logged, styles, strict=False):
            lines.append(Line(time, recording.signals[name][at], style, name, steps=True))
        y = Axis(title, unit_text(recording.units[logged[0]]))
        panels.append(Panel(x, y, lines, f"{title} over time."))
        columns |= {name: recording.signals[name][at] for name in logged}
    table = PlotTable(list(columns), np.column_stack(list(columns.values())).tolist())
    height = 0.45 + 0.95 * len(panels)
    return Plot(panels, table, height, title=titled(recording), legend="above")


def _effort(recording: Recording) -> str:
    return "effort" if "effort" in recording.signals else "T"


def titled(recording: Recording) -> str:
    """Name of a log with the label that a computer-made one carries."""
    return printable(f"{recording.name} ({recording.origin})" if recording.origin else recording.name)


def _rows(recording: Recording, start: float | None, seconds: float) -> slice:
    """Rows of a section; without a start the section with the median spread of the effort."""
    width = min(max(2, round(seconds / recording.period)), recording.rows)
    if start is not None:
        before = int(np.count_nonzero(recording.time < start))
        first = min(before, recording.rows - width)
        return slice(first, first + width)
    effort = recording.signals[_effort(recording)]
    starts = range(0, recording.rows - width + 1, max(1, width // 2))
    by_spread = sorted(starts, key=lambda first: float(effort[first : first + width].std()))
    first = by_spread[len(by_spread) // 2]
    return slice(first, first + width)


def describe_coverage(data: Dataset, name: str = "") -> Plot:
    """Rows a cell, a panel an element, under the name of the log."""
    maps = [_rows_a_cell(element.field, element.slip) for element in data.elements]
    most = max(float(count.max()) for _, _, count in maps)  # one scale of colours for all panels
    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    for number, (field, slip, count) in enumerate(maps, start=1):
        cells = Cells(field, slip, np.where(count > 0, count, np.nan), most, "mass", "rows a cell", log=True)
        label = f"CH{number}: " if len(maps) > 1 else ""
        empty = np.count_nonzero(count == 0) / count.size
        title = f"{label}{empty:.0%} empty"
        x = Axis("field", unit_text(data.units.field), float(field[0]), float(field[-1]))
        y = Axis("slip", unit_text(data.units.slip), float(slip[0]), float(slip[-1]))
        panels.append(Panel(x, y, [cells], f"Rows over field and slip, {title}.", title))
        field_middles = 0.5 * (field[1:] + field[:-1])
        slip_middles = 0.5 * (slip[1:] + slip[:-1])
        for i, j in np.argwhere(count > 0):
            rows.append((number, float(field_middles[i]), float(slip_middles[j]), int(count[i, j])))
    table = PlotTable(("element", "field", "slip", "rows"), rows)
    return Plot(panels, table, 2.9, columns=len(panels), title=name)


def _rows_a_cell(field: Array, slip: Array) -> tuple[Array, Array, Array]:
    """Edges of the cells in field and in slip, shapes (n + 1,), and rows in each cell, shape (n, n)."""
    field_edges = even_edges(field, _BINS)
    slip_edges = even_edges(slip, _BINS)
    count, _, _ = np.histogram2d(field, slip, bins=(field_edges, slip_edges))
    return field_edges, slip_edges, count
