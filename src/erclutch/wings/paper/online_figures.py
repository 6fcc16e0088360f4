"""Figures 7 to 13 show a run of the live loop in the paper's layout: (a) inputs, (b) torque measured and estimated."""

from __future__ import annotations

import numpy as np

from erclutch.report.plots.plot_description import COLUMN, PAGE, Axis, Line, Panel, Plot, PlotTable, ReferenceLine
from erclutch.signals.array import Array
from erclutch.wings.paper.online import OnlineTrace, trial
from erclutch.wings.paper.section_figures import compared, lively
from erclutch.wings.rig.twin.twin import PERIOD

#: Figure of the first program of each experiment.
FIGURE_OF = {"sine": 7, "square": 8, "tracking": 9, "zero-field": 11, "zero-motion": 12, "encoders": 13}
_SECONDS = {7: 1.0, 8: 1.0, 9: 5.0, 10: 2.0, 11: 2.0, 12: 1.0, 13: 5.0}


def describe_online(trace: OnlineTrace, figure: int) -> Plot:
    """The section that a figure of the paper shows, on the TWIN.

    Figures 9 and 10 begin with the first and the last trial, figure 13 with the run; the others show a section in
    which the torque varies as the upper quarter of all sections. Where curves lie on each other a panel shows their
    difference, and each of several models has a panel of its own.

    Args:
        trace: the run.
        figure: its number in the paper, 7 to 13.
    """
    width = min(round(_SECONDS[figure] / PERIOD), len(trace.frames))
    firsts = {9: trial(trace, 0).start, 10: trial(trace, -1).start, 13: 0}
    start = firsts[figure] if figure in firsts else lively(trace.frames["torque"], width)
    at = slice(start, start + width)
    time = trace.frames["time_ns"][at]
    seconds: Array = 1e-9 * (time - time[0]).astype(np.float64)
    several = len(trace.estimates) > 1
    panels = [*_inputs(trace, at, seconds), *_torques(trace, at, seconds)]
    lines = [mark for panel in panels for mark in panel.marks if isinstance(mark, Line)]
    columns = {line.label: line.y for line in lines}
    table = PlotTable(["time", *columns], np.column_stack([seconds, *columns.values()]).tolist())
    title = f"TWIN, {trace.name}: figure {figure} of the paper"
    height = 1.1 * len(panels) / (2 if several else 1) + 0.6
    return Plot(panels, table, height, PAGE if several else COLUMN, 2 if several else 1, title=title, legend="above")


def _inputs(trace: OnlineTrace, at: slice, seconds: Array) -> list[Panel]:
    """(a): the speeds, and the fields or, without a field, the motor's torque."""
    frames = trace.frames[at]
    x = Axis("time", "s", 0.0, float(seconds[-1]))
    speeds = [
        Line(seconds, frames["theta_dot"], "series0", "motor"),
        Line(seconds, frames["alpha_dot"], "series3", "output"),
    ]
    if np.any(frames["field1"] + frames["field2"] > 0.0):
        fields = [
            Line(seconds, frames["field1"], "series0", "E1"),
            Line(seconds, frames["field2"], "series1", "E2"),
        ]
        driving = Panel(x, Axis("(a) field"), fields)
    else:
        torque = Line(seconds, frames["motor_torque"], "series0", "motor torque")
        driving = Panel(x, Axis("(a) motor torque", "N m"), [torque])
    return [Panel(x, Axis("(a) speed", "rad/s"), speeds), driving]


def _torques(trace: OnlineTrace, at: slice, seconds: Array) -> list[Panel]:
    """(b): each model beside the measured torque; a model alone, or one with two encoders, also as a difference."""
    frames = trace.frames[at]
    x = Axis("time", "s", 0.0, float(seconds[-1]))
    torque = Axis("(b) torque", "N m")
    estimates = {name: values[at] for name, values in trace.estimates.items()}
    if len(estimates) > 1:
        return compared(x, torque, seconds, frames["torque"], estimates)

    ((name, online),) = estimates.items()
    panels: list[Panel] = []
    if trace.other_alpha is None:
        lines = [
            Line(seconds, frames["torque"], "measured", "measured"),
            Line(seconds, online, "recommended", name, dashed=True),
        ]
        what, apart = "estimated less measured", online - frames["torque"]
    else:
        alpha, estimate = (values[at] for values in trace.other_alpha)
        lines = [
            Line(seconds, online, "series0", "linear encoder"),
            Line(seconds, estimate, "series1", "rotary encoder", dashed=True),
        ]
        what, apart = "rotary less linear", estimate - online
        off = Line(seconds, 1e3 * (alpha - frames["alpha"]), "measured", "angle, rotary less linear")
        panels.append(Panel(x, Axis("(a) angle apart", "mrad"), [off], share=0.7))
    rest = [ReferenceLine(0.0), Line(seconds, 1e3 * apart, "series4", what)]
    panels.append(Panel(x, torque, lines, share=1.8))
    panels.append(Panel(x, Axis("(b) apart", "mN m"), rest))
    return panels
