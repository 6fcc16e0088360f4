"""A line above the rows that states a number among words is understood as a line with a colon is. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read, read_table
from erclutch.logs.readers.header_pairs import header_pairs

ROWS = np.arange(400.0)
SPEED = 12.0 * np.sin(ROWS / 20)  # rad/s
FIELD = np.repeat([0.0, 1.0, 0.5, 1.5], 100)
TORQUE = (0.2 + 1.5 * FIELD) * np.tanh(4.0 * SPEED)  # N m
COUNTS = np.round(-240.0 * np.cos(ROWS / 20) / 200 / (2 * np.pi) * 4096)


def command(folder: Path, line: str, columns: dict[str, np.ndarray]) -> str:
    """The command that settles what is open of a log below a line."""
    every = {"t [s]": ROWS / 200, "coil current [A]": FIELD, **columns}
    path = folder / "log.csv"
    with path.open("w", encoding="utf-8") as file:
        file.write(f"{line}\n{','.join(every)}\n")
        np.savetxt(file, np.column_stack([*every.values()]), delimiter=",", fmt="%.8g")
    return plan_of(read_table(path), ColumnMap()).command()


@pytest.mark.parametrize(
    "line",
    [
        "lever arm 150 mm",
        "# arm length = 0.15 m",
        "Hebelarm 150 mm",
        "Hebelarm = 0,15 m",
        "Hebelarm 0,15 m",
        "% force measured at 150 mm arm",
        "L = 150 mm lever arm",
        "moment arm (mm) 150",
        "bras de levier 15 cm",
        "brazo de palanca 150 mm",
        "力臂 150 mm",
        "杠杆臂长: 150 mm",
    ],
)
def test_an_arm_in_any_words_makes_a_torque_of_the_force(tmp_path: Path, line: str) -> None:
    said = command(tmp_path, line, {"speed [rad/s]": SPEED, "force [N]": TORQUE / 0.15})
    assert '--scale "effort=0.15 N*m/N"' in said


@pytest.mark.parametrize(
    ("line", "scale"),
    [
        ("encoder 1024 ppr", "0.006135923152"),
        ("# encoder 4096 counts/rev", "0.001533980788"),
        ("# 1024 ppr encoder x4", "0.001533980788"),
        ("Encoder resolution 4096 pulses per revolution", "0.001533980788"),
        ("Geber 1024 Striche", "0.006135923152"),
    ],
)
def test_counts_of_a_turn_in_any_words_make_an_angle(tmp_path: Path, line: str, scale: str) -> None:
    said = command(tmp_path, line, {"encoder_counts": COUNTS, "torque [Nm]": TORQUE})
    assert f'--scale "position={scale} rad/count"' in said


@pytest.mark.parametrize(
    "line",
    [
        "gear ratio 1:10",
        "Gear ratio 10:1 (encoder on the motor)",
        "# reduction 10:1",
        "gearbox ratio 1/10",
        "Gear ratio 10",
        "Übersetzung 10",
        "Getriebe 1 : 10",
    ],
)
def test_the_ratio_of_a_gear_in_any_words_turns_a_speed_of_the_motor(
    tmp_path: Path, line: str
) -> None:
    columns = {"motor_speed [rad/s]": 10.0 * SPEED, "torque [Nm]": TORQUE}
    assert "--scale slip=0.1" in command(tmp_path, line, columns).replace('"', "")


def test_other_lines_state_what_they_did() -> None:
    lines = [
        "Start 12:30",
        "gear 3",
        "armature 0.5 A",
        "stroke 20 mm",
        "run 3 done",
        "Date: 10/12",
        "150 mm armature",
        "x" * 300 + " 150 mm arm",
    ]
    assert header_pairs(lines) == {
        "Start 12": "30",
        "armature": "0.5 A",
        "stroke": "20 mm",
        "Date": "10/12",
    }


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("# Load cell at r = 0.15 m", "Load cell [N]"),
        ("# load cell radius: 150 mm", "force [N]"),
        ("", "Load cell (r=0.15 m) [N]"),
        ("", "Force @ 150 mm [N]"),
        ("", "Kraft am Hebel r=150mm [N]"),
        ("", "Load cell at r = 0.15 m [N]"),
    ],
)
def test_a_radius_of_a_load_cell_makes_a_torque_of_its_force(
    tmp_path: Path, line: str, name: str
) -> None:
    said = command(tmp_path, line, {"speed [rad/s]": SPEED, name: TORQUE / 0.15})
    assert '--scale "effort=0.15 N*m/N"' in said


@pytest.mark.slow
def test_a_load_cell_at_a_radius_without_a_unit_stays_as_logged(tmp_path: Path) -> None:
    said = command(
        tmp_path, "# Load cell at r = 0.15 m", {"speed [rad/s]": SPEED, "Load cell": TORQUE}
    )
    assert '--effort "Load cell" --scale "effort=0.15"' in said
    said = command(tmp_path, "", {"speed [rad/s]": SPEED, "Load cell (r=0.15 m)": TORQUE})
    assert '--scale "effort=0.15"' in said
    # The radius of a disk is none of a force's arm.
    said = command(tmp_path, "# disk r = 0.05 m", {"speed [rad/s]": SPEED, "force [N]": TORQUE})
    assert "0.05 N*m" not in said


def test_several_numbers_in_one_line_are_each_stated() -> None:
    assert header_pairs(["LVDT: 25 mm/V; load cell 200 N/V"]) == {
        "LVDT": "25 mm/V",
        "load cell": "200 N/V",
    }
    assert header_pairs(["I = 0.5 A, f = 2 Hz"]) == {"I": "0.5 A", "f": "2 Hz"}
    # A part that states nothing belongs to what stands in front of it.
    assert header_pairs(["sensor: FX29, 0-100 N"]) == {"sensor": "FX29, 0-100 N"}
    assert header_pairs(["Rate, 1000, Hz"]) == {"Rate": "1000 Hz"}


def test_remarks_between_the_names_and_the_rows_hide_no_name(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = "\n".join(f"{k / 100},{k % 3 / 2},{np.sin(k / 9):.5g},{k % 7}" for k in range(60))
    names = "t [s],coil current [A],speed [rad/s],force [N]"
    path.write_text(f"{names}\n# arm length: 12 cm\n# second run\n{rows}\n", encoding="utf-8")
    table = read_table(path)
    assert [*table.columns] == ["t", "coil current", "speed", "force"]
    assert table.metadata["arm length"] == "12 cm"
    assert '--scale "effort=0.12 N*m/N"' in plan_of(table, ColumnMap()).command()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["load cell [g]", "load_cell_g", "Load Cell (g)", "Load [grams]"])
def test_a_weight_at_a_stated_arm_is_offered_as_a_torque(tmp_path: Path, name: str) -> None:
    grams = TORQUE / 0.12 / 9.80665 * 1e3
    said = command(tmp_path, "# arm length: 12 cm", {"speed [rad/s]": SPEED, name: grams})
    bare = name.partition(" [")[0].partition(" (")[0]
    assert said.endswith(f'--effort "{bare} [gf]" --scale "effort=0.12 N*m/N"')


@pytest.mark.slow
def test_an_arm_in_a_column_of_its_own_makes_a_torque_of_the_force(tmp_path: Path) -> None:
    arms = np.full(TORQUE.size, 150.0)
    columns = {"speed [rpm]": 9.55 * SPEED, "force [N]": TORQUE / 0.15, "lever arm [mm]": arms}
    said = command(tmp_path, "", columns)
    assert said.endswith('--effort "force [N]" --scale "effort=0.15 N*m/N"')
    along = {"speed [m/s]": SPEED, "force [N]": TORQUE / 0.15, "lever arm [mm]": arms}
    assert "N*m/N" not in command(tmp_path, "", along)


@pytest.mark.slow
def test_a_weight_that_is_asked_about_gets_the_stated_arm(tmp_path: Path) -> None:
    columns = {"speed [rpm]": 9.55 * SPEED, "Load [kg]": TORQUE / 0.2 / 9.80665}
    said = command(tmp_path, "# arm 200 mm", columns)
    assert said.endswith('--effort "Load [kgf]" --scale "effort=0.2 N*m/N"')
    log = read(
        tmp_path / "log.csv", effort="Load [kgf]", scale="effort=0.2 N*m/N", slip="speed [rpm]"
    )
    np.testing.assert_allclose(log.signals["effort"], TORQUE, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("unit", ["kg", "Kg", "KG"])
def test_a_load_in_kilograms_in_any_letters_is_offered_as_a_weight(
    tmp_path: Path, unit: str
) -> None:
    said = command(tmp_path, "", {"speed [rad/s]": SPEED, f"Load ({unit})": TORQUE})
    assert said.endswith('--effort "Load [kgf]"')


@pytest.mark.parametrize(
    "line",
    [
        "All values multiplied by 1000",
        "# Scale factor: 0.001",
        "scaling factor = 10",
        "Multiplier: x10",
        "Werte multipliziert mit 1000",
    ],
)
def test_a_factor_without_a_unit_leaves_the_numbers_in_doubt(tmp_path: Path, line: str) -> None:
    """Whether they were multiplied already, nobody says; they were taken as logged, in silence."""
    command(tmp_path, line, {"speed [rad/s]": SPEED, "torque [Nm]": TORQUE})
    plan = plan_of(read_table(tmp_path / "log.csv"), ColumnMap())
    doubts = {each.signal: each.doubt for each in plan.signals if each.sureness == "doubtful"}
    assert [*doubts] == ["effort"]
    assert "as logged, and the file says" in doubts["effort"]


@pytest.mark.parametrize("line", ["Scale factor: 1", "Number of scales: 4", "Factor of safety: 2"])
def test_a_number_that_is_no_factor_of_the_values_leaves_no_doubt(
    tmp_path: Path, line: str
) -> None:
    command(tmp_path, line, {"speed [rad/s]": SPEED, "torque [Nm]": TORQUE})
    plan = plan_of(read_table(tmp_path / "log.csv"), ColumnMap())
    assert not any(each.sureness == "doubtful" for each in plan.signals)
