"""The figure of torque control on the TWIN: errors by frequency, for each model and each controller."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.report.plots.plot_description import PAGE, Axis, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.wings.paper.torque_control import EDGES, INVERSES, KNOWS, ControlRun


def describe_control(runs: Sequence[ControlRun]) -> Plot:
    """RMS error of the chirp by frequency: a panel for each model, a line for each controller, means over the seeds."""
    middle: Array = np.sqrt(EDGES[1:] * EDGES[:-1])
    keep = slice(2, None)  # the motor runs up in the first second
    panels: list[Panel] = []
    columns: list[Array] = [middle[keep]]
    names = ["frequency"]
    for model in INVERSES:
        marks: list[Line] = []
        styles = ("series3", "series1", "series2", "series0")
        for style, knows in zip(styles, KNOWS, strict=True):
            bands = [run.figures["bands"] for run in runs if (run.model, run.knows) == (model, knows)]
            mean: Array = 100.0 * np.mean(np.array(bands, np.float64), axis=0)[keep]
            marks.append(Line(middle[keep], mean, style, knows, marked=True))
            columns.append(mean)
            names.append(f"{model}, {knows}")
        x = Axis("frequency", "Hz", 0.0, 10.0)
        y = Axis("RMS error", "% of range", 0.0, 4.0)
        panels.append(Panel(x, y, marks, title=model))
    table = PlotTable(names, np.column_stack(columns).tolist())
    return Plot(panels, table, 2.6, PAGE, columns=3, badge="TWIN", legend="shared")
