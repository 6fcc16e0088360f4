"""Figures 7 to 13 show a run of the live loop in the paper's layout: (a) inputs, (b) torque measured and estimated."""

from __future__ import annotations

import numpy as np

from erclutch.report.plots.plot_description import (
    COLUMN,
    PAGE,
    Axis,
    Line,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
)
from erclutch.signals.array import Array
from erclutch.wings.paper.online import OnlineTrace, trial
from erclutch.wings.paper.section_figures import compared, lively
from erclutch.wings.rig.twin.twin import PERIOD

#: Figure of the first program of each experiment.
FIGURE_OF = {
    "sine": 7,
    "square": 8,
    "tracking": 9,
    "zero-field": 11,
    "zero-motion": 12,
    "encoders": 13,
}
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
    if figure == 9:
        start = trial(trace, 0).start
    elif figure == 10:
        start = trial(trace, -1).start
    elif figure == 13:
        start = 0
    else:
        start = lively(trace.frames["torque"], width)
    section = slice(start, start + width)
    frames = trace.frames[section]
    since_start = frames["time_ns"] - frames["time_ns"][0]
    time: Array = 1e-9 * since_start.astype(np.float64)  # [s]
    x = Axis("time", "s", 0.0, float(time[-1]))

    # (a): the speeds, and the fields or, without a field, the motor's torque.
    speeds = [
        Line(time, frames["theta_dot"], "series0", "motor"),
        Line(time, frames["alpha_dot"], "series3", "output"),
    ]
    panels = [Panel(x, Axis("(a) speed", "rad/s"), speeds)]
    if np.any(frames["field1"] + frames["field2"] > 0.0):
        fields = [
            Line(time, frames["field1"], "series0", "E1"),
            Line(time, frames["field2"], "series1", "E2"),
        ]
        panels.append(Panel(x, Axis("(a) field"), fields))
    else:
        motor_torque = Line(time, frames["motor_torque"], "series0", "motor torque")
        panels.append(Panel(x, Axis("(a) motor torque", "N m"), [motor_torque]))

    # (b): each model beside the measured torque.
    several = len(trace.estimates) > 1
    if several:
        torque = Axis("(b) torque", "N m")
        estimates = {name: values[section] for name, values in trace.estimates.items()}
        panels += compared(x, torque, time, frames["torque"], estimates)
    else:
        # A model alone: beside the measured torque, or with either of two encoders, and the difference.
        ((name, estimate),) = trace.estimates.items()
        online = estimate[section]
        if trace.other_alpha is None:
            torques = [
                Line(time, frames["torque"], "measured", "measured"),
                Line(time, online, "recommended", name, dashed=True),
            ]
            apart = online - frames["torque"]
            meaning = "estimated less measured"
        else:
            other_alpha, with_other = (values[section] for values in trace.other_alpha)
            torques = [
                Line(time, online, "series0", "linear encoder"),
                Line(time, with_other, "series1", "rotary encoder", dashed=True),
            ]
            apart = with_other - online
            meaning = "rotary less linear"
            angle_apart = 1e3 * (other_alpha - frames["alpha"])  # [mrad]
            angle = Line(time, angle_apart, "measured", "angle, rotary less linear")
            panels.append(Panel(x, Axis("(a) angle apart", "mrad"), [angle], share=0.7))
        difference = Line(time, 1e3 * apart, "series4", meaning)
        panels.append(Panel(x, Axis("(b) torque", "N m"), torques, share=1.8))
        panels.append(Panel(x, Axis("(b) apart", "mN m"), [ReferenceLine(0.0), difference]))

    columns: dict[str, Array] = {}
    for panel in panels:
        for mark in panel.marks:
            if isinstance(mark, Line):
                columns[mark.label] = mark.y
    numbers = np.column_stack([time, *columns.values()])
    side_by_side = 2 if several else 1
    return Plot(
        panels,
        PlotTable(["time", *columns], numbers.tolist()),
        height=1.1 * len(panels) / side_by_side + 0.6,
        width=PAGE if several else COLUMN,
        columns=side_by_side,
        title=f"TWIN, {trace.name}: figure {figure} of the paper",
        legend="above",
    )
