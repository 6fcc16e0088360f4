"""From recordings to the rows that models are fitted to: fields, slips and effort on one clock, and splits in time."""

from __future__ import annotations

import fnmatch
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import PurePath
from typing import cast

import numpy as np
from numpy.typing import NDArray

from erclutch.device import DEVICES, EFFORT_OF, SPEED_OF, DeviceName, Element, Units, elements_of
from erclutch.differentiate import Derivative, differentiate
from erclutch.dynamics import Clock, Span, cut_spans
from erclutch.errors import MappingError, SettingError
from erclutch.signals import Recording

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Share of the RMS slip below which a row is at rest.
_AT_REST = 0.02
#: Share of the largest field by which a field may change and still be called constant.
_STEADY = 1e-6


@dataclass(frozen=True)
class Dataset:
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

    def __post_init__(self) -> None:
        if not self.source_rows:
            object.__setattr__(self, "source_rows", ((0, self.rows),))

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.effort.size)

    @property
    def duration(self) -> float:
        """Seconds recorded, gaps left out."""
        t = self.clock.time
        return float(sum(t[s.stop - 1] - t[s.start] for s in self.clock.spans))

    @property
    def at_rest(self) -> Mask:
        """Rows in which no element slips by more than 2 % of the usual (RMS) slip, shape (n,)."""
        slips = np.array([e.slip for e in self.elements])
        return np.max(np.abs(slips), axis=0) < _AT_REST * float(np.sqrt(np.mean(slips**2)))

    def take(self, mask: Mask) -> Dataset:
        """The rows of a mask. Spans are cut where rows are left out, stretches of a single row are dropped."""
        pieces = [(a, b, cut_spans(self.clock.spans, a, b)) for a, b in _stretches(mask)]
        keep = np.zeros(self.rows, np.bool_)
        spans: list[Span] = []
        for start, _, cut in pieces:
            for span in cut:
                offset = int(np.count_nonzero(keep))
                keep[start + span.start : start + span.stop] = True
                spans.append(Span(offset, offset + span.stop - span.start, span.period))
        bounds = [(int(keep[:a].sum()), int(keep[:b].sum())) for a, b in self.source_rows]
        return replace(
            self,
            elements=tuple(Element(e.field[keep], e.slip[keep]) for e in self.elements),
            effort=self.effort[keep],
            extras={name: values[keep] for name, values in self.extras.items()},
            clock=Clock(self.clock.time[keep], tuple(spans)),
            source_rows=tuple(bounds),
        )


def _stretches(mask: Mask) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def build_dataset(
    recordings: Recording | Sequence[Recording], *, device: DeviceName = "single", derivative: Derivative | None = None
) -> Dataset:
    """Join recordings of one device into a data set, differentiating positions where speeds are not logged.

    Args:
        recordings: one log or several of the same device, with the same units.
        device: how signals become elements.
        derivative: filter for positions; None is Savitzky-Golay over 5 rows.

    Raises:
        MappingError: a signal is missing, or the logs' units differ.
        SettingError: an unknown device, or a filter that does not fit the sampling.
    """
    if device not in DEVICES:
        raise SettingError(f"unknown device {device!r}", remedy=f"Choose one of {', '.join(DEVICES)}")
    logs = [recordings] if isinstance(recordings, Recording) else list(recordings)
    if not logs:
        raise SettingError("no log was given", remedy="Give at least one log file")
    parts = [_one(log, device, derivative or Derivative()) for log in logs]
    _no_twins(logs)
    units = parts[0].units
    for part in parts[1:]:
        if part.units != units:
            raise MappingError(
                f"units differ between logs: {part.units.text()} here, {units.text()} in {parts[0].sources[0]}",
                where=part.sources[0],
                remedy="Give the units of each column, on the command line or in a mapping file",
            )
    return _join(parts)


def _no_twins(logs: Sequence[Recording]) -> None:
    """The same rows twice would shrink every interval."""
    seen: dict[str, str] = {}
    for log in logs:
        if log.digest and log.digest in seen:
            raise SettingError(f"the same file as {seen[log.digest]}", where=log.name, remedy="Give each log once")
        seen[log.digest] = log.name


def _one(log: Recording, device: DeviceName, derivative: Derivative) -> Dataset:
    log, lone = _without_lone_rows(log)
    spans = tuple(Span(a, b, log.period if log.uniform else None) for a, b in log.segments)
    clock = Clock(log.time, spans)
    signals, units, notes = dict(log.signals), dict(log.units), list(log.notes)
    if lone:
        notes.append(f"{lone} row{'s' if lone > 1 else ''} between two gaps left out: they have no neighbour")
    for position, speed in SPEED_OF.items():
        if position in signals and speed not in signals:
            signals[speed] = differentiate(signals[position], clock, derivative)
            units[speed] = f"{units[position]}/s" if units.get(position, "?") not in ("", "?") else "?"
            notes.append(f"{speed} <- {position} by the {derivative.name} derivative")
    effort = EFFORT_OF[device]
    needed = ("field", "slip") if device == "single" else ("theta_dot", "alpha_dot")
    missing = [name for name in (*needed, effort) if name not in signals]
    if missing:
        raise MappingError(
            f"no signal {', '.join(missing)} for device {device}; there are {', '.join(sorted(log.signals))}",
            where=log.name,
            remedy="Map a column to it, for example --effort 'F [N]'",
        )
    _same_unit(log, units, (("E1", "E2"), ("theta_dot", "alpha_dot")) if device == "coaxial" else ())
    field = "field" if device == "single" else ("E1" if "E1" in signals else "E")
    slip = "slip" if device == "single" else "theta_dot"
    return Dataset(
        device=device,
        elements=elements_of(device, signals),
        effort=signals[effort],
        clock=clock,
        units=Units(units.get(effort, "?"), units.get(field, "?"), units.get(slip, "?")),
        sources=(log.name,),
        notes=tuple(notes),
        extras=dict(log.extras),
    )


