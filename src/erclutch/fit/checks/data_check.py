"""Data are checked before a fit: this module says what they can support before any number is printed.

An error stops the fit; a warning means that figures may mislead; a note is good to know.
"""

from __future__ import annotations

from collections.abc import Iterator
from re import compile as pattern

import numpy as np

from erclutch.errors import CheckError
from erclutch.fit.checks.effort_and_slip import effort_against_slip
from erclutch.fit.checks.finding import Finding
from erclutch.fit.checks.releasing_field import releasing_field
from erclutch.fit.checks.sensor_check import sensor_findings
from erclutch.fit.checks.unlike_logs import unlike_logs
from erclutch.fit.training_range import range_of
from erclutch.logs.clock.resample import RESAMPLED
from erclutch.logs.covering_stretches import USUAL_SHARE
from erclutch.logs.dataset import STEADY, Dataset
from erclutch.logs.held_out import hold_out
from erclutch.logs.plan import THOUGH
from erclutch.signals.array import Array, Mask, noise_of
from erclutch.signals.device import largest_field
from erclutch.signals.percent import percent
from erclutch.signals.recording import NO_FIELD
from erclutch.signals.units import amount

#: Subject of the finding that the rows held out have a single field.
ONE_FIELD = "one field"
#: Subject of the finding that all rows have a single field.
STEADY_FIELD = "field"

#: Rows to train on, below which nothing is fitted. A point of a table is a mean of many such rows.
_FEWEST_ROWS = 50
_FEWEST_POINTS = 12
#: Shares of the rows that few rows may hold out in place of the usual one.
_SMALLER_SHARES = (0.25, 0.2, 0.15, 0.1)
#: A field, over the largest, below which it is none.
_NO_FIELD = 1e-6
#: How a note of a recording says that a column's unit was given, and which the file has.
_UNIT_GIVEN = pattern(rf"(\w+) <- column (.+) \[(.+?)\].*, {THOUGH} (.+) \(")
#: Standard deviations within which all rows of a noise lie.
_NOISE_WITHIN = 12.0
#: Of the largest field: a field that moves by more is no noise about a level.
_NOISE_AT_MOST = 0.05
#: Of the largest slip, up to which rows are at rest.
_RESTS = 0.05
#: Of a slip, by which a speed that a drive holds wanders.
_SAME_SLIP = 0.01
#: Of the rows that move: the others are starts and stops.
_MOST = 0.9
#: A motion that has at least this share of its rows in either direction goes to and fro.
_TO_AND_FRO = 0.2
#: Such a motion drifts where its trend is so many times its swing.
_RUNS_AWAY = 3.0
#: Changes of the slip's sign within a stretch without a gap, below which it has no swing: two swings.
_FEWEST_TURNS = 4
#: Values of a slip up to which it is counted in steps.
_FEW_LEVELS = 64
#: Share of the rows held out that no training row comes near, from which that is told.
_UNCOVERED = 0.01
#: Share of the rows held out that are at rest from which that is told.
_MOSTLY_AT_REST = 0.6


def check(data: Dataset, test: Mask) -> tuple[Finding, ...]:
    """Look at a data set before it is fitted.

    Args:
        data: all rows.
        test: mask of the rows that are held out.

    Raises:
        CheckError: too few rows, slip or effort that do not vary, or a field that varies in the rows held out alone.
    """
    train = data.take(~test)
    if train.rows < fewest_rows(train):
        raise CheckError(
            f"{train.rows} rows to train on, at least {fewest_rows(train)} are needed",
            where=data.where,
            remedy="Log for longer, or hold out less with --test",
        )
    if train.one_field and not data.one_field:
        raise CheckError(
            f"the field is constant at {field_text(train)} over {train.rows} training rows, and only the rows held out "
            "have others",
            where=data.where,
            remedy="Hold out other rows with --test, so that the fit sees several fields",
        )
    require_change(train, "training ")
    findings = (
        *_as_read(data),
        *_fields(data),
        releasing_field(data),
        _one_slip(train),
        _drift(data),
        effort_against_slip(train),
        _quantised(train),
        *_held_out(train, data, test),
        *_never_seen(train),
        *unlike_logs(data),
        *sensor_findings(data),
    )
    return tuple(finding for finding in findings if finding is not None)


