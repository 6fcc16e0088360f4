"""Estimated against measured effort, and the distribution of the residual."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from erclutch.diagnostics.material import Material
from erclutch.diagnostics.parity import distributions, parity
from erclutch.figures.parts import Numbers, role_colour, role_line, titled
from erclutch.figures.style import GREY


def draw_parity(figure: Any, material: Material) -> Numbers:
    """Two panels: density of the rows held out around the diagonal; histograms of the residual."""
    colours: Any = import_module("matplotlib.colors")
    factor = material.effort.factor
    found, spread = parity(material.rows, material.recommended), distributions(material.rows, material.shown_names)
    left, right = figure.subplots(2, 1, height_ratios=[1.6, 1])
    edges = found.edges * factor
    counts = np.where(found.counts.T > 0, found.counts.T, np.nan)
    norm = colours.LogNorm(1, max(2, int(found.counts.max())))
    left.pcolormesh(edges, edges, counts, cmap="Blues", norm=norm, rasterized=True)
    left.plot(edges[[0, -1]], edges[[0, -1]], color=GREY, linewidth=0.6)
    left.set_aspect("equal")
    left.set_xlabel(material.effort.titled("Measured"))
    left.set_ylabel(material.effort.titled("Estimated"))
    left.set_title(titled(material, material.recommended), loc="left")
    for shown, d in zip(material.shown, spread, strict=True):
        style = role_line(shown.role) if shown.role != "recommended" else {"color": role_colour(shown.role)}
        right.stairs(d.density / factor, d.edges * factor, label=shown.name, **style)
    right.set_xlabel(material.effort.titled("Measured less estimated"))
    right.set_ylabel(f"Share of rows per {material.effort.unit or 'unit'}")
    right.set_xlim(float(spread[0].edges[0]) * factor, float(spread[0].edges[-1]) * factor)
    right.legend(handlelength=1.4)
    rows = [
        (float(spread[0].edges[k]), float(spread[0].edges[k + 1]), *(float(d.density[k]) for d in spread))
        for k in range(spread[0].density.size)
    ]
    return Numbers(["residual_from", "residual_to", *(f"density:{d.model}" for d in spread)], rows)
