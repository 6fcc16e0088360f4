"""Data are checked before a fit: this module says what they can support before any number is printed.

An error stops the fit; a warning means that figures may mislead; a note is good to know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from re import compile as pattern
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import CheckError, shell_word, worded
from erclutch.fit.training_range import range_of
from erclutch.logs.dataset import Dataset
from erclutch.logs.resample import RESAMPLED
from erclutch.signals.array import Array
from erclutch.signals.recording import NO_FIELD

#: Subject of the finding that the rows held out have a single field.
ONE_FIELD = "one field"

#: Share of the rows held out that are at rest from which that is told.
_MOSTLY = 0.6

#: Subject of the finding that effort opposes slip.
SIGN = "sign"

#: Subject of the finding that all rows have a single field.
STEADY_FIELD = "field"

_FEWEST_ROWS = 50
_COLUMN = pattern(r"(\w+) <- column (.+?)(?:, .*| \(the file says .*)? \([^()]*\)")
#: A motion that has at least this share of its rows in either direction goes to and fro.
_TO_AND_FRO = 0.2
#: Such a motion drifts where its trend is so many times its swing.
_RUNS_AWAY = 3.0

_AROUND = 5  # rows: that and the two on either side; a step is none of its spikes
_SPIKE, _SPIKE_SHARE, _FEW_SPIKES = 30.0, 0.25, 0.005  # of the usual distance; of the range; of all rows
#: Of what devices have, from small to large ones: the largest slip and effort in such a log, by unit.
_USUAL = {"m/s": (1e-5, 20.0), "rad/s": (1e-4, 2e3), "N": (1e-3, 1e6), "N*m": (1e-6, 1e5)}
#: Units of effort and slip of which one is of a turning device and the other of a device on a line.
_NO_POWER = {("N", "rad/s"), ("N*m", "m/s")}
_STUCK_ROWS, _STUCK, _MOVES = 50, 20.0, 0.2  # rows; times the longest usual run; of the range of the other side


@dataclass(frozen=True)
class Finding:
    """One thing that a check saw.

    Attributes:
        level: "warning" or "note".
        subject: what it is about.
        message: what was seen, with value and limit.
        remedy: what to do.
    """

    level: Literal["warning", "note"]
    subject: str
    message: str
    remedy: str

    def __str__(self) -> str:
        return worded(f"{self.message}. {self.remedy}.")


def check(data: Dataset, test: NDArray[np.bool_]) -> tuple[Finding, ...]:
    """Look at a data set before it is fitted.

    Args:
        data: all rows.
        test: mask of the rows that are held out.

    Raises:
        CheckError: too few rows, slip or effort that do not vary, or a field that varies in the rows held out alone.
    """
    train = data.take(~test)
    _must_vary(train, data)
    checks: tuple[Callable[[], Finding | None], ...] = (
        lambda: _resampled(data),
        lambda: _rates(data),
        lambda: _steady_field(data),
        lambda: _both_fields(data),
        lambda: _drift(data),
        lambda: _sign(train),
        lambda: _quantised(train),
        lambda: _one_field(train, data, test),
        lambda: _coverage(train, data, test),
        lambda: _resting(data, test),
        lambda: _zero_field(train),
        lambda: _one_way(train),
        lambda: _negative_field(train),
        lambda: _unlike(data),
    )
    return (*(finding for finding in (look() for look in checks) if finding is not None), *sensor_findings(data))


def sensor_findings(data: Dataset) -> tuple[Finding, ...]:
    """What does not belong to a measurement: magnitudes of no device, spikes, a sensor that is saturated or stuck.

    Args:
        data: the rows; a spike or a stuck sensor is looked for in the effort and the slips.
    """
    signals = [("effort", data.effort), *(("slip", e.slip) for e in data.elements)]
    found = [
        *_implausible(data),
        _saturation(data),
        *(_spikes(data, *each) for each in signals),
        *(_stuck(data, *each) for each in signals),
    ]
    return tuple(finding for finding in found if finding is not None)


def steady_command(train: Dataset) -> bool:
    """Whether the field never changes inside any stretch of rows: then no lag can be identified."""
    moves = (
        np.ptp(e.field[s.start : s.stop]) > 1e-6 * np.abs(e.field).max()
        for e in train.elements
        for s in train.clock.spans
    )
    return not any(moves)


def _must_vary(train: Dataset, data: Dataset) -> None:
    where = data.where
    if train.rows < _FEWEST_ROWS:
        raise CheckError(
            f"{train.rows} rows to train on, at least {_FEWEST_ROWS} are needed",
            where=where,
            remedy="Log for longer, or hold out less with --test",
        )
    if train.one_field and not data.one_field:
        raise CheckError(
            f"the field is constant at {field_text(train)} over {train.rows} training rows, and only the rows held out "
            "have others",
            where=data.where,
            remedy="Hold out other rows with --test, so that the fit sees several fields",
        )
    for name, values in (("slip", np.concatenate([e.slip for e in train.elements])), ("effort", train.effort)):
        if np.ptp(values) <= 1e-12 * (abs(float(values[0])) + 1e-300):
            raise CheckError(
                f"the {name} is constant at {values[0]:g} over {train.rows} training rows",
                where=where,
                remedy=f"Check that the right column is mapped to {name}",
            )


def field_text(data: Dataset) -> str:
    """The first field of each element, with its unit."""
    unit = data.units.field if data.units.field not in ("", "?") else ""
    return " and ".join(f"{e.field[0]:g} {unit}".strip() for e in data.elements)


def _resampled(data: Dataset) -> Finding | None:
    """Logs that were brought to another rate."""
    notes = [note for note in data.notes if note.startswith(RESAMPLED)]
    if not notes:
        return None
    more = f" (and {len(notes) - 1} other ways)" if len(notes) > 1 else ""
    return Finding("note", "rate", f"logs were {notes[0]}{more}", "Fit the log at its own rate to compare")


def _rates(data: Dataset) -> Finding | None:
    """Logs at different rates: laws and stages count in seconds, but each row weighs the same."""
    slow, fast = data.rates
    if slow == fast:
        return None
    message = (
        f"the logs were sampled at {slow:.6g} to {fast:.6g} Hz: a second of the fastest weighs more in the fit, and an "
        f"export is called every {data.period:.6g} s unless --period says otherwise"
    )
    return Finding("note", "rate", message, f"Bring all logs to one rate, for example --resample {slow:.4g}")


def _steady_field(data: Dataset) -> Finding | None:
    """One field in all rows: models without field terms."""
    if not data.one_field:
        return None
    if any(NO_FIELD in note for note in data.notes):
        seen, unknown = "the log has no field", "how the effort depends on the field, nor which field this was"
    else:
        seen = f"the field is {field_text(data)} in all {data.rows} rows"
        unknown = "the effort at any other field, nor how fast it follows a command"
    message = f"{seen}: models are fitted without field terms and cannot know {unknown}"
    return Finding("warning", STEADY_FIELD, message, "Log with a changing field to learn it, or give logs at several")


def _both_fields(data: Dataset) -> Finding | None:
    if len(data.elements) < 2:
        return None
    first, second = (np.abs(e.field) > 1e-6 * np.abs(e.field).max() for e in data.elements)
    both = int(np.count_nonzero(first & second))
    if not both:
        return None
    message = f"both clutches are under field in {both} rows ({both / data.rows:.1%})"
    remedy = "Command one clutch at a time, as the models assume (section III of the paper)"
    return Finding("warning", "fields", message, remedy)


def _drift(data: Dataset) -> Finding | None:
    """A slip to and fro whose sum runs away over a stretch: a position, or a sensor's zero, that drifts."""
    for element in data.elements:
        for span in data.clock.spans:
            slip, time = element.slip[span.start : span.stop], data.clock.time[span.start : span.stop]
            if min(np.mean(slip > 0), np.mean(slip < 0)) < _TO_AND_FRO:
                continue
            position = np.cumsum(slip * np.gradient(time))
            trend = np.polynomial.Polynomial.fit(time, position, 1)
            swing, gone = float(np.ptp(position - trend(time))), abs(float(trend(time[-1]) - trend(time[0])))
            if gone > _RUNS_AWAY * swing:
                unit = data.units.slip.removesuffix("/s") if data.units.slip.endswith("/s") else ""
                message = (
                    f"the position drifts by {gone:.3g} {unit} in {time[-1] - time[0]:.3g} s while it swings by "
                    f"{swing:.3g} {unit}: a constant part of the slip may be the sensor's"
                )
                return Finding(
                    "warning", "drift", message, "Check the sensor's zero, and take the drift out of the log"
                )
    return None


