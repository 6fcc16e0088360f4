"""This plot shows the error over field and slip, and the density of the training rows."""

from __future__ import annotations

import numpy as np

from erclutch.report.numbers.error_map import ErrorMap
from erclutch.report.numbers.number_text import count, percent
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Axis, Cells, Panel, Plot, PlotTable

_HEADER = ("element", "field_from", "field_to", "slip_from", "slip_to", "train_rows", "test_rows", "test_rmse")


def describe_error_map(material: Material) -> Plot:
    """Two panels an element: RMSE of the recommended model on the rows held out, and training rows."""
    maps = material.error_maps
    top = _top(maps) * material.effort.factor
    most = max(int(m.train.max()) for m in maps)
    panels = [panel for m in maps for panel in _panels(material, m, top, most)]
    rows = [row for m in maps for row in _rows(m)]
    height = 0.55 + 1.75 * len(maps)
    return Plot(panels, PlotTable(_HEADER, rows), height, columns=2, badge=material.print_badge)


def _top(maps: tuple[ErrorMap, ...]) -> float:
    """Error of the last colour: the 97th percentile of the rows, so that one cell does not take all contrast."""
    errors = np.concatenate([np.repeat(m.rmse[m.test > 0], np.minimum(m.test[m.test > 0], 50)) for m in maps])
    return float(np.quantile(errors, 0.97)) or 1.0


def _panels(material: Material, found: ErrorMap, top: float, most: int) -> tuple[Panel, Panel]:
    field, slip, effort = material.field, material.slip, material.effort
    name = material.element_name(found.element)
    fx, sy = found.field_edges * field.factor, found.slip_edges * slip.factor
    x = Axis(f"field {name}".strip(), field.unit, float(fx[0]), float(fx[-1]))
    y = Axis(f"slip {name}".strip(), slip.unit, float(sy[0]), float(sy[-1]))
    error = Cells(fx, sy, found.rmse * effort.factor, top, "heat", effort.titled("RMSE"), crossed=found.blind)
    rows = np.where(found.train > 0, found.train, np.nan)
    tail = f", {name}" if name else ""
    return (
        Panel(
            x,
            y,
            [error],
            f"RMSE on the rows held out over field and slip {name}. {worst_cell(material, found)}",
            caption=f"Error{tail}",
        ),
        Panel(
            x,
            y,
            [Cells(fx, sy, rows, float(most), "mass", "training rows", log=True)],
            f"Training rows over field and slip {name}; {percent(found.empty_share, 2)} of the cells hold none.",
            caption=f"Training rows{tail}",
        ),
    )


def worst_cell(material: Material, found: ErrorMap) -> str:
    """Where the error is largest, in a sentence; empty where no cell has enough rows."""
    at = found.worst()
    if at is None:
        return ""
    i, j = at
    field = 0.5 * (found.field_edges[i] + found.field_edges[i + 1])
    slip = 0.5 * (found.slip_edges[j] + found.slip_edges[j + 1])
    name = material.element_name(found.element)
    where = f"field {material.field.of(float(field), 2)} and slip {material.slip.of(float(slip), 2)}"
    error = material.effort.of(float(found.rmse[i, j]))
    return f"Largest{f' on {name}' if name else ''} near {where}: {error} over {count(int(found.test[i, j]))} rows."


def _rows(found: ErrorMap) -> list[tuple[object, ...]]:
    return [
        (
            found.element + 1,
            *(float(v) for v in (*found.field_edges[i : i + 2], *found.slip_edges[j : j + 2])),
            int(found.train[i, j]),
            int(found.test[i, j]),
            float(found.rmse[i, j]),
        )
        for i, j in np.argwhere((found.train > 0) | (found.test > 0))
    ]
