"""This plot shows the error after a switch of the command, and step responses of the models with a lag."""

from __future__ import annotations

import numpy as np

from erclutch.errors import CheckError
from erclutch.report.numbers.run_material import Material
from erclutch.report.numbers.switching import AfterSwitch, StepResponse
from erclutch.report.plots.plot_description import Axis, Line, Panel, Plot, PlotTable

_Rows = list[tuple[object, ...]]


def describe_lag(material: Material) -> Plot:
    """One or two panels, as far as the run has switches and models with a lag.

    Raises:
        CheckError: the run has neither.
    """
    panels: list[Panel] = []
    rows: _Rows = []
    if material.after_switch is not None:
        panels.append(_after(material, material.after_switch, rows))
    if material.step_responses:
        panels.append(_steps(material, material.step_responses, rows))
    if not panels:
        raise CheckError(
            "the command hardly ever switches and no model has a lag",
            where=str(material.run.folder),
            remedy="Fit with --lag auto, or log with a switched field",
        )
    table = PlotTable(("curve", "model", "time_s", "value"), rows)
    return Plot(panels, table, 2.0 * len(panels), badge=material.print_badge, legend="above")


def _after(material: Material, found: AfterSwitch, rows: _Rows) -> Panel:
    for name, rmse in found.rmse.items():
        rows += [("rmse", name, float(since), float(error)) for since, error in zip(found.since, rmse, strict=True)]
    # The axis is logarithmic: the row of the switch itself stands half a period after it.
    since = np.maximum(found.since * 1e3, 0.5e3 * material.period)  # [ms]
    curves = {name: rmse * material.effort.factor for name, rmse in found.rmse.items()}
    largest = max(float(curve.max()) for curve in curves.values())
    return Panel(
        Axis("time since the command switched", "ms", float(since[0]), float(since[-1]), log=True),
        Axis("RMSE", material.effort.unit, 0.0, 1.08 * largest),
        [Line(since, curves[name], role, material.titles[name]) for name, role in reversed(material.shown.items())],
        "RMSE over the time since the command last switched, of "
        f"{', '.join(material.titles[name] for name in found.rmse)}.",
        caption="Error over the time since the command last switched, rows held out. A hump on the left is a lag that "
        "the model does not have.",
        size=(430, 250),
    )


def _steps(material: Material, found: tuple[StepResponse, ...], rows: _Rows) -> Panel:
    time = np.linspace(0.0, 1.15 * max(step.settled for step in found), 241)  # [s]
    lines: list[Line] = []
    for step in found:
        style = material.shown[step.model]
        title = material.titles[step.model]
        up = step.up(time)
        down = step.down(time)
        rows += [("step", step.model, float(at), float(share)) for at, share in zip(time, up, strict=True)]
        if np.allclose(down, 1.0 - up, atol=1e-3):
            lines.append(Line(time * 1e3, up, style, title))
            continue
        # Up and down differ: both are drawn.
        rows += [("fall", step.model, float(at), float(share)) for at, share in zip(time, down, strict=True)]
        lines.append(Line(time * 1e3, up, style, f"{title}, rise"))
        lines.append(Line(time * 1e3, down, style, f"{title}, fall", dashed=True))

    lowest = min(0.0, *(float(line.y.min()) for line in lines))
    highest = max(1.05, *(1.03 * float(line.y.max()) for line in lines))
    caption = "How the field in the fluid follows a step, as the models with a lag have it"
    caption += "; dashed: a step down." if any(line.dashed for line in lines) else "."
    return Panel(
        Axis("time since the command stepped", "ms", 0.0, float(time[-1]) * 1e3),
        Axis("field in the fluid, share of the step", "", lowest, highest),
        lines,
        f"Step responses of {', '.join(material.titles[step.model] for step in found)}.",
        caption=caption,
        size=(430, 250),
    )