def _sign(train: Dataset) -> Finding | None:
    """A passive element dissipates: effort and slip have the same sign on the whole."""
    # A sensor's zero makes no power over a motion to and fro; over a motion one way it cannot be told from friction.
    effort = train.effort if train.one_way else train.effort - np.mean(train.effort)
    power = sum(float(np.mean(effort * e.slip * _weight(e.field))) for e in train.elements)
    if power >= 0:
        return None
    name = "T" if train.device == "coaxial" else "effort"
    found = (match for note in train.notes if (match := _COLUMN.fullmatch(note)) and match[1] == name)
    label = next((("" if "sign turned" in match[0] else "-") + match[2] for match in found), "-NAME [unit]")
    sign = f"--{name} {shell_word(label)}"
    message = "effort opposes slip on average, so the device would deliver energy"
    return Finding("warning", SIGN, message, f"Turn a sign, for example {sign}")


def _weight(field: Array) -> Array:
    """The strength of the field, under which most power is dissipated; one for rows without any field."""
    strength = np.abs(field)
    most = float(strength.max())
    return strength + 1e-3 * most if most > 0.0 else np.ones_like(field)


def _saturation(data: Dataset) -> Finding | None:
    for end, name in ((float(np.max(data.effort)), "largest"), (float(np.min(data.effort)), "smallest")):
        share = float(np.mean(np.equal(data.effort, end)))
        if share > 0.005:
            message = f"{share:.1%} of the rows sit at the {name} effort, {end:g}: the sensor may be saturated"
            return Finding("warning", "effort", message, "Leave saturated rows out, or use a sensor with more range")
    return None


