"""These plots show a log: a section with inputs above and torque below, and where in field and slip it has rows."""

from __future__ import annotations

import numpy as np

from erclutch.errors import printable
from erclutch.logs.dataset import Dataset
from erclutch.report.numbers.error_map import even_edges
from erclutch.report.numbers.number_text import unit_text
from erclutch.report.plots.plot_description import Axis, Cells, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.signals.percent import percent
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


def describe_section(
    recording: Recording,
    *,
    start: float | None = None,
    seconds: float = 1.0,
) -> Plot:
    """A panel for the fields, the motor torque or the speeds, and the effort.

    Args:
        recording: the log.
        start: first time shown, in s on the log's clock; None: where the effort varies most evenly (the median
            section).
        seconds: length.
    """
    effort = "effort" if "effort" in recording.signals else "T"
    window_rows = max(2, round(seconds / recording.period))
    width = min(window_rows, recording.rows)
    if start is not None:
        before = int(np.count_nonzero(recording.time < start))
        first = min(before, recording.rows - width)
    else:
        # The section with the median spread of the effort; sections overlap by half.
        firsts = range(0, recording.rows - width + 1, max(1, width // 2))
        spreads = [float(recording.signals[effort][at : at + width].std()) for at in firsts]
        by_spread = np.argsort(spreads, kind="stable")
        first = firsts[int(by_spread[len(firsts) // 2])]
    section = slice(first, first + width)
    begin = recording.time[section.start]
    time = recording.time[section] - begin
    x = Axis(f"time from {begin:.2f} s", "s", 0.0, float(time[-1]))

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
            signal = recording.signals[name][section]
            lines.append(Line(time, signal, style, name, steps=True))
        y = Axis(title, unit_text(recording.units[logged[0]]))
        panels.append(Panel(x, y, lines, f"{title} over time."))
        for name in logged:
            columns[name] = recording.signals[name][section]

    numbers = np.column_stack(list(columns.values()))
    return Plot(
        panels,
        PlotTable(list(columns), numbers.tolist()),
        height=0.45 + 0.95 * len(panels),
        title=titled(recording),
        legend="above",
    )


def titled(recording: Recording) -> str:
    """Name of a log with the label that a computer-made one carries."""
    label = f" ({recording.origin})" if recording.origin else ""
    return printable(recording.name + label)


def describe_coverage(data: Dataset, name: str = "") -> Plot:
    """Rows a cell, a panel an element, under the name of the log."""
    field_unit = unit_text(data.units.field)
    slip_unit = unit_text(data.units.slip)
    # Edges in field and in slip (n + 1,), and rows in each cell (n, n).
    maps: list[tuple[Array, Array, Array]] = []
    for element in data.elements:
        field_edges = even_edges(element.field, _BINS)
        slip_edges = even_edges(element.slip, _BINS)
        count, _, _ = np.histogram2d(element.field, element.slip, bins=(field_edges, slip_edges))
        maps.append((field_edges, slip_edges, count))
    most = max(float(count.max()) for _, _, count in maps)  # one scale of colours for all panels

    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    for number, (field_edges, slip_edges, count) in enumerate(maps, start=1):
        cells = Cells(
            field_edges,
            slip_edges,
            np.where(count > 0, count, np.nan),
            top=most,
            style="mass",
            label="rows a cell",
            log=True,
        )
        label = f"CH{number}: " if len(maps) > 1 else ""
        empty = np.count_nonzero(count == 0) / count.size
        title = f"{label}{percent(empty)} empty"
        x = Axis.over("field", field_unit, field_edges)
        y = Axis.over("slip", slip_unit, slip_edges)
        panels.append(Panel(x, y, [cells], f"Rows over field and slip, {title}.", title))

        field_middles = 0.5 * (field_edges[1:] + field_edges[:-1])
        slip_middles = 0.5 * (slip_edges[1:] + slip_edges[:-1])
        for i, j in np.argwhere(count > 0):
            field = float(field_middles[i])
            slip = float(slip_middles[j])
            rows.append((number, field, slip, int(count[i, j])))
    table = PlotTable(("element", "field", "slip", "rows"), rows)
    return Plot(
        panels,
        table,
        height=2.9,
        columns=len(panels),
        title=name,
    )
