"""This plot shows the error over field and slip, and the density of the training rows."""

from __future__ import annotations

import numpy as np

from erclutch.report.numbers.error_map import ErrorMap
from erclutch.report.numbers.number_text import count, percent_text
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Axis, Cells, Panel, Plot, PlotTable
from erclutch.signals.array import Array

_HEADER = (
    "element",
    "field_from",
    "field_to",
    "slip_from",
    "slip_to",
    "train_rows",
    "test_rows",
    "test_rmse",
)
#: Sizes of a map: a pair has two rows of maps, which are lower, so that its report is no longer than that of a brake.
_HIGH = (430, 300)
_LOW = (430, 215)


def describe_error_map(material: Material) -> Plot:
    """Two panels an element: RMSE of the recommended model on the rows held out, and training rows."""
    maps = material.error_maps
    # Error of the last colour: the 97th percentile of the rows, so that one cell does not take all contrast.
    errors: list[Array] = []
    for cells in maps:
        met = cells.test > 0
        # So that a few crowded cells are not all that counts.
        rows_of_cells = np.minimum(cells.test[met], 50)
        errors.append(np.repeat(cells.rmse[met], rows_of_cells))
    top = float(np.quantile(np.concatenate(errors), 0.97)) or 1.0
    top *= material.effort.factor
    most = max(int(cells.train.max()) for cells in maps)
    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    for cells in maps:
        panels += _panels(material, cells, top, most)
        # A row for each cell that has rows of the log.
        for i, j in np.argwhere((cells.train > 0) | (cells.test > 0)):
            row = (
                cells.element + 1,
                *cells.field_edges[i : i + 2].tolist(),
                *cells.slip_edges[j : j + 2].tolist(),
                int(cells.train[i, j]),
                int(cells.test[i, j]),
                float(cells.rmse[i, j]),
            )
            rows.append(row)
    return Plot(
        panels,
        PlotTable(_HEADER, rows),
        height=0.55 + 1.75 * len(maps),
        columns=2,
        badge=material.print_badge,
    )


def _panels(
    material: Material,
    cells: ErrorMap,
    top: float,
    most: int,
) -> tuple[Panel, Panel]:
    """The errors of an element, and its training rows, on the same axes."""
    name = material.element_name(cells.element)
    tail = f", {name}" if name else ""
    field = cells.field_edges * material.field.factor
    slip = cells.slip_edges * material.slip.factor
    x = Axis(
        "no field in the log" if material.without_field else f"field {name}".strip(),
        "" if material.without_field else material.field.unit,
        low=float(field[0]),
        high=float(field[-1]),
        unmarked=material.without_field,
    )
    y = Axis(
        f"slip {name}".strip(),
        material.slip.unit,
        low=float(slip[0]),
        high=float(slip[-1]),
    )

    errors = Cells(
        field,
        slip,
        cells.rmse * material.effort.factor,
        top=top,
        style="heat",
        label=material.effort.titled("RMSE"),
        crossed=cells.blind,
    )
    training = Cells(
        field,
        slip,
        np.where(cells.train > 0, cells.train, np.nan),
        top=float(most),
        style="mass",
        label="training rows",
        log=True,
    )
    about_errors = (
        f"RMSE on the rows held out over field and slip {name}. {worst_cell(material, cells)}"
    )
    empty = percent_text(cells.empty_share, 2)
    about_training = f"Training rows over field and slip {name}; {empty} of the cells hold none."
    size = _LOW if len(material.error_maps) > 1 else _HIGH
    return (
        Panel(x, y, [errors], about_errors, caption=f"Error{tail}", size=size),
        Panel(x, y, [training], about_training, caption=f"Training rows{tail}", size=size),
    )


def worst_cell(material: Material, cells: ErrorMap) -> str:
    """Where the error is largest, in a sentence; empty where no cell has enough rows."""
    worst = cells.worst()
    if worst is None:
        return ""
    i, j = worst
    middle_field = 0.5 * (cells.field_edges[i] + cells.field_edges[i + 1])
    middle_slip = 0.5 * (cells.slip_edges[j] + cells.slip_edges[j + 1])
    field = material.field.of(float(middle_field), 2)
    slip = material.slip.of(float(middle_slip), 2)
    error = material.effort.of(float(cells.rmse[i, j]))
    rows = count(int(cells.test[i, j]))
    name = material.element_name(cells.element)
    element = f" on {name}" if name else ""
    near = f"slip {slip}" if material.without_field else f"field {field} and slip {slip}"
    return f"Largest{element} near {near}: {error} over {rows} rows."
