"""This section shows the prediction band: over a section of the log, and what it holds of the rows held out."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from erclutch.report.html.section import Section
from erclutch.report.numbers.number_text import Scale, brief, count, percent_text
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.trace_plot import describe_trace


def _fill(material: Material) -> dict[str, Any] | None:
    """A plot, and a table of coverage by class."""
    band = material.models[material.recommended].band
    figures = material.run.entry(material.recommended).get("band")
    if band is None or figures is None:
        return None
    # What was tried, its figures, its width over that of one width for all.
    held: list[tuple[str, Any, float]] = []
    plain_width = figures["plain"] or 1.0
    for name, key in (("without a sensor", "held"), ("with a torque sensor", "with_sensor")):
        holds = figures[key]
        if holds is not None:
            held.append((name, holds, holds["width"] / plain_width))

    # Class, rows held out, share of them inside, mean width.
    data = material.rows.data
    test = material.rows.test
    assert material.band_ends is not None
    low, high = material.band_ends
    inside = ((low <= data.effort) & (data.effort <= high))[test]
    width = (high - low)[test]
    ways = (
        ["field has settled", "field is switching"],
        _ranges("field", band.field_edges, material.field),
        _ranges("slip", band.slip_edges, material.slip),
    )
    cells = band.cells(data.elements, data.clock)[test]
    classes: list[tuple[str, str, str, str]] = []
    # The class of each row held out, each way of parting them.
    for class_of_row, labels in zip(np.unravel_index(cells, band.shape), ways, strict=True):
        if len(labels) == 1:  # the band does not part the rows this way
            continue
        for number, label in enumerate(labels):
            rows = class_of_row == number
            if rows.any():
                share = float(inside[rows].mean())
                mean_width = material.effort.bare(float(width[rows].mean()))
                classes.append((label, count(int(rows.sum())), percent_text(share), mean_width))
    trace = describe_trace(material).panels[0]
    return {
        "level": percent_text(band.level),
        "figure": replace(trace, size=(880, 300)),
        "held": held,
        "classes": classes,
        "logs": len(material.body["logs"]),
    }


BAND = Section("band", "Prediction band", "Band", _fill)


def _ranges(name: str, edges: Sequence[float], scale: Scale) -> list[str]:
    """Names of the ranges between edges, one more than there are edges."""
    if not edges:
        return [name]
    words = [f"{edge * scale.factor:.3g} {brief(scale.unit)}".strip() for edge in edges]
    between = [f"{name} {low} to {high}" for low, high in itertools.pairwise(words)]
    return [f"{name} up to {words[0]}", *between, f"{name} above {words[-1]}"]
