"""This plot shows the error over field and slip, and the density of the training rows."""

from __future__ import annotations

import numpy as np

from erclutch.report.numbers.error_map import ErrorMap
from erclutch.report.numbers.number_text import count, percent
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Axis, Cells, Panel, Plot, PlotTable
from erclutch.signals.array import Array

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
    errors: list[Array] = []
    for cells in maps:
        met = cells.test > 0
        rows = np.minimum(cells.test[met], 50)  # so that a few crowded cells are not all that counts
        errors.append(np.repeat(cells.rmse[met], rows))
    return float(np.quantile(np.concatenate(errors), 0.97)) or 1.0


def _panels(material: Material, found: ErrorMap, top: float, most: int) -> tuple[Panel, Panel]:
    name = material.element_name(found.element)
    tail = f", {name}" if name else ""
    field = found.field_edges * material.field.factor
    slip = found.slip_edges * material.slip.factor
    x = Axis(f"field {name}".strip(), material.field.unit, float(field[0]), float(field[-1]))
    y = Axis(f"slip {name}".strip(), material.slip.unit, float(slip[0]), float(slip[-1]))

    error = found.rmse * material.effort.factor
    errors = Cells(field, slip, error, top, "heat", material.effort.titled("RMSE"), crossed=found.blind)
    about_errors = f"RMSE on the rows held out over field and slip {name}. {worst_cell(material, found)}"

    rows = np.where(found.train > 0, found.train, np.nan)
    training = Cells(field, slip, rows, float(most), "mass", "training rows", log=True)
    empty = percent(found.empty_share, 2)
    about_training = f"Training rows over field and slip {name}; {empty} of the cells hold none."
    return (
        Panel(x, y, [errors], about_errors, caption=f"Error{tail}"),
        Panel(x, y, [training], about_training, caption=f"Training rows{tail}"),
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
    """A row for each cell that has rows of the log, under `_HEADER`."""
    rows: list[tuple[object, ...]] = []
    for i, j in np.argwhere((found.train > 0) | (found.test > 0)):
        field_ends = found.field_edges[i : i + 2].tolist()
        slip_ends = found.slip_edges[j : j + 2].tolist()
        figures = int(found.train[i, j]), int(found.test[i, j]), float(found.rmse[i, j])
        rows.append((found.element + 1, *field_ends, *slip_ends, *figures))
    return rows
