"""Where a log has data: the density of its rows over field and slip, one panel an element."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.dataset import Array, Dataset
from erclutch.figures.style import COLUMN, new_figure, save, save_numbers, style

_BINS = 40


def draw_coverage(data: Dataset, path: Path, name: str = "") -> list[Path]:
    """Draw the density of rows over field and slip, and write its numbers beside it.

    Args:
        data: rows of one device.
        path: .png, .pdf or .svg; the numbers go to the same name with .csv.
        name: of the log, for the title.

    Returns:
        The files written.
    """
    colours: Any = import_module("matplotlib.colors")
    edges = [(_edges(e.field), _edges(e.slip)) for e in data.elements]
    counts: list[Array] = [
        np.histogram2d(e.field, e.slip, bins=at)[0] for e, at in zip(data.elements, edges, strict=True)
    ]
    most = max(float(c.max()) for c in counts)
    with style():
        figure: Any = new_figure(2.5, COLUMN)
        axes: Any = figure.subplots(1, len(counts), sharex=True, squeeze=False)[0]
        image: Any = None
        for i, (axis, count) in enumerate(zip(axes, counts, strict=True)):
            shown: Array = np.where(count.T > 0, count.T, np.nan)
            image = axis.pcolormesh(
                edges[i][0],
                edges[i][1],
                shown,
                norm=colours.LogNorm(1.0, max(most, 2.0)),
                cmap="viridis",
                rasterized=True,
            )
            label = f"CH{i + 1}: " if len(counts) > 1 else ""
            axis.set_title(f"{label}{np.count_nonzero(count == 0) / count.size:.0%} empty", loc="left")
            axis.set_xlabel(_label("Field", data.units.field))
        axes[0].set_ylabel(_label("Slip", data.units.slip))
        figure.colorbar(image, ax=list(axes), label="rows a cell", shrink=0.9)
        if name:
            figure.suptitle(name, x=0.01, ha="left", fontsize=8.0)
        save(figure, path)
    middles = [tuple(0.5 * (e[1:] + e[:-1]) for e in at) for at in edges]
    rows = [
        (k + 1, float(middles[k][0][i]), float(middles[k][1][j]), int(count[i, j]))
        for k, count in enumerate(counts)
        for i, j in np.argwhere(count > 0)
    ]
    return [path, save_numbers(path.with_suffix(".csv"), ["element", "field", "slip", "rows"], rows)]


def _edges(values: Array) -> Array:
    low, high = float(values.min()), float(values.max())
    return np.linspace(low, high, _BINS + 1) if high > low else np.linspace(low - 0.5, low + 0.5, _BINS + 1)


def _label(name: str, unit: str) -> str:
    return name if unit == "" else f"{name} [{'as logged' if unit == '?' else unit.replace('*', ' ')}]"
