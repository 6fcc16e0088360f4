"""Logs larger than memory are read once, a task a log; their rows are kept as columns in the files of a folder.

All passes of a fit go over these files in tasks. A task gets the folder and a range of rows, never an array, and gives
a sum, an extreme or a triangle back. Ranges depend on the number of rows alone, and what they give is added in their
order: the bits are the same for any number of workers, and those of a data set for as many rows as one range has.
"""

from __future__ import annotations

import itertools
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from erclutch.errors import ErclutchError, LogError, MappingError, RunError
from erclutch.logs import Batch
from erclutch.logs.batches import datasets
from erclutch.logs.blocks import Blocks
from erclutch.logs.dataset import Dataset, joined, refuse_twin, require_units
from erclutch.signals.array import Array
from erclutch.signals.clock import Carry, Clock, Span, within
from erclutch.signals.device import DeviceName, Element, Units
from erclutch.signals.speed import Derivative

T = TypeVar("T")
U = TypeVar("U")

BLOCK = 65_536  # rows at a time; a multiple of all blocks that fits and models work in
RANGE = 16 * BLOCK  # rows of a task, at least
_MOST_RANGES = 4096  # tasks of a pass
_LEAF = 131_072  # rows that are added up at once
_BEHIND = 0.05  # s that a delay looks back: rows ahead of a block, of a model with a memory

_ALONE = "Leave the folder of --scratch alone, and let all workers see it"

#: What a function makes of each item, in their order: `map`, or a pool's.
Spread = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
#: Some rows, and which of them count: those before only bring their past along.
Stretch = tuple[Dataset, slice]


@dataclass(frozen=True)
class Source:
    """One log of many rows.

    Attributes:
        name, digest, origin: of its file.
        read: rows of the file.
        kept: rows that are left after gaps and dropped values.
        notes: what its first stretch said.
    """

    name: str
    digest: str
    origin: str
    read: int
    kept: int
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """The rows of one log as they lie on disk: a file for each column, of doubles.

    Attributes:
        stem: of these files.
        source: the log.
        like: an empty data set of the same device, units and inputs.
        spans: [start, stop, period] of each gapless stretch, shape (spans, 3); the period is nan where steps differ.
        periods: how many stretches have each sampling period.
        ends: smallest and largest value of each column, shape (columns, 2).
        both: rows in which all elements are under field.
    """

    stem: Path
    source: Source
    like: Dataset
    spans: Array
    periods: Counter[float]
    ends: Array
    both: int

    def column(self, index: int, start: int, stop: int, step: int = 1) -> Array:
        """Rows [start, stop) of a column, or every so-many-th of them.

        Raises:
            RunError: the file is not there, or too short.
        """
        where = _file(self.stem, index)
        try:
            if step > 1:
                return np.array(np.memmap(where, np.float64, "r")[start:stop:step])
            values: Array = np.fromfile(where, count=stop - start, offset=8 * start)
        except OSError as error:
            raise RunError(f"cannot be read: {error.strerror or error}", where=str(where), remedy=_ALONE) from error
        if values.size < stop - start:
            raise RunError("kept rows are missing", where=str(where), remedy=_ALONE)
        return values


def _file(stem: Path, index: int) -> Path:
    return stem.with_name(f"{stem.name}-{index}.f8")


