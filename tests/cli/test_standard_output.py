"""What a command says may go nowhere: to a reader that left, a closed output, a full disk. Its work is kept."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path
from subprocess import PIPE

import pytest

from erclutch.cli import main
from erclutch.cli.standard_output import StandardOutput
from erclutch.logs.synthetic import write_synthetic_log
from tests.support.slow_params import slow_but

COMMAND = (sys.executable, "-m", "erclutch")
FIT = ("fit", "log.csv", "--models", "bingham", "--lag", "none", "--json", "--out", "run")


def broken_pipe() -> int:
    """The end of a pipe that nobody reads."""
    reading, writing = os.pipe()
    os.close(reading)
    return writing


@pytest.mark.slow
@pytest.mark.parametrize(
    "words", slow_but([("--version",)], [("laws",), ("--version",), ("fit", "--help")])
)
def test_a_reader_that_went_away_is_no_error(words: tuple[str, ...]) -> None:
    pipe = broken_pipe()
    done = subprocess.run([*COMMAND, *words], stdout=pipe, stderr=PIPE, text=True, timeout=60)
    os.close(pipe)
    assert (done.returncode, done.stderr) == (0, "")


def test_an_output_that_a_plug_in_closes_is_told() -> None:
    """What came after it ended in a traceback."""
    output = StandardOutput(io.StringIO())
    output.close()
    output.write("an answer")
    output.flush()
    assert output.failure is not None
    assert "closed" in str(output.failure)


@pytest.mark.slow
def test_a_closed_output_is_told() -> None:
    done = subprocess.run(
        [*COMMAND, "laws"], stderr=PIPE, text=True, timeout=60, preexec_fn=lambda: os.close(1)
    )
    assert done.returncode == 2
    assert done.stderr == "error: the output cannot be written (standard output is closed)\n"


@pytest.mark.slow
@pytest.mark.parametrize("output", ["full", "closed", "unheard"])
def test_a_run_is_kept_whatever_becomes_of_the_output(output: str, tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv")
    stdout = broken_pipe() if output == "unheard" else os.open("/dev/full", os.O_WRONLY)
    done = subprocess.run(
        [*COMMAND, *FIT],
        cwd=tmp_path,
        stdout=stdout,
        stderr=PIPE,
        text=True,
        timeout=120,
        preexec_fn=(lambda: os.close(1)) if output == "closed" else None,
    )
    os.close(stdout)
    assert done.returncode == (0 if output == "unheard" else 2), done.stderr
    assert "Traceback" not in done.stderr
    assert (tmp_path / "run" / "run.json").is_file()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no full device")
@pytest.mark.parametrize(("words", "code"), [(("fit", "none.csv"), 2), (("--nope",), 2)])
@pytest.mark.parametrize("streams", [("stderr",), ("stdout", "stderr")])
def test_an_error_that_cannot_be_told_keeps_its_exit_code(
    words: tuple[str, ...],
    code: int,
    streams: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It was 1, which says that a question is open."""
    monkeypatch.chdir(tmp_path)
    with open("/dev/full", "w", buffering=1) as full:
        for stream in streams:
            monkeypatch.setattr(sys, stream, full)
        assert main(words) == code


@pytest.mark.slow
def test_names_that_are_not_utf_8(tmp_path: Path) -> None:
    log, run = os.fsdecode(b"lo\xffg.csv"), os.fsdecode(b"r\xffn")
    write_synthetic_log(tmp_path / log)
    for words in (
        ("fit", log, "--models", "bingham", "--lag", "none", "--out", run),
        ("report", run),
    ):
        done = subprocess.run(
            [*COMMAND, *words], cwd=tmp_path, capture_output=True, text=True, timeout=120
        )
        assert done.returncode == 0, done.stderr
    assert (tmp_path / run / "report.html").is_file()


def test_the_first_failure_is_kept_and_the_rest_is_dropped() -> None:
    with open(broken_pipe(), "w", encoding="utf-8") as stream:
        output = StandardOutput(stream)
        output.write("a line\n")
        output.flush()
        first = output.failure
        output.write("more\n")
        output.flush()
    assert isinstance(first, BrokenPipeError)
    assert output.failure is first
    assert output.unheard


@pytest.mark.parametrize(
    ("encoding", "seen"), [("utf-8", "·█ N·m é"), ("cp1252", "·# N·m é"), ("ascii", ".# N.m ?")]
)
def test_signs_that_an_encoding_lacks_are_written_by_like_signs(encoding: str, seen: str) -> None:
    raw = io.BytesIO()
    output = StandardOutput(io.TextIOWrapper(raw, encoding=encoding))
    for sign in "·█ N·m é":
        output.write(sign)
    output.flush()
    assert raw.getvalue().decode(encoding) == seen
    assert output.failure is None
