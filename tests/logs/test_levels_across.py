"""A bench sheet with a column for each field or speed gets rows for each; nothing else is taken apart. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openpyxl import Workbook
from scipy.io import savemat

from erclutch.logs import ColumnMap, plan_of, read, read_all, read_table
from erclutch.signals.array import Array
from tests.support.command import good, run

SPEED = np.linspace(50.0, 600.0, 12)
FIELDS = (0.0, 0.5, 1.5)


def torque(field: float) -> Array:
    return 0.1 + 0.001 * SPEED + 3.0 * field


def written(folder: Path, names: list[str], columns: Sequence[Array], delimiter: str = ",") -> Path:
    path = folder / "sheet.csv"
    lines = [delimiter.join(f"{cell:.9g}" for cell in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([delimiter.join(names), *lines]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "name",
    ["Torque @ {} A (Nm)", "Torque_{}A [Nm]", "{} A Torque (Nm)", "Torque (Nm) at {} A", "T {}A"],
)
def test_each_field_gets_rows_of_its_own(tmp_path: Path, name: str) -> None:
    names = ["Speed (rpm)", *(name.format(f"{field:g}") for field in FIELDS)]
    path = written(tmp_path, names, [SPEED, *map(torque, FIELDS)])
    options: dict[str, Any] = {"effort": "T [N*m]"} if name.startswith("T ") else {}
    log = read(path, **options)
    np.testing.assert_array_equal(log.signals["field"], np.repeat(FIELDS, SPEED.size))
    np.testing.assert_allclose(log.signals["slip"], np.tile(SPEED, 3) * np.pi / 30)
    np.testing.assert_allclose(log.signals["effort"], np.concatenate([*map(torque, FIELDS)]))
    assert any("the names of the columns tell the field" in note for note in log.notes)


@pytest.mark.parametrize(("unit", "factor"), [("kV/mm", 1e6), ("V/mm", 1e3), ("kA/m", 1e3)])
def test_a_field_strength_in_a_name_keeps_its_whole_unit(
    tmp_path: Path, unit: str, factor: float
) -> None:
    names = ["Speed (rpm)", *(f"Torque @ {field:g} {unit} (Nm)" for field in FIELDS)]
    log = read(written(tmp_path, names, [SPEED, *map(torque, FIELDS)]))
    np.testing.assert_allclose(
        log.signals["field"], np.repeat(factor * np.array(FIELDS), SPEED.size)
    )


@pytest.mark.parametrize("heads", [("0 A", "0.5 A", "1.5 A"), ("I=0A", "I=0.5A", "I=1.5A")])
def test_what_is_called_by_its_field_alone_is_asked_about_with_a_command(
    tmp_path: Path, heads: tuple[str, ...]
) -> None:
    path = written(tmp_path, ["v [m/s]", *heads], [SPEED / 1e3, *map(torque, FIELDS)])
    plan = plan_of(read_table(path), ColumnMap())
    assert plan.command().endswith('--time none --effort "value"')
    log = read(path, time="none", effort="value [N]")
    np.testing.assert_array_equal(log.signals["field"], np.repeat(FIELDS, SPEED.size))


@pytest.mark.slow
def test_a_position_and_a_force_at_each_field_are_logs_one_after_another(tmp_path: Path) -> None:
    time: Array = 0.01 * np.arange(400, dtype=np.float64)
    place = np.sin(2.0 * time)
    columns: list[Array] = [time]
    names = ["t [s]"]
    for field in FIELDS:
        columns += [place * (1.0 + field), 5.0 * (1.0 + field) * np.cos(2.0 * time)]
        names += [f"x_{field:g}A [mm]", f"F_{field:g}A [N]"]
    log = read(written(tmp_path, names, columns))
    np.testing.assert_array_equal(log.signals["field"], np.repeat(FIELDS, time.size))
    np.testing.assert_allclose(log.signals["position"][time.size :][: time.size], place * 1.5e-3)
    assert len(log.segments) == 3


def test_a_shorter_sweep_has_fewer_rows(tmp_path: Path) -> None:
    short = torque(1.5)
    short[-4:] = np.nan
    path = written(
        tmp_path, ["Speed [rpm]", "Torque 0A [Nm]", "Torque 1.5A [Nm]"], [SPEED, torque(0.0), short]
    )
    assert read(path).rows == 2 * SPEED.size - 4


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_sheet_of_a_workbook_is_read_so_too(tmp_path: Path) -> None:
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["Speed (rpm)", *(f"Torque {field:g} A (Nm)" for field in FIELDS)])
    for speed, *torques in zip(SPEED, *map(torque, FIELDS), strict=True):
        sheet.append([float(speed), *map(float, torques)])
    book.save(tmp_path / "sheet.xlsx")
    assert read(tmp_path / "sheet.xlsx").rows == 3 * SPEED.size


@pytest.mark.parametrize(
    "names",
    [
        [
            "Speed [rpm]",
            "Torque 1A [Nm]",
            "Torque 2A [Nm]",
            "Torque 3A [Nm]",
        ],  # specimens of a batch A
        [
            "Time [s]",
            "Torque 0A [Nm]",
            "Torque 0.5A [Nm]",
            "Torque 1.5A [Nm]",
        ],  # logs, which are asked about
        [
            "Shear rate [1/s]",
            "Shear stress 0T [Pa]",
            "Shear stress 0.5T [Pa]",
            "Shear stress 1.5T [Pa]",
        ],
        ["Speed [rpm]", "Torque 0A [Nm]", "Torque 0.5V [Nm]", "Torque 1.5A [Nm]"],
        ["Current [A]", "Speed 0V [rpm]", "Speed 5V [rpm]", "Torque 0V [Nm]"],
        ["c1", "0 A", "0.5 A", "1.5 A"],
    ],
)
def test_other_tables_stay_as_they_are(tmp_path: Path, names: list[str]) -> None:
    table = read_table(written(tmp_path, names, [SPEED, *map(torque, FIELDS)]))
    assert table.rows == SPEED.size
    assert "field" not in table.columns


TIME: Array = np.arange(300) / 100


def groups(names: Sequence[str], *, ragged: bool) -> tuple[list[str], list[Array]]:
    """Names and columns of a time, a motion and an effort at each field; with less rows at some fields where ragged."""
    labels: list[str] = []
    columns: list[Array] = []
    for place, field in enumerate(FIELDS):
        motion = np.sin(2 * np.pi * TIME)
        group = [TIME + 0.003 * place, motion, (1.0 + 5.0 * field) * np.tanh(9.0 * motion)]
        for column in group:
            column[column.size - 40 * place * ragged :] = np.nan
        columns += group
        labels += [name.format(f"{field:g}") for name in names]
    return labels, columns


TIMED = (
    ("t ({} A)", "v ({} A) [mm/s]", "F ({} A) [N]"),
    ("t [s] ({} A)", "v [mm/s] ({} A)", "F [N] ({} A)"),
    ("time_{}A_s", "velocity_{}A_mm_s", "force_{}A_N"),
    ("Zeit {} A [s]", "Geschwindigkeit {} A [mm/s]", "Kraft {} A [N]"),
    ("Time @ {}A (s)", "Velocity @ {}A (mm/s)", "Force @ {}A (N)"),
    ("{}A_time [s]", "{}A_velocity [mm/s]", "{}A_force [N]"),
    ("时间(s)-{}A", "速度(mm/s)-{}A", "力(N)-{}A"),
    ("t (I={}A) [s]", "v (I={}A) [mm/s]", "F (I={}A) [N]"),
)


@pytest.mark.slow
@pytest.mark.parametrize("ragged", [False, True])
@pytest.mark.parametrize("names", TIMED)
def test_groups_with_times_of_their_own_are_stacked_each_at_its_field(
    tmp_path: Path, names: tuple[str, ...], ragged: bool
) -> None:
    labels, columns = groups(names, ragged=ragged)
    path = tmp_path / "sheet.csv"
    rows = [
        ",".join("" if np.isnan(c) else f"{c:.9g}" for c in row)
        for row in zip(*columns, strict=True)
    ]
    path.write_text("\n".join([",".join(labels), *rows]) + "\n", encoding="utf-8")
    log = read(path)
    known = [column[np.isfinite(column)] for column in columns]
    np.testing.assert_array_equal(
        log.signals["field"], np.repeat(FIELDS, [column.size for column in known[::3]])
    )
    np.testing.assert_allclose(log.signals["slip"], 1e-3 * np.concatenate(known[1::3]), atol=1e-12)
    np.testing.assert_allclose(log.signals["effort"], np.concatenate(known[2::3]), atol=1e-7)
    assert len(log.segments) == len(FIELDS)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "field"),
    [
        (("t ({} %) [s]", "v ({} %) [mm/s]", "F ({} %) [N]"), "level [%]"),
        (("t_I{} [s]", "v_I{} [mm/s]", "F_I{} [N]"), "level"),
        (("t {} clicks [s]", "v {} clicks [mm/s]", "F {} clicks [N]"), "clicks"),
    ],
)
def test_groups_at_numbers_that_may_be_no_field_are_asked_about_with_these_numbers(
    tmp_path: Path, names: tuple[str, ...], field: str
) -> None:
    path = written(tmp_path, *groups(names, ragged=False))
    plan = plan_of(read_table(path), ColumnMap())
    assert [question.signal for question in plan.questions] == ["field"]
    assert plan.command().replace("'", "").replace('"', "").endswith(f"--field {field}")
    shares = np.array(FIELDS) / (100.0 if "%" in field else 1.0)
    np.testing.assert_allclose(
        read(path, field=field).signals["field"], np.repeat(shares, TIME.size)
    )


@pytest.mark.slow
def test_a_duty_in_the_names_of_groups_is_the_field(tmp_path: Path) -> None:
    names = ("time_pwm{}", "speed_pwm{}_rpm", "torque_pwm{}_Nm")
    log = read(written(tmp_path, *groups(names, ragged=False)))
    np.testing.assert_array_equal(log.signals["field"], np.repeat(FIELDS, TIME.size))


@pytest.mark.parametrize(
    ("name", "called"),
    [
        ("{} clicks (lbf)", "clicks"),
        ("Click {} (lbf)", "clicks"),
        ("Force @ {} clicks from closed [N]", "clicks"),
        ("Kraft {} Klicks (N)", "clicks"),
        ("Force (N) - {} clicks out", "clicks"),
        ("{} turns (N)", "turns"),
        ("Stufe {} (N)", "setting"),
        ("阻尼力 {}段 (N)", "setting"),
    ],
)
def test_positions_of_a_valve_are_asked_about_and_are_no_amperes(
    tmp_path: Path, name: str, called: str
) -> None:
    speed = np.linspace(-0.5, 0.5, 21)
    forces = [(30.0 + 8.0 * clicks) * np.tanh(9.0 * speed) for clicks in (0, 4, 12)]
    names = ["Velocity (m/s)", *(name.format(clicks) for clicks in (0, 4, 12))]
    path = written(tmp_path, names, [speed, *forces])
    plan = plan_of(read_table(path), ColumnMap())
    assert [question.signal for question in plan.questions] == ["time", "field"]
    assert plan.command().endswith(f'--time none --field "{called}"')
    log = read(path, time="none", field=called)
    np.testing.assert_array_equal(log.signals["field"], np.repeat([0.0, 4.0, 12.0], speed.size))
    assert log.units["field"] == "?"


def test_positions_of_a_valve_in_both_senses_are_rows_of_their_own(tmp_path: Path) -> None:
    speed = np.linspace(0.02, 0.5, 15)
    names = ["Velocity (m/s)"]
    columns: list[Array] = [speed]
    for clicks in (0, 4):
        names += [f"{clicks} clicks compression (N)", f"{clicks} clicks rebound (N)"]
        columns += [(30.0 + clicks) * speed, -(40.0 + clicks) * speed]
    log = read(written(tmp_path, names, columns), time="none", field="clicks")
    slip = log.signals["slip"]
    assert log.rows == 4 * speed.size
    assert np.all(slip * log.signals["effort"] > 0.0)
    assert np.count_nonzero(slip < 0.0) == 2 * speed.size


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_the_command_about_sheets_that_differ_by_clicks_is_one_that_goes_on(tmp_path: Path) -> None:
    book = Workbook()
    book.remove(book.worksheets[0])
    for clicks in (0, 6, 12):
        sheet = book.create_sheet(f"{clicks} clicks")
        sheet.append(["Velocity [m/s]", "Force [N]"])
        for speed in np.linspace(-0.5, 0.5, 41):
            sheet.append([float(speed), float((30.0 + 10.0 * clicks) * np.tanh(9.0 * speed))])
    path = tmp_path / "clicks.xlsx"
    book.save(path)
    asked = run("inspect", path, "--variable", "all", "--time", "none")
    assert asked.code == 1
    assert '--constant "field=0, 6, 12"' in asked.out + asked.error
    each = ("--variable", "all", "--constant", "field=0, 6, 12")
    assert "Understood" in good("inspect", path, "--time", "none", *each)


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_vectors_of_each_field_with_a_length_of_their_own_are_stacked(tmp_path: Path) -> None:
    labels, columns = groups(("t_{}A", "v_{}A", "F_{}A"), ragged=True)
    vectors = {
        label.replace(".", "p"): column[np.isfinite(column)]
        for label, column in zip(labels, columns, strict=True)
    }
    path = tmp_path / "fields.mat"
    savemat(path, vectors)
    log = read(path)
    rows = [vectors[name].size for name in ("t_0A", "t_0p5A", "t_1p5A")]
    np.testing.assert_array_equal(log.signals["field"], np.repeat(FIELDS, rows))
    # Groups of other names are no such groups: what has another length is left out.
    savemat(path, {**vectors, "x_2A": np.arange(50.0)})
    assert read_table(path).unreadable


CURRENT: Array = np.linspace(0.0, 2.0, 9)
TURNS = (100.0, 250.0, 400.0)


@pytest.mark.parametrize(
    "name",
    ["Torque @ {} rpm (Nm)", "Torque_{}rpm [Nm]", "{} 1/min Torque (Nm)", "T at {} U/min [Nm]"],
)
def test_each_speed_gets_rows_of_its_own(tmp_path: Path, name: str) -> None:
    torques = [0.2 + 3.0 * CURRENT + 1e-3 * turns for turns in TURNS]
    names = ["Current [A]", *(name.format(f"{turns:g}") for turns in TURNS)]
    log = read(written(tmp_path, names, [CURRENT, *torques]))
    np.testing.assert_allclose(log.signals["slip"], np.repeat(TURNS, 9) * np.pi / 30)
    np.testing.assert_array_equal(log.signals["field"], np.tile(CURRENT, 3))
    np.testing.assert_allclose(log.signals["effort"], np.concatenate(torques))
    assert any("its rows are points" in note for note in log.notes)


def test_columns_called_by_their_speeds_alone_are_asked_about_with_a_command(
    tmp_path: Path,
) -> None:
    torques = [0.2 + 3.0 * CURRENT + 1e-3 * turns for turns in TURNS]
    names = ["I [A]", *(f"{turns:g} rpm" for turns in TURNS)]
    path = written(tmp_path, names, [CURRENT, *torques])
    assert plan_of(read_table(path), ColumnMap()).command().endswith('--effort "value"')
    log = read(path, time="none", effort="value [Nm]")
    np.testing.assert_allclose(log.signals["slip"], np.repeat(TURNS, 9) * np.pi / 30)


@pytest.mark.parametrize(
    "names",
    [
        ["Time [s]", "Force 10mm/s [N]", "Force 50mm/s [N]", "Force 100mm/s [N]"],
        ["Displacement [mm]", "Force 10mm/s [N]", "Force 50mm/s [N]", "Force 100mm/s [N]"],
        ["Current [A]", "Temperature 100rpm", "Temperature 200rpm", "Temperature 300rpm"],
    ],
)
def test_efforts_over_time_or_way_and_other_quantities_at_speeds_stay(
    tmp_path: Path, names: list[str]
) -> None:
    table = read_table(written(tmp_path, names, [SPEED, *map(torque, FIELDS)]))
    assert "slip" not in table.columns


@pytest.mark.parametrize(
    "names",
    [
        ("Velocity [m/s]", "Soft [N]", "Medium [N]", "Hard [N]"),
        ("Velocity [m/s]", "Force soft [N]", "Force mid [N]", "Force firm [N]"),
        ("Geschwindigkeit [m/s]", "weich", "mittel", "hart"),
        ("Geschwindigkeit [m/s]", "Kraft (weich)", "Kraft (mittel)", "Kraft (hart)"),
        ("速度[m/s]", "弱", "中", "强"),
        ("速度[m/s]", "减振力_软 [N]", "减振力_中 [N]", "减振力_硬 [N]"),
        ("velocity [mm/s]", "F_comfort [N]", "F_normal [N]", "F_sport [N]"),
        ("vitesse [m/s]", "souple", "moyen", "ferme"),
    ],
)
def test_words_of_a_valve_are_levels_that_are_asked_about(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    speed = np.linspace(-0.5, 0.5, 21)
    forces = [stiff * np.tanh(9.0 * speed) for stiff in (30.0, 60.0, 120.0)]
    path = written(tmp_path, [*names], [speed, *forces])
    plan = plan_of(read_table(path), ColumnMap())
    assert '--time none --field "setting"' in plan.command()
    effort = "value" if "value" in plan.command() else None
    log = read(path, time="none", field="setting", effort=effort)
    np.testing.assert_array_equal(log.signals["field"], np.repeat([1.0, 2.0, 3.0], speed.size))
    np.testing.assert_allclose(log.signals["effort"], np.concatenate(forces), atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("setting", ("soft", "medium", "hard")),
        ("Stellung", ("weich", "mittel", "hart")),
        ("档位", ("弱", "中", "强")),
        ("damping mode", ("Comfort", "Normal", "Sport")),
        ("current", ("off", "low", "high")),
    ],
)
def test_words_of_a_valve_in_a_column_are_counted(
    tmp_path: Path, name: str, words: tuple[str, ...]
) -> None:
    rows = [f"time [s],{name},velocity [m/s],force [N]"]
    for place, word in enumerate(words, start=1):
        for k in range(200):
            speed = 0.3 * np.sin(0.2 * k)
            force = 100.0 * place * np.tanh(9.0 * speed)
            rows.append(f"{0.01 * k:.2f},{word},{speed:.6g},{force:.6g}")
    path = tmp_path / "log.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    log = read(path, field=name)
    first = 0.0 if words[0] == "off" else 1.0
    levels = [0.0, 1.0, 3.0] if words[0] == "off" else [first, first + 1.0, first + 2.0]
    np.testing.assert_array_equal(log.signals["field"], np.repeat(levels, 200))
    assert any("tells levels by words, which are counted" in note for note in log.notes)


def test_soft_and_hard_pieces_of_a_material_are_no_levels(tmp_path: Path) -> None:
    rows = ["time [s],specimen,velocity [m/s],force [N]"]
    for word in ("soft", "hard"):
        rows += [
            f"{0.01 * k:.2f},{word},{np.sin(0.2 * k):.5f},{np.sin(0.2 * k):.5f}" for k in range(60)
        ]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert "specimen" in read_table(path).words


@pytest.mark.slow
@pytest.mark.parametrize("name", ["F@{}A", "F @ {} A", "F_{}A"])
def test_forces_at_levels_in_one_time_are_logs_at_their_fields(tmp_path: Path, name: str) -> None:
    time = np.arange(60) / 100
    speed = np.sin(9 * time)
    forces = [(50.0 + 200.0 * field) * speed for field in FIELDS]
    names = ["time", "vel", *(name.format(f"{field:g}") for field in FIELDS)]
    written(tmp_path, names, [time, speed, *forces])
    said = run("inspect", "sheet.csv", cwd=tmp_path).out
    # A field of none would mix all of them at one field.
    assert said.splitlines()[-1].endswith("erclutch inspect sheet.csv --variable all")
    logs = read_all(tmp_path / "sheet.csv", ColumnMap(variable="all"))
    assert [float(log.signals["field"][0]) for log in logs] == list(FIELDS)


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    [
        ("Time {}A [s]", "Velocity {}A [mm/s]", "Force {}A [N]"),
        ("{}A_t [s]", "{}A_v [mm/s]", "{}A_F [N]"),
        ("t ({}A) [s]", "speed ({}A) [mm/s]", "force ({}A) [N]"),
    ],
)
def test_groups_at_currents_that_may_count_specimens_are_asked_about(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    labels: list[str] = []
    columns: list[Array] = []
    for level in (1, 2, 3):
        speed = 80.0 * np.sin(6.0 * TIME + level)
        labels += [name.format(level) for name in names]
        columns += [TIME, speed, (10.0 + 40.0 * level) * np.tanh(speed) + speed]
    path = written(tmp_path, labels, columns)
    plan = plan_of(read_table(path), ColumnMap())
    assert [question.signal for question in plan.questions] == ["field"]
    assert plan.command().endswith('--field "level"')
    log = read(path, field="level [A]")
    np.testing.assert_array_equal(log.signals["field"], np.repeat([1.0, 2.0, 3.0], TIME.size))
    np.testing.assert_allclose(log.signals["slip"][TIME.size :][0], 0.08 * np.sin(2.0), atol=1e-9)
