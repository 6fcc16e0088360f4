"""This plot shows estimated against measured effort, and the distribution of the residual."""

from __future__ import annotations

import numpy as np

from erclutch.report.numbers.number_text import count, number
from erclutch.report.numbers.parity import parity
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Axis, Bars, Cells, Line, Mark, Panel, Plot, PlotTable, ReferenceLine
from erclutch.signals.array import Array


def describe_parity(material: Material) -> Plot:
    """Two panels: density of the rows held out around the diagonal; histograms of the residual."""
    spread = material.distributions
    edges = spread[0].edges
    rows = [
        (float(edges[k]), float(edges[k + 1]), *(float(d.density[k]) for d in spread)) for k in range(edges.size - 1)
    ]
    table = PlotTable(["residual_from", "residual_to", *(f"density:{d.model}" for d in spread)], rows)
    return Plot([_parity(material), _distribution(material)], table, 4.7, badge=material.print_badge, legend="above")


def _parity(material: Material) -> Panel:
    found, effort = parity(material.rows, material.recommended), material.effort
    edges = found.edges * effort.factor
    low, high = float(edges[0]), float(edges[-1])
    counts = np.where(found.counts > 0, found.counts, np.nan)
    beyond = f" {count(found.beyond)} rows lie outside." if found.beyond else ""
    r2 = material.run.entry(material.recommended)["test"]["r2"][0]
    return Panel(
        Axis("measured", effort.unit, low, high),
        Axis("estimated", effort.unit, low, high),
        [
            Cells(edges, edges, counts, float(found.counts.max()), "mass", "", log=True),
            Line(np.array([low, high]), np.array([low, high]), "ref"),
        ],
        f"Estimated over measured {material.word} of {material.title}, rows held out; on the diagonal they "
        f"agree. R² {number(r2, 4)}.",
        material.title,
        f"{material.title}, rows held out. Darker: more rows (logarithmic). On the line the two agree.{beyond}",
        square=True,
        size=(430, 350),
        share=1.6,
    )


def _distribution(material: Material) -> Panel:
    spread, effort = material.distributions, material.effort
    first, edges = spread[0], spread[0].edges * effort.factor
    marks: list[Mark] = [Bars(edges, first.density / effort.factor, "recommended", first.model)]
    for d in spread[1:]:
        marks.append(Line(edges, d.density / effort.factor, material.shown[d.model], d.model, steps=True))
    marks += [
        _normal(edges, first.bias * effort.factor, (first.spread or 1.0) * effort.factor),
        ReferenceLine(0.0, "x"),
    ]
    tallest = max(float(d.density.max()) for d in spread) / effort.factor
    return Panel(
        Axis("measured less estimated", effort.unit, float(edges[0]), float(edges[-1])),
        Axis(f"share of rows per {effort.unit or 'unit'}", "", 0.0, 1.06 * tallest),
        marks,
        f"Distribution of the residual of {', '.join(d.model for d in spread)}. Half of the errors of {first.model} "
        f"are below {effort.of(first.quantiles[0])}, 99 % below {effort.of(first.quantiles[2])}.",
        caption=f"Filled: {material.title}. Thin line: a normal distribution of the same width.",
        size=(430, 350),
    )


def _normal(edges: Array, mean: float, deviation: float) -> Line:
    x: Array = np.linspace(float(edges[0]), float(edges[-1]), 121)
    z: Array = (x - mean) / deviation
    return Line(x, np.exp(-0.5 * z * z) / (deviation * np.sqrt(2 * np.pi)), "ref")
