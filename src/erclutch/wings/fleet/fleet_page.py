"""The report of a fleet is one page: what was fitted, what stands out, what drifts, and each parameter as a chart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from erclutch.errors import printable
from erclutch.report.html.report_page import plain_page
from erclutch.report.html.section import Section
from erclutch.report.numbers.number_text import count, number, span
from erclutch.report.numbers.run_material import BADGE_MEANS
from erclutch.report.plots.paper_style import placed
from erclutch.signals.origins import badge_of
from erclutch.wings.fleet.fitted_fleet import Fleet
from erclutch.wings.fleet.fleet_charts import fleet_panels, named
from erclutch.wings.fleet.fleet_statistics import FEWEST, FleetSeries

_CHANCE = 0.01  # below it a trend is said
_NAMED = 3  # logs in a sentence


def trend_of(series: FleetSeries) -> str:
    """The trend with its interval and the probability of chance; bold sentences are for the reader."""
    if series.trend is None:
        return "–"
    line = series.trend
    return f"{number(line.slope)} ({span(line.low, line.high)}), p = {line.chance:.2g}"


def beyond(series: FleetSeries) -> tuple[str, ...]:
    """Devices outside the limits of the control chart."""
    if series.chart is None:
        return ()
    return tuple(d for d, out in zip(series.devices, series.chart.out, strict=True) if out)


def too_few(series: Sequence[FleetSeries]) -> str:
    """Why a fleet has no such figures; empty where it has."""
    devices = max((len(each.devices) for each in series), default=0)
    if not series or devices >= FEWEST:
        return ""
    have = "1 device has" if devices == 1 else f"{devices} devices have"
    return f"Trends, limits and what stands out need {FEWEST} devices with this model; {have} it."


def not_compared(series: Sequence[FleetSeries]) -> str:
    """Which numbers are of another field in some logs, which reached another one; empty where none is."""
    apart = {each.parameter: each.apart for each in series if each.apart}
    if not apart:
        return ""
    fields = next(iter(apart.values()))
    logs = ", ".join(
        f"{named([device])} ({reached:.3g})" for device, reached in list(fields.items())[:_NAMED]
    )
    more = f" and {len(fields) - _NAMED} more" if len(fields) > _NAMED else ""
    numbers = ", ".join(apart)
    return f"{numbers}: at the largest field that was fitted; not compared there, with another field: {logs}{more}."


def mixed(series: Sequence[FleetSeries], over: str) -> str:
    """That several devices stand in one trend, which hides the drift of one of them; empty where they do not."""
    if not series:
        return ""
    most = max(series, key=lambda each: each.x.size)
    _, logs_at_one = np.unique(most.x, return_counts=True)
    usual = int(np.median(logs_at_one)) if logs_at_one.size >= FEWEST else 1
    if usual < 2:
        return ""
    return (
        f"{usual} logs stand at one {over}: a trend over several devices hides the drift of one of them, and so do the "
        "limits. Give the logs of one device alone."
    )


def drifting(series: FleetSeries) -> bool:
    """Whether such a trend would come by chance in fewer than one of a hundred fleets."""
    return series.trend is not None and series.trend.chance < _CHANCE


def fleet_html(fleet: Fleet) -> str:
    """The report of a fleet as one HTML document."""
    series = fleet.stands_for
    rows: list[tuple[object, ...]] = []
    for each in series:
        middle = np.median(each.value)
        outliers = named(each.outliers)
        rows.append((each, middle, trend_of(each), drifting(each), outliers, named(beyond(each))))
    values = {
        "fleet": fleet,
        "series": series,
        "rows": rows,
        "panels": fleet_panels(series, fleet.over),
        "failed": {printable(device): why for device, why in fleet.failed.items()},
        "too_few": too_few(series),
        "not_compared": not_compared(series),
        "mixed": mixed(series, fleet.over),
        "others": sorted({row["model"] for row in fleet.fits if row["model"]} - {fleet.model}),
    }
    badge = badge_of(fleet.origins)
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
        # Names may be no text.
        partial.write_text(text, encoding="utf-8", errors="backslashreplace")
    return path
