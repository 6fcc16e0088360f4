"""Figures 3 and 6 show sections: of the training log, and of the test log with what each approach estimates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from erclutch.logs.dataset import Dataset
from erclutch.report.numbers.number_text import unit_text
from erclutch.report.plots.log_plots import describe_section
from erclutch.report.plots.matplotlib_painter import save_plot
from erclutch.report.plots.plot_description import PAGE, Axis, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.paper.tables import Row

#: Approaches of figure 6, the plainest first, each on a panel of its own: curves this near hide each other.
COMPARED = ("bingham/forward", "seo-seo/forward", "hem/forward", "rbfm-10/forward", "rbfn-50", "fnn-16")
_SECONDS = 1.0
_STYLES = ("series0", "series1")


def draw_training_section(log: Recording, folder: Path) -> list[Path]:
    """Figure 3: fields, motor torque and transmitted torque over a section of the training log."""
    return kept(describe_section(log, seconds=_SECONDS), folder, "fig3")


def draw_estimates(test: Dataset, rows: Sequence[Row], folder: Path, label: str) -> list[Path]:
    """Figure 6: measured torque and that of each approach, fields and slips, over a lively section of the test log."""
    width = min(round(_SECONDS / test.period), test.rows)
    first = lively(test.effort, width)
    at = slice(first, first + width)
    time = test.clock.time[at] - test.clock.time[first]
    measured = test.effort[at]
    estimates = {row.name: row.model.predict(test)[at] for row in rows}
    x = Axis("time", "s", 0.0, float(time[-1]))
    y = Axis("torque", unit_text(test.units.effort))
    panels = compared(x, y, time, measured, estimates)
    columns = {"time_s": time, "measured": measured, **estimates}
    for what, unit in (("field", test.units.field), ("slip", test.units.slip)):
        lines: list[Line] = []
        for number, (element, style) in enumerate(zip(test.elements, _STYLES, strict=False), start=1):
            channel = f"CH{number}"
            signal = getattr(element, what)[at]
            columns[f"{what} {channel}"] = signal
            lines.append(Line(time, signal, style, channel))
        panels.append(Panel(x, Axis(what, unit_text(unit)), lines))
    numbers = np.column_stack(list(columns.values()))
    table = PlotTable(list(columns), numbers.tolist())
    plot = Plot(panels, table, 6.4, PAGE, 2, title=label, legend="above")
    return kept(plot, folder, "fig6")


def compared(x: Axis, y: Axis, time: Array, measured: Array, estimates: Mapping[str, Array]) -> list[Panel]:
    """Measured and estimated torque, a panel a model, all of one height."""
    torques = np.array([measured, *estimates.values()])
    slack = 0.05 * float(np.ptp(torques))
    y = replace(y, low=float(torques.min()) - slack, high=float(torques.max()) + slack)
    known = Line(time, measured, "measured", "measured")
    panels: list[Panel] = []
    for name, estimate in estimates.items():
        title = APPROACHES[name].title if name in APPROACHES else name
        panels.append(Panel(x, y, [known, Line(time, estimate, "recommended", title)]))
    return panels


def lively(effort: Array, width: int) -> int:
    """The first row of a section of so many rows in which the effort varies as the upper quarter of all sections."""
    starts = range(0, effort.size - width + 1, max(1, width // 2))
    calm_first = sorted(starts, key=lambda start: float(effort[start : start + width].std()))
    return calm_first[(3 * len(calm_first)) // 4]


def kept(plot: Plot, folder: Path, name: str) -> list[Path]:
    """Write a figure as PDF and PNG, with its numbers; returns the files."""
    return save_plot(plot, folder / f"{name}.pdf", folder / f"{name}.png")
