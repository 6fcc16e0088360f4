"""What was told to a drive, or computed, is no measured signal, in any language: it is asked about. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, Plan, plan_of, read, read_table

ROWS = np.arange(300)
TIME = ROWS / 100.0
SPEED = 20.0 * np.sin(5.0 * TIME)
CURRENT = 0.5 * (ROWS // 50 % 3)
TORQUE = np.tanh(SPEED) * (0.2 + CURRENT)


def planned(path: Path, *labels: str) -> Plan:
    columns = (TIME, SPEED, CURRENT, *(TORQUE + 0.01 * k for k in range(len(labels))))
    names = ["Time (s)", "Speed (rad/s)", "Current (A)", *labels]
    rows = (",".join(f"{value:.5f}" for value in row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([",".join(names), *rows, ""]), encoding="utf-8")
    return plan_of(read_table(path), ColumnMap())


def effort_of(plan: Plan) -> str | None:
    return next((each.column for each in plan.signals if each.signal == "effort"), None)


@pytest.mark.parametrize(
    "name",
    [
        *("torque_sp", "Tq_dem", "tau_d", "tau_c", "stall torque", "disturbance torque"),
        *("Par deseado", "coppia riferimento", "заданный момент"),
        *("目标扭矩", "指令トルク", "给定转矩", "期望力矩", "목표 토크"),
        *("Drehmoment geschätzt", "couple estimé", "coppia stimata", "оценка момента"),
        *("估计扭矩", "仿真力矩", "推定トルク", "예측 토크"),
        *("torque constant", "torque ripple", "Torque Mode", "torque enable"),
    ],
)
def test_a_told_or_computed_effort_is_asked_about(tmp_path: Path, name: str) -> None:
    """It was the effort, in silence: a fit to what a drive was told says nothing of the device."""
    path = tmp_path / "log.csv"
    assert effort_of(planned(path, f"{name} (Nm)")) is None
    with pytest.raises(MappingError, match="no column for effort"):
        read(path)


@pytest.mark.parametrize("told", ["目标扭矩", "Par deseado", "torque_sp", "예측 토크", "tau_d"])
def test_the_measured_effort_beside_it_is_taken(tmp_path: Path, told: str) -> None:
    plan = planned(tmp_path / "log.csv", f"{told} (Nm)", "Torque (Nm)")
    assert effort_of(plan) == "Torque"


@pytest.mark.parametrize("name", ["torque_filtered", "扭矩", "토크", "момент", "Drehmoment ist"])
def test_a_measured_effort_is_taken_as_before(tmp_path: Path, name: str) -> None:
    assert effort_of(planned(tmp_path / "log.csv", f"{name} (Nm)")) == name


@pytest.mark.parametrize(
    "name",
    [
        *("Tq", "Tbrake", "M_brems", "Fmeas", "remkracht", "moment hamowania", "siła tłumika"),
        *("jarrumomentti", "sönüm kuvveti", "torque do freio"),
    ],
)
def test_an_effort_in_the_words_of_another_bench_is_taken(tmp_path: Path, name: str) -> None:
    assert effort_of(planned(tmp_path / "log.csv", name)) == name
