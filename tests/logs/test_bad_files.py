"""Each kind of bad file and the message that it gets; nothing but errors of ours ever comes out."""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError, MappingError, TimingError
from erclutch.logs import read
from tests.support.examples import examples

HEAD = "t [s],field [V],slip [rad/s],effort [N*m]\n"
LINES = [f"{i / 1000},1,{i},{i * 2}\n" for i in range(20)]


def error_of(path: Path) -> str:
    with pytest.raises((LogError, MappingError)) as caught:
        read(path)
    return str(caught.value)


@pytest.mark.skipif(not Path("/proc/uptime").exists(), reason="this system has no /proc")
def test_no_look_is_taken_into_a_file_of_the_system_that_has_no_size(tmp_path: Path) -> None:
    """A link to /proc/kmsg, called log.csv, was waited for without end."""
    link = tmp_path / "log.csv"
    link.symlink_to("/proc/uptime")
    assert "the file is empty" in error_of(link)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "log.csv: the file is empty. Give a log with one row a sample."),
        (
            HEAD,
            "log.csv: no row of numbers in 1 line (it begins with 't [s],field [V],slip [rad/s],effort [N*m]'). "
            "Give a table of numbers with one row a sample, or check the file's format.",
        ),
        (HEAD + LINES[0], "log.csv: only 1 row of data, 10 are needed. Give a longer log."),
        (
            HEAD + "".join(LINES) + "0.02,1,stalled,4\n" + LINES[1],
            "log.csv: line 22, column slip is 'stalled' where a number is expected. "
            "Leave such rows out: --invalid drop; or correct them.",
        ),
        (
            HEAD + "".join(LINES) + "0.02,1,nan,4\n0.021,1,nan,4\n0.022,1,nan,4\n",
            "log.csv: column slip has 3 values missing or infinite, the first (nan) in data row 21. "
            "Correct them, or cut the log there with --invalid drop.",
        ),
        (
            HEAD + "".join(LINES) + "0.02,1,4,-inf\n",
            "log.csv: column effort has 1 value missing or infinite, the first (-infinity) in data row 21. "
            "Correct them, or cut the log there with --invalid drop.",
        ),
        (
            HEAD + "".join(LINES) + LINES[3],
            "log.csv: column t runs backwards at data row 21: 0.003 s after 0.019 s. "
            "Split the log there, sort it, choose another time column (--time) or a rate (--rate), "
            "or take the rows as points (--time none).",
        ),
        (
            HEAD + "".join(LINES) + "0.02,1,2\n0.021,1,2,3\n",
            "log.csv: line 22 has 3 cells where 4 are expected. Correct or delete that line.",
        ),
        (
            HEAD + "".join(LINES) + "0.02,1,2,3,4,5\n",
            "log.csv: line 22 has 6 cells where 4 are expected (a decimal comma?). "
            "Leave such rows out: --invalid drop; or correct them.",
        ),
    ],
)
def test_bad_rows(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    assert error_of(path) == message


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    assert (
        error_of(tmp_path / "none.csv")
        == f"{tmp_path / 'none.csv'}: there is no such file. Check the path."
    )
    assert error_of(tmp_path) == f"{tmp_path}: this is a folder, not a file. Give one log file."
    with pytest.raises(LogError):
        read("bad\0name.csv")


def test_an_address_is_to_be_downloaded_first() -> None:
    with pytest.raises(LogError) as error:
        read("https://example.org/log.csv")
    assert error.value.remedy == "Download it first: erclutch reads files alone"


def test_no_permission() -> None:
    """As root, who may read everything, it runs as nobody; pytest's own folders are closed to that one."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        path.write_text(HEAD, encoding="utf-8")
        error_of(path)  # whatever is imported on the way is imported as who we are
        Path(folder).chmod(0o755)
        path.chmod(0)
        mine = os.geteuid()
        os.seteuid(65534 if mine == 0 else mine)
        try:
            message = error_of(path)
        finally:
            os.seteuid(mine)
    assert "the file cannot be read (Permission denied). Check its permissions" in message


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(
    ("suffix", "problem"),
    [
        (
            ".csv",
            "the file holds binary data, not text. Export it as CSV, or give a .mat (MATLAB) or .parquet file.",
        ),
        (".log", "the file holds binary data, not text."),
        (
            ".mat",
            "this is neither a MATLAB v4 or v5 nor a v7.3 file (wrong first bytes). Save it with save -v7, or",
        ),
        (
            ".parquet",
            "this is not a whole Parquet file (it does not begin with PAR1). Copy the file again or",
        ),
    ],
)
def test_ten_megabytes_of_noise(tmp_path: Path, suffix: str, problem: str) -> None:
    path = tmp_path / f"log{suffix}"
    path.write_bytes(np.random.default_rng(3).bytes(10_000_000))
    assert problem in error_of(path)


def test_errors_of_timing_are_errors_of_logs(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(HEAD + "0,1,1,1\n" * 20, encoding="utf-8")
    with pytest.raises(TimingError, match="column t is 0 in all 20 rows"):
        read(path)


@pytest.mark.slow
@settings(
    max_examples=examples(100),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    data=st.binary(max_size=400)
    | st.just(b"PAR1" * 5)
    | st.binary(max_size=50).map(lambda tail: HEAD.encode() + tail),
    suffix=st.sampled_from([".csv", ".txt", ".mat", ".parquet", ".gz", ""]),
)
def test_any_bytes_in_any_file_give_an_error_of_ours(
    tmp_path: Path, data: bytes, suffix: str
) -> None:
    path = tmp_path / f"log{suffix}"
    path.write_bytes(data)
    with suppress(ErclutchError):
        assert read(path).rows


@pytest.mark.slow
@settings(
    max_examples=examples(100),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(st.lists(st.tuples(st.integers(0, 400), st.integers(0, 255)), min_size=1, max_size=5))
def test_a_mutated_log_gives_a_recording_or_an_error_of_ours(
    tmp_path: Path, changes: list[tuple[int, int]]
) -> None:
    data = bytearray((HEAD + "".join(LINES)).encode())
    for place, byte in changes:
        data[place % len(data)] = byte
    path = tmp_path / "log.csv"
    path.write_bytes(bytes(data))
    with suppress(ErclutchError):
        recording = read(path)
        assert all(np.isfinite(values).all() for values in recording.signals.values())
        assert recording.segments[-1][1] == recording.rows
