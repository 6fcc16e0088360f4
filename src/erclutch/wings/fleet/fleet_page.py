"""The report of a fleet is one page: what was fitted, what stands out, what drifts, and each parameter as a chart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from erclutch.report.html.report_page import plain_page
from erclutch.report.html.section import Section
from erclutch.report.numbers.number_text import chart_scale, count, number, span
from erclutch.report.numbers.run_material import BADGE_MEANS
from erclutch.report.plots.paper_style import placed
from erclutch.report.plots.plot_description import Axis, Dots, Line, Panel, ReferenceLine, Shade
from erclutch.wings.fleet.fleet import RMSE, Fleet, FleetSeries

_CHANCE = 0.01  # below it a trend is said
_NAMED = 6
_REACH = 20.0  # intervals that an interval is drawn to, so that one that knows nothing leaves the others to be seen


def trend_of(series: FleetSeries) -> str:
    """The trend with its interval and the probability of chance; bold sentences are for the reader."""
    if series.trend is None:
        return "–"
    found = series.trend
    return f"{number(found.slope)} ({span(found.low, found.high)}), p = {found.chance:.2g}"


def named(devices: tuple[str, ...]) -> str:
    """Names, the first six of many."""
    more = f" and {len(devices) - _NAMED} more" if len(devices) > _NAMED else ""
    return ", ".join(devices[:_NAMED]) + more or "–"


def beyond(series: FleetSeries) -> tuple[str, ...]:
    """Devices outside the limits of the control chart."""
    if series.chart is None:
        return ()
    return tuple(d for d, out in zip(series.devices, series.chart.out, strict=True) if out)


def drifting(series: FleetSeries) -> bool:
    """Whether such a trend would come by chance in fewer than one of a hundred fleets."""
    return series.trend is not None and series.trend.chance < _CHANCE


def shown(fleet: Fleet) -> tuple[FleetSeries, ...]:
    """Numbers of the model that stands for the fleet."""
    return tuple(series for series in fleet.series if series.model == fleet.model)


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


def fleet_panels(fleet: Fleet) -> list[Panel]:
    """A chart of each number of the model that stands for the fleet, the error first."""
    return [_panel(s, fleet.over) for s in sorted(shown(fleet), key=lambda s: s.parameter != RMSE)]


def fleet_html(fleet: Fleet) -> str:
    """The report of a fleet as one HTML document."""
    series = shown(fleet)
    values = {
        "fleet": fleet,
        "series": series,
        "rows": [
            (s, np.median(s.value), trend_of(s), drifting(s), named(s.outliers), named(beyond(s))) for s in series
        ],
        "panels": fleet_panels(fleet),
        "failed": fleet.failed,
        "others": sorted({row["model"] for row in fleet.fits if row["model"]} - {fleet.model}),
    }
    badge = fleet.origins[0] if fleet.origins else "RECORDING"
    means = BADGE_MEANS.get(badge, "Made by a computer, not a measurement.")
    heading = f"{count(fleet.devices)} logs or devices"
    line = f"{fleet.model or 'no model'}, {count(len(fleet.fits))} fits, table {fleet.digest[:12]}"
    section = Section("fleet", "Fleet", "Fleet", lambda material: None)
    templates = Path(__file__).with_name("templates")
    return plain_page((heading, heading, line), (badge, means), section, values, templates)


def write_fleet_report(fleet: Fleet, path: Path) -> Path:
    """Write the report of a fleet as one HTML file, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    text = fleet_html(fleet)
    with placed(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="backslashreplace")  # names may be no text
    return path
