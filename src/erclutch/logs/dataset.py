"""Recordings become the rows that models are fitted to: fields, slips and effort on one clock, and splits in time."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import UnionType

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import MappingError, SettingError, keywords_checked
from erclutch.logs.clock.timing import in_no_time
from erclutch.logs.field_between_logs import CourseOfLog, require_one_field
from erclutch.logs.speed_of_position import note_of, speed_of
from erclutch.signals.array import Array, Mask, rms
from erclutch.signals.clock import Clock, Span, cut_spans, stretches
from erclutch.signals.device import (
    DEVICES,
    EFFORT_OF,
    SPEED_OF,
    DeviceName,
    Element,
    Units,
    elements_of,
)
from erclutch.signals.recording import NO_FIELD, Recording
from erclutch.signals.shown import Shown, one_line
from erclutch.signals.speed import Derivative
from erclutch.signals.units import UNKNOWN

#: Share of the RMS slip below which a row is at rest.
_AT_REST = 0.02
_NEAR_REST = 0.05  # of the usual slip
#: Share of the largest field by which a field may change and still be called constant.
STEADY = 1e-6
#: Rates this close are one: clocks of two recorders differ by more than nothing.
_SAME_RATE = 0.01
_GIVE_UNITS = "Give the units of each column, on the command line or in a mapping file"


@dataclass(frozen=True, repr=False)
class Dataset(Shown):
    """Rows of one device, of one or several logs.

    Attributes:
        device: "single" or "coaxial".
        elements: field and slip of each element, each (n,).
        effort: measured torque or force, (n,).
        clock: time stamps and gapless spans; time restarts with each log.
        units: units of effort, field and slip.
        sources: names of the logs, in order.
        source_rows: rows of each log, [start, stop).
        notes: what was done on the way, for the user.
        extras: further logged inputs by name, each (n,).
        extra_units: the unit of each further input and spare column as logged; "?" is unknown.
        spare: further columns that are no input of any model, each (n,).
        origins: what each log says that it is, such as TWIN, "" for a measurement; empty where nobody knows.
    """

    device: DeviceName
    elements: tuple[Element, ...]
    effort: Array
    clock: Clock
    units: Units
    sources: tuple[str, ...] = ("log",)
    source_rows: tuple[tuple[int, int], ...] = ()
    notes: tuple[str, ...] = ()
    extras: Mapping[str, Array] = field(default_factory=dict[str, Array])
    extra_units: Mapping[str, str] = field(default_factory=dict[str, str])
    spare: Mapping[str, Array] = field(default_factory=dict[str, Array])
    origins: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.source_rows:
            object.__setattr__(self, "source_rows", ((0, self.rows),))

    def __repr__(self) -> str:
        extent = f"{self.duration:.4g} s at {1.0 / self.period:.4g} Hz"
        spans = len(self.clock.spans)
        several = [f"{spans} stretches"] if spans > 1 else []
        return one_line(self, self.where, self.device, f"{self.rows} rows", extent, *several)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.effort.size)

    @property
    def in_no_time(self) -> bool:
        """Whether rows of any log are points of a table, none after another."""
        return in_no_time(self.notes)

    @property
    def duration(self) -> float:
        """Seconds recorded, gaps left out."""
        time = self.clock.time
        seconds = [time[span.stop - 1] - time[span.start] for span in self.clock.spans]
        return float(sum(seconds))

    @property
    def at_rest(self) -> Mask:
        """Rows in which no element slips by more than 2 % of the usual (RMS) slip, shape (n,).

        Of points in no time these are the rows without slip: a low shear rate is a setting, and no rest.
        """
        slips = np.array([element.slip for element in self.elements])
        if self.in_no_time:
            return np.all(slips == 0.0, axis=0)
        usual = rms(slips)
        return np.max(np.abs(slips), axis=0) < _AT_REST * usual

    @property
    def one_way(self) -> bool:
        """Whether the slip of each element keeps its sign, and never comes near rest."""
        for element in self.elements:
            usual = rms(element.slip) or 1.0
            forward = np.sign(element.slip[0]) * element.slip / usual
            if not float(forward.min()) > _NEAR_REST:
                return False
        return True

    @property
    def one_field(self) -> bool:
        """Whether the field of each element is the same in all rows."""
        for element in self.elements:
            largest = float(np.abs(element.field).max())
            if not np.ptp(element.field) <= STEADY * largest:
                return False
        return True

    @property
    def period(self) -> float:
        """Sampling period in s: that of half of the rows or more, else one between the others; or the median step."""
        even: list[tuple[float, int]] = []  # period and rows of each stretch with equal steps
        for span in self.clock.spans:
            if span.period is not None:
                even.append((span.period, span.stop - span.start))
        if not even:
            return float(np.median(np.diff(self.clock.time)))
        even.sort()
        rows_so_far = np.cumsum([rows for _, rows in even])
        middle = int(np.searchsorted(rows_so_far, 0.5 * float(rows_so_far[-1])))
        period, _ = even[middle]
        return period

    @property
    def rates(self) -> tuple[float, float]:
        """Lowest and highest sampling rate of the stretches with equal steps, in Hz; equal where they are one rate."""
        periods = [span.period for span in self.clock.spans if span.period is not None]
        periods = periods or [self.period]
        longest = max(periods)
        shortest = min(periods)
        if longest - shortest > _SAME_RATE * shortest:
            return 1 / longest, 1 / shortest
        rate = 1 / self.period
        return rate, rate

    @property
    def named_signals(self) -> dict[str, tuple[Array, str]]:
        """Field and slip of each element, numbered where there are two: values (n,) and unit by name."""
        named: dict[str, tuple[Array, str]] = {}
        for number, element in enumerate(self.elements, start=1):
            tail = "" if len(self.elements) == 1 else str(number)
            named[f"field{tail}"] = element.field, self.units.field
            named[f"slip{tail}"] = element.slip, self.units.slip
        return named

    @property
    def where(self) -> str:
        """The logs' names, for messages."""
        if len(self.sources) == 1:
            return self.sources[0]
        return f"{len(self.sources)} logs"

    def thinned(self, most: int) -> Dataset:
        """Every so-many-th row, so that at most ``most`` are left, without their past."""
        step = -(-self.rows // most)  # rounded up
        return self.picked(slice(None, None, max(1, step)))

    def picked(self, rows: Mask | NDArray[np.intp] | slice) -> Dataset:
        """Some rows, lone ones too, without their past: for models that have no memory.

        Args:
            rows: a mask, shape (n,); or places, shape (k,); or a slice.
        """
        effort = self.effort[rows]
        return replace(
            self,
            elements=tuple(Element(e.field[rows], e.slip[rows]) for e in self.elements),
            effort=effort,
            extras={name: values[rows] for name, values in self.extras.items()},
            spare={name: values[rows] for name, values in self.spare.items()},
            clock=Clock(self.clock.time[rows], ()),
            source_rows=((0, effort.size),),
        )

    def take(self, mask: Mask) -> Dataset:
        """The rows of a mask. Spans are cut where rows are left out, stretches of a single row are dropped.

        Points in no time are cut nowhere: each is a row of its own.
        """
        if self.in_no_time:
            rows_of_logs = self._source_rows_of(mask)
            longer = [(start, stop) for start, stop in rows_of_logs if stop - start >= 2]
            whole = [Span(start, stop, self.period) for start, stop in longer]
            clock = Clock(self.clock.time[mask], tuple(whole))
            return replace(self.picked(mask), clock=clock, source_rows=rows_of_logs)

        keep = np.zeros(self.rows, np.bool_)
        spans: list[Span] = []
        kept = 0  # rows so far
        for span in self._spans_within(mask):
            keep[span.start : span.stop] = True
            rows = span.stop - span.start
            spans.append(Span(kept, kept + rows, span.period))
            kept += rows
        clock = Clock(self.clock.time[keep], tuple(spans))
        return replace(self.picked(keep), clock=clock, source_rows=self._source_rows_of(keep))

    def _source_rows_of(self, keep: Mask) -> tuple[tuple[int, int], ...]:
        """The rows of each log among those that are kept."""
        bounds: list[tuple[int, int]] = []
        for start, stop in self.source_rows:
            first = int(keep[:start].sum())
            behind = int(keep[:stop].sum())
            bounds.append((first, behind))
        return tuple(bounds)

    def with_neighbours(self, mask: Mask) -> Mask:
        """The rows of a mask that `take` keeps: those with a neighbour, or points in no time, shape (n,)."""
        if self.in_no_time:
            return mask.copy()
        keep = np.zeros(self.rows, np.bool_)
        for span in self._spans_within(mask):
            keep[span.start : span.stop] = True
        return keep

    def _spans_within(self, mask: Mask) -> Iterator[Span]:
        """The spans of the clock as far as they lie within a mask."""
        for start, stop in stretches(mask):
            for span in cut_spans(self.clock.spans, start, stop):
                yield replace(span, start=start + span.start, stop=start + span.stop)


@keywords_checked
def build_dataset(
    recordings: Recording | Sequence[Recording],
    *,
    device: DeviceName | None = None,
    derivative: Derivative | None = None,
) -> Dataset:
    """Join recordings of one device into a data set, differentiating positions where speeds are not logged.

    Args:
        recordings: one log or several of the same device, with the same units.
        device: how signals become elements; None: "coaxial" where the first log has a pair's torque, else "single".
        derivative: filter for positions; None is Savitzky-Golay over 5 rows.

    Raises:
        MappingError: a signal is missing, the logs' units differ, or their fields where no log has one.
        SettingError: an unknown device, or a filter that does not fit the sampling.
    """
    if device is not None and device not in DEVICES:
        remedy = f"Choose one of {', '.join(DEVICES)}"
        raise SettingError(f"unknown device {device!r}", remedy=remedy)
    logs = [recordings] if isinstance(recordings, Recording) else list(recordings)
    for log in logs:
        require_kind(log, Recording, "a recording", "Give erclutch.read(PATH)")
    if not logs:
        raise SettingError("no log was given", remedy="Give at least one log file")
    device = device or device_of(logs[0])
    parts = [dataset_of(log, device, derivative or Derivative()) for log in logs]
    seen: dict[str, str] = {}  # names of logs by their digests
    for log, part in zip(logs, parts, strict=True):
        refuse_twin(log.name, log.digest, seen)
        require_units(part, parts[0], log.name)
    refuse_unlogged_fields(parts)
    return joined(parts)


def require_kind(value: object, kind: type | UnionType, what: str, remedy: str) -> None:
    """SettingError unless a value is of a kind: what Python itself would say names an attribute that nobody knows."""
    if not isinstance(value, kind):
        raise SettingError(f"{what} cannot be a {type(value).__name__}", remedy=remedy)


def require_dataset(value: object) -> None:
    """SettingError unless a value is rows: a log is not yet."""
    require_kind(value, Dataset, "a data set", "Give erclutch.build_dataset(erclutch.read(PATH))")


def refuse_twin(name: str, digest: str, seen: dict[str, str]) -> None:
    """SettingError for a log whose digest was seen: the same rows twice would shrink every interval; it is now."""
    if digest and digest in seen:
        problem = f"the same file as {seen[digest]}"
        raise SettingError(problem, where=name, remedy="Give each log once")
    seen[digest] = name


def refuse_unlogged_fields(logs: Sequence[Dataset]) -> None:
    """UnloggedFieldError for logs, or stretches of one, without a field that differ as at several fields."""
    courses: list[CourseOfLog] = []
    for log in logs:
        slip = log.elements[0].slip
        courses.append(
            CourseOfLog(log.sources[0], log.notes, slip, log.effort, None, log.clock.spans)
        )
    require_one_field(courses)


def require_units(data: Dataset, first: Dataset, where: str) -> None:
    """MappingError for rows in other units than those of the first log."""
    if data.units != first.units:
        of_first = f"{first.units.text()} in {first.sources[0]}"
        problem = f"units differ: {data.units.text()} here, {of_first}"
        remedy = _GIVE_UNITS
        for own, other in ((data, first), (first, data)):
            says_none = any(note.startswith(NO_FIELD) for note in own.notes)
            has_none = own.units.field == UNKNOWN and says_none
            if has_none and replace(own.units, field=other.units.field) == other.units:
                name = own.sources[0]
                problem = f"{name} has no field, and {other.sources[0]} has one in {other.units.field or '1'}"
                number = f"0 {other.units.field}".strip()
                remedy = f'Say which it had in a mapping file beside it: {name}.toml with constants.field = "{number}"'
        raise MappingError(problem, where=where, remedy=remedy)
    for name in data.extras:
        unit = data.extra_units.get(name, UNKNOWN)
        before = first.extra_units.get(name, unit)
        if unit != before:
            units = [f"in {each}" if each != UNKNOWN else "as logged" for each in (unit, before)]
            problem = f"units of the further input {name} differ: {units[0]} here, {units[1]} in {first.sources[0]}"
            raise MappingError(problem, where=where, remedy=_GIVE_UNITS)


def device_of(log: Recording) -> DeviceName:
    """What a log is of where nobody said: "coaxial" with a pair's torque, else "single"."""
    return "coaxial" if "T" in log.signals else "single"


def dataset_of(log: Recording, device: DeviceName, derivative: Derivative) -> Dataset:
    """The rows of one log; see `build_dataset`."""
    log = log.without_jumps()
    notes = list(log.notes)
    neighboured = [(start, stop) for start, stop in log.segments if stop - start > 1]
    lone = len(log.segments) - len(neighboured)
    if lone and neighboured:
        log = log.only(neighboured)
        lone_rows = f"{lone} row{'s' if lone > 1 else ''} between two gaps"
        notes.append(f"{lone_rows} left out: they have no neighbour")
    period = log.period if log.uniform else None
    spans = [Span(start, stop, period) for start, stop in log.segments]
    clock = Clock(log.time, tuple(spans))

    signals = dict(log.signals)
    units = dict(log.units)
    for position, speed in SPEED_OF.items():
        if position in signals and speed not in signals:
            signals[speed], how = speed_of(signals[position], clock, derivative)
            unit = units.get(position, UNKNOWN)
            units[speed] = UNKNOWN if unit in ("", UNKNOWN) else f"{unit}/s"
            notes.append(note_of(speed, position, how))
    if derivative != Derivative() and signals.keys() == log.signals.keys():
        notes.append("the filter of speeds that was asked for plays no part: each speed is logged")

    effort = EFFORT_OF[device]
    needed = ("field", "slip") if device == "single" else ("theta_dot", "alpha_dot")
    missing = [name for name in (*needed, effort) if name not in signals]
    if missing:
        problem = f"no signal {', '.join(missing)} for device {device}; there are {', '.join(sorted(log.signals))}"
        remedy = "Map a column to it, for example --effort 'F [N]'"
        raise MappingError(problem, where=log.name, remedy=remedy)
    field = "field"
    slip = "slip"
    if device == "coaxial":
        field = "E1" if "E1" in signals else "E"
        slip = "theta_dot"
        for first, second in (("E1", "E2"), ("theta_dot", "alpha_dot")):
            one = units.get(first)
            other = units.get(second)
            if one is not None and other is not None and one != other:
                problem = f"{first} is in {one or '1'} and {second} in {other or '1'}"
                remedy = f"Give both the same unit, for example --{first} '{first} [{one or '1'}]'"
                raise MappingError(problem, where=log.name, remedy=remedy)

    return Dataset(
        device=device,
        elements=elements_of(device, signals),
        effort=signals[effort],
        clock=clock,
        units=Units(
            effort=units.get(effort, UNKNOWN),
            field=units.get(field, UNKNOWN),
            slip=units.get(slip, UNKNOWN),
        ),
        sources=(log.name,),
        notes=tuple(notes),
        extras=dict(log.extras),
        extra_units=dict(log.extra_units),
        spare=dict(log.spare),
        origins=(log.origin,),
    )


def joined(parts: Sequence[Dataset]) -> Dataset:
    """Logs of one device in the same units, one after another; further inputs are those that all of them have."""
    if len(parts) == 1:
        return parts[0]

    spans: list[Span] = []
    origins: list[str] = []
    notes: list[str] = []
    edges = [0]  # first row of each log, and the row behind the last
    for part in parts:
        begin = edges[-1]
        for span in part.clock.spans:
            spans.append(Span(begin + span.start, begin + span.stop, span.period))
        edges.append(begin + part.rows)
        origins += part.origins
        notes += part.notes
    elements: list[Element] = []
    # Each element of all logs in turn.
    for each in zip(*(part.elements for part in parts), strict=True):
        field = np.concatenate([element.field for element in each])
        slip = np.concatenate([element.slip for element in each])
        elements.append(Element(field, slip))
    time = np.concatenate([part.clock.time for part in parts])

    return replace(
        parts[0],
        elements=tuple(elements),
        effort=np.concatenate([part.effort for part in parts]),
        extras=_shared_by_all([part.extras for part in parts]),
        spare=_shared_by_all([part.spare for part in parts]),
        clock=Clock(time, tuple(spans)),
        sources=tuple(part.sources[0] for part in parts),
        origins=tuple(origins),
        source_rows=tuple(itertools.pairwise(edges)),
        notes=tuple(dict.fromkeys(notes)),  # each once
    )


def _shared_by_all(logs: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """The columns that all logs have, one log after another."""
    shared: dict[str, Array] = {}
    for name in logs[0]:
        if all(name in columns for columns in logs):
            shared[name] = np.concatenate([columns[name] for columns in logs])
    return shared
