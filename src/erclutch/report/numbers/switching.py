"""After a switch of the command a model errs in its lag: this module computes the error and how the field follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.models.stages.stage import Place
from erclutch.report.numbers.correlation import period_of
from erclutch.report.numbers.model_stages import stage_values, stages_in
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span

_STEP = 0.1  # share of the command's range that is a switch
_WITHIN = 2.0e-3  # s, in which the command moves so far
_FEWEST = 20  # switches
_SHORTEST = 1e-3  # s, of step responses
_LONGEST = 1e3
_POINTS = 1201  # of a step response
_STILL = 0.001  # share of a step, by which a response moves at most once it has settled
_SOME_OF_A_STEP = 0.1
_AT_ONCE = 1e-5  # s: what settles sooner shows no lag, as iron that keeps nothing back
_MISSING = 0.01  # share of a step below which the field has settled


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
    """How the field in the fluid follows a step of the command, as a model's stages on the command have it.

    Attributes:
        model: its name.
        time: since the step in s, from 0, shape (n,); both ways have settled at its end.
        rising: share of a step up that has arrived, shape (n,); iron keeps the rest of it back.
        falling: share that is left after a step down to zero, shape (n,).
    """

    model: str
    time: Array
    rising: Array
    falling: Array

    @property
    def kept_back(self) -> float:
        """The share of the largest step that stays behind for good, as in iron."""
        share = 1.0 - float(self.rising[-1])
        return share if share > _MISSING else 0.0

    def up(self, time: Array) -> Array:
        """Share of a step up that has arrived."""
        return np.interp(time, self.time, self.rising)

    def down(self, time: Array) -> Array:
        """Share that is left after a step down to zero."""
        return np.interp(time, self.time, self.falling)

    @property
    def settled(self) -> float:
        """Time in s after which less than 1 % of a step is missing; what stays in iron is no part of that."""
        above = np.abs(self.rising[-1] - self.rising)
        below = np.abs(self.falling - self.falling[-1])
        missing = np.maximum(above, below)
        off = missing > _MISSING
        last_off = int(np.flatnonzero(off)[-1])
        return float(self.time[min(last_off + 1, off.size - 1)])


def switches_of(rows: RunRows) -> NDArray[np.bool_]:
    """Rows at which the command of any element switches, shape (n,): the first of a run of rows that have moved.

    A switch: the command moves by more than a tenth of its range within 2 ms (or from one row to the next). The field
    of a log that follows another, or of rows behind a gap, is no switch: nobody saw the command move.
    """
    within = max(1, round(_WITHIN / period_of(rows)))
    count = rows.data.rows
    switch = np.zeros(count, np.bool_)
    for element in rows.data.elements:
        reach = float(np.ptp(element.field)) or 1.0
        step = np.abs(element.field[within:] - element.field[:-within])
        jump = np.zeros(count, np.bool_)
        jump[within:] = step > _STEP * reach
        for span in rows.data.clock.spans:
            jump[span.start : span.start + within] = False
        switch[1:] |= jump[1:] & ~jump[:-1]
    return switch


def after_switch(rows: RunRows, models: Sequence[str]) -> AfterSwitch | None:
    """RMSE over the time since a switch; None where the command switches too seldom for it, see `switches_of`."""
    period = period_of(rows)
    within = max(1, round(_WITHIN / period))
    switch = switches_of(rows)

    # Seconds since the last switch in the same stretch; nan where there was none yet.
    of_switches = np.where(switch, np.arange(rows.data.rows), -1)
    last = np.maximum.accumulate(of_switches)
    time = rows.data.clock.time
    since = np.where(last >= 0, time - time[last], np.nan)
    # A gap hides switches: what was before it does not count behind it.
    for span in rows.data.clock.spans:
        own = slice(span.start, span.stop)
        lost = last[own] < span.start + within
        since[own][lost] = np.nan
    test = rows.test & np.isfinite(since)
    switches = int(np.count_nonzero(rows.test & (since == 0.0)))
    if switches < _FEWEST:
        return None
    longest = float(np.quantile(since[test], 0.98)) / period
    even = np.geomspace(1.0, longest + 1.0, 25)
    ticks = np.unique(np.round(even).astype(int))
    if ticks.size < 5:
        return None
    # Bins of whole periods: 0, 1, 2, 3 and 4, ...
    edges = (ticks - 1.5) * period
    bins = edges.size - 1
    of_rows = np.searchsorted(edges, since[test], "right") - 1
    inside = of_rows < bins
    of_rows = of_rows[inside]
    counts = np.bincount(of_rows, minlength=bins)[:bins]
    rmse: dict[str, Array] = {}
    for model in models:
        residual = rows.residual(model)[test][inside]
        squares = np.bincount(of_rows, residual**2, minlength=bins)[:bins]
        rmse[model] = np.sqrt(squares / np.maximum(counts, 1))
    middles = 0.5 * (ticks[1:] + ticks[:-1] - 3) * period  # [s]
    return AfterSwitch(switches, middles, counts, rmse)


def step_responses(body: Mapping[str, Any], models: Sequence[str]) -> tuple[StepResponse, ...]:
    """Step responses of those models whose stages on the command take time or keep a share, from run.json."""
    responses: list[StepResponse] = []
    for entry in body["ranking"]:
        response = step_response(entry) if entry["name"] in models else None
        if response is not None and (response.settled >= _AT_ONCE or response.kept_back):
            responses.append(response)
    return tuple(responses)


def step_response(
    entry: Mapping[str, Any], places: Sequence[Place] = ("command",)
) -> StepResponse | None:
    """How the stages of a model at some places follow a step; None where there is none."""
    on_command = [stage for stage in stages_in(entry) if stage.place in places]
    if not on_command:
        return None
    # The time is made longer until the last quarter of the response stands still. Iron keeps a share for ever.
    last_quarter = slice(-_POINTS // 4, None)
    horizon = _SHORTEST
    while True:
        time = np.linspace(0.0, horizon, _POINTS)
        period = horizon / (time.size - 1)  # [s]
        clock = Clock(time, (Span(0, time.size, period),))
        # The command steps in the second row.
        rising: Array = np.minimum(np.arange(time.size, dtype=np.float64), 1.0)
        falling: Array = 1.0 - rising
        for stage in on_command:
            parameters = list(stage_values(entry, stage).values())
            rising = np.asarray(stage.respond(rising, clock, parameters, slice(None)))
            falling = np.asarray(stage.respond(falling, clock, parameters, slice(None)))
        response = StepResponse(str(entry["name"]), time, rising, falling)
        # Before a dead time is over everything stands still, and nothing of the step has come.
        has_come = bool(response.rising[-1] > _SOME_OF_A_STEP)
        rise_left = np.abs(response.rising[-1] - response.rising[last_quarter]).max()
        fall_left = np.abs(response.falling[-1] - response.falling[last_quarter]).max()
        if (max(rise_left, fall_left) < _STILL and has_come) or horizon > _LONGEST:
            return response
        horizon *= 1.5
