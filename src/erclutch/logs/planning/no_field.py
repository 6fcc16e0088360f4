"""A log without a field is read as such only where every column is known to be something else: this says why it is."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.labels import COUNTS, split_label
from erclutch.logs.columns.levels_in_names import are_at_fields
from erclutch.logs.columns.phases import is_of_phases
from erclutch.logs.columns.quotients import quotient_of
from erclutch.logs.columns.seen_columns import NO_UNITS, SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import are_whole
from erclutch.logs.columns.two_courses import (
    are_estimates,
    go_straight,
    is_course_times_a_number,
    is_rate_of,
    is_same_course,
    is_set_point_of,
    is_size_of,
)
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.field_doubts import LARGEST_SUPPLY, is_current_of_a_drive
from erclutch.logs.planning.missing_columns import has_short_name
from erclutch.logs.planning.stated_field import states_a_field, take_stated_field
from erclutch.logs.planning.told_motions import has_a_controller, has_a_told_motion
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SIGNALS

_OTHER_AXIS = frozenset({"id", "isd", "d"})
_OWN_SCALE = re.compile(
    r"(?:°|deg ?)?[CF]|[℃℉]|dB\w*|bits?|counts?|ticks?|lsb|unitless|segments?|cycles?", re.I
)
#: The last word of a column that numbers the steps of a test or the tests, and words that may stand in front of it.
_PARTS = frozenset(
    (
        "step segment stage interval block schritt abschnitt etape paso etapa "
        "test run trial experiment repetition rep repeat versuch messung prufung essai ensayo prova prueba 试验 試験"
    ).split()
)
_OF_A_TEST = frozenset({"test", "recipe", "program", "sequence", "measurement", "active", "actual"})
#: What a bench marks rows by: where it stopped, what went wrong, what the drive does.
_MARKS = frozenset(
    (
        "is has holding endstop limit limiter flag valid error fault alarm trigger trig event "
        "home homed homing contact ready done moving saturated sync status "
        "complete completed finished reached arrived"
    ).split()
)
#: What is made of several points.
_OF_POINTS = frozenset({"avg", "average", "mean", "mittel"})
_MANY = 4  # columns: more are told together
_LOAD_CELL = re.compile(r"(?<![^\W_])(?:lc ?\d+|load ?cell\w*)(?![^\W_])", re.IGNORECASE)
#: The square of a drive's current over time, by which drives guard themselves against heat.
_HEAT_OF_A_DRIVE = frozenset({"i2t", "i²t", "ixt"})
_GAIN = re.compile(r"k_?(\d)(?!\d)", re.IGNORECASE)
_FEWEST_GAINS = 3
#: What a sine that a drive was told is made with; a field that alternates may be described so too.
_OF_A_SINE = frozenset(
    {
        "amplitude",
        "amplitudes",
        "ampl",
        "amplitud",
        "ampiezza",
        "frequency",
        "freq",
        "frequenz",
        "frequence",
    }
)


def settle_the_field(draft: Draft) -> None:
    """Take the field from what the file states, or as not logged, where no column may be it; else it stays asked."""
    if "field" not in draft.missing:
        return
    taken = [*draft.taken, *draft.table.truths]
    efforts, _ = candidates(draft.seen, "effort", taken)
    if are_at_fields(efforts):  # F@0A and F@1A hold no field, they tell it
        taken += efforts
    inputs: list[str] = []
    for choice in draft.told.inputs:
        label = str(choice.column)
        name, _ = split_label(label)
        inputs += [label, name]
    open_ones = maybe_field(draft.seen, [*taken, *inputs, *draft.no_fields])
    # A v may be a voltage, but beside a stated current it is none that is needed.
    have_short_names = all(
        not column.unit and has_short_name(column, "field") for column in open_ones
    )
    if open_ones and not (have_short_names and states_a_field(draft)):
        return
    del draft.questions["field"]
    if take_stated_field(draft):
        return
    alike: dict[str, list[str]] = {}  # why -> the columns that are no field for it
    for column in draft.seen.without(taken):
        why = draft.no_fields.get(column.name) or _why_no_field(draft.seen, column, taken)
        if why:
            alike.setdefault(why, []).append(column.name)
    whys: list[str] = []
    for why, names in alike.items():
        if len(names) > _MANY:
            whys.append(f"each of the {len(names)} columns {names[0]} .. {names[-1]} {why}")
        else:
            whys += [f"{name} {why}" for name in names]
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
    why = _why_of_a_drive(seen, column, taken)
    has_the_unit = column.unit not in NO_UNITS and column.fits(SIGNALS["field"].si_units)
    if not why and not has_the_unit:
        why = _why_by_itself(seen, column) or _why_beside(seen, column, taken)
        why = why or ("is a load cell by its name" if _LOAD_CELL.search(column.name) else "")
    return why


def _why_of_a_drive(seen: SeenColumns, column: SeenColumn, taken: Iterable[str]) -> str:
    """What a column of a drive's telemetry is: its current, the other current of its two axes, or its supply."""
    if is_of_phases(seen, column):
        return "belongs to the phases of a machine"
    if tells_heat_of_a_drive(column):
        return "is how warm the drive is, by its current"
    efforts: list[Array] = []
    for name in taken:
        other = seen.columns.get(name)
        if other is not None and "effort" in other.spoken.may_be | other.spoken.within:
            efforts.append(other.values)
    if is_current_of_a_drive(column, efforts):
        return "is the current of the drive, which goes along with the effort"
    beside = [other for other in seen.of_drives if is_current_of_a_drive(other, efforts)]
    if not beside:
        return ""
    if column.spoken.says(_OTHER_AXIS) and column.fits(("A",)) is not False:
        return f"is the other current of the drive, beside {beside[0].name}"
    largest = float(np.nanmax(np.abs(column.values), initial=0.0))
    is_a_supply = column.is_steady and largest < LARGEST_SUPPLY and column.fits(("V",)) is not False
    if is_a_supply and not column.spoken.is_accounted:
        return f"keeps one level, as the supply of the drive with {beside[0].name}"
    return ""


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
    bare_words = [re.sub(r"\d+$", "", word) for word in words]
    is_a_part = bool(words) and bare_words[-1] in _PARTS and _OF_A_TEST.issuperset(bare_words[:-1])
    if shape.rises and is_a_part and are_whole(column.values):
        return "numbers the parts of the test"
    if words[-1:] == ("id",) and are_whole(column.values):
        is_a_current = len(words) == 1 and bool(seen.saying(frozenset({"iq"})))
        if not is_a_current:
            return "tells one device from another"  # a current along an axis is no whole number
    is_share_of_a_load = column.written_unit == "%" and "load" in words  # that a brake is told
    if column.spoken.is_accounted and not is_share_of_a_load:
        return "is another quantity by its name"
    if is_a_mark(column) and not _MARKS.isdisjoint(words):
        return "marks rows by 0 and 1"
    is_a_motion = not column.spoken.may_be.isdisjoint(("slip", "position"))
    # The rate of a position, or a position with its rate.
    for other in seen.without([column.name]) if is_a_motion else ():
        for speed, position in ((column, other), (other, column)):
            is_called = "slip" in speed.spoken.may_be and "position" in position.spoken.may_be
            if is_called and is_rate_of(speed.values, position.values, seen.stamps):
                return f"is a motion, beside {other.name}"
    if is_of_models(seen, column):
        return "is what a model says of the effort"
    place = _place_among_others(seen, column)
    if place:
        return place
    if not _OF_A_SINE.isdisjoint(words[-1:]) and has_a_told_motion(seen):
        return "belongs to the motion that the drive was told"
    return ""


