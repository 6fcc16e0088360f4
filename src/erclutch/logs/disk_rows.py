"""Rows of logs that are larger than memory: read once, then kept as fields, slips and effort in a temporary file.

All passes of a fit go over that file block by block. Blocks do not depend on how the logs were read, and means are
added in the order in which NumPy adds an array in memory, so a network gets the same weights as from a data set.
"""

from __future__ import annotations

import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import IO

import numpy as np
from numpy.typing import NDArray

from erclutch.dataset import Dataset, build_dataset
from erclutch.device import DeviceName, Element, Units
from erclutch.differentiate import Derivative, reach
from erclutch.dynamics import Clock, Span
from erclutch.errors import ErclutchError, LogError, MappingError, RunError, SettingError
from erclutch.logs import Batch
from erclutch.logs.batches import MARGIN
from erclutch.signals import Recording

Array = NDArray[np.float64]

BLOCK = 65_536  # rows at a time; a multiple of all blocks that fits and models work in
_LEAF = 131_072  # rows that are added up at once
_PLACE = "\0row"


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


def datasets(
    batches: Iterator[Batch], device: DeviceName, derivative: Derivative
) -> Iterator[tuple[Batch, Dataset | None]]:
    """Rows of each batch without its margins, speeds differentiated across its edges; None where none are left.

    Raises:
        MappingError, SettingError: see `erclutch.build_dataset`; a filter that looks further back than a margin.
    """
    for batch in batches:
        recording = _cored(batch)
        if recording is None:
            yield batch, None
            continue
        speeds = any(name in recording.signals for name in ("position", "theta", "alpha"))
        if batch.start and speeds and reach(derivative, recording.period) > MARGIN:
            raise SettingError(
                f"{derivative.name} at {derivative.cutoff:g} Hz remembers more than {MARGIN} rows",
                remedy="Give a higher --cutoff, or another --derivative",
                where=recording.name,
            )
        data = build_dataset(recording, device=device, derivative=derivative)
        places = data.extras[_PLACE]
        data = replace(data, extras={name: values for name, values in data.extras.items() if name != _PLACE})
        inside = (places >= batch.start) & (places < batch.stop)
        yield batch, (data if inside.all() else _only(data, inside))


def _cored(batch: Batch) -> Recording | None:
    """The recording with each row's place in the file, without segments that lie in a margin alone."""
    log, inside = batch.recording, (batch.rows >= batch.start) & (batch.rows < batch.stop)
    cored = [(a, b) for a, b in log.segments if inside[a:b].any() and b - a > 1]
    if not cored:
        return None
    keep = np.concatenate([np.arange(a, b) for a, b in cored])
    ends = np.cumsum([b - a for a, b in cored]).tolist()
    return replace(
        log,
        signals={name: values[keep] for name, values in log.signals.items()},
        extras={name: values[keep] for name, values in (*log.extras.items(), (_PLACE, batch.rows.astype(np.float64)))},
        time=log.time[keep],
        segments=tuple((end - (b - a), end) for end, (a, b) in zip(ends, cored, strict=True)),
    )


def _only(data: Dataset, rows: NDArray[np.bool_]) -> Dataset:
    """Some rows of memoryless data; unlike `Dataset.take`, lone ones too."""
    return replace(
        data,
        elements=tuple(Element(e.field[rows], e.slip[rows]) for e in data.elements),
        effort=data.effort[rows],
        extras={name: values[rows] for name, values in data.extras.items()},
        clock=Clock(data.clock.time[rows], ()),
        source_rows=((0, int(rows.sum())),),
    )


