"""Logs larger than memory are read once; their rows are kept as fields, slips and effort in a temporary file.

All passes of a fit go over that file block by block. Blocks do not depend on how the logs were read, and means are
added in the order in which NumPy adds an array in memory, so a network gets the same weights as from a data set.
"""

from __future__ import annotations

import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, TypeVar

import numpy as np

from erclutch.errors import ErclutchError, LogError, MappingError, RunError
from erclutch.logs import Batch
from erclutch.logs.batches import datasets
from erclutch.logs.blocks import Blocks
from erclutch.logs.dataset import Dataset, joined, refuse_twin, require_units
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units
from erclutch.signals.speed import Derivative

T = TypeVar("T")
U = TypeVar("U")

BLOCK = 65_536  # rows at a time; a multiple of all blocks that fits and models work in
_LEAF = 131_072  # rows that are added up at once


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
class _Passes(Blocks[T]):
    """What a function makes of each block on disk, made anew in each pass."""

    rows: DiskRows
    make: Callable[[Dataset], T]

    def __iter__(self) -> Iterator[T]:
        for start in range(0, self.rows.rows, BLOCK):
            yield self.make(self.rows.read(start, min(start + BLOCK, self.rows.rows)))

    def map(self, make: Callable[[T], U]) -> Blocks[U]:
        return _Passes(self.rows, lambda block: make(self.make(block)))

    def means(self, of: Callable[[T], Sequence[Array]]) -> list[float]:
        def total(start: int, stop: int) -> Array:
            """NumPy adds an array by halves, each half by halves again; the same halves are added here."""
            if stop - start <= _LEAF:
                values = of(self.make(self.rows.read(start, stop)))
                return np.array([float(np.add.reduce(v)) for v in values])
            middle = start + (stop - start) // 2 // 8 * 8
            return total(start, middle) + total(middle, stop)

        return (total(0, self.rows.rows) / self.rows.rows).tolist()


class DiskRows(AbstractContextManager["DiskRows"]):
    """Rows on disk, as `TrainingRows`. A context manager: the file is gone at its end, and with the process.

    Args:
        folder: where the temporary file lies; None is the system's place for such.
    """

    def __init__(self, folder: str | Path | None = None) -> None:
        self._folder = Path(folder or tempfile.gettempdir())
        try:
            self._file: IO[bytes] = tempfile.TemporaryFile(dir=self._folder)  # noqa: SIM115
        except OSError as error:
            raise self._unwritable(error) from error
        self._like: Dataset | None = None
        self._seen: dict[str, str] = {}
        self._periods: Counter[float] = Counter()
        self.sources: list[Source] = []
        self.rows = 0

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(
        self,
        batches: Iterator[Batch],
        device: DeviceName,
        derivative: Derivative,
        report: Callable[[int], None] | None = None,
    ) -> None:
        """Read a log to its end.

        Args:
            batches: of one log.
            device: how signals become elements.
            derivative: filter for positions.
            report: called with the rows of the file that are read.

        Raises:
            LogError, MappingError: see `erclutch.read`; units that change on the way or from log to log.
            SettingError: a log that was there before, or a filter that does not fit.
            RunError: the disk is full.
        """
        before, last, read = self.rows, None, 0
        for batch, data in datasets(batches, device, derivative):
            if last is None:
                refuse_twin(batch.recording, self._seen)
            last = last or batch.recording
            if data is not None:
                self._require_same(data, batch)
                self._write(data)
                uniform = batch.recording.uniform
                self._periods[batch.recording.period] += len(batch.recording.segments) if uniform else 1
            read = batch.stop
            if report is not None:
                report(read)
        if last is None or self.rows == before:
            name = "the log" if last is None else last.name
            raise LogError("no row is left", where=name, remedy="Give a log with finite values")
        self.sources.append(Source(last.name, last.digest, last.origin, read, self.rows - before, last.notes))

    @property
    def like(self) -> Dataset:
        """An empty data set of the same device, units and inputs."""
        assert self._like is not None
        return self._like

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
        return float(np.median(list(self._periods.elements())))

    @property
    def in_memory(self) -> None:
        """The rows need not fit into memory."""

    @property
    def blocks(self) -> Blocks[Dataset]:
        """All rows in their order, some at a time."""
        return _Passes(self, lambda block: block)

    def thinned(self, most: int) -> Dataset:
        """Every so-many-th row, so that at most ``most`` are left, without their past."""
        step = max(1, -(-self.rows // most))
        parts: list[Dataset] = []
        at = 0
        for block in self.blocks:
            parts.append(block.picked(np.arange(-at % step, block.rows, step)))  # a copy: the block goes
            at += block.rows
        whole = joined(parts)
        clock = Clock(np.arange(float(whole.rows)) * (step * self.period), (Span(0, whole.rows, step * self.period),))
        return replace(whole, clock=clock, sources=self.like.sources, source_rows=((0, whole.rows),))

    def read(self, start: int, stop: int) -> Dataset:
        """The rows [start, stop)."""
        rows = stop - start
        self._file.seek(8 * self._wide * start)
        content = np.frombuffer(self._file.read(8 * self._wide * rows))
        columns = np.ascontiguousarray(content.reshape(rows, self._wide).T)
        count = len(self.like.elements)
        return replace(
            self.like,
            elements=tuple(Element(columns[2 * i], columns[2 * i + 1]) for i in range(count)),
            effort=columns[2 * count],
            extras=dict(zip(self.like.extras, columns[2 * count + 1 :], strict=True)),
            clock=Clock(np.arange(float(rows)), (Span(0, rows, None),)),
            source_rows=((0, rows),),
        )

    @property
    def _wide(self) -> int:
        return 2 * len(self.like.elements) + 1 + len(self.like.extras)

    def _write(self, data: Dataset) -> None:
        columns = [c for e in data.elements for c in (e.field, e.slip)]
        columns += [data.effort, *data.extras.values()]
        content = np.column_stack(columns).tobytes()
        try:
            self._file.seek(8 * self._wide * self.rows)
            self._file.write(content)
            self._file.flush()
        except OSError as error:
            raise self._unwritable(error) from error
        self.rows += data.rows

    def _require_same(self, data: Dataset, batch: Batch) -> None:
        if self._like is None:
            self._like = replace(data.picked(slice(0)), notes=())
            return
        name = batch.recording.name
        where = f"{name}, data rows {batch.start + 1} to {batch.stop}" if batch.start else name
        require_units(data, self.like, where)
        if list(data.extras) != list(self.like.extras):
            there, before = (", ".join(names) or "none" for names in (data.extras, self.like.extras))
            problem = f"further inputs differ: {there} here, {before} before"
            raise MappingError(problem, where=where, remedy="Give --input for each")

    def _unwritable(self, error: OSError) -> ErclutchError:
        there = self._folder.is_dir()
        free = f", {shutil.disk_usage(self._folder).free / 1e6:.0f} MB are free" if there else ""
        problem = f"rows cannot be kept there: {error.strerror or error}{free}"
        remedy = "Give --scratch a folder with about 40 bytes of room a row"
        return RunError(problem, where=str(self._folder), remedy=remedy)


#: The rows that a model is fitted to. What both kinds offer is ``device``, ``units``, ``rows``, ``period``, ``where``,
#: ``blocks``, ``in_memory`` (None where the rows need not fit into memory) and ``thinned``.
TrainingRows = Dataset | DiskRows