def fewest_rows(data: Dataset) -> int:
    """Rows to train on, below which nothing is fitted: fewer where they are points of a table."""
    return _FEWEST_POINTS if data.in_no_time else _FEWEST_ROWS


def smaller_share(data: Dataset) -> float | None:
    """What few rows may hold out at most: None for the usual share, 0 where none leaves enough to train on."""
    for share in (None, *_SMALLER_SHARES):
        held = hold_out(data, share or USUAL_SHARE)
        if data.rows - int(held.sum()) >= fewest_rows(data):
            return share
    return 0.0


def steady_command(train: Dataset) -> bool:
    """Whether the field never changes inside any stretch of rows: then no lag can be identified.

    A measured current that keeps its level changes by its noise.
    """
    for element in train.elements:
        largest = float(np.abs(element.field).max())
        for span in train.clock.spans:
            field = element.field[span.start : span.stop]
            noise = min(_NOISE_WITHIN * noise_of(field), _NOISE_AT_MOST * largest)
            if np.ptp(field) > max(STEADY * largest, noise):
                return False
    return True


def field_text(data: Dataset) -> str:
    """The first field of each element, with its unit."""
    return " and ".join(f"{element.field[0]:g}{_field_unit(data)}" for element in data.elements)


def _field_unit(data: Dataset) -> str:
    """The unit of the field behind a space; nothing where it is unknown."""
    return f" {data.units.field}" if data.units.field not in ("", "?") else ""


def require_change(data: Dataset, part: str = "") -> None:
    """Stop where nothing can be fitted: the effort does not change, or the slip does not and nothing else changes.

    A brake that turns at one speed while its field is switched tells how the effort follows the field.

    Args:
        data: the rows that a fit would have.
        part: what stands in front of "rows" in an error, such as "training ".

    Raises:
        CheckError: the effort is constant, or the slip is while the field is constant too or nothing moves.
    """
    slips = np.concatenate([element.slip for element in data.elements])
    field_tells = not data.one_field and bool(slips.any())
    for name, values in (("slip", slips), ("effort", data.effort)):
        if _is_constant(values) and not (name == "slip" and field_tells):
            raise CheckError(
                f"the {name} is constant at {values[0]:g} over {data.rows} {part}rows",
                where=data.where,
                remedy=f"Check that the right column is mapped to {name}",
            )


def _is_constant(values: Array) -> bool:
    """Whether all values are the same but for rounding."""
    return bool(np.ptp(values) <= 1e-12 * (abs(float(values[0])) + 1e-300))


def _as_read(data: Dataset) -> Iterator[Finding]:
    """How the logs were read: not as their files say, at another rate than their own, at several rates."""
    # All numbers hang on a unit or a rate that was given.
    for note in dict.fromkeys(note for note in data.notes if THOUGH in note):
        message = note
        of_a_signal = _UNIT_GIVEN.match(note)
        if of_a_signal:
            signal, column, unit, own = of_a_signal.groups()
            message = f"the {signal} is read in {unit}, {THOUGH} {own} (column {column})"
        remedy = "Check which is right; leave the option out to take what the file says"
        yield Finding("warning", "given", message, remedy)

    notes = [note for note in data.notes if note.startswith(RESAMPLED)]
    if notes:
        more = f" (and {len(notes) - 1} other ways)" if len(notes) > 1 else ""
        remedy = "Fit the log at its own rate to compare"
        yield Finding("note", "rate", f"logs were {notes[0]}{more}", remedy)

    # Laws and stages count in seconds, but each row weighs the same.
    slow, fast = data.rates
    if slow != fast:
        message = (
            f"the logs were sampled at {slow:.6g} to {fast:.6g} Hz: a second of the fastest weighs more in the fit, "
            f"and an export is called every {data.period:.6g} s unless --period says otherwise"
        )
        remedy = f"Bring all logs to one rate, for example --resample {slow:.4g}"
        yield Finding("note", "rate", message, remedy)


