"""Levels of the field in labels, in marks of 0 and 1 and in one text of all rows are read or asked about. SYNTHETIC."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import read, read_table
from erclutch.logs.columns.marked_levels import with_levels_of_marks
from erclutch.logs.reading import Reading
from erclutch.logs.table import Table
from tests.support.command import run

TIME = np.arange(300) / 100
LEVELS = (0.0, 0.5, 1.0)
CURRENT = np.repeat(LEVELS, 100)
VELOCITY = 0.3 * np.sin(10.7 * TIME)
FORCE = (80 + 420 * CURRENT) * np.tanh(VELOCITY / 0.02) + 900 * VELOCITY
LOGGED: dict[str, Any] = {"time_s": TIME, "velocity_m_s": VELOCITY, "force_N": FORCE}


def marks(*names: str, as_words: bool = False) -> dict[str, Sequence[object]]:
    """A column for each of the last levels: 1 in its rows, else 0."""
    columns: dict[str, Sequence[object]] = {}
    for name, level in zip(names, LEVELS[-len(names) :], strict=True):
        is_level = np.isclose(CURRENT, level)
        columns[name] = [str(each) for each in is_level] if as_words else [*is_level.astype(int)]
    return columns


def labels(*words: str) -> list[str]:
    return [words[LEVELS.index(level)] for level in CURRENT.tolist()]


def written(path: Path, columns: Mapping[str, Sequence[object]]) -> Path:
    rows = zip(*{**LOGGED, **columns}.values(), strict=True)
    lines = [",".join([*LOGGED, *columns]), *(",".join(map(str, row)) for row in rows)]
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize(
    "columns",
    [
        marks("I_0A", "I_0.5A", "I_1A"),
        marks("0A", "0.5A", "1A", as_words=True),
        marks("level_0A", "level_0.5A", "level_1A"),
        marks("current_0.0", "current_0.5", "current_1.0"),
    ],
)
def test_marks_of_0_and_1_tell_the_field(
    tmp_path: Path, columns: dict[str, Sequence[object]]
) -> None:
    # The command that was printed said that no field is logged.
    log = read(written(tmp_path / "log.csv", columns))
    np.testing.assert_array_equal(log.signals["field"], CURRENT)
    np.testing.assert_allclose(log.signals["effort"], FORCE)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("columns", "name"),
    [
        (marks("I_0A", "I_05A", "I_1A"), "level"),  # 0.5 A or 5 A
        (marks("current_0.5A", "current_1.0A"), "level"),  # and rows without a mark
        ({"label": labels("I_0A", "I_05A", "I_1A")}, "label"),
        ({"label": labels("red", "green", "blue")}, "label"),
        ({"class": labels("low", "mid", "high")}, "class"),
    ],
)
def test_words_with_other_efforts_at_one_slip_are_asked_about(
    tmp_path: Path, columns: dict[str, Sequence[object]], name: str
) -> None:
    # They were read as a log without a field, and nothing was asked.
    path = written(tmp_path / "log.csv", columns)
    with pytest.raises(MappingError, match=f"--variable .?{name}=all"):
        read(path)
    assert run("inspect", path.name, cwd=tmp_path).code == 1
    logs = Reading.from_options({"variable": f"{name}=all", "field": "none"}).read(path, None)
    assert sum(log.rows for log in logs) == TIME.size


@pytest.mark.slow
def test_marks_without_a_point_ask_for_a_number(tmp_path: Path) -> None:
    path = written(tmp_path / "log.csv", marks("I_0A", "I_05A", "I_1A"))
    said = run("inspect", path.name, "--variable", "level=all", cwd=tmp_path).out
    assert 'field=0, NUMBER, 1 A"' in said


@pytest.mark.slow
def test_a_class_of_numbers_is_offered_and_a_text_of_settings_read(tmp_path: Path) -> None:
    path = written(tmp_path / "class.csv", {"label": CURRENT.tolist()})
    assert '--field "label"' in run("inspect", path.name, cwd=tmp_path).out
    path = written(tmp_path / "text.csv", {"Condition": labels("I=0", "I=0.5", "I=1")})
    log = read(path, field="field of Condition")
    np.testing.assert_array_equal(log.signals["field"], CURRENT)


@pytest.mark.parametrize(
    ("word", "option"),
    [
        ("d_0.5A", "--constant .field=0.5 A"),
        ("damper_0.5A.csv", "--constant .field=0.5 A"),
        ("run_05A", "--constant .field=NUMBER A"),
    ],
)
def test_one_text_in_all_rows_is_asked_about(tmp_path: Path, word: str, option: str) -> None:
    path = written(tmp_path / "log.csv", {"test": [word] * TIME.size})
    with pytest.raises(MappingError, match=option):
        read(path)
    assert read_table(path).metadata["test"] == word


@pytest.mark.parametrize("word", ["A17", "steel", "2 Hz"])
def test_another_text_in_all_rows_is_no_field(tmp_path: Path, word: str) -> None:
    log = read(written(tmp_path / "log.csv", {"test": [word] * TIME.size}))
    assert not log.signals["field"].any()


@pytest.mark.parametrize(
    "names", [("E1", "E2", "E3"), ("up", "down", "rest"), ("is_0A", "valid", "home")]
)
def test_marks_of_elements_and_of_states_stay(names: tuple[str, ...]) -> None:
    table = Table("log", {name: np.array(m, float) for name, m in marks(*names).items()}, {}, "")
    assert with_levels_of_marks(table) is table


def test_words_of_one_effort_are_no_field(tmp_path: Path) -> None:
    sides = ["up" if speed >= 0 else "down" for speed in VELOCITY]
    log = read(written(tmp_path / "log.csv", {"label": sides}))
    assert log.rows == TIME.size


@pytest.mark.parametrize("letter", "I_ 0.")
def test_long_names_of_marks_take_no_long_time(letter: str) -> None:
    both = np.array([0.0, 1.0])
    table = Table("log", {"I" + letter * 20_000: both, letter * 20_000 + "A": 1 - both}, {}, "")
    assert re.match("log", with_levels_of_marks(table).name)
