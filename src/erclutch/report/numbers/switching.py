"""Lag and dynamics: how a model errs after a switch of the command, and how its field follows one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.diagnostics.correlation import period_of
from erclutch.run_rows import RunRows

Array = NDArray[np.float64]

_STEP, _WITHIN = 0.1, 2.0e-3
_FEWEST = 20


@dataclass(frozen=True)
class AfterSwitch:
    """Error over the time since the command last switched.

    Attributes:
        switches: how many there are in the rows held out.
        since: middle of each bin in s, shape (n,).
        rows: in each bin, shape (n,).
        rmse: by model, each (n,).
    """

    switches: int
    since: Array
    rows: NDArray[np.int64]
    rmse: dict[str, Array]


@dataclass(frozen=True)
class StepResponse:
    """How the field in the fluid follows a step of the command, as a model has it.

    Attributes:
        model: its name.
        delay: dead time in s.
        rise, fall: time constants in s.
    """

    model: str
    delay: float
    rise: float
    fall: float

    def up(self, time: Array) -> Array:
        """Share of a step up that has arrived."""
        return -np.expm1(-np.maximum(time - self.delay, 0.0) / self.rise)

    def down(self, time: Array) -> Array:
        """Share that is left after a step down to zero."""
        return np.exp(-np.maximum(time - self.delay, 0.0) / self.fall)


def after_switch(rows: RunRows, models: Sequence[str]) -> AfterSwitch | None:
    """RMSE over the time since a switch; None where the command hardly ever switches.

    A switch: the command moves by more than a tenth of its range within 2 ms (or from one row to the next).
    """
    period = period_of(rows)
    since = _time_since(rows, max(1, round(_WITHIN / period)))
    test = rows.test & np.isfinite(since)
    switches = int(np.count_nonzero(rows.test & (since == 0.0)))
    if switches < _FEWEST:
        return None
    longest = float(np.quantile(since[test], 0.98)) / period
    ticks = np.unique(np.round(np.geomspace(1.0, longest + 1.0, 25)).astype(int))
    if ticks.size < 5:
        return None
    # Bins of whole periods: 0, 1, 2, 3 and 4, ...
    edges = (ticks - 1.5) * period
    count = edges.size - 1
    which = np.searchsorted(edges, since[test], "right") - 1
    inside = which < count
    which = which[inside]
    total = np.bincount(which, minlength=count)[:count]
    rmse: dict[str, Array] = {}
    for model in models:
        squares = np.bincount(which, rows.residual(model)[test][inside] ** 2, minlength=count)[:count]
        rmse[model] = np.sqrt(squares / np.maximum(total, 1))
    return AfterSwitch(switches, 0.5 * (ticks[1:] + ticks[:-1] - 3) * period, total, rmse)


def _time_since(rows: RunRows, within: int) -> Array:
    """Seconds since the last switch of any element's command in the same stretch; nan where there was none yet."""
    n = rows.data.rows
    switch = np.zeros(n, np.bool_)
    for element in rows.data.elements:
        reach = float(np.ptp(element.field)) or 1.0
        jump = np.zeros(n, np.bool_)
        jump[within:] = np.abs(element.field[within:] - element.field[:-within]) > _STEP * reach
        # The first row of a run of such rows is the switch.
        switch[1:] |= jump[1:] & ~jump[:-1]
    last = np.maximum.accumulate(np.where(switch, np.arange(n), -1))
    time = rows.data.clock.time
    since = np.where(last >= 0, time - time[last], np.nan)
    for span in rows.data.clock.spans:
        lost = last[span.start : span.stop] < span.start + within
        since[span.start : span.stop][lost] = np.nan
    return since


def step_responses(body: Mapping[str, Any], models: Sequence[str]) -> tuple[StepResponse, ...]:
    """Step responses of those models that have dynamics, from their numbers in run.json."""
    found: list[StepResponse] = []
    for entry in body["ranking"]:
        times = entry["dynamics"]
        if entry["name"] in models and times:
            rise = times.get("tau", times.get("tau_rise"))
            found.append(StepResponse(entry["name"], times["delay"], rise, times.get("tau_fall", rise)))
    return tuple(found)
