"""This plot shows the recommended model at rest: over slip, over the field, and beside one rival."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.fit.choice.standing import standing_of_run
from erclutch.report.numbers.flow_curves import FlowCurves
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import (
    PAGE,
    Axis,
    Dots,
    Line,
    Mark,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
)
from erclutch.signals.array import Array

_SHADES = 6  # the last shade of the ramp
_SIZE = (380, 290)


def describe_model(material: Material) -> Plot:
    """A row of panels an element: effort over slip, effort over the field, and a rival's effort over slip.

    A log of one field, or of none, has no panel over the field, and a log of one slip has none over the slip.
    """
    word = standing_of_run(material.body).word
    low, high = material.models[material.recommended].trained_on.field
    moves = any(np.ptp(own.slip) > 0.0 for (own, *_), _ in material.recommended_curves)
    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    for over_slip, over_field in material.recommended_curves:
        own, *rivals = over_slip
        # One axis for all panels of an element, so that they can be compared. It reaches around the recommended
        # model's curves and all dots; a rival that leaves it is cut off.
        efforts_around = [own.effort.ravel(), over_field.effort.ravel()]
        for curves in (own, *rivals, over_field):
            efforts_around += [dots[:, 1] for dots in curves.dots if dots.size]
        all_efforts = np.concatenate(efforts_around)
        lowest = float(np.quantile(all_efforts, 0.001)) * material.effort.factor
        highest = float(np.quantile(all_efforts, 0.999)) * material.effort.factor
        slack = 0.06 * ((highest - lowest) or 1.0)
        y = Axis(material.word, material.effort.unit, lowest - slack, highest + slack)
        name = material.element_name(over_field.element)
        if moves:
            panels.append(_over_slip(material, own, y, f"{name} {word}, over slip".strip()))
        if low < high:
            field = over_field.field * material.field.factor
            _, first = np.unique(over_field.slips, return_index=True)
            levels: list[int] = first.tolist()
            labels = [material.slip.of(float(over_field.slips[level]), 2) for level in levels]
            dots = [over_field.dots[level] * [material.field.factor, 1.0] for level in levels]
            panel = Panel(
                Axis.over("field", material.field.unit, field),
                y,
                _marks(material, field, over_field.effort[levels], labels, dots),
                _sentence(material, material.title, "field", len(labels)),
                f"{name} {word}, over the field".strip(),
                size=_SIZE,
            )
            panels.append(panel)
        for rival in rivals if moves else ():
            panels.append(_over_slip(material, rival, y, f"{name} rival, over slip".strip()))
        for curves in over_slip:
            rows += curves.rows()
        for slip, efforts in zip(over_field.slips, over_field.effort, strict=True):
            for field, effort in zip(over_field.field, efforts, strict=True):
                point = float(field), float(slip), float(effort)
                rows.append((material.recommended, over_field.element + 1, *point))

    columns = moves + (low < high) + (moves and bool(material.rival))
    height = 0.35 + 2.1 * (len(panels) // columns)
    title = f"{word.capitalize()}: {material.title}."
    if material.rival and moves:
        title += f" Rival: {material.titles[material.rival]}."
    return Plot(
        panels,
        PlotTable(FlowCurves.HEADER, rows),
        height,
        PAGE,
        columns,
        badge=material.print_badge,
        legend="above",
        title=title,
    )


def _over_slip(
    material: Material,
    curves: FlowCurves,
    y: Axis,
    title: str,
) -> Panel:
    slip = curves.slip * material.slip.factor
    labels = [material.field.of(float(level), 2) for level in curves.fields]
    if material.without_field:
        labels = ["no field in the log"]
    dots = [near * [material.slip.factor, 1.0] for near in curves.dots]
    return Panel(
        Axis.over("slip", material.slip.unit, slip),
        y,
        _marks(material, slip, curves.effort, labels, dots),
        _sentence(material, material.titles[curves.model], "slip", len(labels)),
        title,
        size=_SIZE,
    )


def _marks(
    material: Material,
    at: Array,
    efforts: Array,
    labels: Sequence[str],
    dots: Sequence[Array],
) -> Sequence[Mark]:
    """Curves with the measured rows near them as dots.

    Args:
        material: of the scales.
        at: places on the axis, as drawn, shape (n,).
        efforts: as the run has them, shape (curves, n).
        labels: of the curves.
        dots: place as drawn and effort of the rows near each curve, shapes (m, 2).
    """
    factor = material.effort.factor
    last = max(len(labels) - 1, 1)
    styles = [f"level{round(_SHADES * k / last)}" for k in range(len(labels))]
    marks: list[Mark] = [ReferenceLine(0.0)]
    for style, near in zip(styles, dots, strict=True):
        effort_near = near[:, 1] * factor
        marks.append(Dots(near[:, 0], effort_near, style, size=1.6))
    for style, effort, label in zip(styles, efforts, labels, strict=True):
        marks.append(Line(at, effort * factor, style, label))
    return marks


def _sentence(
    material: Material,
    model: str,
    axis: str,
    curves: int,
) -> str:
    return f"{material.word} of {model} over {axis} in settled fields, {curves} curves, measured rows as dots."
