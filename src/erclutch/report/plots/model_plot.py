"""This plot shows the recommended model at rest: over slip, over the field, and beside one rival."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.report.numbers.flow_curves import FieldCurves, FlowCurves
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import PAGE, Axis, Dots, Line, Mark, Panel, Plot, PlotTable, ReferenceLine
from erclutch.signals.array import Array

_SHADES = 6  # the last shade of the ramp


def describe_model(material: Material) -> Plot:
    """A row of panels an element: effort over slip, effort over the field, and a rival's effort over slip."""
    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    for over_slip, over_field in material.recommended_curves:
        y = _effort_axis(material, [*over_slip, over_field])
        name = material.element_name(over_field.element)
        own, *rivals = over_slip
        panels.append(_over_slip(material, own, y, f"{name} recommended, over slip".strip()))
        panels.append(_over_field(material, over_field, y, f"{name} recommended, over the field".strip()))
        panels += [_over_slip(material, rival, y, f"{name} rival, over slip".strip()) for rival in rivals]
        rows += [row for found in over_slip for row in _rows_over_slip(found)]
        rows += _rows_over_field(material, over_field)
    columns = 3 if material.rival else 2
    return Plot(
        panels,
        PlotTable(("model", "element", "field", "slip", "effort"), rows),
        0.35 + 2.1 * (len(panels) // columns),
        PAGE,
        columns,
        badge=material.print_badge,
        legend="above",
        title=f"Recommended: {material.title}."
        + (f" Rival: {material.titles[material.rival]}." if material.rival else ""),
    )


def _effort_axis(material: Material, found: Sequence[FlowCurves | FieldCurves]) -> Axis:
    """One axis for all panels of an element, so that they can be compared: around curves and dots."""
    factor = material.effort.factor
    drawn = [found[0].effort.ravel(), *(curves.effort.ravel() for curves in found if isinstance(curves, FieldCurves))]
    dots = [d[:, 1] for curves in found for d in curves.dots if d.size]
    low, high = (
        float(end(np.concatenate([*drawn, *dots]), share)) * factor
        for end, share in ((np.quantile, 0.001), (np.quantile, 0.999))
    )
    slack = 0.06 * ((high - low) or 1.0)
    return Axis(material.word, material.effort.unit, low - slack, high + slack)


def _over_slip(material: Material, found: FlowCurves, y: Axis, title: str) -> Panel:
    x = found.slip * material.slip.factor
    axis = Axis("slip", material.slip.unit, float(x[0]), float(x[-1]))
    labels = [material.field.of(float(level), 2) for level in found.fields]
    dots = [d * [material.slip.factor, 1.0] for d in found.dots]
    return _panel(material, (x, found.effort, labels, dots), axis, y, (title, material.titles[found.model]))


def _over_field(material: Material, found: FieldCurves, y: Axis, title: str) -> Panel:
    x = found.field * material.field.factor
    axis = Axis("field", material.field.unit, float(x[0]), float(x[-1]) if x[-1] > x[0] else None)
    labels = [material.slip.of(float(level), 2) for level in found.slips]
    dots = [d * [material.field.factor, 1.0] for d in found.dots]
    return _panel(material, (x, found.effort, labels, dots), axis, y, (title, material.title))


def _panel(
    material: Material,
    curves: tuple[Array, Array, list[str], list[Array]],
    x: Axis,
    y: Axis,
    titles: tuple[str, str],
) -> Panel:
    """Curves with the dots near them.

    Args:
        material: of the scales.
        curves: places on the axis, efforts (curves, n), labels, and dots (m, 2) of each curve.
        x: axis of the places.
        y: axis of the efforts.
        titles: of the panel, and of the model.
    """
    at, efforts, labels, dots = curves
    factor, last = material.effort.factor, max(len(labels) - 1, 1)
    styles = [f"level{round(_SHADES * k / last)}" for k in range(len(labels))]
    marks: list[Mark] = [ReferenceLine(0.0)]
    marks += [Dots(d[:, 0], d[:, 1] * factor, style, size=1.6) for style, d in zip(styles, dots, strict=True)]
    marks += [
        Line(at, effort * factor, style, label) for style, effort, label in zip(styles, efforts, labels, strict=True)
    ]
    title, model = titles
    says = f"{material.word} of {model} over {x.label} in settled fields, {len(labels)} curves, measured rows as dots."
    return Panel(x, y, marks, says, title, size=(380, 290))


def _rows_over_slip(found: FlowCurves) -> list[tuple[object, ...]]:
    return [
        (found.model, found.element + 1, float(field), float(slip), float(effort))
        for field, line in zip(found.fields, found.effort, strict=True)
        for slip, effort in zip(found.slip, line, strict=True)
    ]


def _rows_over_field(material: Material, found: FieldCurves) -> list[tuple[object, ...]]:
    return [
        (material.recommended, found.element + 1, float(field), float(slip), float(effort))
        for slip, line in zip(found.slips, found.effort, strict=True)
        for field, effort in zip(found.field, line, strict=True)
    ]