def _without_lone_rows(log: Recording) -> tuple[Recording, int]:
    """The log without segments of a single row, and how many there were."""
    kept = [(a, b) for a, b in log.segments if b - a >= 2]
    lone = len(log.segments) - len(kept)
    if not lone or not kept:
        return log, 0
    rows = np.concatenate([np.arange(a, b) for a, b in kept])
    ends = np.cumsum([b - a for a, b in kept])
    segments = tuple((int(end - (b - a)), int(end)) for (a, b), end in zip(kept, ends, strict=True))
    signals = {name: values[rows] for name, values in log.signals.items()}
    extras = {name: values[rows] for name, values in log.extras.items()}
    return replace(log, signals=signals, extras=extras, time=log.time[rows], segments=segments), lone


def _same_unit(log: Recording, units: dict[str, str], pairs: Sequence[tuple[str, str]]) -> None:
    for first, second in pairs:
        if first in units and second in units and units[first] != units[second]:
            raise MappingError(
                f"{first} is in {units[first] or '1'} and {second} in {units[second] or '1'}",
                where=log.name,
                remedy=f"Give both the same unit, for example --{first} '{first} [{units[first] or '1'}]'",
            )


def _join(parts: list[Dataset]) -> Dataset:
    if len(parts) == 1:
        return parts[0]
    offsets = np.cumsum([0, *(part.rows for part in parts)])
    spans = [
        Span(int(offset) + s.start, int(offset) + s.stop, s.period)
        for part, offset in zip(parts, offsets, strict=False)
        for s in part.clock.spans
    ]
    count = len(parts[0].elements)
    shared = [name for name in parts[0].extras if all(name in part.extras for part in parts)]
    notes = dict.fromkeys(note for part in parts for note in part.notes)
    return Dataset(
        device=parts[0].device,
        elements=tuple(
            Element(
                np.concatenate([p.elements[i].field for p in parts]),
                np.concatenate([p.elements[i].slip for p in parts]),
            )
            for i in range(count)
        ),
        effort=np.concatenate([p.effort for p in parts]),
        extras={name: np.concatenate([p.extras[name] for p in parts]) for name in shared},
        clock=Clock(np.concatenate([p.clock.time for p in parts]), tuple(spans)),
        units=parts[0].units,
        sources=tuple(p.sources[0] for p in parts),
        source_rows=tuple((int(a), int(b)) for a, b in itertools.pairwise(offsets)),
        notes=tuple(notes),
    )


def hold_out(dataset: Dataset, test: float | str | Sequence[str]) -> Mask:
    """Rows that are kept from fitting: the last share in time, or whole logs by the pattern of their names.

    Args:
        dataset: the rows.
        test: a share above 0 and below 0.9 (of each log: its last rows; of a log that was taken at one field after
            another, of each stretch), or shell patterns such as ``*0x5A.txt``.

    Returns:
        Mask (n,), true for test rows.

    Raises:
        SettingError: the share is out of range, a pattern matches no log, or nothing is left to train on.
    """
    mask = np.zeros(dataset.rows, np.bool_)
    if isinstance(test, Real):
        share = float(test)
        if not 0 < share < 0.9:
            raise SettingError(
                f"a test share of {share}",
                where="--test",
                remedy="Give a share above 0 and below 0.9, for example 0.3, or a pattern of logs' names: 'run7*'",
            )
        for log in dataset.source_rows:
            for start, stop in constant_stretches(dataset, *log) or [log]:
                mask[start + round((1 - share) * (stop - start)) : stop] = True
        return mask
    patterns = (test,) if isinstance(test, str) else tuple(cast(Sequence[str], test))
    for pattern in patterns:
        hits = [i for i, name in enumerate(dataset.sources) if fnmatch.fnmatchcase(PurePath(name).name, pattern)]
        if not hits:
            raise SettingError(
                f"the test pattern {pattern!r} matches none of {len(dataset.sources)} logs",
                remedy=f"Logs are called for example {dataset.sources[0]!r}",
            )
        for i in hits:
            mask[slice(*dataset.source_rows[i])] = True
    if mask.all():
        raise SettingError("all logs are held out, none is left to train on", remedy="Narrow the test patterns")
    return mask


def constant_stretches(dataset: Dataset, start: int, stop: int) -> list[tuple[int, int]]:
    """Stretches of a log that was taken at one constant field after another; empty for any other log.

    The end of such a log is a field that no earlier row has, so a share of it is held out of each stretch.
    """
    spans = [(s.start, s.stop) for s in dataset.clock.spans if start <= s.start and s.stop <= stop]
    fields = [e.field for e in dataset.elements]
    reach = _STEADY * max(float(np.abs(f).max()) for f in fields)
    steady = all(np.ptp(f[a:b]) <= reach for f in fields for a, b in spans)
    several = any(np.ptp(f[start:stop]) > reach for f in fields)
    return spans if steady and several else []


def blocks(dataset: Dataset, count: int) -> list[Mask]:
    """Masks of ``count`` contiguous blocks of rows, for cross-validation over time; each row is in one block.

    Raises:
        SettingError: fewer than 2 blocks, or blocks of fewer than 20 rows.
    """
    if count < 2 or dataset.rows // count < 20:
        raise SettingError(
            f"{count} blocks of {dataset.rows} rows", remedy="Give 2 blocks or more, of at least 20 rows each"
        )
    edges = np.linspace(0, dataset.rows, count + 1).round().astype(int)
    row = np.arange(dataset.rows)
    return [(row >= a) & (row < b) for a, b in itertools.pairwise(edges)]
