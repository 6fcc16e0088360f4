"""A reader in a process of its own: its answer, its limits, and each way in which it can fail."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read_table
from erclutch.logs.readers import budget, child_process
from tests.support.slow_params import slow_behind

OWN = """
import os, sys
from pathlib import Path
from erclutch.errors import LogError
from erclutch.logs.readers.child_process import serve

def read(path, how):
    if how == "limits":
        import resource
        limits = [resource.getrlimit(getattr(resource, f"RLIMIT_{n}"))[0] for n in ("AS", "FSIZE", "CPU", "CORE")]
        return [limits, [1.0, 2.0, 3.0]], {"name": path}
    if how == "memory":
        bytearray(3 << 30)
    if how == "loop":
        while True:
            pass
    if how == "tell":
        import time
        Path(path).write_text(str(os.getpid()))
        time.sleep(60)
    if how == "said":
        raise LogError("no such thing", remedy="Look again")
    if how == "odd":
        raise IndexError("list index out of range")
    if how == "exit":
        sys.stderr.write("one\\nthe last line")
        os._exit(3)
    if how == "signal":
        os.abort()

code = serve(read)
sys.exit(4 if sys.argv[-1] == "code" else code)
"""


PIECES = """
import os, sys
import numpy as np
from erclutch.errors import LogError
from erclutch.logs.readers.child_process import serve_pieces

def read(path, how):
    for number in range(5):
        if number == 3 and how == "said":
            raise LogError("no such thing", remedy="Look again")
        if number == 3 and how == "signal":
            os.abort()
        yield [np.arange(number), np.ones(2)], {"number": number, "pid": os.getpid()}

