"""What a program writes where it has nothing: empty cells behind settings, the largest number, zeros behind a word."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, Table, plan_of, read_table
from erclutch.logs.log_file import tidied

TIMES = 0.2 * np.arange(60)
WAYS = 0.05 * TIMES
FORCES = 300.0 * np.tanh(WAYS) + 2.0 * np.sin(TIMES)


def _text(delimiter: str, settings: list[tuple[str, ...]], ending: str = "\n") -> str:
    width = 5
    lines = [[*setting, *[""] * (width - len(setting))] for setting in settings]
    lines += [
        ["Time", "Extension", "Load", "Strain", "Stress"],
        ["(s)", "(mm)", "(N)", "(-)", "(MPa)"],
    ]
    for time, way, force in zip(TIMES, WAYS, FORCES, strict=True):
        lines.append(
            [f"{time:g}", f"{way:.5f}", f"{force:.3f}", f"{way / 50:.6f}", f"{force / 30:.3f}"]
        )
    return ending.join(delimiter.join(cells) for cells in lines) + ending


SETTINGS: list[tuple[str, ...]] = [
    ("General : Specimen number", "1"),
    ("Specimen : Material", "<None>"),
    ("Specimen : Length", "50", "mm"),
    ("Specimen : Area", "30", "mm^2"),
    (),
]


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("settings", [SETTINGS, SETTINGS[:-1]])
def test_settings_that_are_filled_up_to_the_table_are_no_rows(
    tmp_path: Path, delimiter: str, ending: str, settings: list[tuple[str, ...]]
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(_text(delimiter, settings, ending).encode())
    table = read_table(path)
    assert table.rows == TIMES.size
    assert [*table.columns][:3] == ["Time", "Extension", "Load"]
    plan = plan_of(table, ColumnMap())
    assert plan.questions == ()
    np.testing.assert_allclose(table.columns["Load"], FORCES, atol=1e-3)


def test_a_first_row_with_gaps_stays_a_row(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [
        f"{time:g},{way:.4f},{force:.3f},,"
        for time, way, force in zip(TIMES, WAYS, FORCES, strict=True)
    ]
    path.write_text("\n".join(["Time [s],Way [mm],Force [N],,", "0,0,,,", *rows[1:]]) + "\n")
    assert read_table(path).rows == TIMES.size


@pytest.mark.parametrize("largest", [np.finfo(np.float64).max, float(np.finfo(np.float32).max)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_number_is_no_number(largest: float, sign: float) -> None:
    hardness = np.where(np.arange(TIMES.size) < 3, sign * largest, 12.0)
    columns = {
        "Displacement Into Surface": WAYS,
        "Load On Sample": FORCES,
        "Time On Sample": TIMES,
        "Hardness": hardness,
    }
    units = {
        "Displacement Into Surface": "nm",
        "Load On Sample": "mN",
        "Time On Sample": "s",
        "Hardness": "GPa",
    }
    table = tidied(Table("a", columns, units, "0" * 64))
    assert np.isnan(table.columns["Hardness"]).sum() == 3
    assert table.columns["Load On Sample"] is columns["Load On Sample"]
    assert any("in 3 rows: read as no number" in note for note in table.notes)
    plan = plan_of(table, ColumnMap())
    assert plan.questions == ()
    effort = plan.signal("effort")
    assert effort is not None
    assert effort.column == "Load On Sample"


def test_infinity_and_large_numbers_are_left_as_they_are() -> None:
    numbers = np.array([1e300, np.inf, -np.inf, 3.4e38, 3.5e38])
    table = Table("a", {"x": numbers}, {}, "0" * 64)
    assert tidied(table) is table


@pytest.mark.parametrize("name", ["Hardness", "Modulus", "Härte", "dureté"])
def test_a_hardness_or_a_modulus_is_no_effort(name: str) -> None:
    columns = {"Time": TIMES, "Weg": WAYS, name: FORCES}
    plan = plan_of(
        Table("a", columns, {"Time": "s", "Weg": "mm", name: "MPa"}, "0" * 64), ColumnMap()
    )
    assert [question.signal for question in plan.questions] == ["effort"]


def _of_a_program(zeros: bytes, behind: bytes) -> bytes:
    rows = [
        f"{time:g},{way:.5f},{force:.3f}"
        for time, way, force in zip(TIMES, WAYS, FORCES, strict=True)
    ]
    above = b"UserID:, username" + behind + zeros + b"\r\n\r\n"
    return above + "\r\n".join(["Time [s],Disp [mm],Load [N]", *rows, ""]).encode()


def test_zeros_behind_a_word_at_the_end_of_its_line_are_no_binary_data(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(_of_a_program(b"\0\0", b""))
    assert read_table(path).rows == TIMES.size


@pytest.mark.parametrize(("zeros", "behind"), [(b"\0", b"1.2"), (b"\0" * 9, b"x")])
def test_zeros_behind_a_number_and_runs_of_zeros_are_refused(
    tmp_path: Path, zeros: bytes, behind: bytes
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(_of_a_program(zeros, behind))
    with pytest.raises(LogError, match="binary data"):
        read_table(path)


def test_a_text_of_two_bytes_a_letter_keeps_its_words(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(_of_a_program(b"", b"").replace(b"\r", b"").decode().encode("utf-16-le"))
    assert [*read_table(path).columns] == ["Time", "Disp", "Load"]


def _stand(rows: list[str], more: str = ",Target,Step,") -> str:
    return "\n".join([f"Time (s),Servo (us),Torque (N·m),Speed (RPM),Message{more}", *rows]) + "\n"


def test_names_behind_those_of_the_cells_stand_over_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [
        f"{time:g},,{way:.4f},{force:.2f},,"
        for time, way, force in zip(TIMES, WAYS, FORCES, strict=True)
    ]
    path.write_text(_stand(rows), encoding="utf-8")
    table = read_table(path)
    assert {"Time", "Torque", "Speed"} <= {*table.columns}
    np.testing.assert_allclose(table.columns["Torque"], WAYS, atol=1e-4)
    assert any("stand over no cells" in note for note in table.notes)


def test_names_over_rows_without_an_empty_cell_may_have_lost_one(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [
        f"{time:g},5,{way:.4f},{force:.2f},1,"
        for time, way, force in zip(TIMES, WAYS, FORCES, strict=True)
    ]
    path.write_text(_stand(rows), encoding="utf-8")
    assert "names 8 columns, the rows have 5 cells" in read_table(path).unsure_names
