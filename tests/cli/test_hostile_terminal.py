"""What files, their names and the words of a command bring never commands the terminal: it is shown written out."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from erclutch.cli import main, terminal
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.model_file import digest_of

HOSTILE = "\x1b]0;PWN\x07\x1b[2J\u202e"
SHOWN = "\\x1b]0;PWN\\x07\\x1b[2J\\u202e"
_HIDDEN = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2060-\u2069]")
_QUICK = ("--models", "quadratic", "--lag", "none")

Said = Callable[..., str]


@pytest.fixture
def said(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> Said:
    """Runs a command; all that it says, which holds no hidden character."""
    monkeypatch.chdir(tmp_path)

    def run(*words: str, code: int = 0) -> str:
        assert main(words) == code
        text = "".join(capfd.readouterr())
        assert not _HIDDEN.search(text), text
        return text

    return run


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_units_of_a_parquet_file(said: Said, tmp_path: Path) -> None:
    time = np.arange(400) / 1000
    columns = {
        "time": time,
        "current": abs(np.sin(7 * time)),
        "speed": np.sin(20 * time),
        "torque": np.sin(9 * time),
    }
    fields = [pa.field(name, pa.float64(), metadata={"unit": f"N*m{HOSTILE}"}) for name in columns]
    table = pa.Table.from_arrays(
        [pa.array(values) for values in columns.values()], schema=pa.schema(fields)
    )
    parquet.write_table(table, tmp_path / "a.parquet")
    assert f"N*m{SHOWN}" in said("inspect", "a.parquet", code=1)
    said("inspect", "a.parquet", "--json", code=1)
    said("fit", "a.parquet", code=2)


@pytest.mark.slow
@pytest.mark.filterwarnings("error:Glyph")
def test_names_of_logs_and_runs(said: Said, tmp_path: Path) -> None:
    log, runs = f"c{HOSTILE}.csv", (f"first{HOSTILE}", f"other{HOSTILE}")
    write_synthetic_log(tmp_path / log, 2.0)
    assert f"c{SHOWN}.csv" in said("inspect", log, "--plots", "drawn")
    for run in runs:
        assert f"c{SHOWN}.csv" in said("fit", log, *_QUICK, "--out", run)
    assert SHOWN in said("compare", *runs)
    assert SHOWN in said("score", log, "--run", runs[0])
    assert SHOWN in said("report", runs[0])
    assert SHOWN in said("export", runs[0], "--to", "c", "--out", f"written{HOSTILE}")


@pytest.mark.slow
def test_texts_of_a_run(said: Said, tmp_path: Path) -> None:
    write_synthetic_log(tmp_path / "log.csv", 2.0)
    said("fit", "log.csv", *_QUICK, "--out", "first")
    shutil.copytree(tmp_path / "first", tmp_path / "other")
    file = tmp_path / "other" / "run.json"
    body = json.loads(file.read_text(encoding="utf-8"))
    body["versions"]["numpy"] = body["logs"][0]["name"] = HOSTILE
    body.pop("digest")
    file.write_text(json.dumps({**body, "digest": digest_of(body)}), encoding="utf-8")
    assert (
        said("compare", "first", "other").count(SHOWN) == 3
    )  # two cells, and the sentence on what changed


def test_words_of_a_command(said: Said) -> None:
    assert f"--{SHOWN}" in said("fit", f"--{HOSTILE}", code=2)
    assert SHOWN in said("inspect", f"{HOSTILE}.csv", code=2)
    assert SHOWN in said(HOSTILE, code=2)


def test_titles_headings_and_our_own_line_ends(capsys: pytest.CaptureFixture[str]) -> None:
    terminal.tell(
        terminal.table(
            HOSTILE, [terminal.with_unit("F", HOSTILE), "two\nlines"], [["a:x:[b]", "\r"]]
        )
    )
    terminal.say(f"one\ntwo {HOSTILE}")
    printed = capsys.readouterr().out
    assert not _HIDDEN.search(printed)
    assert printed.count(SHOWN) == 3
    assert "one\ntwo " in printed
    assert re.search("two *\n.*lines", printed)
    assert "a:x:[b]" in printed


@pytest.mark.slow
@pytest.mark.parametrize("width", ["0", "1", "2", "abc"])
def test_help_ends_on_a_screen_of_next_to_no_columns(
    said: Said, monkeypatch: pytest.MonkeyPatch, width: str
) -> None:
    """A word was cut without end."""
    monkeypatch.setenv("COLUMNS", width)
    assert said("fit", "--help").endswith("\n")