sys.exit(serve_pieces(read))
"""


@pytest.fixture
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "own_reader.py").write_text(OWN, encoding="utf-8")
    (tmp_path / "own_pieces.py").write_text(PIECES, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    return "own_reader"


@pytest.mark.slow
def test_it_answers_within_its_limits(reader: str, tmp_path: Path) -> None:
    (limits, more), texts = child_process.run(
        reader, tmp_path / "a.mat", "limits", memory=2 << 30, seconds=7.2
    )
    assert limits.tolist() == [2 << 30, 2 << 30, 8, 0]
    assert more.tolist() == [1.0, 2.0, 3.0]
    assert more.dtype == np.float64
    assert texts["name"] == str(tmp_path / "a.mat")


@pytest.mark.slow
def test_larger_files_have_more_time_and_memory(tmp_path: Path, reader: str) -> None:
    path = tmp_path / "a.mat"
    path.write_bytes(bytes(2 << 20))
    (limits, _), _ = child_process.run(reader, path, "limits")
    room = (1 << 30) + (128 << 20)  # bytes: 1 GiB, and 64 times the size
    assert limits.tolist() == [room, room, 16, 0]
    folder = tmp_path / "bag"
    folder.mkdir()
    for name in ("a", "b"):
        (folder / name).write_bytes(bytes(100))
    assert budget.size_of(folder) == 200
    assert budget.size_of(tmp_path / "none") == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("memory", "reading the file needs more than 2048 MiB"),
        ("said", "no such thing. Look again"),
        ("signal", r"the reader broke on this file \(signal 6\)"),
        *slow_behind(
            0,
            [
                (
                    "odd",
                    r"damaged or of a kind that cannot be read \(IndexError: list index out of range\)",
                ),
                ("exit", r"the reader broke on this file \(code 3: the last line\)"),
                ("code", r"the reader broke on this file \(code 4"),
                ("loop", "takes longer than the 0.5 s that its size allows|took longer than"),
            ],
        ),
    ],
)
def test_each_failure_is_a_line(reader: str, tmp_path: Path, how: str, said: str) -> None:
    with pytest.raises(LogError, match=said):
        child_process.run(
            reader, tmp_path / "a.mat", how, memory=2 << 30, seconds=0.5 if how == "loop" else None
        )


@pytest.mark.slow
def test_a_log_that_became_a_pipe_is_a_line(reader: str, tmp_path: Path) -> None:
    """Nobody fills it, so to open it had no end: the child was killed after minutes."""
    os.mkfifo(tmp_path / "a.mat")
    with pytest.raises(LogError, match="the file was replaced while it was read"):
        child_process.run(reader, tmp_path / "a.mat", "limits", memory=2 << 30)


@pytest.mark.slow
@pytest.mark.usefixtures("reader")
def test_pieces_come_one_after_another_and_the_child_ends_with_who_asked(tmp_path: Path) -> None:
    pieces = list(child_process.stream("own_pieces", tmp_path / "a", "all"))
    assert [texts["number"] for _, texts in pieces] == [0, 1, 2, 3, 4]
    assert [[values.tolist() for values in arrays] for arrays, _ in pieces[:3]] == [
        *([[], [1.0, 1.0]], [[0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 1.0]])
    ]
    wanted = child_process.stream("own_pieces", tmp_path / "a", "all")
    child = next(wanted)[1]["pid"]
    del wanted  # whoever wants no more says nothing
    assert not _runs(child)


@pytest.mark.slow
@pytest.mark.usefixtures("reader")
@pytest.mark.parametrize(
    ("how", "said"), [("said", "no such thing"), ("signal", r"reader broke .*\(signal 6\)")]
)
def test_a_child_that_breaks_among_its_pieces_is_a_line(
    tmp_path: Path, how: str, said: str
) -> None:
    pieces = child_process.stream("own_pieces", tmp_path / "a", how)
    assert [next(pieces)[1]["number"] for _ in range(3)] == [0, 1, 2]
    with pytest.raises(LogError, match=said):
        next(pieces)


@pytest.mark.parametrize("pieces", [True, False])
def test_no_room_for_what_was_read_is_no_damage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pieces: bool
) -> None:
    class Full(np.ndarray[Any, Any]):
        def tofile(self, *_: object) -> None:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(
        np, "ascontiguousarray", lambda values, kind: np.asarray(values, kind).view(Full)
    )
    monkeypatch.setattr(child_process, "limit_process", lambda memory, seconds: None)
    monkeypatch.setattr(child_process, "end_with_parent", lambda: None)
    monkeypatch.setattr(sys, "argv", ["reader", str(tmp_path / "a"), str(tmp_path), "1", "1"])
    answer = [np.ones(2)], {"labels": []}
    if pieces:
        child_process.serve_pieces(lambda path: iter([answer]))
    else:
        child_process.serve(lambda path: answer)
    with pytest.raises(
        LogError, match=r"temporary files .No space left on device.* Make room there"
    ):
        child_process._answer(tmp_path, 0, b"", 1)


@pytest.mark.slow
@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="only Linux ends a child with its parent"
)
def test_it_ends_with_its_parent_however_that_dies(reader: str, tmp_path: Path) -> None:
    told = tmp_path / "pid"
    code = "import sys, pathlib\nfrom erclutch.logs.readers import child_process\n"
    code += f"sys.path.insert(0, {str(tmp_path)!r})\n"
    code += f"child_process.run({reader!r}, pathlib.Path({str(told)!r}), 'tell', seconds=60.0)"
    with subprocess.Popen([sys.executable, "-c", code]) as parent:
        until = time.monotonic() + 30.0
        while not (told.exists() and told.read_text()) and time.monotonic() < until:
            time.sleep(0.02)
        parent.kill()
    child = int(told.read_text())
    until = time.monotonic() + 5.0
    while _runs(child) and time.monotonic() < until:
        time.sleep(0.02)
    assert not _runs(child)


def _runs(process: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.slow
def test_a_small_file_has_little_memory(
    reader: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What unpacks to gigabytes is refused before the memory is given; a user may allow it."""
    path = tmp_path / "a.mat"
    path.write_bytes(bytes(1 << 20))
    (limits, _), _ = child_process.run(reader, path, "limits")
    assert limits[0] == (1 << 30) + (64 << 20)
    with pytest.raises(LogError, match=r"needs more than 1088 MiB") as raised:
        child_process.run(reader, path, "memory")
    assert "ERCLUTCH_READER_MEMORY=8192" in raised.value.remedy
    monkeypatch.setenv("ERCLUTCH_READER_MEMORY", "6000")
    (limits, _), _ = child_process.run(reader, path, "limits")
    assert limits[0] == 6000 << 20
    monkeypatch.setenv("ERCLUTCH_READER_MEMORY", "much")
    with pytest.raises(LogError, match=r"ERCLUTCH_READER_MEMORY: 'much' MiB"):
        child_process.run(reader, path, "limits")


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("ending", ["h5", "mat"])
@pytest.mark.parametrize("damaged", [False, True], ids=["half of either", "damaged"])
def test_a_file_that_is_written_while_it_is_read_is_a_line(
    ending: str, damaged: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Written in place, half of the old torque and half of the new came back as one log.

    Who asks the child looks at the file before and after, so that no child is needed here.
    """
    path = tmp_path / f"log.{ending}"
    columns = {"time_s": 1e-3 * np.arange(50.0), "torque_Nm": np.linspace(0.0, 1.0, 50)}
    if ending == "h5":
        import h5py

        with h5py.File(path, "w") as file:
            for name, values in columns.items():
                file[name] = values
    else:
        import scipy.io

        scipy.io.savemat(path, columns)
    assert len(read_table(path).columns) == 2
    if damaged:
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    child = child_process.run

    def beside_a_writer(*given: Any, **named: Any) -> Any:
        try:
            return child(*given, **named)
        finally:
            os.utime(path, ns=(1, 1))  # as a write does

    monkeypatch.setattr(child_process, "run", beside_a_writer)
    with pytest.raises(LogError, match=r"the file was written while it was read"):
        read_table(path)
