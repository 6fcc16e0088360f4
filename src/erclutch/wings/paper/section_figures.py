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
COMPARED = (
    "bingham/forward",
    "seo-seo/forward",
    "hem/forward",
    "rbfm-10/forward",
    "rbfn-50",
    "fnn-16",
)
_SECONDS = 1.0
_STYLES = ("series0", "series1")


def draw_training_section(log: Recording, folder: Path) -> list[Path]:
    """Figure 3: fields, motor torque and transmitted torque over a section of the training log."""
    return kept(describe_section(log, seconds=_SECONDS), folder, "fig3")


def draw_estimates(
    test: Dataset,
    rows: Sequence[Row],
    folder: Path,
    label: str,
) -> list[Path]:
    """Figure 6: measured torque and that of each approach, fields and slips, over a lively section of the test log."""
    width = min(round(_SECONDS / test.period), test.rows)
    first = lively(test.effort, width)
    section = slice(first, first + width)
    time = test.clock.time[section] - test.clock.time[first]
    measured = test.effort[section]
    estimates = {row.name: row.model.predict(test)[section] for row in rows}
    x = Axis("time", "s", 0.0, float(time[-1]))
    torque = Axis("torque", unit_text(test.units.effort))
    panels = compared(x, torque, time, measured, estimates)
    columns = {"time_s": time, "measured": measured, **estimates}

    # Below the torques: what went in, a line an element.
    units = {"field": test.units.field, "slip": test.units.slip}
    for quantity, unit in units.items():
        lines: list[Line] = []
        for number, (element, style) in enumerate(
            zip(test.elements, _STYLES, strict=False), start=1
        ):
            channel = f"CH{number}"
            signal = getattr(element, quantity)[section]
            columns[f"{quantity} {channel}"] = signal
            lines.append(Line(time, signal, style, channel))
        axis = Axis(quantity, unit_text(unit))
        panels.append(Panel(x, axis, lines))

    numbers = np.column_stack(list(columns.values()))
    plot = Plot(
        panels,
        PlotTable(list(columns), numbers.tolist()),
        height=6.4,
        width=PAGE,
        columns=2,
        title=label,
        legend="above",
    )
    return kept(plot, folder, "fig6")


def compared(
    x: Axis,
    y: Axis,
    time: Array,
    measured: Array,
    estimates: Mapping[str, Array],
) -> list[Panel]:
    """Measured and estimated torque, a panel a model, all of one height."""
    torques = np.array([measured, *estimates.values()])
    lowest = float(torques.min())
    highest = float(torques.max())
    slack = 0.05 * float(np.ptp(torques))
    y = replace(y, low=lowest - slack, high=highest + slack)

    known = Line(time, measured, "measured", "measured")
    panels: list[Panel] = []
    for name, estimate in estimates.items():
        title = APPROACHES[name].title if name in APPROACHES else name
        line = Line(time, estimate, "recommended", title)
        panels.append(Panel(x, y, [known, line]))
    return panels


def lively(effort: Array, width: int) -> int:
    """The first row of a section of so many rows in which the effort varies as the upper quarter of all sections."""

    def spread(start: int) -> float:
        return float(effort[start : start + width].std())

    half = max(1, width // 2)  # sections overlap by half
    starts = range(0, effort.size - width + 1, half)
    calm_first = sorted(starts, key=spread)
    upper_quarter = (3 * len(calm_first)) // 4
    return calm_first[upper_quarter]


def kept(plot: Plot, folder: Path, name: str) -> list[Path]:
    """Write a figure as PDF and PNG, with its numbers; returns the files."""
    pdf = folder / f"{name}.pdf"
    png = folder / f"{name}.png"
    return save_plot(plot, pdf, png)
