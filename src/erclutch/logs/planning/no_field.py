"""A log without a field is read as such only where every column is known to be something else: this says why it is."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from erclutch.logs.columns.labels import COUNTS, split_label
from erclutch.logs.columns.names import TOLD, spoken_name
from erclutch.logs.columns.quotients import quotient_of
from erclutch.logs.columns.seen_columns import NO_UNITS, SeenColumn, SeenColumns
from erclutch.logs.columns.two_courses import (
    are_estimates,
    go_straight,
    goes_along,
    is_rate_of,
    is_same_course,
    is_set_point_of,
    is_size_of,
)
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.stated_field import take_stated_field
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS

#: Words of a drive in the name of its current (i_q, q_current, motor_current), and of the current beside it.
OF_DRIVES = frozenset({"motor", "mot", "servo", "drive", "iq", "isq", "q", "motorstrom"})
_OTHER_AXIS = frozenset({"id", "isd", "d"})
LARGEST_SUPPLY = 100.0  # V, or as logged, above which a voltage is that across a fluid
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
        why = _why_no_field(draft.seen, column, taken)
        if why:
            whys.append(f"{column.name} {why}")
    draft.take_no_field(whys)


def maybe_field(seen: SeenColumns, taken: Iterable[str]) -> list[SeenColumn]:
    """Columns that nobody took and that may hold the field: its unit fits or nobody knows it, its name is open."""
    taken = {*taken}
    open_ones: list[SeenColumn] = []
    for column in seen.without(taken):
        unit = column.unit or ""
        # A unit that we do not know may be one of a field; a temperature or a level has its own scale.
        is_odd = bool(unit) and not units.is_unit(unit) and not _OWN_SCALE.fullmatch(unit)
        fits = column.fits(SIGNALS["field"].si_units)
        if (fits is not False or is_odd) and not _why_no_field(seen, column, taken):
            open_ones.append(column)
    return open_ones


def _why_no_field(seen: SeenColumns, column: SeenColumn, taken: Iterable[str]) -> str:
    """Why a column is not the field, beside columns that are something else; "" where it may be."""
    of_a_drive = _why_of_a_drive(seen, column, taken)
    if of_a_drive or (column.unit not in NO_UNITS and column.fits(SIGNALS["field"].si_units)):
        return of_a_drive
    return _why_by_itself(seen, column) or _why_beside(seen, column, taken)


def _why_of_a_drive(seen: SeenColumns, column: SeenColumn, taken: Iterable[str]) -> str:
    """What a column of a drive's telemetry is: its current, the other current of its two axes, or its supply."""
    efforts: list[Array] = []
    for name in taken:
        other = seen.columns.get(name)
        if other is not None and "effort" in other.spoken.may_be | other.spoken.within:
            efforts.append(other.values)
    if is_current_of_a_drive(column, efforts):
        return "is the current of the drive, which goes along with the effort"
    beside = [other for other in seen.columns.values() if is_current_of_a_drive(other, efforts)]
    if not beside:
        return ""
    if not _OTHER_AXIS.isdisjoint(column.spoken.stem_words) and column.fits(("A",)) is not False:
        return f"is the other current of the drive, beside {beside[0].name}"
    largest = float(np.nanmax(np.abs(column.values), initial=0.0))
    if column.is_steady and largest < LARGEST_SUPPLY and column.fits(("V",)) is not False:
        return f"keeps one level, as the supply of the drive with {beside[0].name}"
    return ""


def is_current_of_a_drive(column: SeenColumn, efforts: Iterable[Array]) -> bool:
    """Whether a column is called like the current of a drive, takes the sign of an effort and goes along with it."""
    if OF_DRIVES.isdisjoint(column.spoken.stem_words) or column.fits(("A",)) is False:
        return False
    return any(goes_along(column.values, effort) for effort in efforts)


def _why_by_itself(seen: SeenColumns, column: SeenColumn) -> str:
    """What else a column is by its name and its numbers."""
    shape = column.shape
    words = column.spoken.stem_words
    if shape.constant:
        return "never changes"
    if shape.counts_rows:
        return "counts rows"
    if column.spoken.is_time or (column.spoken.ends_in_time and shape.rises):
        return "is a time"
    if shape.rises and _numbers_parts(column):
        return "numbers the parts of the test"
    if len(words) > 1 and words[-1] == "id" and np.all(column.values == np.round(column.values)):
        return "tells one device from another"  # a current along an axis is no whole number
    if column.spoken.is_accounted:
        return "is another quantity by its name"
    if is_a_mark(column) and not _MARKS.isdisjoint(words):
        return "marks rows by 0 and 1"
    if is_of_models(seen, column):
        return "is what a model says of the effort"
    if not _OF_A_SINE.isdisjoint(words[-1:]) and _has_a_told_motion(seen):
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
        if is_same_course(column.values, other.values):
            return f"is {other.name} in other numbers"
    for other in measured:
        if is_size_of(column.values, other.values):
            return f"is {other.name} without its sign" if np.nanmin(other.values) < 0.0 else f"repeats {other.name}"
    for other in measured:
        if is_set_point_of(column.values, other.values):
            return f"is the set point that {other.name} follows"
    for other in measured:
        if is_rate_of(column.values, other.values, seen.stamps):
            return f"is the rate of {other.name}"
        if not other.shape.constant and is_rate_of(other.values, column.values, seen.stamps):
            return f"is what {other.name} is the rate of"
    parts = quotient_of(seen, column)
    if parts is None:
        return ""
    top, bottom = parts
    return f"is {top} over {bottom}"


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


def is_of_models(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a column is called like a model, or goes with such columns: a table of models beside a measured effort.

    One name alone may be that of a device; two are a comparison of models.
    """
    models = [other for other in seen.columns.values() if other.spoken.is_of_a_model]
    if len(models) < 2:
        return False
    return column.spoken.is_of_a_model or any(are_estimates(column.values, model.values) for model in models)


def _has_a_told_motion(seen: SeenColumns) -> bool:
    """Whether a drive was told a motion, such as a target position, and no column holds a told field."""
    told: set[str] = set()  # signals that a word of a told column's name speaks for
    for column in seen.columns.values():
        words = column.spoken.stem_words
        if TOLD.isdisjoint(words):
            continue
        for word in words:
            if len(word) > 1:
                told |= {signal for signal, form in spoken_name(word).forms.items() if form}
    return not told.isdisjoint(("slip", "position")) and "field" not in told
