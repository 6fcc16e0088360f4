"""Pipes, devices, files without an end and huge files in the place of what is small: one line, at once."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.errors import LogError, RunError
from erclutch.files import given_files
from erclutch.files.given_files import file_digest, small_file, small_json, small_text, toml_of
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.runs import kept_columns
from erclutch.runs.run_folder import read_run
from erclutch.runs.run_rows import read_rows
from tests.support.command import good, refused

ODD: dict[str, Callable[[Path], None]] = {
    "a pipe": lambda path: os.mkfifo(path),
    "a device": lambda path: path.symlink_to("/dev/zero"),
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log and a run of it."""
    folder = tmp_path_factory.mktemp("odd")
    write_synthetic_log(folder / "log.csv", seconds=4.0)
    good("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out", "run", cwd=folder)
    return folder


@pytest.mark.parametrize("make", ODD.values(), ids=ODD)
def test_a_small_file_is_a_plain_file(make: Callable[[Path], None], tmp_path: Path) -> None:
    make(tmp_path / "odd")
    for read in (small_file, small_text, file_digest):
        with pytest.raises(OSError, match="it is a pipe or a device and no plain file"):
            read(tmp_path / "odd")


def test_json_that_is_nested_without_end_is_told(tmp_path: Path) -> None:
    """What Python says of such a file is an error of its own kind, which half of the readers forgot."""
    (tmp_path / "deep.json").write_text("[" * 100_000)
    with pytest.raises(ValueError, match="it is nested too deep"):
        small_json(tmp_path / "deep.json")


def test_a_small_file_is_small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(given_files, "MOST_BYTES", 2 << 20)
    (tmp_path / "large").write_bytes(bytes(2 << 20))
    assert len(small_file(tmp_path / "large")) == 2 << 20
    (tmp_path / "larger").write_bytes(bytes((2 << 20) + 1))
    with pytest.raises(OSError, match="it has more than 2 MiB"):
        small_file(tmp_path / "larger")
    with pytest.raises(IsADirectoryError):
        small_file(tmp_path)


@pytest.mark.parametrize(
    "text",
    ["a" + ".a" * 50_000 + "=1", "[" + '"b c" . ' * 50_000 + "d]", "x={" + "a." * 50_000 + "b=1}"],
)
def test_a_name_of_many_parts_takes_no_time(text: str) -> None:
    """The library takes the square of their number: a file of 200 kB took minutes."""
    with pytest.raises(ValueError, match="more than 100 parts"):
        toml_of(text.encode())
    assert toml_of(b"a.b.c = [" + b"0.25, " * 1000 + b"]")["a"]["b"]["c"] == [0.25] * 1000


@pytest.mark.slow
@pytest.mark.parametrize("make", ODD.values(), ids=ODD)
def test_no_command_waits_for_a_pipe_or_reads_a_device_to_its_end(
    make: Callable[[Path], None], place: Path, tmp_path: Path
) -> None:
    shutil.copytree(place, tmp_path, dirs_exist_ok=True)
    for name in ("odd.toml", "odd.json"):
        make(tmp_path / name)
    made = shutil.copytree(tmp_path / "run", tmp_path / "other")
    (made / "run.json").unlink()
    make(made / "run.json")
    for words in (
        ("inspect", "log.csv", "--map", "odd.toml"),
        ("report", "other", "--out", "report.html"),
        ("table", "other"),
        ("export", "other", "--to", "c", "--out", "made"),
        ("predict", "log.csv", "--run", "other", "--out", "out.csv"),
        ("simulate", "training", "--seconds", "1", "--rig-file", "odd.toml", "--out", "out.csv"),
        ("excite", "--rig-limits", "odd.toml", "--seconds", "1", "--out", "out.csv"),
        ("live", "--headless", "--seconds", "1", "--run", "odd.json"),
    ):
        said = refused(*words, cwd=tmp_path)
        assert "it is a pipe or a device and no plain file" in said or "is no plain file" in said, (
            words,
            said,
        )


@pytest.mark.slow
@pytest.mark.parametrize("make", ODD.values(), ids=ODD)
@pytest.mark.parametrize("name", ["predictions.parquet", "models/bingham.json"])
def test_the_files_of_a_run_are_plain_files(
    make: Callable[[Path], None], name: str, place: Path, tmp_path: Path
) -> None:
    made = shutil.copytree(place / "run", tmp_path / "run")
    (made / name).unlink()
    make(made / name)
    run = read_run(made)
    with pytest.raises(RunError, match="it is a pipe or a device and no plain file"):
        run.model("bingham") if name.endswith(".json") else read_rows(run)


@pytest.mark.slow
def test_the_rows_of_a_run_have_the_budget_of_a_log(tmp_path: Path) -> None:
    """One value that stands in 60 million rows: it has less than 300 kB, and half a gigabyte in memory."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = pa.table({"time": pa.array([0.0] * 10**6)})
    with pq.ParquetWriter(tmp_path / "bomb.parquet", rows.schema, compression="zstd") as writer:
        for _ in range(60):
            writer.write_table(rows)
    assert (tmp_path / "bomb.parquet").stat().st_size < 300_000
    with pytest.raises(LogError, match="unpacks to more than"):
        kept_columns.kept_columns(tmp_path / "bomb.parquet")
