"""What a small file may unpack to: bombs are refused or read within little memory and time; a user may allow more."""

from __future__ import annotations

import _thread
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from erclutch.errors import LogError
from erclutch.logs import read_table
from erclutch.logs.readers import budget
from erclutch.logs.readers.budget import (
    CELLS,
    CELLS_PER_BYTE,
    MEMORY,
    NAMES,
    TEXT,
    Budget,
    take_zip,
    within_seconds,
)
from tests.support.bombs import BOMBS, MOST_MIB, MOST_SECONDS, read_alone
from tests.support.pace import within

#: These are made and read within a second.
QUICK = ("mat 7.3 unwritten", "json sparse")


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in BOMBS]
)
def test_a_bomb_takes_little(tmp_path: Path, name: str) -> None:
    file, make = BOMBS[name]
    make(tmp_path / file)
    taken = read_alone(tmp_path / file)
    assert taken.said.startswith((f"{file}: ", f"{file}, ", "2 things", "read ")), taken
    assert taken.mib <= MOST_MIB
    assert within(taken.seconds, MOST_SECONDS)


def test_limits_grow_with_the_file_and_with_what_a_user_gives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    small, large = Budget(0), Budget(1000)
    assert (small.memory, small.cells, small.text, small.names) == (MEMORY, CELLS, TEXT, NAMES)
    assert large.cells == CELLS + CELLS_PER_BYTE * 1000
    monkeypatch.setenv("ERCLUTCH_READER_MEMORY", "4096")
    raised = Budget(0)
    assert (raised.memory, raised.cells, raised.text, raised.names) == (
        4 * MEMORY,
        4 * CELLS,
        4 * TEXT,
        4 * NAMES,
    )
    assert raised.seconds == 4.0 * small.seconds
    monkeypatch.setenv("ERCLUTCH_READER_MEMORY", "512")
    assert (Budget(0).memory, Budget(0).cells) == (MEMORY // 2, CELLS)


def test_each_limit_is_told_with_its_number() -> None:
    held = Budget(0)
    held.take_cells(CELLS)
    with pytest.raises(
        LogError, match=r"unpacks to more than 25,165,824 numbers\. .*ERCLUTCH_READER_MEMORY=8192"
    ):
        held.take_cells(1)
    held.take_names(NAMES)
    with pytest.raises(LogError, match=r"unpacks to more than 16,384 names"):
        held.take_names()
    with pytest.raises(LogError, match=r"unpacks to more than 33,554,432 bytes of text"):
        held.take_text(TEXT + 1)


@pytest.mark.slow
def test_a_user_may_allow_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "wide.csv"
    path.write_text(("1," * 200 + "1\n") * 2, encoding="utf-8")
    monkeypatch.setattr(budget, "NAMES", 100)
    with pytest.raises(LogError, match="more than 100 names"):
        read_table(path)
    monkeypatch.setenv("ERCLUTCH_READER_MEMORY", "4096")
    assert len(read_table(path).columns) == 201


def test_a_damaged_archive_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.xlsx"
    path.write_bytes(b"PK\x03\x04" + bytes(100))
    with pytest.raises(LogError, match="the file is damaged"):
        take_zip(path, Budget(104))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no ulimit")
@pytest.mark.slow
@pytest.mark.parametrize("mib", [150, 200, 250, 300, 400, 500, 700, 1000])
def test_little_address_space_gives_one_error_and_no_hang(tmp_path: Path, mib: int) -> None:
    log = tmp_path / "log.csv"
    log.write_text(
        "t,field,slip,effort\n" + "".join(f"{k / 1000},1,{k % 7},{k % 5}\n" for k in range(50))
    )
    limit = f"ulimit -v {mib << 10}; exec {sys.executable} -m erclutch inspect {log}"
    done = subprocess.run(
        ["sh", "-c", limit], capture_output=True, text=True, timeout=60, check=False
    )
    assert "Traceback" not in done.stderr
    assert done.returncode == 0 or "error: " in done.stderr
    if mib < 512:
        assert (
            f"error: this process may have {mib} MiB of address space, and needs 512. Raise it"
            in done.stderr
        )


@pytest.mark.slow
def test_what_takes_longer_than_its_time_is_told_in_any_thread() -> None:
    said: list[str] = []

    def read() -> None:
        try:
            with within_seconds(0.05):
                while True:
                    with suppress(Exception):  # as a reader that takes everything for damage
                        sum(range(1000))
        except LogError as error:
            said.append(error.problem)

    read()
    other = threading.Thread(target=read)
    other.start()
    other.join(60.0)
    assert said == ["reading the file takes longer than the 0.05 s that its size allows"] * 2


def test_waiting_takes_no_time_of_the_processor_and_leaves_no_thread() -> None:
    before = _thread._count()  # pyright: ignore[reportAttributeAccessIssue]
    with within_seconds(0.02):
        time.sleep(0.1)
    time.sleep(0.01)
    assert _thread._count() == before  # pyright: ignore[reportAttributeAccessIssue]


def test_reading_ends_where_a_thread_finds_no_memory_to_begin_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """`Thread.start` waits until the thread runs, so for ever."""
    goes, ended = threading.Event(), threading.Event()

    def read() -> None:
        goes.wait(60.0)
        with within_seconds(1.0):
            pass
        ended.set()

    threading.Thread(target=read, daemon=True).start()
    monkeypatch.setattr(_thread, "start_new_thread", lambda *_: 0)
    for name in ("_start_new_thread", "_start_joinable_thread"):  # by the version of Python
        monkeypatch.setattr(threading, name, lambda *_, **__: 0, raising=False)
    goes.set()
    assert ended.wait(10.0)
