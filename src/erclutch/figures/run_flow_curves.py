"""Flow curves of the laws at several fields, with the rows near them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from erclutch.diagnostics.flow_curves import FlowCurves, flow_curves, law_names
from erclutch.diagnostics.material import Material
from erclutch.errors import CheckError
from erclutch.figures.parts import Numbers, titled
from erclutch.model import TorqueModel

_MOST = 12


def laws(material: Material) -> list[TorqueModel]:
    """The laws that are drawn, the best form of each: as many as twelve panels hold."""
    models = [material.models[name] for name in law_names(material.body)]
    return [m for m in models if isinstance(m, TorqueModel)][: _MOST // len(material.rows.data.elements)]


def _across(material: Material) -> int:
    """Panels in a row: a law's two clutches stand beside each other."""
    return 2 if len(material.rows.data.elements) > 1 else 3


def height(material: Material) -> float:
    """Height that the panels need, in inches."""
    panels = max(len(laws(material)), 1) * len(material.rows.data.elements)
    return 0.35 + 1.35 * math.ceil(panels / _across(material))


def draw_flow_curves(figure: Any, material: Material) -> Numbers:
    """A panel a law: curves in a settled field, dots where the log has such rows. Of a pair both clutches.

    Raises:
        CheckError: the run holds no law.
    """
    models = laws(material)
    if not models:
        raise CheckError("the run holds no law", where=str(material.run.folder), remedy="Fit laws too: --models all")
    groups = [flow_curves(material.rows, models, k) for k in range(len(material.rows.data.elements))]
    found = [curves for law in zip(*groups, strict=True) for curves in law]
    across = min(_across(material), len(found))
    down = math.ceil(len(found) / across)
    axes: Any = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    shades = _shades(found[0].fields.size)
    for axis, curves in zip(axes.flat, found, strict=False):
        _panel(axis, material, curves, shades)
    for axis in list(axes.flat)[len(found) :]:
        axis.set_visible(False)
    _limits(axes.flat[0], material, found)
    for axis in axes[:, 0]:
        axis.set_ylabel(material.effort.titled(material.word.capitalize()))
    for column in axes.T:
        last = [axis for axis in column if axis.get_visible()][-1]
        last.set_xlabel(titled(material, material.slip.titled("Slip")))
        last.tick_params(labelbottom=True)
    labels = [material.field.of(float(f), 2) for f in found[0].fields]
    handles = axes.flat[0].get_lines()[-len(labels) :]
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), title="field", handlelength=1.4)
    rows = [
        (c.model, c.element + 1, float(f), float(w), float(t))
        for c in found
        for f, line in zip(c.fields, c.effort, strict=True)
        for w, t in zip(c.slip, line, strict=True)
    ]
    return Numbers(["model", "element", "field", "slip", "effort"], rows)


def _shades(count: int) -> list[Any]:
    from matplotlib import colormaps

    return [colormaps["viridis"](0.85 * i / max(count - 1, 1)) for i in range(count)]


def _panel(axis: Any, material: Material, curves: FlowCurves, shades: list[Any]) -> None:
    sx, sy = material.slip.factor, material.effort.factor
    for shade, dots in zip(shades, curves.dots, strict=True):
        axis.plot(dots[:, 0] * sx, dots[:, 1] * sy, ".", ms=2.0, mew=0, color=shade, alpha=0.6)
    for shade, effort in zip(shades, curves.effort, strict=True):
        axis.plot(curves.slip * sx, effort * sy, color=shade)
    chosen = curves.model == material.recommended
    title = f"{curves.model} {material.element_name(curves.element)}".strip()
    axis.set_title(title, loc="left", fontweight="bold" if chosen else "normal", fontsize=7)


def _limits(axis: Any, material: Material, found: list[FlowCurves]) -> None:
    dots = np.concatenate([d[:, 1] for c in found for d in c.dots])
    values = dots if dots.size > 50 else found[0].effort
    low, high = (float(v) * material.effort.factor for v in np.quantile(values, (0.002, 0.998)))
    axis.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
