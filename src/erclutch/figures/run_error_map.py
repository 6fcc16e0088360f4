"""Error over field and slip, and the density of the training rows."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from erclutch.diagnostics.error_map import error_maps
from erclutch.diagnostics.material import Material
from erclutch.figures.parts import Numbers


def draw_error_map(figure: Any, material: Material) -> Numbers:
    """Two panels an element: RMSE of the recommended model on the rows held out, and training rows."""
    colours: Any = import_module("matplotlib.colors")
    maps = error_maps(material.rows, material.recommended)
    axes: Any = figure.subplots(len(maps), 2, sharey="row", squeeze=False)
    errors = np.concatenate([m.rmse[np.isfinite(m.rmse)] for m in maps]) * material.effort.factor
    top = float(np.quantile(errors, 0.97))
    most = max(2, *(int(m.train.max()) for m in maps))
    images: list[Any] = []
    for m, (left, right) in zip(maps, axes, strict=True):
        fx, sy = m.field_edges * material.field.factor, m.slip_edges * material.slip.factor
        rmse = m.rmse.T * material.effort.factor
        images = [left.pcolormesh(fx, sy, rmse, cmap="YlOrBr", vmin=0.0, vmax=top, rasterized=True)]
        rows = np.where(m.train.T > 0, m.train.T, np.nan)
        norm = colours.LogNorm(1, most)
        images.append(right.pcolormesh(fx, sy, rows, cmap="Blues", norm=norm, rasterized=True))
        i, j = np.nonzero(m.blind)
        left.plot(0.5 * (fx[i] + fx[i + 1]), 0.5 * (sy[j] + sy[j + 1]), "x", color="black", ms=2.0, mew=0.4)
        name = material.element_name(m.element)
        left.set_ylabel(material.slip.titled(f"Slip {name}".strip()))
        for axis in (left, right):
            axis.set_xlabel(material.field.titled(f"Field {name}".strip()))
    bars = (f"RMSE, {material.effort.unit}".rstrip(", "), "training rows")
    for k, label in enumerate(bars):
        bar = figure.colorbar(images[k], ax=list(axes[:, k]), location="top", shrink=0.9, aspect=28, pad=0.02)
        bar.set_label(label)
    rows = [
        (
            m.element + 1,
            *(float(v) for v in (*m.field_edges[i : i + 2], *m.slip_edges[j : j + 2])),
            int(m.train[i, j]),
            int(m.test[i, j]),
            float(m.rmse[i, j]),
        )
        for m in maps
        for i, j in np.argwhere((m.train > 0) | (m.test > 0))
    ]
    header = ["element", "field_from", "field_to", "slip_from", "slip_to", "train_rows", "test_rows", "test_rmse"]
    return Numbers(header, rows)
