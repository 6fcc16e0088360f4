"""Parity and the distribution of the residual."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from erclutch.diagnostics.material import Material
from erclutch.diagnostics.parity import Distribution, Parity, distributions, parity
from erclutch.diagnostics.text import count, number, percent
from erclutch.report.section import Section
from erclutch.report.svg import RAMP, Axis, Plot

Array = NDArray[np.float64]


class ParitySection(Section):
    """Estimated against measured; how errors are distributed."""

    name: ClassVar[str] = "parity"
    title: ClassVar[str] = "How errors are distributed"
    short: ClassVar[str] = "Parity"

    def fill(self, material: Material) -> dict[str, Any]:
        """See `Section.fill`."""
        found = parity(material.rows, material.recommended)
        spread = distributions(material.rows, material.shown_names)
        return {
            "model": material.recommended,
            "parity": _parity(material, found),
            "beyond": count(found.beyond) if found.beyond else "",
            "distribution": _distribution(material, spread),
            "quantiles": [_quantiles(material, d) for d in spread],
            "unit": material.effort.unit,
        }


def _parity(material: Material, found: Parity) -> Any:
    edges = found.edges * material.effort.factor
    low, high = float(edges[0]), float(edges[-1])
    unit = material.effort
    plot = Plot(Axis(low, high, unit.titled("measured")), Axis(low, high, unit.titled("estimated")), height=350)
    most = float(np.log1p(found.counts.max()))
    steps = np.where(found.counts > 0, np.clip(np.log1p(found.counts) / most * RAMP, 0, RAMP - 1), -1)
    plot.cells(edges, edges, steps.astype(np.int64), "mass")
    plot.line(np.array([low, high]), np.array([low, high]), "ref")
    r2 = material.run.entry(material.recommended)["test"]["r2"][0]
    return plot.svg(
        f"Estimated over measured {material.word} of {material.recommended}, rows held out; on the diagonal they "
        f"agree. R² {number(r2, 4)}."
    )


def _distribution(material: Material, spread: tuple[Distribution, ...]) -> Any:
    factor = material.effort.factor
    edges = spread[0].edges * factor
    tallest = max(float(d.density.max()) for d in spread) / factor
    plot = Plot(
        Axis(float(edges[0]), float(edges[-1]), material.effort.titled("measured less estimated")),
        Axis(0.0, 1.06 * tallest, f"share of rows per {material.effort.unit or 'unit'}"),
        height=350,
    )
    first = spread[0]
    plot.bars(edges, first.density / factor, "bars recommended")
    for shown, d in zip(material.shown[1:], spread[1:], strict=True):
        plot.line(edges, d.density / factor, f"line {shown.role}", steps=True)
    x: Array = np.linspace(float(edges[0]), float(edges[-1]), 121)
    z: Array = (x / factor - first.bias) / (first.spread or 1.0)
    plot.line(x, np.exp(-0.5 * z * z) / ((first.spread or 1.0) * factor * np.sqrt(2 * np.pi)), "ref")
    plot.upright(0.0, "zero")
    return plot.svg(
        f"Distribution of the residual of {', '.join(d.model for d in spread)}. Half of the errors of {first.model} "
        f"are below {material.effort.of(first.quantiles[0])}, 99 % below {material.effort.of(first.quantiles[2])}."
    )


def _quantiles(material: Material, found: Distribution) -> dict[str, str]:
    q = [material.effort.bare(v) for v in found.quantiles]
    role = next(s.role for s in material.shown if s.name == found.model)
    return {
        "model": found.model,
        "role": role,
        "half": q[0],
        "most": q[1],
        "nearly": q[2],
        "all": q[3],
        "bias": material.effort.bare(found.bias, 2),
        "beyond": percent(found.beyond, 2) if found.beyond > 0 else "",
    }
