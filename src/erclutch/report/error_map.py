"""Error over field and slip, and the density of the data, so that holes in coverage are seen."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from erclutch.diagnostics.error_map import ErrorMap, error_maps
from erclutch.diagnostics.material import Material
from erclutch.diagnostics.text import count, percent
from erclutch.report.section import Section
from erclutch.report.svg import RAMP, Axis, Plot

Array = NDArray[np.float64]


class ErrorMaps(Section):
    """Two maps an element."""

    name: ClassVar[str] = "error_map"
    title: ClassVar[str] = "Where it errs, and where there are data"
    short: ClassVar[str] = "Error map"

    def fill(self, material: Material) -> dict[str, Any]:
        """See `Section.fill`."""
        maps = error_maps(material.rows, material.recommended)
        top = _top(maps)
        most = max(int(m.train.max()) for m in maps)
        return {
            "model": material.recommended,
            "maps": [_drawn(material, m, top, most) for m in maps],
            "grids": [_grid(material, m) for m in maps],
            "error_steps": [material.effort.bare(top * (i + 1) / RAMP, 2) for i in range(RAMP)],
            "row_steps": [count(_rows_at(i + 1, most)) for i in range(RAMP)],
            "unit": material.effort.unit,
            "lead": _lead(material, maps),
        }


def _top(maps: tuple[ErrorMap, ...]) -> float:
    """Error of the last colour: the 97th percentile of the rows, so that one cell does not take all contrast."""
    errors = np.concatenate([np.repeat(m.rmse[m.test > 0], np.minimum(m.test[m.test > 0], 50)) for m in maps])
    return float(np.quantile(errors, 0.97)) or 1.0


def _rows_at(step: int, most: int) -> int:
    return round(np.expm1(np.log1p(most) * step / RAMP))


def _steps(values: Array, top: float) -> NDArray[np.int64]:
    shares = np.nan_to_num(values / top, nan=-1.0)
    return np.where(shares < 0, -1, np.clip((shares * RAMP).astype(np.int64), 0, RAMP - 1))


def _drawn(material: Material, found: ErrorMap, top: float, most: int) -> dict[str, Any]:
    name = material.element_name(found.element)
    field, slip = material.field, material.slip
    fx, sy = found.field_edges * field.factor, found.slip_edges * slip.factor

    def blank() -> Plot:
        return Plot(
            Axis(float(fx[0]), float(fx[-1]), field.titled("field")),
            Axis(float(sy[0]), float(sy[-1]), slip.titled("slip")),
            height=300,
        )

    error, density = blank(), blank()
    error.cells(fx, sy, _steps(found.rmse, top), "heat")
    error.outline(fx, sy, found.blind, "blind")
    shown = np.where(found.train > 0, np.log1p(found.train), np.nan)
    density.cells(fx, sy, _steps(shown, float(np.log1p(most)) * 1.0001), "mass")
    return {
        "name": name,
        "error": error.svg(f"RMSE on the rows held out over field and slip {name}. {_worst(material, found)}"),
        "density": density.svg(
            f"Training rows over field and slip {name}; {percent(found.empty_share, 2)} of the cells hold none."
        ),
    }


def _worst(material: Material, found: ErrorMap) -> str:
    at = found.worst()
    if at is None:
        return ""
    i, j = at
    field = 0.5 * (found.field_edges[i] + found.field_edges[i + 1])
    slip = 0.5 * (found.slip_edges[j] + found.slip_edges[j + 1])
    name = material.element_name(found.element)
    where = f"field {material.field.of(float(field), 2)} and slip {material.slip.of(float(slip), 2)}"
    error = material.effort.of(float(found.rmse[i, j]))
    return f"Largest{f' on {name}' if name else ''} near {where}: {error} over {count(int(found.test[i, j]))} rows."


def _lead(material: Material, maps: tuple[ErrorMap, ...]) -> str:
    worst = " ".join(text for text in (_worst(material, m) for m in maps) if text)
    blind = max(m.blind_share for m in maps)
    if not blind:
        return f"{worst} Every row held out lies in a cell that training rows reach."
    return f"{worst} {percent(blind, 2)} of the rows held out lie in cells without a training row (crossed)."


def _grid(material: Material, found: ErrorMap) -> dict[str, Any]:
    """For the readout under the pointer."""
    rmse = np.where(np.isfinite(found.rmse), found.rmse * material.effort.factor, -1.0)
    return {
        "name": material.element_name(found.element),
        "field": [float(f"{v:.4g}") for v in found.field_edges * material.field.factor],
        "slip": [float(f"{v:.4g}") for v in found.slip_edges * material.slip.factor],
        "train": found.train.tolist(),
        "test": found.test.tolist(),
        "rmse": [[float(f"{v:.3g}") for v in line] for line in rmse],
        "units": [material.field.unit, material.slip.unit, material.effort.unit],
    }
