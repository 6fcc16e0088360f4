"""Texts of testing machines: sensors called by their serial numbers, blocks of one test below each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, Plan, plan_of
from erclutch.logs.planning.recording_choice import table_of_log

TIMES = 0.5 * np.arange(60)
WAYS = 0.01 * TIMES + 0.02 * np.sin(0.9 * TIMES)
FORCES = 12.0 * WAYS + 0.2 * np.cos(0.9 * TIMES)
NAMES = ["Laufzeit", "Ch 1 Kraft Sollwert", "Ch 1 Kraft", "Ch 1 Weg", "1944 B", "1281068", "2157"]
UNITS = ["s", "kN", "kN", "mm", "mm", "mm", "mm"]


def _row(at: int) -> str:
    numbers = (
        TIMES[at],
        FORCES[at] + 0.1,
        FORCES[at],
        WAYS[at],
        *(0.1 * WAYS[at] + 0.01 * k for k in range(3)),
    )
    return "\t".join(f"{number:.7f}".replace(".", ",") for number in numbers)


def _block(first: int, last: int, time: str) -> list[str]:
    head = [f"Datenerfassung\t\t\t\t\t\tZeit:\t{time}\ts\t22.07.2014 07:28:27"]
    return [*head, "\t".join(NAMES), "\t".join(UNITS), *map(_row, range(first, last)), ""]


ABOVE = [
    "MACH1|DEU|1|2|,|.|:|49",
    "",
    "Bediener\t\t\t\t\t\tZeit:\t78,49\ts\t22.07.2014 07:20:41",
    "Masse :\t5646,2",
    "",
]
ENDS = [
    "Datenerfassung\t\t\t\t\t\tZeit:\t544,36\ts\t22.07.2014 07:28:27",
    "Ch 1 Kraft\tCh 1 Mittel\t1944 A\t1944 B\t1281068",
    "kN\tmm\tmm\tmm\tmm",
    "0,24799444\t2,0349319\t0,00019342918\t0,00011074543\t0,0037599527",
    "-473,42752\t2,0347652\t-0,00045152754\t-0,28250676\t-0,21965788",
]


def _plan(path: Path, lines: list[str]) -> Plan:
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")
    return plan_of(table_of_log(path, ColumnMap(), None), ColumnMap())


def _columns(plan: Plan) -> dict[str, str]:
    return {each.signal: each.column for each in plan.signals if each.column}


def test_a_line_of_units_is_no_line_of_names_where_sensors_are_called_by_numbers(
    tmp_path: Path,
) -> None:
    plan = _plan(tmp_path / "a.dat", [*ABOVE, *_block(0, 60, "1,0")])
    assert plan.questions == ()
    assert _columns(plan) == {"position": "Ch 1 Weg", "effort": "Ch 1 Kraft"}
    assert plan.clock is not None
    assert plan.clock.column == "Laufzeit"


@pytest.mark.slow
@pytest.mark.parametrize("below", [False, True])
def test_the_ends_of_the_ranges_beside_a_test_are_left_out(tmp_path: Path, below: bool) -> None:
    test = _block(0, 60, "1,0")
    lines = [*ABOVE, *test, *ENDS] if below else [*ABOVE, *ENDS, "", *test]
    table = table_of_log(_written(tmp_path / "a.dat", lines), ColumnMap(), None)
    assert table.rows == 60
    assert "Laufzeit" in table.columns


def _written(path: Path, lines: list[str]) -> Path:
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")
    return path


def test_blocks_of_one_test_are_joined_without_the_ends_of_their_ranges(tmp_path: Path) -> None:
    ends = [*_block(0, 1, "9,0")[:3], _row(59), _row(0)]
    lines = [*ABOVE, *_block(0, 35, "1,0"), *_block(35, 60, "8,0"), *ends]
    table = table_of_log(_written(tmp_path / "a.dat", lines), ColumnMap(), None)
    assert table.rows == 60
    assert any("the names stand 2 times" in note for note in table.notes)
    assert any("has two rows, the ends of each range" in note for note in table.notes)


def test_a_line_of_numbers_above_units_names_nothing(tmp_path: Path) -> None:
    rows = ["\t".join([str(n), str(n * n), "3", "4"]) for n in range(30)]
    path = _written(tmp_path / "a.txt", ["1\t2\t3\t4", "s\tmm\tN\tmm", *rows])
    with pytest.raises(LogError, match="'s' where a number is expected"):
        table_of_log(path, ColumnMap(), None)


@pytest.mark.parametrize("name", ["Prüfzeit", "Laufzeit", "Messzeit", "Time On Sample"])
def test_a_time_of_a_machine_is_the_time(tmp_path: Path, name: str) -> None:
    rows = [f"{time};{way};{force}" for time, way, force in zip(TIMES, WAYS, FORCES, strict=True)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([f"{name};Weg [mm];Kraft [N]", *rows]) + "\n", encoding="utf-8")
    plan = plan_of(table_of_log(path, ColumnMap(), None), ColumnMap())
    assert plan.clock is not None
    assert plan.clock.column == name
