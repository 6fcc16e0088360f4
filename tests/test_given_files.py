"""A file of gigabytes in which next to nothing was ever written is refused at its first look."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.errors import LogError
from erclutch.files import given_files
from erclutch.files.given_files import UnfitFileError, file_digest, has_large_holes, small_file
from erclutch.logs.log_file import read_table
from tests.support.log_formats import FORMATS, small_log

MIB = 1 << 20

pytestmark = pytest.mark.skipif(not hasattr(os, "SEEK_HOLE"), reason="the system tells no holes")


def made(path: Path, written: list[int], size: int) -> Path:
    """A file in which 4 kB are written at these places, in MiB."""
    with path.open("wb") as file:
        for place in written:
            file.seek(place * MIB)
            file.write(b"1" * 4096)
        file.truncate(size * MIB)
    return path


@pytest.mark.parametrize(
    ("written", "size", "large"),
    [
        ([0], 255, False),  # as small files are, whatever they hold
        ([0, 200], 201, False),
        ([0, 200], 300, True),
        ([0, 299], 300, True),
        ([], 300, True),
        ([0, 100, 200, 300, 400], 401, True),  # holes count together
    ],
)
def test_what_was_never_written_is_counted(
    written: list[int], size: int, large: bool, tmp_path: Path
) -> None:
    with made(tmp_path / "log", written, size).open("rb") as file:
        assert has_large_holes(file.fileno()) == large
        assert file.tell() == 0


def test_a_large_file_that_is_written_has_no_holes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(given_files, "MOST_UNWRITTEN", MIB)
    (tmp_path / "log").write_bytes(b"1" * 3 * MIB)
    with (tmp_path / "log").open("rb") as file:
        assert not has_large_holes(file.fileno())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["csv", "xlsx", "mat 5", "jsonl", "bag mcap"])
def test_a_log_of_4_gb_with_nothing_in_it_is_refused_at_once(name: str, tmp_path: Path) -> None:
    """It takes no room on the disk, and took minutes and 4 GB of memory."""
    _, file, write = FORMATS[name]
    write(tmp_path / file, small_log(50))
    path = tmp_path / file
    os.truncate(next(path.glob("*.mcap")) if path.is_dir() else path, 4_000 * MIB)
    with pytest.raises(LogError, match="more than 256 MiB of the file were never written"):
        read_table(path)


@pytest.mark.parametrize("read", [small_file, file_digest])
def test_a_file_that_became_a_pipe_behind_the_look_at_it_is_refused(
    read: Callable[[Path], object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The opening of a pipe that nobody fills has no end."""
    monkeypatch.setattr(given_files, "_require_plain", lambda path: None)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UnfitFileError, match="was replaced while it was read"):
        read(tmp_path / "pipe")