def read_part(
    batches: Iterator[Batch],
    device: DeviceName,
    derivative: Derivative,
    stem: Path,
    report: Callable[[int], None] | None = None,
) -> Part:
    """Read a log to its end.

    Args:
        batches: of one log.
        device: how signals become elements.
        derivative: filter for positions.
        stem: of the files that are written.
        report: called with the rows of the file that are read.

    Raises:
        LogError, MappingError: see `erclutch.read`; units that change on the way.
        SettingError: a filter that does not fit.
        RunError: the disk is full.
    """
    first, last, like, read, both = None, None, None, 0, 0
    spans: list[list[float]] = []
    periods: Counter[float] = Counter()
    ends: list[Array] = []
    with _Columns(stem) as columns:
        for batch, data in datasets(batches, device, derivative):
            first, last, read = first or batch.recording, batch.recording, batch.stop
            if data is not None:
                like = like or replace(data.picked(slice(0)), notes=(), spare={})
                rows = f", data rows {batch.start + 1} to {batch.stop}" if batch.start else ""
                _require_same(data, like, last.name + rows)
                _append_spans(spans, data.clock, columns.rows)
                periods[last.period] += len(last.segments) if last.uniform else 1
                values = _columns_of(data)
                ends.append(np.array([(v.min(), v.max()) for v in values]))
                both += int(np.count_nonzero(np.logical_and.reduce([e.field != 0 for e in data.elements])))
                columns.write(values)
            if report is not None:
                report(read)
    if first is None or like is None:
        name = "the log" if first is None else first.name
        raise LogError("no row is left", where=name, remedy="Give a log with finite values")
    source = Source(first.name, first.digest, first.origin, read, columns.rows, first.notes)
    low, high = np.min(ends, axis=0)[:, 0], np.max(ends, axis=0)[:, 1]
    return Part(stem, source, like, np.array(spans), periods, np.column_stack([low, high]), both)


def _columns_of(data: Dataset) -> list[Array]:
    columns = [c for e in data.elements for c in (e.field, e.slip)]
    return [*columns, data.effort, *data.extras.values(), data.clock.time]


def _append_spans(spans: list[list[float]], clock: Clock, at: int) -> None:
    """Add the spans of a batch; one that goes on from the batch before becomes longer."""
    for i, span in enumerate(clock.spans):
        period = np.nan if span.period is None else span.period
        if i == 0 and clock.joins and spans:
            spans[-1][1] = at + span.stop
            spans[-1][2] = spans[-1][2] if span.period is not None else np.nan
        else:
            spans.append([at + span.start, at + span.stop, period])


def _require_same(data: Dataset, like: Dataset, where: str) -> None:
    require_units(data, like, where)
    if list(data.extras) != list(like.extras):
        there, before = (", ".join(names) or "none" for names in (data.extras, like.extras))
        problem = f"further inputs differ: {there} here, {before} before"
        raise MappingError(problem, where=where, remedy="Give --input for each")


class _Columns(ExitStack):
    """The files of a part as they are written."""

    def __init__(self, stem: Path) -> None:
        super().__init__()
        self._stem, self._files, self.rows = stem, list[Any](), 0

    def write(self, columns: Sequence[Array]) -> None:
        if not self._stem.parent.is_dir():
            raise RunError("the folder of kept rows is gone", where=str(self._stem.parent), remedy=_ALONE)
        try:
            if not self._files:
                self._files = [self.enter_context(_file(self._stem, i).open("wb")) for i in range(len(columns))]
            for file, values in zip(self._files, columns, strict=True):
                file.write(np.ascontiguousarray(values).data)
                file.flush()
        except OSError as error:
            raise _unwritable(self._stem.parent, error) from error
        self.rows += columns[0].size


def _unwritable(folder: Path, error: OSError) -> ErclutchError:
    there = folder.is_dir()
    free = f", {shutil.disk_usage(folder).free / 1e6:.0f} MB are free" if there else ""
    problem = f"rows cannot be kept there: {error.strerror or error}{free}"
    remedy = "Give --scratch a folder with about 50 bytes of room a row"
    return RunError(problem, where=str(folder), remedy=remedy)