def _implausible(data: Dataset) -> Iterator[Finding]:
    """Magnitudes that no clutch, brake or damper has: most often the unit of a column is wrong."""
    slips = np.concatenate([e.slip for e in data.elements])
    for name, values, unit in (("slip", slips, data.units.slip), ("effort", data.effort, data.units.effort)):
        least, most = _USUAL.get(unit, (0.0, np.inf))
        largest = float(np.quantile(np.abs(values), 0.99))
        if not least <= largest <= most and largest > 0:
            limit = f"above the {most:g}" if largest > most else f"below the {least:g}"
            message = f"the {name} reaches {largest:.3g} {unit}, {limit} {unit} that such devices have"
            yield Finding("warning", name, message, "Check the column and its unit")
    if (data.units.effort, data.units.slip) in _NO_POWER:
        message = f"an effort in {data.units.effort} beside a slip in {data.units.slip} makes no power"
        yield Finding("warning", "units", message, "Check both units: a force goes with m/s, a torque with rad/s")


def _spikes(data: Dataset, name: str, values: Array) -> Finding | None:
    """Rows far from the median of the five around them, where such rows are few and all others are near it."""
    away = np.zeros(values.size)
    for span in data.clock.spans:
        part = values[span.start : span.stop]
        if part.size >= _AROUND:
            middle = np.median(np.lib.stride_tricks.sliding_window_view(part, _AROUND), axis=1)
            edge = _AROUND // 2
            away[span.start + edge : span.stop - edge] = np.abs(part[edge:-edge] - middle)
    low, high = np.quantile(values, (0.001, 0.999))
    rows = np.flatnonzero(away > max(_SPIKE * 1.4826 * float(np.median(away)), _SPIKE_SHARE * float(high - low)))
    rows = rows[(rows >= 4) & (rows < values.size - 4)] if rows.size <= _FEW_SPIKES * values.size else rows[:0]
    beside = values[rows[:, None] + np.array([-4, -3, -2, 2, 3, 4])]
    rows = rows[np.ptp(beside, axis=1) < 0.5 * away[rows]]  # ringing after a blow is no spike
    if not rows.size:
        return None
    many = f"{rows.size} row{'s' if rows.size > 1 else ''} of the {name} stand{'s' if rows.size == 1 else ''} out"
    message = f"{many} from the rows beside, the first at {data.clock.time[rows[0]]:.6g} s with {values[rows[0]]:.4g}"
    return Finding("warning", name, message, "Correct these rows, or empty their cells and give --invalid drop")


def _stuck(data: Dataset, name: str, values: Array) -> Finding | None:
    """A value that stays to the last digit, and is met nowhere else, while the other side of the device moves."""
    others = [data.effort] if name == "slip" else [e.slip for e in data.elements]
    cut = np.concatenate(([True], np.diff(values) != 0, [True]))
    cut[[span.stop for span in data.clock.spans]] = True
    starts = np.flatnonzero(cut)
    lengths = np.diff(starts)
    for place in np.argsort(-lengths)[:3].tolist():
        start, stop = int(starts[place]), int(starts[place + 1])
        if stop - start < max(_STUCK_ROWS, _STUCK * float(np.quantile(lengths, 0.99))):
            return None
        elsewhere = int(np.count_nonzero(values == values[start])) - (stop - start)
        moves = max(np.ptp(x[start:stop]) / max(float(np.ptp(x)), 1e-300) for x in others)
        resting = name == "slip" and bool(data.at_rest[start])
        if moves > _MOVES and 10 * elsewhere < stop - start and not resting:
            message = (
                f"the {name} stays at {values[start]:g} for {stop - start:,} rows from {data.clock.time[start]:.6g} s "
                f"on while the {'effort' if name == 'slip' else 'slip'} moves: its sensor may have been stuck"
            )
            return Finding(
                "warning", name, message, "Leave that stretch out with --from and --until, and check the sensor"
            )
    return None


