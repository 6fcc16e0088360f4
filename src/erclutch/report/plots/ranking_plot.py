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
    ranking = material.body["ranking"]
    finite = [entry for entry in ranking if entry["test"]["rmse"][0] is not None]
    shown = finite[:_MOST]
    left_out = len(ranking) - len(shown)

    titles = [material.titles[entry["name"]] for entry in shown]
    styles = [material.shown.get(entry["name"], "other") for entry in shown]
    rmse = np.array([entry["test"]["rmse"] for entry in shown])
    errors = rmse * material.effort.factor
    value, low, high = errors.T
    most = 1.04 * float(high.max())
    panel = Panel(
        Axis("RMSE, rows held out", material.effort.unit, 0.0, most),
        Axis("", low=-0.6, high=len(shown) - 0.4),
        [NamedBars(titles, value, low, high, styles)],
        "RMSE of each model on the rows held out, with its 95 % band.",
        f"the first {len(shown)} of {len(ranking)} models" if left_out else "",
    )

    unit = material.body["units"]["effort"]
    rows: list[tuple[object, ...]] = []
    for entry in finite:
        test = entry["test"]
        row = (
            entry["name"],
            entry["parameters_count"],
            *test["rmse"],
            test["share"][0],
            test["r2"][0],
            unit,
        )
        rows.append(row)
    height = 0.55 + _HEIGHT * len(shown)
    if left_out:
        height += 0.15  # for the title
    return Plot([panel], PlotTable(_HEADER, rows), height, badge=material.print_badge)