@dataclass(frozen=True)
class _Passes(Blocks[T]):
    """What functions make of each block on disk, one after the other, made anew in each pass."""

    rows: DiskRows
    makes: tuple[Callable[[Any], Any], ...] = ()

    def __iter__(self) -> Iterator[T]:
        return map(self.made, self.rows.read_blocks(0, self.rows.rows))

    def made(self, block: Any) -> T:
        """What they make of one block."""
        for make in self.makes:
            block = make(block)
        return block

    def map(self, make: Callable[[T], U]) -> Blocks[U]:
        return _Passes(self.rows, (*self.makes, make))

    def fold(self, of: Callable[[Iterable[T]], U]) -> Iterator[U]:
        jobs = ((self.rows.only(*rows), rows) for rows in self.rows.ranges)
        return iter(self.rows.spread(partial(_fold_range, self.makes, of), jobs))

    def means(self, of: Callable[[T], Sequence[Array]]) -> list[float]:
        """NumPy adds an array by halves, each half by halves again; the same halves are added here."""
        leaves = list(_leaves(0, self.rows.rows))
        several = -(-self.rows.range // _LEAF)
        tasks = [leaves[at : at + several] for at in range(0, len(leaves), several)]
        jobs = ((self.rows.only(task[0][0], task[-1][1]), task) for task in tasks)
        totals = itertools.chain.from_iterable(self.rows.spread(partial(_leaf_totals, self.makes, of), jobs))

        def total(start: int, stop: int) -> Array:
            if stop - start <= _LEAF:
                return next(totals)
            middle = _middle(start, stop)
            return total(start, middle) + total(middle, stop)

        return (total(0, self.rows.rows) / self.rows.rows).tolist()


def _middle(start: int, stop: int) -> int:
    return start + (stop - start) // 2 // 8 * 8


def _leaves(start: int, stop: int) -> Iterator[tuple[int, int]]:
    if stop - start <= _LEAF:
        yield start, stop
    else:
        middle = _middle(start, stop)
        yield from _leaves(start, middle)
        yield from _leaves(middle, stop)


#: Some rows, and which of them are meant.
Job = tuple["DiskRows", Any]
Makes = tuple[Callable[[Any], Any], ...]


def _fold_range(makes: Makes, of: Callable[[Iterable[Any]], U], job: Job) -> U:
    rows, (start, stop) = job
    return of(map(_Passes[Any](rows, makes).made, rows.read_blocks(start, stop)))


def _leaf_totals(makes: Makes, of: Callable[[Any], Sequence[Array]], job: Job) -> list[Array]:
    rows, leaves = job
    values = (of(_Passes[Any](rows, makes).made(rows.read(*leaf))) for leaf in leaves)
    return [np.array([float(np.add.reduce(v)) for v in each]) for each in values]


def _fold_chain(of: Callable[[Iterable[Stretch]], U], job: Job) -> list[U]:
    """What a function makes of each piece of a chain; states go from block to block and from piece to piece."""
    rows, chain = job
    carry = None
    found: list[U] = []

    def stretches(start: int, stop: int) -> Iterator[Stretch]:
        nonlocal carry
        for at in range(start, stop, BLOCK):
            upto = min(at + BLOCK, stop)
            first, following = (rows.past_of(row) if row < rows.rows else row for row in (at, upto))
            data = rows.read(first, upto, ordered=True)
            carry = Carry(carry.end if carry and first < at else [], min(following, upto - 1) - first)
            clock = replace(data.clock, carry=carry)
            yield replace(data, clock=clock), slice(at - first, upto - first)

    for start, stop in chain:
        found.append(of(stretches(start, stop)))
    return found


class DiskRows(AbstractContextManager["DiskRows"]):
    """Rows on disk, as `TrainingRows`. A context manager: the files are gone at its end.

    Args:
        folder: where the folder of the files lies; None is the system's place for such.
        spread: runs the tasks of a pass.
    """

    def __init__(self, folder: str | Path | None = None, spread: Spread = map) -> None:
        place = Path(folder or tempfile.gettempdir())
        try:
            self._kept = tempfile.TemporaryDirectory(prefix="erclutch-rows-", dir=place)
        except OSError as error:
            raise _unwritable(place, error) from error
        self.spread = spread
        self._parts: list[Part] = []
        self._starts: Any = np.zeros(1, np.int64)
        self._spans: Array = np.zeros((0, 3))
        self._seen: dict[str, str] = {}

    def __exit__(self, *_: object) -> None:
        self._kept.cleanup()

    def __getstate__(self) -> dict[str, Any]:
        """What a task gets of it: where the files are."""
        return {**self.__dict__, "_kept": None, "_seen": {}, "spread": map}

    def stem(self, index: int) -> Path:
        """Of the files of a part that is to be read."""
        return Path(self._kept.name).absolute() / f"{index:05}"

    def add(
        self,
        batches: Iterator[Batch],
        device: DeviceName,
        derivative: Derivative,
        report: Callable[[int], None] | None = None,
    ) -> None:
        """`read_part`, then `append`."""
        self.append(read_part(batches, device, derivative, self.stem(len(self._parts)), report))

    def append(self, part: Part) -> None:
        """Take the rows of a log that was read.

        Raises:
            SettingError: a log that was there before.
            MappingError: units or further inputs that differ from those of the logs before.
        """
        source = part.source
        refuse_twin(source.name, source.digest, self._seen)
        if self._parts:
            _require_same(part.like, self.like, source.name)
        self._parts.append(replace(part, spans=part.spans[:0]))
        self._spans = np.vstack([self._spans, part.spans + np.array([self.rows, self.rows, 0.0])])
        self._starts = np.append(self._starts, self.rows + source.kept)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self._starts[-1])

    @property
    def sources(self) -> list[Source]:
        """The logs."""
        return [part.source for part in self._parts]

    @property
    def like(self) -> Dataset:
        """An empty data set of the same device, units and inputs."""
        return self._parts[0].like

    @property
    def device(self) -> DeviceName:
        """Which device the rows are of."""
        return self.like.device

    @property
    def units(self) -> Units:
        """Units of effort, field and slip."""
        return self.like.units

    @property
    def where(self) -> str:
        """The logs' names, for messages."""
        return self.sources[0].name if len(self.sources) == 1 else f"{len(self.sources)} logs"

    @property
    def period(self) -> float:
        """Sampling period in s: the median over segments."""
        return float(np.median(list(sum((part.periods for part in self._parts), Counter[float]()).elements())))

    @property
    def under_both_fields(self) -> int:
        """Rows in which both elements of a pair are under field."""
        return sum(part.both for part in self._parts) * (len(self.like.elements) > 1)

    @property
    def ends(self) -> Dataset:
        """Two rows: the smallest and the largest value of each column."""
        low, high = (pick([part.ends[:, i] for part in self._parts], axis=0) for i, pick in ((0, np.min), (1, np.max)))
        both: Array = np.column_stack([low, high])
        return self._dataset([*both], Clock(np.arange(2.0), ()))

    @property
    def blocks(self) -> Blocks[Dataset]:
        """All rows in their order, some at a time."""
        return _Passes(self)

    @property
    def range(self) -> int:
        """Rows of a task: a number of them that follows from all rows alone."""
        longer = -(-self.rows // (RANGE * _MOST_RANGES))
        return RANGE << max(longer - 1, 0).bit_length()

    @property
    def ranges(self) -> list[tuple[int, int]]:
        """First row and end of each task."""
        return [(at, min(at + self.range, self.rows)) for at in range(0, self.rows, self.range)]

    def stretches(self, of: Callable[[Iterable[Stretch]], U], *, past: bool) -> Iterator[U]:
        """What a function makes of each range of rows, in their order.

        Args:
            of: makes it from the stretches of a range.
            past: whether the stretches bring the states of their past along. Then a task is a chain of ranges, as far
                as a gapless span reaches over their borders, and a range is cut where its first span begins.
        """
        if not past:
            return self.blocks.fold(partial(_whole_blocks, of))
        jobs = ((self.only(chain[0][0], chain[-1][1]), chain) for chain in self._chains())
        return itertools.chain.from_iterable(self.spread(partial(_fold_chain, of), jobs))

    def only(self, start: int, stop: int) -> DiskRows:
        """What a task needs to know of these rows: little, however many there are in all."""
        part, end = (int(np.searchsorted(self._starts, row, side="right")) - 1 for row in (start, stop - 1))
        span, last = (int(np.searchsorted(self._spans[:, 0], row, side="right")) - 1 for row in (start, stop - 1))
        some = copy(self)
        some._parts, some._starts = self._parts[part : end + 1], self._starts[part : end + 2]
        some._spans = self._spans[span : last + 1]
        return some

    def _chains(self) -> list[list[tuple[int, int]]]:
        chains: list[list[tuple[int, int]]] = []
        begins = self._spans[:, 0]
        for start, stop in self.ranges:
            place = int(np.searchsorted(begins, start))
            cut = int(begins[place]) if place < begins.size and begins[place] < stop else stop
            if start < cut:
                chains[-1].append((start, cut))
            if cut < stop:
                chains.append([(cut, stop)])
        return chains

    def past_of(self, row: int) -> int:
        """The first of the rows that a model with a memory wants ahead of a row: inside its span."""
        begin = self._spans[int(np.searchsorted(self._spans[:, 0], row, side="right")) - 1, 0]
        shortest = min(min(part.periods) for part in self._parts)
        return max(int(begin), row - int(max(_BEHIND / shortest, 5.0)) - 8)

    def thinned(self, most: int) -> Dataset:
        """Every so-many-th row, so that at most ``most`` are left, without their past."""
        step = max(1, -(-self.rows // most))
        count, period = -(-self.rows // step), step * self.period
        clock = Clock(np.arange(float(count)) * period, (Span(0, count, period),))
        return self._dataset([self._column(i, 0, self.rows, step) for i in range(self._wide)], clock)

    def windows(self, starts: Sequence[int], length: int) -> Dataset:
        """Some stretches of neighbouring rows, with their clock."""
        parts = [self.read(at, min(at + length, self.rows), ordered=True) for at in starts]
        return joined([part.take(np.ones(part.rows, np.bool_)) for part in parts])

    def read_blocks(self, start: int, stop: int) -> Iterator[Dataset]:
        """The rows [start, stop), some at a time, without their past."""
        return (self.read(at, min(at + BLOCK, stop)) for at in range(start, stop, BLOCK))

    def read(self, start: int, stop: int, *, ordered: bool = False) -> Dataset:
        """The rows [start, stop), with their clock if they are asked for in their order."""
        columns = [self._column(index, start, stop) for index in range(self._wide)]
        if not ordered:
            rows = stop - start
            return self._dataset(columns, Clock(np.arange(float(rows)), (Span(0, rows, None),)))
        first, last = (int(np.searchsorted(self._spans[:, 0], row, side="right")) - 1 for row in (start, stop - 1))
        spans = [Span(int(a), int(b), None if p != p else p) for a, b, p in self._spans[first : last + 1].tolist()]
        time, joins = self._column(self._wide, start, stop), spans[0].start < start
        return self._dataset(columns, Clock(time, within(spans, start, stop), joins))

    @property
    def _wide(self) -> int:
        """Columns but for the time, which is the last."""
        return 2 * len(self.like.elements) + 1 + len(self.like.extras)

    def _column(self, index: int, start: int, stop: int, step: int = 1) -> Array:
        first, last = (int(np.searchsorted(self._starts, row, side="right")) for row in (start, stop - 1))
        pieces: list[Array] = []
        for part, begin in zip(self._parts[first - 1 : last], self._starts[first - 1 : last].tolist(), strict=True):
            at = max(start, begin)
            at += (start - at) % step
            pieces.append(part.column(index, at - begin, min(stop - begin, part.source.kept), step))
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def _dataset(self, columns: Sequence[Array], clock: Clock) -> Dataset:
        count = len(self.like.elements)
        return replace(
            self.like,
            elements=tuple(Element(columns[2 * i], columns[2 * i + 1]) for i in range(count)),
            effort=columns[2 * count],
            extras=dict(zip(self.like.extras, columns[2 * count + 1 :], strict=False)),
            clock=clock,
            source_rows=((0, columns[0].size),),
        )


def _whole_blocks(of: Callable[[Iterable[Stretch]], U], blocks: Iterable[Dataset]) -> U:
    return of((block, slice(None)) for block in blocks)


#: The rows that a model is fitted to. What both kinds offer is ``device``, ``units``, ``rows``, ``period``, ``where``,
#: ``blocks``, ``ends`` and ``thinned``.
TrainingRows = Dataset | DiskRows
