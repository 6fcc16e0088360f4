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
    residuals = material.distributions
    edges = residuals[0].edges
    columns = {"residual_from": edges[:-1], "residual_to": edges[1:]}
    columns |= {f"density:{residual.model}": residual.density for residual in residuals}
    table = PlotTable(list(columns), np.column_stack(list(columns.values())).tolist())
    return Plot([_parity(material), _distribution(material)], table, 4.7, badge=material.print_badge, legend="above")


def _parity(material: Material) -> Panel:
    found = parity(material.rows, material.recommended)
    edges = found.edges * material.effort.factor
    low = float(edges[0])
    high = float(edges[-1])
    counts = np.where(found.counts > 0, found.counts, np.nan)
    cells = Cells(edges, edges, counts, float(found.counts.max()), "mass", "", log=True)
    diagonal = Line(np.array([low, high]), np.array([low, high]), "ref")
    beyond = f" {count(found.beyond)} rows lie outside." if found.beyond else ""
    r2 = material.run.entry(material.recommended)["test"]["r2"][0]
    return Panel(
        Axis("measured", material.effort.unit, low, high),
        Axis("estimated", material.effort.unit, low, high),
        [cells, diagonal],
        f"Estimated over measured {material.word} of {material.title}, rows held out; on the diagonal they "
        f"agree. R² {number(r2, 4)}.",
        material.title,
        f"{material.title}, rows held out. Strong colour: many rows (logarithmic). On the line the two agree.{beyond}",
        square=True,
        size=(430, 350),
        share=1.6,
    )


def _distribution(material: Material) -> Panel:
    effort = material.effort
    first, *others = material.distributions
    edges = first.edges * effort.factor
    marks: list[Mark] = [Bars(edges, first.density / effort.factor, "recommended", first.model)]
    for other in others:
        density = other.density / effort.factor
        marks.append(Line(edges, density, material.shown[other.model], other.model, steps=True))
    marks.append(_normal(edges, first.bias * effort.factor, (first.spread or 1.0) * effort.factor))
    marks.append(ReferenceLine(0.0, "x"))

    names = ", ".join(residual.model for residual in material.distributions)
    tallest = max(float(residual.density.max()) for residual in material.distributions) / effort.factor
    return Panel(
        Axis("measured less estimated", effort.unit, float(edges[0]), float(edges[-1])),
        Axis(f"share of rows per {effort.unit or 'unit'}", "", 0.0, 1.06 * tallest),
        marks,
        f"Distribution of the residual of {names}. Half of the errors of {first.model} "
        f"are below {effort.of(first.quantiles[0])}, 99 % below {effort.of(first.quantiles[2])}.",
        caption=f"Filled: {material.title}. Thin line: a normal distribution of the same width.",
        size=(430, 350),
    )


def _normal(edges: Array, mean: float, deviation: float) -> Line:
    x: Array = np.linspace(float(edges[0]), float(edges[-1]), 121)
    z: Array = (x - mean) / deviation
    return Line(x, np.exp(-0.5 * z * z) / (deviation * np.sqrt(2 * np.pi)), "ref")
