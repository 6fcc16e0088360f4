"""A log without a field is read as such only where every column is known to be something else: this says why it is."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from erclutch.logs.columns.labels import COUNTS, split_label
from erclutch.logs.columns.names import TOLD, spoken_name
from erclutch.logs.columns.quotients import quotient_of
from erclutch.logs.columns.seen_columns import NO_UNITS, SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import FEW, LOOKED_AT, go_straight, is_rate_of
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.stated_field import take_stated_field
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS

_RETURNS = 0.1  # of the range, by which a column comes back that does not only rise or only fall
_SAME_COURSE = 2e-3  # of the range, within which two columns are one course
_SET_ENDS = 0.1  # of the range, by which the ends of a set point and of what follows it differ at most
_FOLLOWS_CLOSELY = 0.996  # correlation of a set point with what follows it some rows later
_OWN_SCALE = re.compile(r"(?:°|deg ?)?[CF]|[℃℉]|dB\w*|bits?|counts?|ticks?|lsb", re.I)
#: The last word of a column that numbers the steps of a test, and words that may stand in front of it.
_PARTS = frozenset({"step", "segment", "stage", "interval", "block", "schritt", "abschnitt", "etape", "paso", "etapa"})
_OF_A_TEST = frozenset({"test", "recipe", "program", "sequence", "measurement", "active", "actual"})
#: What a bench marks rows by: where it stopped, what went wrong, what the drive does.
_MARKS = frozenset(
    {
        *("is", "has", "holding", "endstop", "limit", "limiter", "flag", "valid", "error", "fault", "alarm", "trigger"),
        *("trig", "event", "home", "homed", "homing", "contact", "ready", "done", "moving", "saturated", "sync"),
        "status",
    }
)
_ESTIMATES = 0.7  # correlation of the signs of two estimates of one thing
#: What a sine that a drive was told is made with; a field that alternates may be described so too.
_OF_A_SINE = frozenset(
    {"amplitude", "amplitudes", "ampl", "amplitud", "ampiezza", "frequency", "freq", "frequenz", "frequence"}
)


def settle_the_field(draft: Draft) -> None:
    """Take the field from what the file states, or as not logged, where no column may be it; else it stays asked."""
    if "field" not in draft.missing:
        return
    taken = [*draft.taken, *draft.table.truths]
    inputs: list[str] = []
    for choice in draft.told.inputs:
        label = str(choice.column)
        name, _ = split_label(label)
        inputs += [label, name]
    if maybe_field(draft.seen, [*taken, *inputs]):
        return
    del draft.questions["field"]
    if take_stated_field(draft):
        return
    whys: list[str] = []
    for column in draft.seen.without(taken):
        why = why_no_field(draft.seen, column, taken)
        if why:
            whys.append(f"{column.name} {why}")
    draft.take_no_field(whys)


def maybe_field(seen: SeenColumns, taken: Iterable[str]) -> list[SeenColumn]:
    """Columns that nobody took and that may hold the field: its unit fits or nobody knows it, its name is open."""
    si_units = SIGNALS["field"].si_units
    known = set(taken)
    free = [column for column in seen.without(known) if column.fits(si_units) is not False or _has_odd_unit(column)]
    return [column for column in free if not why_no_field(seen, column, known)]


def _has_odd_unit(column: SeenColumn) -> bool:
    """Whether a unit is written that we do not know; a temperature or a level has its own scale."""
    unit = column.unit or ""
    return bool(unit) and not units.is_unit(unit) and not _OWN_SCALE.fullmatch(unit)


def why_no_field(seen: SeenColumns, column: SeenColumn, taken: Iterable[str]) -> str:
    """Why a column is not the field, beside columns that are something else; "" where it may be."""
    if column.unit not in NO_UNITS and column.fits(SIGNALS["field"].si_units):
        return ""
    return _why_by_itself(seen, column) or _why_beside(seen, column, taken)


def _why_by_itself(seen: SeenColumns, column: SeenColumn) -> str:
    """What else a column is by its name and its numbers."""
    if column.shape.constant:
        return "never changes"
    if column.shape.counts_rows:
        return "counts rows"
    if column.spoken.is_time:
        return "is a time"
    if column.shape.rises and _numbers_parts(column):
        return "numbers the parts of the test"
    if column.spoken.is_accounted:
        return "is another quantity by its name"
    if is_a_mark(column) and not _MARKS.isdisjoint(column.spoken.stem_words):
        return "marks rows by 0 and 1"
    if _is_of_models(seen, column):
        return "is what a model says of the effort"
    if not _OF_A_SINE.isdisjoint(column.spoken.stem_words[-1:]) and _has_a_told_motion(seen):
        return "is that of the motion that the drive was told"
    return ""


def _why_beside(seen: SeenColumns, column: SeenColumn, taken: Iterable[str]) -> str:
    """What else a column is by how it goes with columns that are something else."""
    measured = [seen.columns[name] for name in sorted(taken) if name in seen.columns]
    if not COUNTS.isdisjoint(column.spoken.stem_words[-1:]):
        for other in measured:
            if go_straight(column.values, other.values):
                return f"counts what {other.name} measures"
    for other in measured:
        if _is_same_course(column.values, other.values):
            return f"is {other.name} in other numbers"
    for other in measured:
        if _is_set_point_of(column.values, other.values):
            return f"is the set point that {other.name} follows"
    for other in measured:
        if is_rate_of(column.values, other.values, seen.stamps):
            return f"is the rate of {other.name}"
    parts = quotient_of(seen, column)
    return f"is {parts[0]} over {parts[1]}" if parts else ""


def is_a_mark(column: SeenColumn) -> bool:
    """Whether a column marks rows by 0 and 1."""
    known = column.values[np.isfinite(column.values)]
    return bool(np.isin(known, (0.0, 1.0)).all())


def _numbers_parts(column: SeenColumn) -> bool:
    """Whether a column is called like the steps of a test, and holds whole numbers."""
    if not np.all(column.values == np.round(column.values)):
        return False
    words = [re.sub(r"\d+$", "", word) for word in column.spoken.stem_words]
    if not words:
        return False
    *before, last = words
    return last in _PARTS and _OF_A_TEST.issuperset(before)


def _is_of_models(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a column is called like a model, or goes with such columns: a table of models beside a measured effort.

    One name alone may be that of a device; two are a comparison of models.
    """
    models = [other for other in seen.columns.values() if other.spoken.is_of_a_model]
    if len(models) < 2:
        return False
    return column.spoken.is_of_a_model or any(_are_estimates(column.values, model.values) for model in models)