class Spool:
    """Rows on disk. A context manager: the file is gone at its end, and with the process.

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
        self._periods: Counter[float] = Counter()
        self.sources: list[Source] = []
        self.rows = 0

    def __enter__(self) -> Spool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
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
                self._refuse_twin(batch.recording)
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
        source = Source(last.name, last.digest, last.origin, read, self.rows - before, last.notes)
        self.sources.append(source)

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
        periods = np.array(sorted(self._periods))
        counts = np.cumsum([self._periods[p] for p in periods.tolist()])
        low, high = np.searchsorted(counts, [(counts[-1] - 1) // 2, counts[-1] // 2], side="right")
        return float(0.5 * (periods[low] + periods[high]))

    def blocks(self, rows: int = BLOCK) -> Iterator[Dataset]:
        """All rows in their order, some at a time; the last block may be shorter."""
        return self._pieces([rows] * (self.rows // rows) + [self.rows % rows] * (self.rows % rows > 0))

    def thinned(self, most: int) -> Dataset:
        """Every so-many-th row, so that at most ``most`` are left."""
        step = max(1, -(-self.rows // most))
        parts: list[Dataset] = []
        at = 0
        for block in self.blocks():
            mask = np.zeros(block.rows, np.bool_)
            mask[-at % step :: step] = True
            parts.append(_only(block, mask))
            at += block.rows
        return _joined(self.like, parts, step * self.period)

    def means(self, of: Callable[[Dataset], Sequence[Array]]) -> list[float]:
        """Means over all rows of what a function makes of a block, each shape (n,): as `numpy.mean` of the whole.

        NumPy adds an array by halves, each half by halves again; the same halves are read here.
        """
        sizes = _halves(self.rows)
        pieces = self._pieces(list(_flat(sizes)))

        def total(size: _Sizes) -> Array:
            if isinstance(size, tuple):
                return total(size[0]) + total(size[1])
            return np.array([float(np.add.reduce(values)) for values in of(next(pieces))])

        return (total(sizes) / self.rows).tolist()

    def _pieces(self, sizes: Sequence[int]) -> Iterator[Dataset]:
        wide = self._wide
        self._file.seek(0)
        at = 0
        for size in sizes:
            self._file.seek(8 * wide * at)  # another pass may have begun in between
            content = np.frombuffer(self._file.read(8 * wide * size))
            yield self._dataset(np.ascontiguousarray(content.reshape(size, wide).T))
            at += size

    @property
    def _wide(self) -> int:
        return 2 * len(self.like.elements) + 1 + len(self.like.extras)

    def _dataset(self, columns: Array) -> Dataset:
        count = len(self.like.elements)
        rows = columns.shape[1]
        return replace(
            self.like,
            elements=tuple(Element(columns[2 * i], columns[2 * i + 1]) for i in range(count)),
            effort=columns[2 * count],
            extras=dict(zip(self.like.extras, columns[2 * count + 1 :], strict=True)),
            clock=Clock(np.arange(float(rows)), (Span(0, rows, None),)),
            source_rows=((0, rows),),
        )

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
            none = np.zeros(data.rows, np.bool_)
            self._like = replace(_only(data, none), notes=())
            return
        name = batch.recording.name
        where = f"{name}, data rows {batch.start + 1} to {batch.stop}" if batch.start else name
        if data.units != self.like.units:
            raise MappingError(
                f"units differ: {data.units.text()} here, {self.like.units.text()} before",
                where=where,
                remedy="Give the units of each column, on the command line or in a mapping file",
            )
        if list(data.extras) != list(self.like.extras):
            there, before = (", ".join(names) or "none" for names in (data.extras, self.like.extras))
            raise MappingError(
                f"further inputs differ: {there} here, {before} before", where=where, remedy="Give --input for each"
            )

    def _refuse_twin(self, log: Recording) -> None:
        for source in self.sources:
            if source.digest == log.digest:
                raise SettingError(f"the same file as {source.name}", where=log.name, remedy="Give each log once")

    def _unwritable(self, error: OSError) -> ErclutchError:
        free = ""
        if self._folder.is_dir():
            free = f", {shutil.disk_usage(self._folder).free / 1e6:.0f} MB are free"
        return RunError(
            f"rows cannot be kept there: {error.strerror or error}{free}",
            where=str(self._folder),
            remedy="Give --scratch a folder with about 40 bytes of room a row",
        )


_Sizes = int | tuple["_Sizes", "_Sizes"]


def _halves(rows: int) -> _Sizes:
    """How NumPy's pairwise sum divides an array, down to leaves that are added up at once."""
    if rows <= _LEAF:
        return rows
    half = rows // 2
    half -= half % 8
    return _halves(half), _halves(rows - half)


def _flat(sizes: _Sizes) -> Iterator[int]:
    if isinstance(sizes, tuple):
        yield from _flat(sizes[0])
        yield from _flat(sizes[1])
    else:
        yield sizes


def _joined(like: Dataset, parts: Sequence[Dataset], period: float) -> Dataset:
    rows = sum(part.rows for part in parts)
    return replace(
        like,
        elements=tuple(
            Element(
                np.concatenate([p.elements[i].field for p in parts]),
                np.concatenate([p.elements[i].slip for p in parts]),
            )
            for i in range(len(like.elements))
        ),
        effort=np.concatenate([p.effort for p in parts]),
        extras={name: np.concatenate([p.extras[name] for p in parts]) for name in like.extras},
        clock=Clock(np.arange(float(rows)) * np.float64(period), (Span(0, rows, period),)),
        source_rows=((0, rows),),
    )
