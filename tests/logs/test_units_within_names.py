"""A unit that neither ends its name nor stands in brackets behind it is read, or its column is asked about."""

from __future__ import annotations

from pathlib import Path
from time import process_time

import numpy as np
import pytest

from erclutch.logs import plan_of, read_table
from erclutch.logs.columns.labels import own_unit, says_a_unit, split_label
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.words_behind_units import without_words_behind
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Plan
from erclutch.logs.table import Table
from tests.support.pace import within

ROWS = np.arange(400)
TIME = ROWS / 100.0
SPEED = 5.0 * np.sin(5.0 * TIME)
CURRENT = 0.5 * (ROWS // 50 % 3)
EFFORT = np.tanh(SPEED) * (0.2 + CURRENT) + 0.01 * SPEED


def planned(path: Path, speed: str, effort: str) -> Plan:
    rows = zip(TIME, CURRENT, SPEED, EFFORT, strict=True)
    text = "\n".join(",".join(f"{value:.6f}" for value in row) for row in rows)
    path.write_text(f"time [s],Current [A],{speed},{effort}\n{text}\n", encoding="utf-8")
    return plan_of(read_table(path), ColumnMap())


def factor_of(plan: Plan, signal: str) -> float | None:
    return next((each.factor for each in plan.signals if each.signal == signal), None)


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("Force_kN_filtered", 1e3),
        ("Force_mN_raw_mean", 1e-3),
        ("Force (kN) avg", 1e3),
        ("Force[lbf]_f", 4.4482216152605),
        ("Kraft_kN_gefiltert", 1e3),
        ("Force (kN", 1e3),
        ("Force kN)", 1e3),
        ("Force-kN", 1e3),
        ("Force/kN", 1e3),
        ("Force_daN", 10.0),
        ("Force cN", 0.01),
        ("Force.uN", 1e-6),
        ("Force_MN", 1e6),
        ("FORCE_LBS", 4.4482216152605),
        ("FORCE_KIP", 4448.2216152605),
        ("force_kilonewtons", 1e3),
        ("mN_force", 1e-3),
        ("lbf Load", 4.4482216152605),
        ("Kraft [in kN]", 1e3),
        ("Kraft (in N)", 1.0),
    ],
)
def test_a_force_is_read_in_the_unit_of_its_name(tmp_path: Path, name: str, factor: float) -> None:
    """Each of these was taken as newtons, in silence."""
    plan = planned(tmp_path / "log.csv", "Velocity [m/s]", name)
    assert not plan.questions
    assert factor_of(plan, "effort") == pytest.approx(factor)


@pytest.mark.parametrize(
    "name",
    [
        *("Force_kg_filtered", "Force (kg) avg", "Force_g", "Load g", "force_grams_mean"),
        *("FORCE_MN", "force_mn", "Force (mn)", "LOAD (UN)"),
    ],
)
def test_a_mass_or_a_prefix_that_nobody_knows_is_asked_about(tmp_path: Path, name: str) -> None:
    plan = planned(tmp_path / "log.csv", "Velocity [m/s]", name)
    assert [question.signal for question in plan.questions] == ["effort"]


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("Torque_mNm_filtered", 1e-3),
        ("Torque (Ncm) mean", 0.01),
        ("Torque_uNm", 1e-6),
        ("Torque dNm", 0.1),
        ("oz-in_Torque", 0.00706155181422604),
        ("mN.m_Torque", 1e-3),
    ],
)
def test_a_torque_is_read_in_the_unit_of_its_name(tmp_path: Path, name: str, factor: float) -> None:
    plan = planned(tmp_path / "log.csv", "Speed [rad/s]", name)
    assert not plan.questions
    assert factor_of(plan, "effort") == pytest.approx(factor)


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("Drehzahl [in 1/min]", np.pi / 30.0),
        ("Drehzahl (in min-1)", np.pi / 30.0),
        ("Drehzahl [x1000/min]", 1000.0 * np.pi / 30.0),
        ("Speed [10^3 1/min]", 1000.0 * np.pi / 30.0),
        ("Speed/rpm", np.pi / 30.0),
        ("Speed-RPM", np.pi / 30.0),
        ("deg/s_Speed", np.pi / 180.0),
        ("Speed_rpm_filt", np.pi / 30.0),
    ],
)
def test_a_speed_is_read_in_the_unit_of_its_name(tmp_path: Path, name: str, factor: float) -> None:
    """In 1/min was an inch a minute, and 1000/min no turns, in silence."""
    plan = planned(tmp_path / "log.csv", name, "Torque [N*m]")
    assert not plan.questions
    assert factor_of(plan, "slip") == pytest.approx(factor)


@pytest.mark.parametrize("name", ["Angle °", "Winkel_°", "Position, °", "Angle°"])
def test_the_sign_of_degrees_behind_a_name_is_its_unit(name: str) -> None:
    assert own_unit(name, None, ("rad",)) == "deg"


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("Torque (in lb)", "Torque", "in lb"),
        ("Torque [in lbf]", "Torque", "in lbf"),
        ("Weg [in mm]", "Weg", "mm"),
        ("Zeit (in s)", "Zeit", "s"),
        ("Valve (in use)", "Valve (in use)", None),
    ],
)
def test_in_is_an_inch_before_a_weight_alone(label: str, name: str, unit: str | None) -> None:
    assert split_label(label) == (name, unit)


@pytest.mark.parametrize(
    "name",
    [
        *("Torque/rpm", "Force/mm", "Stress-strain", "min_Force", "in_Position", "rev_speed"),
        *("g_force", "min_Speed", "Sensor 90°", "torque_Hz_filtered", "raw", "filtered", "mean_f"),
    ],
)
def test_what_is_no_unit_of_its_name_is_none(name: str) -> None:
    assert own_unit(name, None, ("N", "N*m")) is None
    assert own_unit(name, None, ("m", "rad")) is None


@pytest.mark.parametrize("index", ["[0x2201/31]", "[0x4C01/2]", "[12/A]", "[front/left]"])
def test_an_index_in_brackets_is_no_unit_and_refuses_no_log(index: str) -> None:
    name = f"User Parameter {index}"
    assert own_unit(name, None, ("V", "A")) is None
    assert not says_a_unit(name)
    columns = {"time": TIME, "velocity": SPEED, "torque": EFFORT, name: CURRENT}
    plan = plan_of(Table("a.csv", columns, dict.fromkeys(columns), "0" * 64), ColumnMap())
    assert [question.signal for question in plan.questions if question.signal == "field"]


def test_words_are_taken_off_behind_a_unit_and_never_a_whole_name() -> None:
    assert without_words_behind("Force_kN_raw_mean") == "Force_kN"
    assert without_words_behind("Load (lbf) avg") == "Load (lbf)"
    assert without_words_behind("filtered") == "filtered"
    assert split_end("Torque_mNm_filtered") == ("Torque_filtered", "mN*m")
    assert says_a_unit("Force (kg) avg")
    assert not says_a_unit("Force (front) avg")


def test_long_names_take_linear_time() -> None:
    for part in ("_f", " (", "kN)", "/-", "° ", "a_", "in ", "[in "):
        name = part * 10_000
        begin = process_time()
        without_words_behind(name)
        split_end(name)
        assert within(process_time() - begin, 0.5)
