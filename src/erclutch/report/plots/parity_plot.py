"""This plot shows estimated against measured effort, and the distribution of the residual."""

from __future__ import annotations

import numpy as np

from erclutch.report.numbers.number_text import count, number
from erclutch.report.numbers.parity import parity
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import (
    Axis,
    Bars,
    Cells,
    Line,
    Mark,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
)
from erclutch.signals.array import Array


def describe_parity(material: Material) -> Plot:
    """Two panels: density of the rows held out around the diagonal; histograms of the residual."""
    # The density of the rows held out around the diagonal, of the recommended model.
    density = parity(material.rows, material.recommended)
    edges = density.edges * material.effort.factor
    low = float(edges[0])
    high = float(edges[-1])
    cells = Cells(
        edges,
        edges,
        np.where(density.counts > 0, density.counts, np.nan),
        top=float(density.counts.max()),
        style="mass",
        label="",
        log=True,
    )
    ends = np.array([low, high])
    diagonal = Line(ends, ends, "ref")
    r2, *_ = material.run.entry(material.recommended)["test"]["r2"]
    beyond = f" {count(density.beyond)} rows lie outside." if density.beyond else ""
    around_diagonal = Panel(
        Axis("measured", material.effort.unit, low, high),
        Axis("estimated", material.effort.unit, low, high),
        [cells, diagonal],
        says=f"Estimated over measured {material.word} of {material.title}, rows held out; on the diagonal they "
        f"agree. R² {number(r2, 4)}.",
        title=material.title,
        caption=f"{material.title}, rows held out. Strong colour: many rows (logarithmic). On the line the two "
        f"agree.{beyond}",
        square=True,
        size=(430, 300),
        share=1.6,
    )

    # Histograms of the residuals, and a normal distribution as wide as the recommended model's.
    effort = material.effort
    first, *others = material.distributions
    edges = first.edges * effort.factor
    lowest = float(edges[0])
    highest = float(edges[-1])
    heights = first.density / effort.factor
    title = material.titles[first.model]
    marks: list[Mark] = [Bars(edges, heights, "recommended", title)]
    for other in others:
        density = other.density / effort.factor
        look = material.shown[other.model]
        marks.append(Line(edges, density, look, material.titles[other.model], steps=True))

    mean = first.bias * effort.factor
    deviation = (first.spread or 1.0) * effort.factor
    residual: Array = np.linspace(lowest, highest, 121)
    z: Array = (residual - mean) / deviation
    area = deviation * np.sqrt(2 * np.pi)
    normal: Array = np.exp(-0.5 * z * z) / area
    marks.append(Line(residual, normal, "ref"))
    marks.append(ReferenceLine(0.0, "x"))

    names = ", ".join(each.model for each in material.distributions)
    tallest = max(float(each.density.max()) for each in material.distributions) / effort.factor
    half = effort.of(first.quantiles[0])
    nearly_all = effort.of(first.quantiles[2])
    histograms = Panel(
        Axis("measured less estimated", effort.unit, lowest, highest),
        Axis(f"share of rows per {effort.unit or 'unit'}", low=0.0, high=1.06 * tallest),
        marks,
        says=f"Distribution of the residual of {names}. Half of the errors of {first.model} "
        f"are below {half}, 99 % below {nearly_all}.",
        caption=f"Filled: {material.title}. Thin line: a normal distribution of the same width.",
        size=(430, 300),
    )

    columns = {"residual_from": first.edges[:-1], "residual_to": first.edges[1:]}
    for each in material.distributions:
        columns[f"density:{each.model}"] = each.density
    numbers = np.column_stack(list(columns.values()))
    return Plot(
        [around_diagonal, histograms],
        PlotTable(list(columns), numbers.tolist()),
        height=4.7,
        badge=material.print_badge,
        legend="above",
    )