def _quantised(train: Dataset) -> Finding | None:
    for element in train.elements:
        few = np.unique(element.slip[:10_000]).size <= 64  # of millions of values that would take seconds
        levels = np.unique(element.slip) if few else element.slip
        if 2 < levels.size <= 64 < train.rows / 10:
            step = float(np.median(np.diff(levels)))
            message = f"the slip takes only {levels.size} values, {step:g} apart: a differenced encoder"
            return Finding("warning", "slip", message, "Map the position and try --derivative kalman or savgol")
    return None


def _one_field(train: Dataset, data: Dataset, test: NDArray[np.bool_]) -> Finding | None:
    """Rows held out at a single field cannot rank models of what a field does."""
    held = np.concatenate([e.field[test] for e in data.elements])
    reach = 1e-6 * max(float(np.abs(e.field).max()) for e in data.elements)
    if not held.size or np.ptp(held) > reach or all(np.ptp(e.field) <= reach for e in train.elements):
        return None
    unit = f" {data.units.field}" if data.units.field not in ("", "?") else ""
    message = (
        f"all rows held out have the same field, {held[0]:g}{unit}, so they do not test how the effort depends on it"
    )
    return Finding("warning", ONE_FIELD, message, "Hold out rows at several fields with --test")


def _coverage(train: Dataset, data: Dataset, test: NDArray[np.bool_]) -> Finding | None:
    """Test rows that every model fitted to the training rows will call outside."""
    outside = range_of(train).outside(data.take(test))
    share = float(outside.mean()) if outside.size else 0.0
    if share < 0.01:
        return None
    message = f"{share:.1%} of the test rows have a field and slip that no training row comes near"
    remedy = (
        "Figures there are inter- or extrapolated: log those fields and slips too, or hold out other rows with --test"
    )
    return Finding("warning", "coverage", message, remedy)


def _resting(data: Dataset, test: NDArray[np.bool_]) -> Finding | None:
    """Rows held out that are at rest, where every model is right, and far more of them than of the training rows."""
    if not test.any():
        return None
    held, fitted = (float(np.mean(data.at_rest[rows])) for rows in (test, ~test))
    if held < _MOSTLY or fitted > 0.5 * held:
        return None
    message = f"{held:.0%} of the rows held out are at rest, of the others {fitted:.0%}: they say little of any model"
    return Finding("warning", "rest", message, "Hold out stretches that are like the whole log: --test stretches")


def _unlike(data: Dataset) -> Finding | None:
    """Logs whose efforts or slips are of another order: a unit taken for another."""
    if len(data.sources) < 2:
        return None
    for name, values in (("effort", data.effort), ("slip", data.elements[0].slip)):
        sizes = np.array([float(np.sqrt(np.mean(values[a:b] ** 2))) for a, b in data.source_rows])
        usual = float(np.median(sizes))
        odd = np.flatnonzero((sizes > 30.0 * usual) | (sizes < usual / 300.0))
        if odd.size and usual > 0:
            message = f"the {name} of {data.sources[odd[0]]} is {sizes[odd[0]]:.3g}, that of the usual log {usual:.3g}"
            return Finding("warning", name, message, f"Check the unit of the {name}")
    return None


def _negative_field(train: Dataset) -> Finding | None:
    if train.device != "single" or train.one_field or float(train.elements[0].field.max()) > 0.0:
        return None
    message = "the field is never above zero, and a model's inverse looks for fields from zero up"
    return Finding("warning", "field", message, "Turn its sign, for example --field '-NAME [unit]'")


def _one_way(train: Dataset) -> Finding | None:
    if not train.one_way:
        return None
    ends = " and ".join(f"{e.slip.min():.4g} to {e.slip.max():.4g}" for e in train.elements)
    message = f"the slip keeps its sign ({ends} {train.units.slip}): effort near rest and in reverse is extrapolated"
    return Finding("note", "coverage", message, "Log some time in both directions")


def _zero_field(train: Dataset) -> Finding | None:
    for element in () if train.one_field else train.elements:
        strength = np.abs(element.field)
        if float(strength.min()) > 0.05 * float(strength.max()):
            message = f"the field never falls below {strength.min():g}, so effort at zero field is extrapolated"
            return Finding("note", "coverage", message, "Log some time without field")
    return None
