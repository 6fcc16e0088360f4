"""What does not belong to a measurement is looked for: a wrong unit, a sensor saturated, spiked, stuck or too slow."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from erclutch.fit.checks.finding import Finding
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import SIGMA_OF_MAD, Array
from erclutch.signals.percent import percent

#: Of what devices have, from small to large ones: the largest slip and effort in such a log, by unit.
_USUAL = {
    "m/s": (1e-5, 20.0),
    "rad/s": (1e-4, 2e3),
    "N": (1e-3, 1e6),
    "N*m": (1e-6, 1e5),
}
#: Units of effort and slip of which one is of a device that turns, moves along a line or lets a fluid flow, and the
#: other of another.
_NO_POWER = {("N", "rad/s"), ("N*m", "m/s"), ("N", "m^3/s"), ("N*m", "m^3/s")}
#: Share of the rows at the very end of the effort's range from which its sensor may be saturated.
_SATURATED = 0.005
_FEWEST_SATURATED = 4  # rows: a table of points has one at its end

#: Rows of the median that a spike stands out from: that row and two on either side. A step is none of its spikes.
_AROUND = 5
#: How far a spike is from that median, over the usual distance of a row.
_SPIKE = 30.0
#: The same over the range of the values.
_SPIKE_OF_RANGE = 0.25
#: Share of all rows above which it is no matter of spikes.
_FEW_SPIKES = 0.005
#: Neighbours of a spike, in rows from it: they are alike, and in the ringing after a blow they are not.
_BESIDE = (-4, -3, -2, 2, 3, 4)
#: Rows from which a value that stays may be a sensor's that is stuck.
_STUCK_ROWS = 50
#: How many times longer it stays than values usually do.
_STUCK_RUN = 20.0
#: Share of its range by which the other side of the device moves meanwhile.
_MOVES = 0.2
#: Rows from which on a value that stays regularly is one of a slower sampling, held in between.
_HELD_ROWS = 3
#: Times that it changes, at least, share of them that are as far apart, and share that an encoder's count has at most.
_FEWEST_CHANGES = 30
_REGULAR = 0.8
_COUNTS = 0.5
#: Share of its rows in which the other side of the device changes, at least.
_ALWAYS = 0.7


def sensor_findings(data: Dataset) -> tuple[Finding, ...]:
    """What does not belong to a measurement: magnitudes of no device, spikes, a sensor saturated, stuck or too slow.

    Args:
        data: the rows; a spike, a stuck or a slow sensor is looked for in the effort and the slips.
    """
    signals = [("effort", data.effort)]
    for element in data.elements:
        signals.append(("slip", element.slip))
    findings = [
        *_ranges(data),
        *(_spikes(data, name, values) for name, values in signals),
        *(_stuck(data, name, values) for name, values in signals),
        *(_held(data, name, values) for name, values in signals),
    ]
    return tuple(finding for finding in findings if finding is not None)


def _ranges(data: Dataset) -> Iterator[Finding]:
    """Slips and efforts that no clutch, brake or damper has, and an effort that its sensor has cut off."""
    # Most often the unit of a column is wrong.
    slips = np.concatenate([element.slip for element in data.elements])
    looked_at = {"slip": (slips, data.units.slip), "effort": (data.effort, data.units.effort)}
    for name, (values, unit) in looked_at.items():
        least, most = _USUAL.get(unit, (0.0, np.inf))
        largest = float(np.quantile(np.abs(values), 0.99))
        if not least <= largest <= most and largest > 0:
            limit = f"above the {most:g}" if largest > most else f"below the {least:g}"
            message = (
                f"the {name} reaches {largest:.3g} {unit}, {limit} {unit} that such devices have"
            )
            yield Finding("warning", name, message, "Check the column and its unit")
    if (data.units.effort, data.units.slip) in _NO_POWER:
        message = (
            f"an effort in {data.units.effort} beside a slip in {data.units.slip} makes no power"
        )
        remedy = (
            "Check both units: a force goes with m/s, a torque with rad/s, a pressure with m^3/s"
        )
        yield Finding("warning", "units", message, remedy)

    # A sensor that is saturated has many rows at one end of its range.
    ends = {"largest": float(np.max(data.effort)), "smallest": float(np.min(data.effort))}
    if ends["largest"] == ends["smallest"]:
        return  # a log of commands alone: a fit refuses it
    for name, end in ends.items():
        at_end = np.count_nonzero(data.effort == end)
        share = at_end / data.rows
        if share > _SATURATED and at_end >= _FEWEST_SATURATED:
            message = f"{percent(share, 1)} of the rows sit at the {name} effort, {end:g}: the sensor may be saturated"
            remedy = "Leave saturated rows out, or use a sensor with more range"
            yield Finding("warning", "effort", message, remedy)
            return


def _spikes(data: Dataset, name: str, values: Array) -> Finding | None:
    """Rows far from the median of the five around them, where such rows are few and all others are near it."""
    away = np.zeros(values.size)  # from that median; rows at the ends of a stretch have none
    edge = _AROUND // 2
    for span in data.clock.spans:
        part = values[span.start : span.stop]
        if part.size >= _AROUND:
            median = np.median(sliding_window_view(part, _AROUND), axis=1)
            away[span.start + edge : span.stop - edge] = np.abs(part[edge:-edge] - median)

    low, high = np.quantile(values, (0.001, 0.999))
    usual = SIGMA_OF_MAD * float(np.median(away))
    spike = max(_SPIKE * usual, _SPIKE_OF_RANGE * float(high - low))
    rows = np.flatnonzero(away > spike)
    if rows.size > _FEW_SPIKES * values.size:
        return None
    most = max(_BESIDE)
    rows = rows[(rows >= most) & (rows < values.size - most)]
    beside = values[rows[:, None] + np.array(_BESIDE)]  # (rows, neighbours)
    rows = rows[np.ptp(beside, axis=1) < 0.5 * away[rows]]  # ringing after a blow is no spike
    if not rows.size:
        return None

    first = rows[0]
    many = "1 row" if rows.size == 1 else f"{rows.size} rows"
    stand = "stands" if rows.size == 1 else "stand"
    message = (
        f"{many} of the {name} {stand} out from the rows beside, the first at {data.clock.time[first]:.6g} s with "
        f"{values[first]:.4g}"
    )
    return Finding(
        "warning", name, message, "Correct these rows, or empty their cells and give --invalid drop"
    )


def _stuck(data: Dataset, name: str, values: Array) -> Finding | None:
    """A value that stays to the last digit, and is met nowhere else, while the other side of the device moves."""
    other, other_side = _other_side(data, name)
    starts = _starts_of_runs(data, values)
    lengths = np.diff(starts)
    usually = float(np.quantile(lengths, 0.99))
    long = max(_STUCK_ROWS, _STUCK_RUN * usually)

    for run in np.argsort(-lengths)[:3].tolist():  # the longest first
        start = int(starts[run])
        stop = int(starts[run + 1])
        count = stop - start
        if count < long:
            return None
        stays = values[start]
        elsewhere = int(np.count_nonzero(values == stays)) - count
        moves = 0.0  # share of its range by which the other side moves meanwhile
        for x in other_side:
            whole = max(float(np.ptp(x)), 1e-300)
            moves = max(moves, float(np.ptp(x[start:stop])) / whole)
        resting = name == "slip" and bool(data.at_rest[start])
        if moves > _MOVES and 10 * elsewhere < count and not resting:
            message = (
                f"the {name} stays at {stays:g} for {count:,} rows from {data.clock.time[start]:.6g} s on while the "
                f"{other} moves: its sensor may have been stuck"
            )
            remedy = "Leave that stretch out with --from and --until, and check the sensor"
            return Finding("warning", name, message, remedy)
    return None


def _held(data: Dataset, name: str, values: Array) -> Finding | None:
    """A value that changes in each tenth row, say, while the other side of the device changes in all: it comes late."""
    periods = [span.period for span in data.clock.spans if span.period]
    if not periods or len(periods) < len(data.clock.spans):
        return None  # points in no time
    lengths = np.diff(_starts_of_runs(data, values))
    if lengths.size < _FEWEST_CHANGES:
        return None
    rows = int(np.median(lengths))
    is_regular = float(np.mean(np.abs(lengths - rows) <= max(1, rows // 10))) >= _REGULAR
    if rows < _HELD_ROWS or not is_regular:
        return None
    # A slow course in counts of an encoder changes by one count, each time.
    steps: Array = np.abs(np.diff(values))
    rounded: Array = steps[steps > 0.0].round(9)
    different, counts = np.unique(rounded, return_counts=True)
    is_counted = different.size > 0 and counts.max() > _COUNTS * counts.sum()
    other, other_side = _other_side(data, name)
    shares = [np.count_nonzero(np.diff(each)) / each.size for each in other_side]
    goes_on = max(shares) >= _ALWAYS
    if is_counted or not goes_on:
        return None
    rate = 1.0 / (rows * periods[0])
    late = (rows - 1) * periods[0] / 2.0
    message = (
        f"the {name} changes once in {rows} rows, and the {other} in nearly all: it was sampled at {rate:.3g} Hz and "
        f"held in between, so that it is {late:.2g} s late in the mean"
    )
    return Finding(
        "warning", name, message, f"Log it as fast as the {other}, or give --resample {rate:.3g}"
    )


def _other_side(data: Dataset, name: str) -> tuple[str, list[Array]]:
    """What is measured on the other side of the power, and its values."""
    if name == "slip":
        return "effort", [data.effort]
    return "slip", [element.slip for element in data.elements]


def _starts_of_runs(data: Dataset, values: Array) -> NDArray[np.intp]:
    """First rows of the runs of one value, each within a stretch, and the number of rows behind them."""
    begins = np.concatenate(([True], np.diff(values) != 0, [True]))
    begins[[span.stop for span in data.clock.spans]] = True
    return np.flatnonzero(begins)
