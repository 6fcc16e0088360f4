"""Figures 7 to 13 show a run of the live loop: inputs above, measured and estimated torque below."""

from __future__ import annotations

import numpy as np

from erclutch.paper.online import OnlineTrace
from erclutch.report.plots.plot_description import COLUMN, PAGE, Axis, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array

_ESTIMATES = ("series1", "series0", "series2", "series3", "series4", "series5")
_CROWDED = 4  # lines of a panel from which the figure needs two columns


def describe_online(trace: OnlineTrace, title: str, start: int = 0, rows: int = 4000) -> Plot:
    """A stretch of a run: a panel for each kind of signal.

    Args:
        trace: the run.
        title: above the panels, with TWIN, RECORDING or HARDWARE in it.
        start: first row.
        rows: how many.
    """
    at = slice(start, min(start + rows, len(trace.frames)))
    time = trace.frames["time_ns"][at]
    seconds: Array = 1e-9 * (time - time[0]).astype(np.float64)
    panels = _panels(trace, at, seconds)
    lines = [line for panel in panels for line in panel.marks if isinstance(line, Line)]
    table = PlotTable(["time", *(k.label for k in lines)], np.column_stack([seconds, *(k.y for k in lines)]).tolist())
    crowded = max(len(panel.marks) for panel in panels) > _CROWDED
    height, width = 0.55 + 0.95 * len(panels) + 0.2 * crowded, PAGE if crowded else COLUMN
    return Plot(panels, table, height, width, title=title, legend="above")


def _panels(trace: OnlineTrace, at: slice, seconds: Array) -> list[Panel]:
    f = trace.frames[at]
    x = Axis("time", "s", 0.0, float(seconds[-1]))

    def line(name: str, values: Array, style: str = "measured", dashed: bool = False) -> Line:
        return Line(seconds, values, style, name, dashed=dashed)

    speeds = [line("motor", f["theta_dot"], "series0"), line("output", f["alpha_dot"], "series3")]
    panels = [Panel(x, Axis("speed", "rad/s"), speeds)]
    if trace.other_alpha is not None:
        difference = line("linear - rotary", 1e3 * (f["alpha"] - trace.other_alpha[0][at]))
        panels.append(Panel(x, Axis("difference", "mrad"), [difference]))
    if np.any(f["field1"] + f["field2"] > 0.0):
        fields = [line("E1", f["field1"], "series0"), line("E2", f["field2"], "series1")]
        panels.append(Panel(x, Axis("field"), fields))
    if float(np.ptp(f["motor_torque"])) > 0.0:
        panels.append(Panel(x, Axis("motor torque", "N m"), [line("motor torque", f["motor_torque"])]))
    if np.isfinite(f["reference"]).all():
        angles = [line("reference", f["reference"]), line("output", f["alpha"], "series3", True)]
        panels.append(Panel(x, Axis("angle", "rad"), angles))
    estimates = {name: values[at] for name, values in trace.estimates.items()}
    if trace.other_alpha is not None:
        linear, rotary = next(iter(estimates.values())), trace.other_alpha[1][at]
        torque = [line("linear encoder", linear, "series0"), line("rotary encoder", rotary, "series1", True)]
    else:
        torque = [line("measured", f["torque"])]
        for k, (style, (name, values)) in enumerate(zip(_ESTIMATES, estimates.items(), strict=False)):
            torque.append(line(name, values, style, k == 0))
    return [*panels, Panel(x, Axis("torque", "N m"), torque)]
