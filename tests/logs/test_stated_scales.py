"""What a file states above its rows of a sensor, a motor or a gear is put into the command, or asked about."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import erclutch
from erclutch.logs import ColumnMap, plan_of
from erclutch.logs.table import Table
from tests.support.command import good
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(600) / 200
FIELD = np.repeat([0.0, 0.5, 1.0, 0.25, 0.75, 0.0], 100)
SPEED = 5 * np.sin(6 * TIME)  # rad/s
TORQUE = (0.3 + 1.7 * FIELD) * np.tanh(4 * SPEED) + 0.02 * SPEED  # N*m
COUNTS = np.round(np.cumsum(SPEED) / 200 / (2 * np.pi) * 4096)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("head", "columns"),
    slow_behind(
        3,
        [
            ("# Encoder: 4096 counts/rev", {"encoder_counts": COUNTS, "torque_Nm": TORQUE}),
            ("# counts_per_rev: 4096", {"position [counts]": COUNTS, "torque [N*m]": TORQUE}),
            ("# Encoder: 4096 counts/rev (x4)", {"encoder": COUNTS, "torque [N*m]": TORQUE}),
            ("# PPR: 1024, quadrature x4", {"encoder": COUNTS, "torque [N*m]": TORQUE}),
            ("Kt = 0.12 Nm/A; N = 4096 counts/rev", {"counts": COUNTS, "I_motor": TORQUE / 0.12}),
            ("# Kt: 0.12 Nm/A", {"speed [rad/s]": SPEED, "motor_current [A]": TORQUE / 0.12}),
            ("# sensitivity: 20 N*m/V", {"speed [rad/s]": SPEED, "torque sensor [V]": TORQUE / 20}),
            (
                "# sensitivity: 20 N*m/V\n# zero: 2.5 V",
                {"speed [rad/s]": SPEED, "torque sensor [V]": TORQUE / 20 + 2.5},
            ),
            (
                "# sensitivity: 20 N*m/V\n# Nullwert: 2.5 V",
                {"speed [rad/s]": SPEED, "torque sensor [V]": TORQUE / 20 + 2.5},
            ),
            ("# gear ratio: 50", {"motor_speed [rad/s]": 50 * SPEED, "torque [N*m]": TORQUE}),
            ("Gear ratio;50:1\n", {"speed [rad/s]": SPEED, "motor_torque [N*m]": TORQUE / 50}),
        ],
    ),
)
def test_a_number_above_the_rows_stands_in_the_command_that_settles_the_question(
    tmp_path: Path, head: str, columns: dict[str, np.ndarray]
) -> None:
    every = {"time [s]": TIME, "coil_current [A]": FIELD, **columns}
    path = tmp_path / "log.csv"
    rows = np.column_stack(list(every.values()))
    np.savetxt(
        path, rows, delimiter=",", fmt="%.8g", header=f"{head}\n{','.join(every)}", comments=""
    )
    last = good("inspect", "log.csv", cwd=tmp_path, code=1).splitlines()[-1]
    _, _, command = last.partition("erclutch ")
    settled = good(*shlex.split(command), cwd=tmp_path).splitlines()[-1]
    assert settled.startswith("Understood.")
    words = shlex.split(command)[2:]
    given: dict[str, Any] = {}
    scales: list[str] = []
    for option, value in zip(words[::2], words[1::2], strict=True):
        if option == "--scale":
            scales.append(value)
        else:
            given[option.removeprefix("--")] = value
    read = erclutch.read(path, scale=scales, **given)
    assert read.signals["effort"] == pytest.approx(TORQUE, abs=1e-4)
    motion = read.signals.get("slip")
    if motion is None:
        assert read.signals["position"] == pytest.approx(np.cumsum(SPEED) / 200, abs=2e-3)
    else:
        assert motion == pytest.approx(SPEED, abs=1e-4)


@pytest.mark.slow
def test_a_gear_between_signals_of_one_side_is_no_matter(tmp_path: Path) -> None:
    every = {
        "time [s]": TIME,
        "coil_current [A]": FIELD,
        "motor_speed [rad/s]": SPEED,
        "motor_torque [N*m]": TORQUE,
    }
    rows = np.column_stack(list(every.values()))
    head = f"# gear ratio: 50\n{','.join(every)}"
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=head, comments="")
    good("inspect", "log.csv", cwd=tmp_path)


@pytest.mark.slow
@given(
    st.sampled_from(["NetID", "Kt", "Encoder", "Gear ratio", "sensitivity", "PPR"]),
    st.from_regex(r"[0-9.:/eE+-]{1,12} ?(counts/rev|Nm/A|N/V|)", fullmatch=True),
)
@example("NetID", "5.1.1.1")
@example("Kt", "1e999 Nm/A")
@example("PPR", "9" * 12)
def test_whatever_stands_above_the_rows_a_plan_comes_of_it(key: str, text: str) -> None:
    columns = {"time [s]": TIME, "encoder_counts": COUNTS, "I_motor": TORQUE / 0.12}
    units = {"time [s]": "s", "encoder_counts": None, "I_motor": "A"}
    table = Table("log.csv", columns, units, "", metadata={key: text}, path="log.csv")
    assert plan_of(table, ColumnMap()).command().startswith("erclutch inspect log.csv")


def test_a_number_beside_vectors_whose_name_ends_in_its_unit_is_a_scale() -> None:
    columns = {"time": TIME, "LVDT_V": SPEED, "force [N]": TORQUE}
    units = {"time": None, "LVDT_V": None, "force [N]": None}
    beside = {"LVDT_cal_mm_per_V": 5.0, "K": 1000.0}
    table = Table("a.mat", columns, units, "0" * 64, constants=beside, path="a.mat")
    plan = plan_of(table, ColumnMap())
    assert '--position "LVDT_V" --scale "position=5 mm/V"' in plan.command().replace("'", '"')


@pytest.mark.parametrize(
    "stated",
    [
        {"LVDT": "25 mm/V", "Load cell": "500 N/V", "Current monitor": "1 A/V"},
        {"LVDT": "40 mV/mm", "Load cell": "2 mV/N", "Current probe": "1000 mV/A"},
        {"LVDT": "0.04 V/mm", "Load cell": "0.5 kN/V", "Monitor": "1 V/A"},
    ],
)
def test_of_several_sensors_in_volts_each_gets_the_scale_of_its_own_kind(
    stated: dict[str, str],
) -> None:
    """A monitor of 1 A/V was asked about as 1 kV/V, and no sensor got its number."""
    columns = {"t": TIME, "LVDT": SPEED, "LoadCell": TORQUE, "Imon": FIELD}
    units = {"t": "s", "LVDT": "V", "LoadCell": "V", "Imon": "V"}
    table = Table("a.txt", columns, units, "0" * 64, metadata=stated, path="a.txt")
    words = shlex.split(plan_of(table, ColumnMap()).command())
    scales = {words[at + 1] for at, word in enumerate(words) if word == "--scale"}
    force = "effort=0.5 kN/V" if "kN" in stated["Load cell"] else "effort=500 N/V"
    assert scales == {"position=25 mm/V", force, "field=1 A/V"}


def test_a_scale_of_another_kind_fills_no_place() -> None:
    columns = {"t": TIME, "LVDT": SPEED, "LoadCell": TORQUE, "I [A]": FIELD}
    units = {"t": "s", "LVDT": "V", "LoadCell": "V", "I [A]": "A"}
    stated = {"Load cell": "500 N/V", "Laser": "1e-320 V/mm"}
    table = Table("a.txt", columns, units, "0" * 64, metadata=stated, path="a.txt")
    command = plan_of(table, ColumnMap()).command()
    assert "effort=500 N/V" in command
    assert "position=NUMBER m/V" in command
