"""This plot shows the error after a switch of the command, and step responses of the models with a lag."""

from __future__ import annotations

import numpy as np

from erclutch.errors import CheckError
from erclutch.report.numbers.run_material import Material
from erclutch.report.numbers.switching import StepResponse
from erclutch.report.plots.plot_description import Axis, Line, Panel, Plot, PlotTable

_Rows = list[tuple[object, ...]]


def describe_lag(material: Material) -> Plot:
    """One or two panels, as far as the run has switches and models with a lag.

    Raises:
        CheckError: the run has neither.
    """
    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    after = material.after_switch
    if after is not None:
        # The axis is logarithmic: the row of the switch itself stands half a period after it.
        since_switch = np.maximum(after.since * 1e3, 0.5e3 * material.period)  # [ms]
        curves = {name: rmse * material.effort.factor for name, rmse in after.rmse.items()}
        largest = max(float(curve.max()) for curve in curves.values())
        lines: list[Line] = []
        for name, role in reversed(material.shown.items()):
            lines.append(Line(since_switch, curves[name], role, material.titles[name]))
        titles = ", ".join(material.titles[name] for name in after.rmse)
        panel = Panel(
            Axis.over("time since the command switched", "ms", since_switch, log=True),
            Axis("RMSE", material.effort.unit, 0.0, 1.08 * largest),
            lines,
            f"RMSE over the time since the command last switched, of {titles}.",
            caption="Error over the time since the command last switched, rows held out. A hump on the left is a lag "
            "that the model does not have.",
            size=(430, 250),
        )
        panels.append(panel)
        for name, rmse in after.rmse.items():
            for since, error in zip(after.since, rmse, strict=True):
                rows.append(("rmse", name, float(since), float(error)))
    if material.step_responses:
        panel, responses = step_panel(material, material.step_responses)
        panels.append(panel)
        rows += responses
    if not panels:
        raise CheckError(
            "the command hardly ever switches in the rows held out, and no model that would be drawn has a lag",
            where=str(material.run.folder),
            remedy="Fit with --lag auto, or log with a switched field",
        )
    return Plot(
        panels,
        PlotTable(("curve", "model", "time_s", "value"), rows),
        height=2.0 * len(panels),
        badge=material.print_badge,
        legend="above",
    )


def step_panel(material: Material, responses: tuple[StepResponse, ...]) -> tuple[Panel, _Rows]:
    """The field in the fluid after a step up, and after a step down where that differs; and rows of the table."""
    longest = max(response.settled for response in responses)
    time = np.linspace(0.0, 1.15 * longest, 241)  # [s]
    lines: list[Line] = []
    rows: _Rows = []
    for response in responses:
        model = response.model
        style = material.shown[model]
        title = material.titles[model]
        up = response.up(time)
        down = response.down(time)
        for since, share in zip(time, up, strict=True):
            rows.append(("step", model, float(since), float(share)))
        if np.allclose(down, 1.0 - up, atol=1e-3):
            lines.append(Line(time * 1e3, up, style, title))
            continue
        # Up and down differ: both are drawn.
        for since, share in zip(time, down, strict=True):
            rows.append(("fall", model, float(since), float(share)))
        lines.append(Line(time * 1e3, up, style, f"{title}, rise"))
        lines.append(Line(time * 1e3, down, style, f"{title}, fall", dashed=True))

    lowest = min(0.0, *(float(line.y.min()) for line in lines))
    highest = max(1.05, *(1.03 * float(line.y.max()) for line in lines))
    caption = "How the field in the fluid follows a step, as the models with a lag have it"
    caption += "; dashed: a step down." if any(line.dashed for line in lines) else "."
    titles = ", ".join(material.titles[response.model] for response in responses)
    panel = Panel(
        Axis("time since the command stepped", "ms", 0.0, float(time[-1]) * 1e3),
        Axis("field in the fluid, share of the step", low=lowest, high=highest),
        lines,
        f"Step responses of {titles}.",
        caption=caption,
        size=(430, 250),
    )
    return panel, rows
