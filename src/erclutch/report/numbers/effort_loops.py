"""Effort runs around a loop over slip where the device remembers: periods of the motion, measured and modelled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.report.numbers.correlation import spans_inside
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array, rms
from erclutch.signals.device import largest_field

Rows = NDArray[np.intp]

_RESTLESS = 0.1  # share of the largest field by which a steady field may move in a window
_DEAD = 0.2  # share of the RMS slip within which a change of sign is noise
_FEWEST_ROWS = 12  # of a period
_FEWEST_PERIODS = 5  # before anything is said of all loops
_LEVELS = 3
_POINTS = 300  # of a curve that is drawn
_OTHER = 0.1  # share of the largest field below which the other clutch of a pair is free


@dataclass(frozen=True)
class EffortLoop:
    """A few periods of the motion of one element, at nearly one field.

    Attributes:
        element: its number, from 0.
        held: whether the rows were held out.
        log: its name, where there are several.
        start: time of the first row in s.
        fields: smallest and largest magnitude of the field.
        slip: shape (n,).
        travel: the slip summed up over the window, around the middle of its range, shape (n,).
        measured: effort, shape (n,).
        modelled: effort by model, each (n,).
    """

    element: int
    held: bool
    log: str
    start: float
    fields: tuple[float, float]
    slip: Array
    travel: Array
    measured: Array
    modelled: Mapping[str, Array]


@dataclass(frozen=True)
class LoopAreas:
    """How wide loops of effort over slip are, over all periods held out in which the field hardly moves.

    Attributes:
        periods: how many.
        measured: area of the measured loops as a share of the boxes around them; the sign is that of the usual loop.
        drawn: share of that area that each model draws.
    """

    periods: int
    measured: float
    drawn: Mapping[str, float]


@dataclass(frozen=True)
class _Periods:
    """Windows of an element: first rows, rows behind the last ones, whether they are held out."""

    starts: Rows
    stops: Rows
    held: NDArray[np.bool_]


def effort_loops(rows: RunRows, models: Sequence[str]) -> list[EffortLoop]:
    """Windows of a few periods, one for each of a few fields, weak fields first; empty where the slip never turns.

    Rows held out come first; a field that was not held out is shown on training rows.
    """
    largest = largest_field(rows.data.elements) or 1.0
    loops: list[EffortLoop] = []
    for element in range(len(rows.data.elements)):
        windows = _windows(rows, element, 2)
        restless = True
        if windows.starts.size:
            field = np.abs(rows.data.elements[element].field)
            moves = _reach(field, windows.starts, windows.stops) / largest
            restless = bool(np.median(moves) > _RESTLESS)
        if restless:  # shorter windows have a steadier field
            windows = _windows(rows, element, 1)
        for place in _chosen(rows, element, windows, largest):
            start = int(windows.starts[place])
            stop = int(windows.stops[place]) + 1
            own = rows.data.elements[element]
            time = rows.data.clock.time[start:stop]
            field = np.abs(own.field[start:stop])
            slip = own.slip[start:stop]
            steps = 0.5 * (slip[1:] + slip[:-1]) * np.diff(time)
            travel = np.concatenate([[0.0], np.cumsum(steps)])
            travel -= 0.5 * (travel.min() + travel.max())
            # Few enough points to be drawn.
            even = np.linspace(0, slip.size - 1, min(slip.size, _POINTS))
            few = np.unique(even.round().astype(np.intp))
            logs = zip(rows.data.sources, rows.data.source_rows, strict=True)
            log = next(name for name, (_, end) in logs if start < end)
            loop = EffortLoop(
                element=element,
                held=bool(windows.held[place]),
                log=log if len(rows.data.sources) > 1 else "",
                start=float(time[0]),
                fields=(float(field.min()), float(field.max())),
                slip=slip[few],
                travel=travel[few],
                measured=rows.data.effort[start:stop][few],
                modelled={name: rows.predicted[name][start:stop][few] for name in models},
            )
            loops.append(loop)
    return loops


def loop_areas(rows: RunRows, models: Sequence[str]) -> LoopAreas | None:
    """Areas of the loops over slip of the periods held out at a steady field; None where there are few.

    A field that moves draws loops too, which are no memory of the slip.
    """
    efforts = [rows.data.effort, *(rows.predicted[name] for name in models)]
    largest = largest_field(rows.data.elements)
    areas = np.zeros(len(efforts))  # of the measured loops, then of each model's
    boxes = 0.0
    periods = 0
    for element, own in enumerate(rows.data.elements):
        windows = _windows(rows, element, 1)
        moves = _reach(np.abs(own.field), windows.starts, windows.stops)
        usable = windows.held & (moves <= _RESTLESS * largest)
        starts = windows.starts[usable]
        stops = windows.stops[usable]
        if not starts.size:
            continue
        widths = _reach(own.slip, starts, stops)
        heights = _reach(rows.data.effort, starts, stops)
        boxes += float(np.sum(widths * heights))
        for place, effort in enumerate(efforts):
            # Signed area around which effort runs over slip in each window, the last row joined to the first.
            slip = own.slip
            middles = 0.5 * (effort[1:] + effort[:-1])
            strips = middles * np.diff(slip)
            sums = np.concatenate([[0.0], np.cumsum(strips)])
            closing_middle = 0.5 * (effort[starts] + effort[stops])
            closing = closing_middle * (slip[starts] - slip[stops])
            areas_of_windows = sums[stops] - sums[starts] + closing
            areas[place] += float(np.sum(areas_of_windows))
        periods += starts.size
    measured, *modelled = areas
    if periods < _FEWEST_PERIODS or not boxes or not measured:
        return None
    drawn = {name: float(area / measured) for name, area in zip(models, modelled, strict=True)}
    return LoopAreas(periods, abs(float(measured)) / boxes, drawn)


def _windows(rows: RunRows, element: int, periods: int) -> _Periods:
    """All windows of so many periods in which the other element of a pair is without field."""
    elements = rows.data.elements
    slip = elements[element].slip
    dead = _DEAD * rms(slip)
    starts: list[Rows] = []
    stops: list[Rows] = []
    held: list[NDArray[np.bool_]] = []
    for is_held in (True, False):
        for span in spans_inside(rows, rows.test == is_held):
            # Rows at which the slip, about its mean, turns from negative to positive; a small slip does not turn.
            own = slip[span.start : span.stop]
            own = own - own.mean()
            beyond = np.flatnonzero(np.abs(own) > dead)
            large = own[beyond]
            up = np.flatnonzero((large[:-1] < 0.0) & (large[1:] > 0.0))
            turns = beyond[up + 1] + span.start
            if turns.size > periods:
                starts.append(turns[:-periods])
                stops.append(turns[periods:])
                held.append(np.full(turns.size - periods, is_held))
    if not starts:
        return _Periods(
            starts=np.zeros(0, np.intp),
            stops=np.zeros(0, np.intp),
            held=np.zeros(0, np.bool_),
        )

    first = np.concatenate(starts)
    last = np.concatenate(stops)
    keep = last - first >= periods * _FEWEST_ROWS
    largest = largest_field(elements)
    for place, other in enumerate(elements):
        if place != element:
            is_busy = np.abs(other.field) > _OTHER * largest
            busy_before = np.concatenate([[0], np.cumsum(is_busy)])  # rows before each row
            keep &= busy_before[last] == busy_before[first]
    return _Periods(first[keep], last[keep], np.concatenate(held)[keep])


def _chosen(
    rows: RunRows,
    element: int,
    windows: _Periods,
    largest: float,
) -> list[int]:
    """For each of a few fields the window with the steadiest field near it and at least the usual motion."""
    if not windows.starts.size:
        return []
    own = rows.data.elements[element]
    field = np.abs(own.field)
    starts = windows.starts
    stops = windows.stops
    mean_field = _mean(field, starts, stops)
    spread = _reach(field, starts, stops) / largest
    mean_square = _mean(own.slip * own.slip, starts, stops)
    lively = mean_square >= np.median(mean_square)
    weakest = float(mean_field.min())
    strongest = float(mean_field.max())
    targets = np.linspace(weakest, strongest, _LEVELS)
    chosen: list[int] = []
    for target in targets:
        # Rows held out first, where they have such a field.
        off_target = np.abs(mean_field - target) / largest
        price = spread + off_target + 0.25 * ~windows.held + 1.0 * ~lively
        best = int(np.argmin(price))
        # Windows of nearly one field would tell the same twice.
        apart = [abs(mean_field[best] - mean_field[other]) > 0.05 * largest for other in chosen]
        if best not in chosen and all(apart):
            chosen.append(best)
    return chosen


def _mean(values: Array, starts: Rows, stops: Rows) -> Array:
    """Mean value of each window."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    return (total[stops] - total[starts]) / (stops - starts)


def _reach(values: Array, starts: Rows, stops: Rows) -> Array:
    """Largest less smallest value of each window."""
    reach: Array = np.empty(starts.size)
    for window, (start, stop) in enumerate(zip(starts.tolist(), stops.tolist(), strict=True)):
        reach[window] = np.ptp(values[start : stop + 1])
    return reach
