"""Every model of a run with its error and its interval."""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.diagnostics.material import Material
from erclutch.figures.parts import Numbers, role_colour, titled

_MOST = 24


def height(material: Material) -> float:
    """Height that the rows need, in inches."""
    return 0.55 + 0.17 * min(len(material.run.names), _MOST)


def draw_ranking(figure: Any, material: Material) -> Numbers:
    """Bars of the test RMSE with 95 % bands, best on top; the first 24 of many."""
    entries = [e for e in material.body["ranking"] if e["test"]["rmse"][0] is not None]
    shown = entries[:_MOST]
    roles = {s.name: s.role for s in material.shown}
    axis: Any = figure.subplots()
    at = np.arange(len(shown))
    value, low, high = (np.array([e["test"]["rmse"][k] for e in shown]) * material.effort.factor for k in range(3))
    axis.barh(at, value, 0.62, color=[role_colour(roles.get(e["name"])) for e in shown])
    axis.errorbar(value, at, xerr=[value - low, high - value], fmt="none", ecolor="black", elinewidth=0.7, capsize=1.5)
    axis.set_yticks(at, [e["name"] for e in shown])
    axis.set_ylim(len(shown) - 0.4, -0.6)
    axis.grid(False, axis="y")
    axis.set_xlabel(titled(material, material.effort.titled("RMSE, rows held out")))
    axis.set_xlim(0.0, 1.04 * float(high.max()))
    header = ["model", "parameters", "rmse", "low", "high", "share", "r2", "effort_unit"]
    unit = material.body["units"]["effort"]
    rows = [
        (e["name"], e["parameters_count"], *e["test"]["rmse"], e["test"]["share"][0], e["test"]["r2"][0], unit)
        for e in entries
    ]
    return Numbers(header, rows)
