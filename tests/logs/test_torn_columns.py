"""Damaged cells and rows are asked about: without them, at the user's word, the log is what it was. SYNTHETIC."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError, MappingError
from erclutch.logs import ColumnMap, apply, plan_of, read, read_table

COUNT = 200
TIME = np.arange(COUNT) / 100
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 50)
SPEED = 10.0 * np.cos(7.0 * TIME)
TORQUE = (0.3 + 2.0 * CURRENT) * np.tanh(SPEED)
NAMES = "Time [s]{0}Coil Current [A]{0}Motor Speed [rad/s]{0}Brake Torque [Nm]"


def cells_of_rows() -> list[list[str]]:
    numbers = zip(TIME, CURRENT, SPEED, TORQUE, strict=True)
    return [[f"{t:.2f}", f"{i:g}", f"{w:.5f}", f"{m:.5f}"] for t, i, w, m in numbers]


def written(path: Path, rows: list[list[str]], mark: str = ",", names: str = NAMES) -> Path:
    lines = [names.format(mark), *(mark.join(cells) for cells in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize(
    ("place", "damage"),
    [(3, ["Reduce Speed"] * 9), (2, ["4g7", "O.51"]), (1, ["?"]), (0, ["--1x", "0.5.5s"])],
)
def test_words_among_numbers_are_left_out_at_the_users_word(
    tmp_path: Path, mark: str, place: int, damage: list[str]
) -> None:
    rows = cells_of_rows()
    torn = [17 * (1 + number) for number in range(len(damage))]
    for row, text in zip(torn, damage, strict=True):
        rows[row][place] = text
    path = written(tmp_path / "log.csv", rows, mark)
    plan = plan_of(read_table(path), ColumnMap())
    assert [question.signal for question in plan.questions] == ["invalid"]
    assert f"'{damage[0]}' where a number is expected" in plan.questions[0].problem
    assert shlex.split(plan.command())[3:] == ["--invalid", "drop"]
    with pytest.raises(MappingError, match=r"invalid[= ]'?drop"):
        read(path)

    log = read(path, invalid="drop")
    whole = np.setdiff1d(np.arange(COUNT), torn)
    np.testing.assert_allclose(log.signals["slip"], SPEED[whole], atol=1e-5)
    np.testing.assert_allclose(log.signals["effort"], TORQUE[whole], atol=1e-5)
    np.testing.assert_allclose(log.signals["field"], CURRENT[whole])
    assert any("no number there" in note for note in log.notes)


@pytest.mark.slow
@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("count", [1, 2])
def test_rows_with_cells_too_many_are_left_out_at_the_users_word(
    tmp_path: Path, mark: str, count: int
) -> None:
    rows = cells_of_rows()
    for row in range(40, 40 + count):
        rows[row] += ["3500", "-1.5", "7"]
    path = written(tmp_path / "log.csv", rows, mark)
    plan = plan_of(read_table(path), ColumnMap())
    assert "line 42 has 7 cells where 4 are expected" in plan.questions[0].problem
    assert shlex.split(plan.command())[3:] == ["--invalid", "drop"]
    table = read_table(path)
    assert table.rows == COUNT
    told = plan_of(table, ColumnMap(), invalid="drop")
    assert not told.questions
    whole = np.delete(np.arange(COUNT), np.arange(40, 40 + count))
    np.testing.assert_allclose(apply(told, table).signals["effort"], TORQUE[whole], atol=1e-5)


def test_many_rows_with_cells_too_many_may_have_decimal_commas(tmp_path: Path) -> None:
    rows = cells_of_rows()
    for cells in rows[5::10]:
        cells.append("5")
    with pytest.raises(LogError, match="has 5 cells where 4 are expected"):
        read_table(written(tmp_path / "log.csv", rows))


@pytest.mark.slow
@pytest.mark.parametrize("text", ["1,0,2", "1.0.2", "12'5", "1-2"])
def test_what_may_be_a_number_in_another_way_of_writing_is_refused(
    tmp_path: Path, text: str
) -> None:
    rows = cells_of_rows()
    rows[100][3] = text
    path = written(tmp_path / "log.csv", rows, ";")
    assert not read_table(path).torn
    with pytest.raises(LogError, match="it is called like the effort"):
        plan_of(
            read_table(written(tmp_path / "log.csv", rows, ";", NAMES.replace("Brake ", ""))),
            ColumnMap(),
        )


def test_a_column_with_many_words_is_refused(tmp_path: Path) -> None:
    rows = cells_of_rows()
    for cells in rows[::5]:
        cells[3] = "later"
    path = written(tmp_path / "log.csv", rows, names=NAMES.replace("Brake ", ""))
    with pytest.raises(LogError, match="it is called like the effort"):
        plan_of(read_table(path), ColumnMap(), invalid="drop")


def test_a_damaged_column_that_no_signal_needs_stays_out(tmp_path: Path) -> None:
    rows = [[*cells, f"{20 + k / 7:.1f}"] for k, cells in enumerate(cells_of_rows())]
    rows[30][4] = "open"
    path = written(tmp_path / "log.csv", rows, names=NAMES + "{0}Lamp")
    plan = plan_of(read_table(path), ColumnMap())
    assert not plan.questions
    assert "Lamp" not in plan.labels
    named = plan_of(read_table(path), ColumnMap.from_options({"field": "Lamp"}))
    assert [question.signal for question in named.questions] == ["invalid"]


def test_rows_that_a_rule_made_have_no_damaged_columns_beside_them(tmp_path: Path) -> None:
    rows = [[*cells, "up" if k % 2 else "down"] for k, cells in enumerate(cells_of_rows())]
    rows[30][3] = "later"
    table = read_table(written(tmp_path / "log.csv", rows, names=NAMES + "{0}Direction"))
    for values in table.torn.values():
        assert values.size == table.rows
