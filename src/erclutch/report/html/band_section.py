"""This section shows the prediction band: over a section of the log, and what it holds of the rows held out."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from erclutch.models.band import Band
from erclutch.report.html.section import Section
from erclutch.report.numbers.number_text import brief, count, percent
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.trace_plot import describe_trace


def _fill(material: Material) -> dict[str, Any] | None:
    """A plot, and a table of coverage by class."""
    band, figures = material.models[material.recommended].band, material.run.entry(material.recommended).get("band")
    if band is None or figures is None:
        return None
    tried = (("without a sensor", figures["held"]), ("with a torque sensor", figures["with_sensor"]))
    held = [(name, f, f["width"] / (figures["plain"] or 1.0)) for name, f in tried if f is not None]
    return {
        "level": percent(band.level),
        "figure": replace(describe_trace(material).panels[0], size=(880, 300)),
        "held": held,
        "classes": list(_classes(material, band)),
        "logs": len(material.body["logs"]),
    }


BAND = Section("band", "Prediction band", "Band", _fill)


def _classes(material: Material, band: Band) -> Iterator[tuple[str, str, str, str]]:
    """Class, rows held out, share of them inside, mean width."""
    test, data, ends = material.rows.test, material.rows.data, material.band_ends
    assert ends is not None
    inside = ((ends[0] <= data.effort) & (data.effort <= ends[1]))[test]
    width = (ends[1] - ends[0])[test]
    places = np.unravel_index(band.cells(data.elements, data.clock)[test], band.shape)
    names = (
        ["field has settled", "field is switching"],
        _ranges("field", [edge * material.field.factor for edge in band.field_edges], material.field.unit),
        _ranges("slip", [edge * material.slip.factor for edge in band.slip_edges], material.slip.unit),
    )
    for place, labels in zip(places, names, strict=True):
        for k, label in enumerate(labels):
            rows = place == k
            if rows.any() and len(labels) > 1:
                said = percent(float(inside[rows].mean())), material.effort.bare(float(width[rows].mean()))
                yield label, count(int(rows.sum())), *said


def _ranges(name: str, edges: list[float], unit: str) -> list[str]:
    words = [f"{edge:.3g} {brief(unit)}".strip() for edge in edges]
    between = [f"{name} {low} to {high}" for low, high in itertools.pairwise(words)]
    return [f"{name} up to {words[0]}", *between, f"{name} above {words[-1]}"] if words else [name]
