"""This plot shows loops of effort over slip and over travel, measured and modelled, a row of panels a field."""

from __future__ import annotations

import numpy as np

from erclutch.errors import CheckError
from erclutch.report.numbers.effort_loops import EffortLoop
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import PAGE, Axis, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array

_STEADY = 0.01  # share of the largest field by which a field may move and still be one


def describe_loops(material: Material) -> Plot:
    """A row of two panels a field: effort over slip, and effort over travel. Of a pair both clutches.

    Raises:
        CheckError: the slip never turns.
    """
    found = material.effort_loops
    if not found:
        raise CheckError(
            "the slip does not go to and fro, so there are no loops",
            where=str(material.run.folder),
            remedy="Log a motion of several periods without a gap",
        )
    panels = [panel for loop in found for panel in _row(material, loop)]
    header = ("element", "field_low", "field_high", "time_s", "slip", "travel", "curve", "effort")
    return Plot(
        panels,
        PlotTable(header, [row for loop in found for row in _rows(loop)]),
        0.35 + 1.75 * len(found),
        PAGE,
        2,
        badge=material.print_badge,
        legend="shared",
    )


def _row(material: Material, loop: EffortLoop) -> list[Panel]:
    over_slip = _panel(material, loop, Axis("slip", material.slip.unit), loop.slip * material.slip.factor)
    travel = material.travel
    return [over_slip, _panel(material, loop, Axis("travel", travel.unit), loop.travel * travel.factor)]


def _panel(material: Material, loop: EffortLoop, x: Axis, values: Array) -> Panel:
    factor = material.effort.factor
    lines = [Line(values, loop.measured * factor, "measured", "measured")]
    for name, role in material.looped.items():
        lines.append(Line(values, loop.modelled[name] * factor, role, material.titles[name]))
    at = _field_of(material, loop)
    where = f"from {loop.start:.4g} s"
    if loop.log:
        where += f" of {loop.log}"
    if not loop.held:
        where += ", training rows"
    return Panel(
        x,
        Axis(material.word, material.effort.unit),
        lines,
        f"{material.word} over {x.label} at {at}, measured and estimated by "
        f"{', '.join(material.titles[name] for name in loop.modelled)}.",
        f"{at}, {where}",
        caption=f"Over {x.label} at {at}, {where}.",
        size=(430, 250),
    )


def _field_of(material: Material, loop: EffortLoop) -> str:
    """The field as text, or its range where the field moves."""
    low, high = loop.fields
    begin = f"{material.element_name(loop.element)} ".lstrip()
    if not material.field.unit:
        begin += "E = "
    largest = max(float(np.abs(element.field).max()) for element in material.rows.data.elements)
    if high - low < _STEADY * largest:
        return f"{begin}{material.field.of(0.5 * (low + high), 2)}"
    return f"{begin}{material.field.bare(low, 2)} to {material.field.of(high, 2)}"


def _rows(loop: EffortLoop) -> list[tuple[object, ...]]:
    curves: dict[str, Array] = {"measured": loop.measured, **loop.modelled}
    return [
        (loop.element + 1, *loop.fields, loop.start, float(w), float(x), name, float(t))
        for name, effort in curves.items()
        for w, x, t in zip(loop.slip, loop.travel, effort, strict=True)
    ]
