"""A log that changes while it is read is told: half of the old log and half of the new came back as one."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import log_file, log_reader, read_batches
from erclutch.logs.log_file import read_table
from erclutch.logs.log_reader import LogSource, ReadableLog, log_at, read_by, source_of, source_with
from tests.support.log_formats import FORMATS, small_log

NAMES = {"field": "E", "slip": "w", "effort": "T"}


def written(path: Path, first: float, count: int = 60_000) -> Path:
    """A SYNTHETIC log; all its numbers have as many digits as those of another first number."""
    rows = np.arange(count)
    columns = (1e-3 * rows, rows % 7 / 7, np.sin(0.01 * rows), first + 0.1 * np.cos(0.01 * rows))
    np.savetxt(
        path,
        np.column_stack(columns),
        "%.6f",
        ",",
        header="t [s],E [V],w [rad/s],T [N m]",
        comments="",
    )
    return path


def over(path: Path) -> None:
    count = path.read_bytes().count(b"\n") - 1
    other = written(path.with_name("other.csv"), 2.0, count).read_bytes()
    with path.open("r+b") as file:
        file.write(other)


def grown(path: Path) -> None:
    with path.open("ab") as file:
        file.write(b"60.000000,0.0,0.0,1.0\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        over,
        grown,
        lambda path: os.truncate(path, path.stat().st_size // 2),
        lambda path: path.unlink(),
    ],
    ids=["written over", "grown", "cut", "gone"],
)
def test_a_log_that_changes_between_its_blocks_is_told(
    change: Callable[[Path], None], tmp_path: Path
) -> None:
    path = written(tmp_path / "log.csv", 1.0)
    batches = read_batches(path, NAMES, rows=10_000)
    assert next(batches).start == 0
    change(path)
    with pytest.raises(LogError, match=r"log\.csv: the file was written while it was read"):
        list(batches)


@pytest.mark.slow
def test_a_log_that_stays_is_read_to_its_end(tmp_path: Path) -> None:
    batches = list(read_batches(written(tmp_path / "log.csv", 1.0), NAMES, rows=10_000))
    assert (batches[0].start, batches[-1].stop) == (0, 60_000)
    assert len(batches) > 4


# --- logs that are read whole -----------------------------------------------------------------------------------------

#: A text, a binary file that a child reads, a folder of files.
WHOLE = ("csv", "jsonl", "mat 5", "xlsx", "bag mcap")
OPENED_AGAIN = ("mat 5", "xlsx", "bag mcap")  # by a child, after the digest was made


def in_format(name: str, folder: Path, factor: float) -> Path:
    """A SYNTHETIC log; those of two factors differ in all signals."""
    _, file, write = FORMATS[name]
    folder.mkdir()
    columns = {
        label: (unit, values if label == "time" else factor * values)
        for label, (unit, values) in small_log(50).items()
    }
    write(folder / file, columns)
    return folder / file


def replaced(path: Path, other: Path) -> None:
    for one in sorted(path.iterdir()) if path.is_dir() else [path]:
        twin = other / one.name if other.is_dir() else other
        os.replace(twin, one)


def made_a_pipe(path: Path, other: Path) -> None:
    for one in sorted(path.iterdir()) if path.is_dir() else [path]:
        one.unlink()
        os.mkfifo(one)


@pytest.mark.slow
@pytest.mark.parametrize("name", WHOLE)
def test_a_log_that_is_replaced_before_its_reader_opens_it_is_the_old_log_or_told(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, read_here: None
) -> None:
    """The rows were those of the new file, and the digest of the run was the old file's."""
    path = in_format(name, tmp_path / "old", 1.0)
    other = in_format(name, tmp_path / "new", 2.0)
    old = read_table(path)
    source_of = log_file.source_of

    def then_replaced(log: ReadableLog) -> LogSource:
        source = source_of(log)
        replaced(path, other)
        return source

    monkeypatch.setattr(log_file, "source_of", then_replaced)
    if name in OPENED_AGAIN:
        with pytest.raises(LogError, match=r"the file was written while it was read"):
            read_table(path)
    else:
        table = read_table(path)
        assert table.digest == old.digest
        for label, values in old.columns.items():
            assert np.array_equal(table.columns[label], values)


class Written:
    """A file that something happens to when its bytes have been read once."""

    def __init__(self, file: BufferedReader, happens: Callable[[], None]) -> None:
        self.file = file
        self.happens = happens

    def read(self, size: int = -1) -> bytes:
        content = self.file.read(size)
        self.happens()
        self.happens = lambda: None
        return content

    def seek(self, place: int) -> None:
        self.file.seek(place)


@pytest.mark.parametrize("change", [over, grown])
def test_of_a_log_that_is_written_while_its_bytes_are_fetched_the_beginning_counts(
    change: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a recorder appends is no harm; what is written over what was read is."""
    path = written(tmp_path / "log.csv", 1.0, 100)
    whole = path.read_bytes()
    log = log_at(path)
    opened_plainly = log_reader.opened_plainly

    @contextmanager
    def beside_a_writer(file: Path) -> Iterator[Written]:
        with opened_plainly(file) as content:
            yield Written(content, lambda: change(path))

    monkeypatch.setattr(log_reader, "opened_plainly", beside_a_writer)
    if change is grown:
        assert source_of(log).data == whole
    else:
        with pytest.raises(LogError, match=r"the file was written while it was read"):
            source_of(log)


@pytest.mark.parametrize("other", ["parquet", "cut", "emptied"])
def test_a_log_has_the_beginning_by_which_its_reader_was_found(other: str, tmp_path: Path) -> None:
    """Changed before any byte of it was fetched, a file came to a reader of another format, and was called damaged."""
    path = written(tmp_path / "log.csv", 1.0, 100)
    log = log_at(path)
    if other == "parquet":
        in_format("parquet", tmp_path / "new", 2.0).replace(path)
    else:
        os.truncate(path, path.stat().st_size // 2 if other == "cut" else 0)
    with pytest.raises(LogError, match=r"log\.csv: the file was written while it was read"):
        source_of(log)


def test_a_log_that_grew_since_its_reader_was_found_is_read(tmp_path: Path) -> None:
    path = written(tmp_path / "log.csv", 1.0, 100)
    log = log_at(path)
    grown(path)
    assert source_of(log).data == path.read_bytes()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
@pytest.mark.parametrize("name", WHOLE)
def test_a_log_that_becomes_a_pipe_is_an_error_at_once(
    name: str, tmp_path: Path, read_here: None
) -> None:
    """The opening of a pipe that nobody fills has no end."""
    path = in_format(name, tmp_path / "old", 1.0)
    log = log_at(path)
    made_a_pipe(path, path)
    signal.signal(signal.SIGALRM, lambda number, frame: pytest.fail("it waits for the pipe"))
    signal.alarm(10)
    try:
        with pytest.raises(LogError):
            read_by(log.plugin, source_of(log))
    finally:
        signal.alarm(0)


def test_names_of_recordings_are_kept_for_the_bytes_that_have_them(
    tmp_path: Path, read_here: None
) -> None:
    """A file that changed between two readings gave the names of the new file under the digest of the old."""
    path = in_format("xlsx", tmp_path / "old", 1.0)
    digest = source_of(log_at(path)).digest
    replaced(path, in_format("xlsx", tmp_path / "new", 2.0))
    with pytest.raises(LogError, match=r"a\.xlsx: the file was written while it was read"):
        source_with(log_at(path), digest)