def _fields(data: Dataset) -> Iterator[Finding]:
    """One field in all rows, or rows of a pair in which both clutches are under field."""
    if data.one_field:
        if any(NO_FIELD in note for note in data.notes):
            seen = "the log has no field"
            unknown = "how the effort depends on the field, nor which field this was"
        else:
            seen = f"the field is {field_text(data)} in all {data.rows} rows"
            unknown = "the effort at any other field, nor how fast it follows a command"
        message = f"{seen}: models are fitted without field terms and cannot know {unknown}"
        remedy = "Log with a changing field to learn it, or give logs at several"
        yield Finding("warning", STEADY_FIELD, message, remedy)

    if len(data.elements) < 2:
        return
    first, second = (np.abs(element.field) for element in data.elements)
    first_on = first > _NO_FIELD * first.max()
    second_on = second > _NO_FIELD * second.max()
    under_both = first_on & second_on
    count = int(np.count_nonzero(under_both))
    if count:
        share = percent(count / data.rows, 1)
        message = f"both clutches are under field in {count} rows ({share})"
        remedy = "Command one clutch at a time, as the models assume (section III of the paper)"
        yield Finding("warning", "fields", message, remedy)


def _one_slip(train: Dataset) -> Finding | None:
    """A slip that never changes, or that rests where it is not at one level: its share of the effort cannot be told."""
    slips = np.concatenate([element.slip for element in train.elements])
    sizes = np.abs(slips)
    moving = sizes[sizes > _RESTS * sizes.max()]
    if _is_constant(slips):
        where = f"{slips[0]:.4g} {train.units.slip} in all rows"
    elif np.mean(np.abs(moving - np.median(moving)) <= _SAME_SLIP * np.median(moving)) >= _MOST:
        where = f"0 or {np.median(moving):.4g} {train.units.slip} in nearly all rows"
    else:
        return None
    message = (
        f"the slip is {where}: no model knows the effort at any other slip, and "
        "which part of it depends on the slip"
    )
    return Finding("warning", "slip", message, "Log at several slips to learn it")


def _drift(data: Dataset) -> Finding | None:
    """A slip to and fro whose sum runs away over a stretch: a position, or a sensor's zero, that drifts."""
    for element in data.elements:
        for span in data.clock.spans:
            slip = element.slip[span.start : span.stop]
            time = data.clock.time[span.start : span.stop]
            forth = np.mean(slip > 0)  # share of the rows
            back = np.mean(slip < 0)
            if min(forth, back) < _TO_AND_FRO:
                continue
            signs = np.sign(slip)
            turns = np.count_nonzero(np.diff(signs))
            if turns < _FEWEST_TURNS:
                continue  # the few rows between two gaps are a straight line, which swings by nothing
            position = np.cumsum(slip * np.gradient(time))
            trend = np.polynomial.Polynomial.fit(time, position, 1)
            off_trend = position - trend(time)
            swing = float(np.ptp(off_trend))
            across = trend(time[-1]) - trend(time[0])
            drift = abs(float(across))
            if drift > _RUNS_AWAY * swing:
                unit = (
                    f" {data.units.slip.removesuffix('/s')}"
                    if data.units.slip.endswith("/s")
                    else ""
                )
                message = (
                    f"the position drifts by {drift:.3g}{unit} in {time[-1] - time[0]:.3g} s while it swings by "
                    f"{swing:.3g}{unit}: a constant part of the slip may be the sensor's"
                )
                remedy = "Check the sensor's zero, and take the drift out of the log"
                return Finding("warning", "drift", message, remedy)
    return None


