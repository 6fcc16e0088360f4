"""This plot shows tuned loops: gain and phase over frequency, sensitivity, and what follows a step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from erclutch.report.plots.plot_description import (
    PAGE,
    Axis,
    Line,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
)
from erclutch.signals.array import Array
from erclutch.wings.live.loop_margins import TunedLoop


def describe_loops(loops: Sequence[TunedLoop]) -> Plot:
    """Bode plot, sensitivity and step of both loops: of motion the reference steps, of torque what no model knows."""
    gains: list[Any] = [ReferenceLine(0.0)]
    phases: list[Any] = [ReferenceLine(-180.0)]
    sensitivities: list[Any] = [ReferenceLine(1.0)]
    steps: list[Any] = []
    names = ["frequency [Hz]"]
    columns: list[Array] = []
    for style, tuned in zip(("series1", "series3"), loops, strict=True):
        frequency, response = tuned.loop.response()
        if not columns:
            columns.append(frequency)  # the same of every loop
        gain: Array = 20.0 * np.log10(np.abs(response))
        turned = np.unwrap(np.angle(response))
        phase: Array = np.degrees(turned)
        # It begins within half a turn of -180 degrees.
        phase -= 360.0 * round((float(phase[0]) + 180.0) / 360.0)
        sensitivity: Array = 1.0 / np.abs(1.0 + response)
        gains.append(Line(frequency, gain, style, tuned.name))
        phases.append(Line(frequency, phase, style, tuned.name))
        sensitivities.append(Line(frequency, sensitivity, style, tuned.name))
        names += [f"{tuned.name}, dB", f"{tuned.name}, deg", f"{tuned.name}, sensitivity"]
        columns += [gain, phase, sensitivity]
        step = tuned.loop.step()[:400]
        time: Array = tuned.loop.period * np.arange(step.size, dtype=np.float64)
        steps.append(Line(time, step, style, tuned.name))

    hertz = Axis("frequency", "Hz", 0.1, 500.0, log=True)
    seconds = Axis("time", "s", 0.0, 0.4)
    panels = [
        Panel(hertz, Axis("gain", "dB", -40.0, 40.0), gains, title="gain of the loop"),
        Panel(hertz, Axis("phase", "deg", -360.0, 0.0), phases, title="phase of the loop"),
        Panel(
            hertz,
            Axis("sensitivity", "", 0.0, 2.5),
            sensitivities,
            title="sensitivity |1 / (1 + L)|",
        ),
        Panel(
            seconds,
            Axis("step", "", -0.2, 1.6),
            steps,
            title="step of the reference, or of a torque beyond the model",
        ),
    ]
    table = PlotTable(names, np.column_stack(columns).tolist())
    return Plot(panels, table, 4.6, PAGE, columns=2, legend="shared")
