"""Charts of a fleet: each number of a model over the devices, with intervals, outliers and control limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from erclutch.report.numbers.number_text import chart_scale
from erclutch.report.plots.plot_description import Axis, Dots, Line, Panel, ReferenceLine, Shade
from erclutch.wings.fleet.fleet_statistics import RMSE, FleetSeries

_NAMED = 6
_REACH = 20.0  # intervals that an interval is drawn to, so that one that knows nothing leaves the others to be seen


def named(devices: tuple[str, ...]) -> str:
    """Names, the first six of many."""
    more = f" and {len(devices) - _NAMED} more" if len(devices) > _NAMED else ""
    return ", ".join(devices[:_NAMED]) + more or "–"


def _panel(series: FleetSeries, over: str) -> Panel:
    scale = chart_scale(series.unit, float(np.abs(series.value).max()))
    value, low, high = (scale.factor * v for v in (series.value, series.low, series.high))
    outliers = np.array([d in series.outliers for d in series.devices], bool)
    bars = np.column_stack([low, high, np.full_like(low, np.nan)]).ravel()
    marks: list[Any] = [Line(np.repeat(series.x, 3), bars, "whisker")]
    known = (high - low)[np.isfinite(high - low)]
    reach = _REACH * float(np.median(known)) if known.size else 0.0
    ends = [value, np.clip(low, value - reach, value), np.clip(high, value, value + reach)]
    if series.chart is not None:
        lower, centre, upper = (scale.factor * v for v in (series.chart.lower, series.chart.centre, series.chart.upper))
        marks = [Shade(lower, upper), ReferenceLine(centre), *marks]
        ends.append(np.array([lower, upper]))
    marks.append(Dots(series.x[~outliers], value[~outliers], "series1", "device", 3.6))
    if outliers.any():
        marks.append(Dots(series.x[outliers], value[outliers], "series0", "stands out", 5.0))
    least, most = float(np.nanmin(np.concatenate(ends))), float(np.nanmax(np.concatenate(ends)))
    slack = 0.08 * (most - least) or 0.5
    label = {"name": "device, in the order of the names", "mtime": "days since the first log"}.get(over, over)
    return Panel(
        Axis(label, whole=over == "name"),
        Axis(series.parameter, scale.unit, least - slack, most + slack),
        marks,
        f"{series.parameter} of {len(series.devices)} devices.",
        caption=f"{series.parameter} with 95 % intervals."
        + (" Grey: the limits of the control chart." if series.chart is not None else ""),
    )


def fleet_panels(series: Sequence[FleetSeries], over: str) -> list[Panel]:
    """A chart of each number of a model over what the devices are ordered by, the error first."""
    return [_panel(s, over) for s in sorted(series, key=lambda s: s.parameter != RMSE)]
