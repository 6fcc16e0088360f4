"""Flow curves: each law at several fields, the data beside it."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from erclutch.diagnostics.flow_curves import FlowCurves, flow_curves, law_names
from erclutch.diagnostics.material import Material
from erclutch.model import TorqueModel
from erclutch.report.section import Section
from erclutch.report.svg import Axis, Plot


class FlowSection(Section):
    """One small plot a law."""

    name: ClassVar[str] = "flow_curves"
    title: ClassVar[str] = "Flow curves of the laws"
    short: ClassVar[str] = "Flow curves"

    def fill(self, material: Material) -> dict[str, Any] | None:
        """See `Section.fill`."""
        groups = [curves_of(material, k) for k in range(len(material.rows.data.elements))]
        if not groups[0]:
            return None
        return {
            "groups": [
                {"element": material.element_name(k), "plots": _plots(material, group)}
                for k, group in enumerate(groups)
            ],
            "levels": [
                material.field.of(float(f), 2) if material.field.unit else f"E = {material.field.of(float(f), 2)}"
                for f in groups[0][0].fields
            ],
            "pair": len(groups) > 1,
            "dots": any(d.size for group in groups for c in group for d in c.dots),
        }


def _plots(material: Material, found: list[FlowCurves]) -> list[dict[str, Any]]:
    """A small plot a law, all of one element with the same axes."""
    dots = np.concatenate([d[:, 1] for c in found for d in c.dots if d.size] or [np.array([0.0])])
    low, high = _reach(material, found, dots)
    return [
        {"name": c.model, "svg": _drawn(material, c, low, high), "chosen": c.model == material.recommended}
        for c in found
    ]


def curves_of(material: Material, element: int = 0) -> list[FlowCurves]:
    """Flow curves of all laws of a run."""
    models = [material.models[name] for name in law_names(material.body)]
    return flow_curves(material.rows, [m for m in models if isinstance(m, TorqueModel)], element)


def _reach(material: Material, found: list[FlowCurves], dots: Any) -> tuple[float, float]:
    """Range of the effort: the data's where there are enough, else the best law's."""
    first = next((c for c in found if c.model == material.recommended), found[0])
    values = dots if dots.size > 50 else first.effort
    low, high = (float(v) for v in np.quantile(values, (0.002, 0.998)))
    slack = 0.15 * (high - low)
    return (low - slack) * material.effort.factor, (high + slack) * material.effort.factor


def _drawn(material: Material, found: FlowCurves, low: float, high: float) -> Any:
    x = found.slip * material.slip.factor
    plot = Plot(
        Axis(float(x[0]), float(x[-1]), material.slip.titled("slip")),
        Axis(low, high, material.effort.titled(material.word)),
        width=330,
        height=230,
        ticks=(5, 4),
    )
    plot.level(0.0, "zero")
    factor = np.array([material.slip.factor, material.effort.factor])
    steps = _colours(found.fields.size)
    for k, dots in zip(steps, found.dots, strict=True):
        if dots.size:
            at = dots * factor
            plot.dots(at[:, 0], at[:, 1], f"level{k}", 1.1)
    for k, effort in zip(steps, found.effort, strict=True):
        plot.line(x, effort * material.effort.factor, f"line level{k}")
    return plot.svg(
        f"{material.word} over slip of {found.model} at {found.fields.size} fields, with measured rows as dots."
    )


def _colours(levels: int) -> list[int]:
    return [round(6 * i / max(levels - 1, 1)) for i in range(levels)]
