"""A table that is wider than any log is refused before its names are understood, and each name is understood once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, Table, plan_of, read_table
from erclutch.logs.columns import name_ends, names, seen_columns
from erclutch.logs.log_file import finished
from erclutch.logs.readers.budget import NAMES

ROW = np.zeros(3)


def understood() -> int:
    return names.spoken.cache_info().misses


def test_a_table_wider_than_any_log_is_refused_before_a_name_is_understood() -> None:
    columns = {f"wide channel {k} of a rig": ROW for k in range(1001)}
    before = understood()
    with pytest.raises(LogError, match="3 rows of 1,001 columns: a log has one row a sample"):
        finished(Table("a.csv", columns, {}, "0" * 64), (), "a.csv")
    assert understood() == before


@pytest.mark.slow
@pytest.mark.parametrize("end", ["csv", "json"])
def test_so_is_such_a_file(tmp_path: Path, end: str) -> None:
    labels = [f"{end} channel {k} of a broad rig" for k in range(1500)]
    path = tmp_path / f"wide.{end}"
    rows = [[str(k % 7 + row / 8) for k in range(1500)] for row in range(30)]
    text = "\n".join(",".join(cells) for cells in [labels, *rows])
    if end == "json":
        objects = (
            ",".join(f'"{label}": {cell}' for label, cell in zip(labels, cells, strict=True))
            for cells in rows
        )
        text = "[" + ",\n".join(f"{{{each}}}" for each in objects) + "]"
    path.write_text(text)
    before = understood()
    with pytest.raises(LogError, match="30 rows of 1,500 columns: a log has one row a sample"):
        read_table(path)
    assert understood() - before < 100


@pytest.mark.parametrize(
    "kept",
    [names.spoken, names._words_of, name_ends.split_end, seen_columns.unit_fits],
)
def test_as_many_names_are_kept_as_a_file_may_have(kept: object) -> None:
    assert kept.cache_info().maxsize >= NAMES  # type: ignore[attr-defined]


def _asked_of_names(count: int, monkeypatch: pytest.MonkeyPatch) -> int:
    """How often a name is asked for its words while a table of so many channels without a field is planned."""
    asked = 0
    says = names.SpokenName.says

    def counted(self: names.SpokenName, words: frozenset[str]) -> bool:
        nonlocal asked
        asked += 1
        return says(self, words)

    angle = np.arange(40) / 5.0
    columns = {"time": angle, "speed": np.sin(angle), "torque": np.tanh(np.sin(angle))}
    for number in range(count):
        columns[f"channel {number} of this rig"] = np.sin((2.0 + number) * angle)
    with monkeypatch.context() as patch:
        patch.setattr(names.SpokenName, "says", counted)
        plan_of(Table("a.csv", columns, dict.fromkeys(columns), "0" * 64), ColumnMap())
    return asked


@pytest.mark.slow
def test_the_questions_to_names_grow_as_the_columns_do(monkeypatch: pytest.MonkeyPatch) -> None:
    few = _asked_of_names(60, monkeypatch)
    many = _asked_of_names(180, monkeypatch)
    assert few > 60
    assert many < 3.5 * few