def _quantised(train: Dataset) -> Finding | None:
    """A slip of few values: the difference of an encoder's counts."""
    for element in train.elements:
        # Of millions of values that would take seconds: most slips have many values among the first rows.
        if np.unique(element.slip[:10_000]).size > _FEW_LEVELS:
            continue
        levels = np.unique(element.slip)
        if 2 < levels.size <= _FEW_LEVELS < train.rows / 10:
            step = float(np.median(np.diff(levels)))
            message = (
                f"the slip takes only {levels.size} values, {step:g} apart: a differenced encoder"
            )
            return Finding(
                "warning", "slip", message, "Map the position and try --derivative kalman or savgol"
            )
    return None


def _held_out(train: Dataset, data: Dataset, test: Mask) -> Iterator[Finding]:
    """Why the rows held out may say little of a model: one field, places without training rows, or rest."""
    # Rows at a single field cannot rank models of what a field does.
    fields = np.concatenate([element.field[test] for element in data.elements])
    same = STEADY * largest_field(data.elements)
    trained_on_several = any(np.ptp(element.field) > same for element in train.elements)
    if fields.size and np.ptp(fields) <= same and trained_on_several:
        message = (
            f"all rows held out have the same field, {fields[0]:g}{_field_unit(data)}, so they do not test how the "
            "effort depends on it"
        )
        remedy = "Hold out rows at several fields with --test"
        yield Finding("warning", ONE_FIELD, message, remedy)

    # Rows that every model fitted to the training rows will call outside.
    outside = range_of(train).outside(data.take(test))
    share = float(outside.mean()) if outside.size else 0.0
    if share >= _UNCOVERED:
        message = f"{percent(share, 1)} of the test rows have a field and slip that no training row comes near"
        remedy = (
            "Figures there are inter- or extrapolated: log those fields and slips too, or hold out "
            "other rows with --test"
        )
        yield Finding("warning", "coverage", message, remedy)

    # At rest every model is right; that matters where far more of these rows rest than of the training rows.
    if not test.any():
        return
    resting = float(np.mean(data.at_rest[test]))
    others = float(np.mean(data.at_rest[~test]))
    if resting >= _MOSTLY_AT_REST and others <= 0.5 * resting:
        message = (
            f"{percent(resting)} of the rows held out are at rest, of the others {percent(others)}: they say little of "
            "any model"
        )
        remedy = "Hold out stretches that are like the whole log: --test stretches"
        yield Finding("warning", "rest", message, remedy)


def _never_seen(train: Dataset) -> Iterator[Finding]:
    """What the training rows never have: no field, one of the two directions, a field above zero."""
    for element in train.elements:
        strength = np.abs(element.field)
        if not train.one_field and float(strength.min()) > 0.05 * float(strength.max()):
            least = amount(f"{strength.min():g}", train.units.field)
            message = (
                f"the field never falls below {least}, so effort at zero field is extrapolated"
            )
            yield Finding("note", "coverage", message, "Log some time without field")
            break

    if train.one_way and not any(_is_constant(element.slip) for element in train.elements):
        ends = " and ".join(
            f"{element.slip.min():.4g} to {element.slip.max():.4g}" for element in train.elements
        )
        message = (
            f"the slip keeps its sign ({amount(ends, train.units.slip)}): effort near rest and in reverse is "
            "extrapolated"
        )
        yield Finding("note", "coverage", message, "Log some time in both directions")

    largest = float(train.elements[0].field.max())
    if train.device == "single" and not train.one_field and not largest > 0.0:
        message = (
            "the field is never above zero, and a model's inverse looks for fields from zero up"
        )
        remedy = "Turn its sign, for example --field '-NAME [unit]'"
        yield Finding("warning", "field", message, remedy)
