"""This plot shows flow curves of the laws at several fields, with the rows near them."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

import numpy as np

from erclutch.errors import CheckError
from erclutch.report.numbers.flow_curves import FlowCurves
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import PAGE, Axis, Dots, Line, Mark, Panel, Plot, PlotTable, ReferenceLine

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
        raise CheckError("the run holds no law", where=str(material.run.folder), remedy="Fit laws too: --models all")
    found = [curves for law in zip(*groups, strict=True) for curves in law]
    drawn = [panel for law in zip(*(flow_panels(material, g) for g in groups), strict=True) for panel in law]
    columns = min(2 if len(groups) > 1 else 3, len(drawn))
    return Plot(
        drawn,
        PlotTable(
            ("model", "element", "field", "slip", "effort"),
            [row for c in found for law in (c, *c.alike) for row in _rows(law)],
        ),
        min(0.35 + 2.1 * math.ceil(len(drawn) / columns), _TALLEST),
        PAGE,
        columns,
        badge=material.print_badge,
        legend="shared",
        legend_title="field",
        title="\n".join(textwrap.wrap(material.about_flow_curves, _LINE, break_on_hyphens=False)),
    )


def flow_panels(material: Material, found: Sequence[FlowCurves]) -> list[Panel]:
    """A small panel a law, all of one element with the same axes."""
    dots = np.concatenate([d[:, 1] for c in found for d in c.dots if d.size] or [np.array([0.0])])
    first = next((c for c in found if c.model == material.recommended), found[0])
    # The range of the data where there are enough, else that of the best law.
    low, high = np.quantile(dots if dots.size > 50 else first.effort, (0.002, 0.998)) * material.effort.factor
    slack = 0.15 * (high - low)
    y = Axis(material.word, material.effort.unit, float(low - slack), float(high + slack))
    return [_panel(material, curves, y) for curves in found]


def _panel(material: Material, found: FlowCurves, y: Axis) -> Panel:
    x = found.slip * material.slip.factor
    factors = np.array([material.slip.factor, material.effort.factor])
    styles = [f"level{round(_SHADES * i / max(found.fields.size - 1, 1))}" for i in range(found.fields.size)]
    marks: list[Mark] = [ReferenceLine(0.0)]
    for style, dots in zip(styles, found.dots, strict=True):
        x_dots, y_dots = (dots * factors).T
        marks.append(Dots(x_dots, y_dots, style, size=1.1))
    for style, level, effort in zip(styles, found.fields, found.effort, strict=True):
        marks.append(Line(x, effort * material.effort.factor, style, material.field.of(float(level), 2)))
    return Panel(
        Axis("slip", material.slip.unit, float(x[0]), float(x[-1])),
        y,
        marks,
        f"{material.word} over slip of {material.titles[found.model]} at {found.fields.size} fields, "
        "with measured rows as dots.",
        f"{material.titles[found.model]} {material.element_name(found.element)}".strip()
        + (f" (and {len(found.alike)} alike)" if found.alike else ""),
        chosen=found.model == material.recommended,
        size=(330, 230),
    )


def _rows(found: FlowCurves) -> list[tuple[object, ...]]:
    return [
        (found.model, found.element + 1, float(f), float(w), float(t))
        for f, line in zip(found.fields, found.effort, strict=True)
        for w, t in zip(found.slip, line, strict=True)
    ]
