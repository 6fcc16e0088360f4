"""Lag and dynamics: the error after a switch of the command, and the step response that was found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from erclutch.diagnostics.material import Material
from erclutch.diagnostics.switching import AfterSwitch, StepResponse, after_switch, step_responses
from erclutch.diagnostics.text import count, number, percent
from erclutch.report.section import Section
from erclutch.report.svg import Axis, Plot
from erclutch.report.symbols import symbol


class DynamicsSection(Section):
    """Between command and field."""

    name: ClassVar[str] = "dynamics"
    title: ClassVar[str] = "Lag between command and effort"
    short: ClassVar[str] = "Lag"

    def fill(self, material: Material) -> dict[str, Any] | None:
        """See `Section.fill`."""
        after = after_switch(material.rows, material.shown_names)
        steps = step_responses(material.body, material.shown_names)
        lagged = [e for e in material.body["ranking"] if e["dynamics"]]
        if after is None and not lagged:
            return {"after": None, "steps": None, "times": [], "lead": _nothing(material)}
        return {
            "after": None if after is None else _after(material, after),
            "steps": _steps(material, steps) if steps else None,
            "times": _times(material),
            "lead": _lead(material, after, lagged),
        }


def _nothing(material: Material) -> str:
    asked = material.body["settings"]["lag"]
    why = "none was asked for (--lag none)" if asked == "none" else "the field never changes within a stretch of rows"
    return f"No model has a lag: {why}. The command hardly ever switches, so these rows could not tell one either."


def _after(material: Material, found: AfterSwitch) -> Any:
    x = np.maximum(found.since * 1e3, 0.5e3 * material.period)
    factor = material.effort.factor
    top = max(float(v.max()) for v in found.rmse.values()) * factor
    plot = Plot(
        Axis(float(x[0]), float(x[-1]), "time since the command switched [ms]", log=True),
        Axis(0.0, 1.08 * top, material.effort.titled("RMSE")),
        height=300,
    )
    for shown in reversed(material.shown):
        plot.line(x, found.rmse[shown.name] * factor, f"line {shown.role}")
    return plot.svg(f"RMSE over the time since the command last switched, of {', '.join(found.rmse)}.")


def _steps(material: Material, found: tuple[StepResponse, ...]) -> Any:
    last = 1.15 * max(s.delay + 4.5 * max(s.rise, s.fall) for s in found)
    t = np.linspace(0.0, last, 241)
    plot = Plot(
        Axis(0.0, last * 1e3, "time since the command stepped [ms]"),
        Axis(0.0, 1.05, "field in the fluid, share of the step"),
        height=300,
    )
    roles = {s.name: s.role for s in material.shown}
    for step in found:
        plot.line(t * 1e3, step.up(t), f"line {roles[step.model]}")
        if step.fall != step.rise:
            plot.line(t * 1e3, step.down(t), f"line {roles[step.model]}")
    return plot.svg(f"Step responses of {', '.join(s.model for s in found)}.")


def _times(material: Material) -> list[dict[str, Any]]:
    """Delays and time constants with intervals, of the models with dynamics, best first."""
    rows: list[dict[str, Any]] = []
    for entry in material.body["ranking"]:
        if not entry["dynamics"]:
            continue
        known = {p["name"]: p for p in entry["fit"]["parameters"]}
        cells = [_time(name, value, known.get(name)) for name, value in entry["dynamics"].items()]
        rows.append({"model": entry["name"], "cells": cells, "rmse": material.effort.bare(entry["test"]["rmse"][0])})
    return rows[:6]


def _time(name: str, value: float, estimate: Mapping[str, Any] | None) -> dict[str, Any]:
    text = {"symbol": symbol(name), "value": f"{number(1e3 * value)} ms", "band": "from the best law"}
    if estimate is None:
        return text
    low, high = estimate["low"], estimate["high"]
    if estimate["at_bound"]:
        return {**text, "band": f"at its {estimate['at_bound']} bound"}
    return {
        **text,
        "band": "not identified" if low is None or high is None else f"{number(1e3 * low)} to {number(1e3 * high)}",
    }


def _when(since: float) -> str:
    return "in the very row of one" if since == 0.0 else f"{number(1e3 * since, 2)} ms after one"


def _lead(material: Material, after: AfterSwitch | None, lagged: list[Mapping[str, Any]]) -> str:
    parts: list[str] = []
    without = [e for e in material.body["ranking"] if not e["dynamics"]]
    if lagged and without:
        a, b = lagged[0]["test"]["rmse"][0], without[0]["test"]["rmse"][0]
        if a and b:
            change = f"{percent(1 - a / b, 2)} smaller" if a < b else f"{percent(a / b - 1, 2)} larger"
            parts.append(
                f"The best model with a lag ({lagged[0]['name']}) errs by {material.effort.of(a)}, the best without "
                f"({without[0]['name']}) by {material.effort.of(b)}: with a lag the error is {change}."
            )
    elif not lagged:
        parts.append("No model of this run has a lag.")
    if after is not None:
        curve = after.rmse[material.recommended]
        parts.append(
            f"Over {count(after.switches)} switches held out, {material.recommended} errs at worst by "
            f"{material.effort.of(float(curve.max()))}, {_when(float(after.since[int(curve.argmax())]))}."
        )
    else:
        parts.append("The command hardly ever switches in the rows held out.")
    return " ".join(parts)