def _has_a_told_motion(seen: SeenColumns) -> bool:
    """Whether a drive was told a motion, such as a target position, and no column holds a told field."""
    told = [column for column in seen.columns.values() if not TOLD.isdisjoint(column.spoken.stem_words)]
    motions = [column for column in told if any(_names(column, signal) for signal in ("slip", "position"))]
    return bool(motions) and not any(_names(column, "field") for column in told)


def _names(column: SeenColumn, signal: str) -> bool:
    """Whether a word of the column's name is one of the signal."""
    return any(len(word) > 1 and spoken_name(word).forms[signal] for word in column.spoken.stem_words)


def _are_estimates(first: Array, second: Array) -> bool:
    """Whether two columns that take both signs go together as two estimates of one effort do."""
    known = np.isfinite(first) & np.isfinite(second)
    a = np.sign(first[known][:LOOKED_AT])
    b = np.sign(second[known][:LOOKED_AT])
    if a.size < FEW or min(np.ptp(a), np.ptp(b)) < 2.0:
        return False
    return bool(np.corrcoef(a, b)[0, 1] > _ESTIMATES)


def _is_same_course(first: Array, second: Array) -> bool:
    """Whether a column is another one times a number plus a number, and both come back: stress and force, say.

    Two columns that only rise, such as two ramps, may go together by chance.
    """
    known = np.isfinite(first) & np.isfinite(second)
    a = first[known][:LOOKED_AT]
    b = second[known][:LOOKED_AT]
    if a.size < FEW or np.ptp(a) == 0.0 or not _comes_back(b):
        return False
    from_0_to_1 = (b - b.min()) / np.ptp(b)
    scaled = np.column_stack([np.ones_like(b), from_0_to_1])
    line, *_ = np.linalg.lstsq(scaled, a, rcond=None)
    left = a - scaled @ line
    return bool(np.ptp(left) <= _SAME_COURSE * np.ptp(a))


def _is_set_point_of(column: Array, measured: Array) -> bool:
    """Whether a column swings between the same two ends as a measured one, which follows it some rows later."""
    known = np.isfinite(column) & np.isfinite(measured)
    a = column[known][:LOOKED_AT]
    b = measured[known][:LOOKED_AT]
    if a.size < FEW or not _comes_back(a) or not _comes_back(b):
        return False
    off_below = abs(a.min() - b.min())
    off_above = abs(a.max() - b.max())
    if max(off_below, off_above) > _SET_ENDS * np.ptp(b):
        return False

    # The lag at which both correlate most, by their spectra; zeros behind the rows keep the ends apart.
    size = 2 * a.size
    of_column = np.fft.rfft(a - a.mean(), size)
    of_measured = np.fft.rfft(b - b.mean(), size)
    correlations = np.fft.irfft(np.conj(of_column) * of_measured, size)
    lag = int(correlations[: a.size // 2].argmax())  # rows
    if lag == 0:
        return False
    correlation = np.corrcoef(a[:-lag], b[lag:])[0, 1]
    return bool(correlation > _FOLLOWS_CLOSELY)


def _comes_back(values: Array) -> bool:
    """Whether a column both falls and rises by a good part of its range."""
    moved = float(np.ptp(values))
    falls = float((np.maximum.accumulate(values) - values).max())
    climbs = float((values - np.minimum.accumulate(values)).max())
    return moved > 0.0 and min(falls, climbs) > _RETURNS * moved
