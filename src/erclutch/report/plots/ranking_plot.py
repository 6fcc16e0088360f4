"""This plot shows every model of a run with its error and its interval."""

from __future__ import annotations

import numpy as np

from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Axis, NamedBars, Panel, Plot, PlotTable

_MOST = 24
_HEIGHT = 0.22  # inches of a bar, whose title may take two lines
_HEADER = ("model", "parameters", "rmse", "low", "high", "share", "r2", "effort_unit")


def describe_ranking(material: Material) -> Plot:
    """Bars of the test RMSE with 95 % bands, best on top; of many the first 24, which the title says."""
    entries = [e for e in material.body["ranking"] if e["test"]["rmse"][0] is not None]
    shown = entries[:_MOST]
    value, low, high = (np.array([e["test"]["rmse"][k] for e in shown]) * material.effort.factor for k in range(3))
    styles = [material.shown.get(e["name"], "other") for e in shown]
    left = len(material.body["ranking"]) - len(shown)
    panel = Panel(
        Axis("RMSE, rows held out", material.effort.unit, 0.0, 1.04 * float(high.max())),
        Axis("", low=-0.6, high=len(shown) - 0.4),
        [NamedBars([material.titles[e["name"]] for e in shown], value, low, high, styles)],
        "RMSE of each model on the rows held out, with its 95 % band.",
        f"the first {len(shown)} of {left + len(shown)} models" if left else "",
    )
    unit = material.body["units"]["effort"]
    rows = [
        (e["name"], e["parameters_count"], *e["test"]["rmse"], e["test"]["share"][0], e["test"]["r2"][0], unit)
        for e in entries
    ]
    return Plot(
        [panel],
        PlotTable(_HEADER, rows),
        0.55 + _HEIGHT * len(shown) + (0.15 if left else 0.0),
        badge=material.print_badge,
    )
