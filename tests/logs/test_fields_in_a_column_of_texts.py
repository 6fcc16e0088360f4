"""Logs were put one under another with the names of their files: this column tells the field of each row. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read_table
from tests.support.command import run

pytestmark = pytest.mark.slow

ROWS = 100  # of each part
TIME = np.arange(ROWS) / 100
VELOCITY = 0.3 * np.sin(10.7 * TIME)
FIELDS = (0.0, 0.5, 1.0, 0.25)


def written(folder: Path, words: list[str], *, current: str = "") -> Path:
    lines = [f"part,time,{'current,' if current else ''}velocity,force"]
    for word, field in zip(words, FIELDS, strict=True):
        force = (80 + 420 * field) * np.tanh(VELOCITY / 0.02)
        for t, v, f in zip(TIME, VELOCITY, force, strict=True):
            lines.append(f"{word},{t:g},{current and f'{field},'}{v:.6g},{f:.6g}")
    path = folder / "log.csv"
    path.write_text("\n".join([*lines, ""]), "utf-8")
    return path


@pytest.mark.parametrize("form", ["I{:g}A_f1.7Hz", "{:g}A slow", "data/damper_{:g}A.csv"])
def test_the_field_that_texts_tell_is_a_column(tmp_path: Path, form: str) -> None:
    path = written(tmp_path, [form.format(field) for field in FIELDS])
    table = read_table(path)
    assert table.units["field of part"] == "A"
    assert table.columns["field of part"].tolist() == np.repeat(FIELDS, ROWS).tolist()
    said = run("inspect", "log.csv", cwd=tmp_path).out
    assert "column part tells the field: " in said
    assert said.splitlines()[-1].startswith("Understood.")


@pytest.mark.parametrize(
    "words",
    [
        ["0A", "05A", "1A", "025A"],  # half an ampere, or five
        ["M1V12", "M2V12", "M3V12", "M4V12"],
        ["soft 1", "soft 2", "hard 1", "hard 2"],
        ["0 A", "0.5 A", "1 A", "none"],
    ],
)
def test_other_texts_tell_none(tmp_path: Path, words: list[str]) -> None:
    assert "field of part" not in read_table(written(tmp_path, words)).columns


def test_beside_a_logged_current_texts_are_names(tmp_path: Path) -> None:
    path = written(tmp_path, [f"{field:g}A slow" for field in FIELDS], current="yes")
    assert set(read_table(path).columns) == {"time", "current", "velocity", "force"}
