"""Charts of a fleet: each number of a model over the devices, with intervals, outliers and control limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from erclutch.errors import printable
from erclutch.report.numbers.number_text import chart_scale
from erclutch.report.plots.plot_description import (
    Axis,
    Dots,
    Line,
    Panel,
    ReferenceLine,
    Shade,
)
from erclutch.signals.array import largest_size
from erclutch.wings.fleet.fleet_statistics import RMSE, FleetSeries

_NAMED = 6  # devices in a sentence; the others are counted
_LONGEST = 60  # letters of a name in a sentence
_FEW = 100  # devices whose intervals stand beside each other; those of more are drawn thinner
_REACH = 20.0  # intervals that an interval is drawn to, so that one that knows nothing leaves the others to be seen


def named(devices: Sequence[str], most: int = _NAMED) -> str:
    """Names, the first six of many, with hidden signs written out, and long names cut."""
    names = [printable(device) for device in devices[:most]]
    short = [name if len(name) <= _LONGEST else f"{name[:_LONGEST]}…" for name in names]
    more = f" and {len(devices) - most} more" if len(devices) > most else ""
    return ", ".join(short) + more or "–"


def fleet_panels(series: Sequence[FleetSeries], over: str) -> list[Panel]:
    """A chart of each number of a model over what the devices are ordered by, the error first."""
    panels: list[Panel] = []
    for number in sorted(series, key=lambda number: number.parameter != RMSE):
        largest = largest_size(number.value)
        scale = chart_scale(number.unit, largest)
        x = number.x
        value = scale.factor * number.value
        low = scale.factor * number.low
        high = scale.factor * number.high
        outlying = np.array([device in number.outliers for device in number.devices], bool)

        gap = np.full_like(low, np.nan)
        whiskers = np.column_stack([low, high, gap]).ravel()  # NaN parts one from the next
        marks: list[Any] = [
            Line(np.repeat(x, 3), whiskers, "whisker" if x.size <= _FEW else "whiskers")
        ]
        width = high - low
        known = width[np.isfinite(width)]
        reach = _REACH * float(np.median(known)) if known.size else 0.0
        shown_low = np.clip(low, value - reach, value)
        shown_high = np.clip(high, value, value + reach)
        shown = [value, shown_low, shown_high]
        chart = number.chart
        if chart is not None:
            lower = scale.factor * chart.lower
            upper = scale.factor * chart.upper
            centre = scale.factor * chart.centre
            marks = [Shade(lower, upper), ReferenceLine(centre), *marks]
            shown.append(np.array([lower, upper]))
        marks.append(Dots(x[~outlying], value[~outlying], "series1", "device", 3.6))
        if outlying.any():
            marks.append(Dots(x[outlying], value[outlying], "series0", "stands out", 5.0))

        every = np.concatenate(shown)
        least = float(np.nanmin(every))
        most = float(np.nanmax(every))
        slack = 0.08 * (most - least) or 0.5
        labels = {"name": "device, in the order of the names", "mtime": "days since the first log"}
        grey = " Grey: the limits of the control chart." if chart is not None else ""
        panel = Panel(
            Axis(labels.get(over, over), whole=over == "name"),
            Axis(number.parameter, scale.unit, least - slack, most + slack),
            marks,
            f"{number.parameter} of {len(number.devices)} devices.",
            caption=f"{number.parameter} with 95 % intervals.{grey}",
        )
        panels.append(panel)
    return panels