def _why_beside(seen: SeenColumns, column: SeenColumn, taken: Iterable[str]) -> str:
    """What else a column is by how it goes with columns that are something else."""
    measured = [seen.columns[name] for name in sorted(taken) if name in seen.columns]
    if not COUNTS.isdisjoint(column.spoken.stem_words[-1:]):
        for other in measured:
            if go_straight(column.values, other.values):
                return f"counts what {other.name} measures"
    for other in measured:
        is_motion = "effort" not in other.spoken.may_be
        is_multiple = is_motion and is_course_times_a_number(column.values, other.values)
        if is_multiple or is_same_course(column.values, other.values):
            return f"is {other.name} in other numbers"
    for other in measured:
        if is_size_of(column.values, other.values):
            has_a_sign = np.nanmin(other.values) < 0.0
            return f"is {other.name} without its sign" if has_a_sign else f"repeats {other.name}"
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


def tells_heat_of_a_drive(column: SeenColumn) -> bool:
    """Whether a name is that of the number by which a drive guards itself against heat."""
    return column.spoken.plain_stem in _HEAT_OF_A_DRIVE


def is_of_models(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a column is called like a model, or goes with such columns: a table of models beside a measured effort.

    One name alone may be that of a device; two are a comparison of models.
    """
    if len(seen.of_models) < 2:
        return False
    return column.spoken.is_of_a_model or any(
        are_estimates(column.values, model.values) for model in seen.of_models
    )


def _place_among_others(seen: SeenColumns, column: SeenColumn) -> str:
    """What a column is by its name and by the names beside it; "" where it may be anything."""
    if _is_of_a_matrix(seen, column):
        return "is an entry of a matrix by its name"
    if _is_of_a_point(seen, column):
        return "is a coordinate of one of several points by its name"
    if _is_a_gain(seen, column):
        return "is a gain of the controller by its name"
    return ""


def _is_a_gain(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a name is a k with a number, one of several in a row, beside what a controller told: k1, k2, k3.

    Relays are called so too, but those are on or off.
    """
    if _GAIN.match(column.name) is None or is_a_mark(column) or not has_a_controller(seen):
        return False
    numbers: list[int] = []
    for other in seen.columns.values():
        gain = _GAIN.match(other.name)
        if gain is not None and not is_a_mark(other):
            numbers.append(int(gain[1]))
    numbers.sort()
    return len(numbers) >= _FEWEST_GAINS and numbers == [*range(numbers[0], numbers[-1] + 1)]


def _is_of_a_matrix(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a name is a letter with the row and the column of a matrix, whose entries all stand in the table: K12."""
    letter = column.spoken.plain_stem.rstrip("0123456789")
    if len(letter) != 1 or letter == column.spoken.plain_stem:
        return False
    places: set[str] = set()
    for other in seen.columns.values():
        stem = other.spoken.plain_stem
        if stem.rstrip("0123456789") == letter:
            places.add(stem.removeprefix(letter))
    if any(len(place) != 2 for place in places):
        return False
    rows = {place[0] for place in places}
    columns = {place[1] for place in places}
    return min(len(rows), len(columns)) > 1 and len(places) == len(rows) * len(columns)


def _is_of_a_point(seen: SeenColumns, column: SeenColumn) -> bool:
    """Whether a name is x or y in front of what tells points apart, and each point has both: X1, Y1, X2, Y2.

    A program of learning calls its inputs X1, X2, ... and its output y: there the field may be one of them.
    """
    points: dict[str, set[str]] = {"x": set(), "y": set()}
    for other in seen.columns.values():
        axis, point = other.spoken.plain_stem[:1], other.spoken.plain_stem[1:]
        if axis in points and (point.isdecimal() or point in _OF_POINTS):
            points[axis].add(point)
    own = column.spoken.plain_stem
    return (
        len(points["x"]) > 1 and points["x"] == points["y"] and own[1:] in points.get(own[:1], ())
    )
