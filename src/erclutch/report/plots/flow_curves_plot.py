"""This plot shows flow curves of the laws at several fields, with the rows near them."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

import numpy as np

from erclutch.errors import CheckError
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

_MOST = 12  # panels that a page holds
_TALLEST = 9.2  # inches that a page has, its caption aside
_LINE = 115  # letters over both columns
_SHADES = 6  # the last shade of the ramp of fields


def describe_flow_curves(material: Material) -> Plot:
    """A panel a law: curves in a settled field, dots where the log has such rows. Of a pair both clutches.

    Raises:
        CheckError: the run holds no law.
    """
    groups = [group[: _MOST // len(material.flow_curves)] for group in material.flow_curves]
    if not groups[0]:
        raise CheckError(
            "the run holds no law",
            where=str(material.run.folder),
            remedy="Fit laws too: --models all",
        )

    # Laws follow one another; both clutches of a law stand side by side.
    panels: list[Panel] = []
    for of_elements in zip(*(flow_panels(material, group) for group in groups), strict=True):
        panels += of_elements
    rows: list[tuple[object, ...]] = []
    for of_elements in zip(*groups, strict=True):
        for curves in of_elements:
            for law in (curves, *curves.alike):
                rows += law.rows()

    columns = min(2 if len(groups) > 1 else 3, len(panels))
    height = 0.35 + 2.1 * math.ceil(len(panels) / columns)
    return Plot(
        panels,
        PlotTable(FlowCurves.HEADER, rows),
        min(height, _TALLEST),
        PAGE,
        columns,
        badge=material.print_badge,
        legend="shared",
        legend_title="field",
        title="\n".join(textwrap.wrap(material.about_flow_curves, _LINE, break_on_hyphens=False)),
    )


def flow_panels(material: Material, laws: Sequence[FlowCurves]) -> list[Panel]:
    """A small panel a law, all of one element with the same axes."""
    measured: list[Array] = []  # efforts of the dots
    for curves in laws:
        measured += [dots[:, 1] for dots in curves.dots if dots.size]
    dot_efforts = np.concatenate(measured or [np.zeros(1)])
    recommended = [curves for curves in laws if curves.model == material.recommended]
    best = [*recommended, *laws][0]
    # The axis reaches around the data where there are enough, else around the best law.
    efforts = dot_efforts if dot_efforts.size > 50 else best.effort
    low, high = np.quantile(efforts, (0.002, 0.998)) * material.effort.factor
    slack = 0.15 * (high - low)
    low_end = float(low - slack)
    high_end = float(high + slack)
    y = Axis(material.word, material.effort.unit, low_end, high_end)

    panels: list[Panel] = []
    for law in laws:
        slip = law.slip * material.slip.factor
        last = max(law.fields.size - 1, 1)
        styles = [f"level{round(_SHADES * k / last)}" for k in range(law.fields.size)]
        marks: list[Mark] = [ReferenceLine(0.0)]
        for style, near in zip(styles, law.dots, strict=True):
            dot_slip = near[:, 0] * material.slip.factor
            dot_effort = near[:, 1] * material.effort.factor
            marks.append(Dots(dot_slip, dot_effort, style, size=1.1))
        for style, level, effort in zip(styles, law.fields, law.effort, strict=True):
            label = material.field.of(float(level), 2)
            marks.append(Line(slip, effort * material.effort.factor, style, label))
        model = material.titles[law.model]
        title = f"{model} {material.element_name(law.element)}".strip()
        if law.alike:
            title += f" (and {len(law.alike)} alike)"
        panel = Panel(
            Axis.over("slip", material.slip.unit, slip),
            y,
            marks,
            f"{material.word} over slip of {model} at {law.fields.size} fields, with measured rows as dots.",
            title,
            chosen=law.model == material.recommended,
            size=(330, 230),
        )
        panels.append(panel)
    return panels
