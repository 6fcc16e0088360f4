"""The figure of torque control on the TWIN: errors by frequency, for each model and each controller."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.report.plots.plot_description import PAGE, Axis, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.wings.paper.torque_control import EDGES, INVERSES, KNOWS, ControlRun

_STYLES = ("series3", "series1", "series2", "series0")  # of the controllers


def describe_control(runs: Sequence[ControlRun]) -> Plot:
    """RMS error of the chirp by frequency: a panel for each model, a line for each controller, means over the seeds."""
    settled = slice(2, None)  # bands: the motor runs up in the first second
    middles: Array = np.sqrt(EDGES[1:] * EDGES[:-1])
    frequency = middles[settled]  # [Hz], one a band
    x = Axis("frequency", "Hz", 0.0, 10.0)
    y = Axis("RMS error", "% of range", 0.0, 4.0)
    panels: list[Panel] = []
    columns = {"frequency": frequency}
    for model in INVERSES:
        lines: list[Line] = []
        for style, knows in zip(_STYLES, KNOWS, strict=True):
            of_seeds: list[list[float]] = []
            for run in runs:
                if run.model == model and run.knows == knows:
                    of_seeds.append(run.figures["bands"])
            mean: Array = np.mean(np.array(of_seeds, np.float64), axis=0)
            percent = 100.0 * mean[settled]
            lines.append(Line(frequency, percent, style, knows, marked=True))
            columns[f"{model}, {knows}"] = percent
        panels.append(Panel(x, y, lines, title=model))
    numbers = np.column_stack(list(columns.values()))
    return Plot(
        panels,
        PlotTable(list(columns), numbers.tolist()),
        height=2.6,
        width=PAGE,
        columns=3,
        badge="TWIN",
        legend="shared",
    )
