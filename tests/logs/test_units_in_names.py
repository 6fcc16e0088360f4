"""A unit in a name is read, or asked about: taken as logged, the numbers would be wrong in silence.

The data are SYNTHETIC.
"""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.logs.columns.name_ends import split_end
from erclutch.signals.array import Array

TIME: Array = 0.01 * np.arange(600.0)
RATE: Array = np.sin(3.0 * TIME)
EFFORT: Array = 3.0 * np.tanh(8.0 * RATE) + 0.1 * RATE
FIELD: Array = np.repeat([0.0, 1.0, 2.0], 200)


def planned(
    slip: str, effort: str, field: str = "", *, units: dict[str, str] | None = None
) -> Plan:
    """The plan of a log with these columns, and the units of some of them."""
    columns: dict[str, Array] = {"time": TIME, slip: RATE, effort: EFFORT}
    if field:
        columns[field] = FIELD
    known: dict[str, str | None] = dict.fromkeys(columns)
    known |= {"time": "s", **(units or {})}
    return plan_of(Table("a.csv", columns, known, "x", path="a.csv"), ColumnMap())


def doubted(plan: Plan, signal: str) -> bool:
    chosen = plan.signal(signal)
    asked = signal in {question.signal for question in plan.questions}
    return asked or (chosen is not None and chosen.sureness == "doubtful")


@pytest.mark.parametrize(
    ("effort", "factor"),
    [
        ("kgfcm_Torque", 0.0980665),
        ("Torque_mNM", 1e-3),
        ("TorquemNM", 1e-3),
        ("Torque_kNM", 1e3),
        ("Torque_NM", 1.0),
    ],
)
def test_a_unit_of_a_torque_is_read_from_its_name(effort: str, factor: float) -> None:
    chosen = planned("omega", effort, units={"omega": "rad/s"}).signal("effort")
    assert chosen is not None
    assert chosen.factor == pytest.approx(factor)
    assert chosen.sureness != "doubtful"


@pytest.mark.parametrize(
    ("slip", "unit"),
    [
        ("Speeddeg_per_s", "rad/s"),
        ("Omegarad_per_s", "rad/s"),
        ("velocitymm_per_sec", "m/s"),
        ("Speed_deg_per_s", "rad/s"),
    ],
)
def test_a_speed_with_its_unit_behind_it_is_no_shear_rate(slip: str, unit: str) -> None:
    effort = "torque" if unit == "rad/s" else "force"
    chosen = planned(slip, effort).signal("slip")
    assert chosen is not None
    assert chosen.si == unit


def test_what_a_speed_counts_that_nobody_knows_is_asked() -> None:
    plan = planned("Speedsteps_per_s", "torque")
    assert doubted(plan, "slip")


def test_a_shear_rate_a_second_is_still_a_shear_rate() -> None:
    plan = planned("shear_rate_per_s", "shear_stress_Pa")
    chosen = plan.signal("slip")
    assert chosen is not None
    assert chosen.si == "1/s"


@pytest.mark.parametrize(
    ("field", "factor"), [("CurrentkA", 1e3), ("kA_Current", 1e3), ("Current_kA", 1e3)]
)
def test_a_current_in_kiloamperes_is_one(field: str, factor: float) -> None:
    chosen = planned("omega", "torque", field).signal("field")
    assert chosen is not None
    assert chosen.factor == pytest.approx(factor)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("CurrentMilliAmps", "mA"),
        ("Current milli ampere", "mA"),
        ("Current_milli_amps", "mA"),
        ("MilliAmps", "mA"),
        ("ForceKiloNewton", "kN"),
        ("Force kilo newtons", "kN"),
        ("VoltageKiloVolts", "kV"),
        ("TorqueMilliNewtonMeter", "mN*m"),
        ("position_milli_metres", "mm"),
        ("ForceNewton", "N"),
        ("Force_kilonewton", "kN"),
        ("kilo", None),
    ],
)
def test_a_prefix_in_a_word_of_its_own_belongs_to_the_unit(name: str, unit: str | None) -> None:
    """``CurrentMilliAmps`` was a current in A, in silence."""
    assert split_end(name)[1] == unit


@pytest.mark.parametrize("effort", ["Force G", "Force_G", "ForceMN", "FORCE_G", "LoadMN"])
def test_a_unit_of_a_force_that_may_be_two_is_asked(effort: str) -> None:
    plan = planned("velocity", effort, units={"velocity": "m/s"})
    assert doubted(plan, "effort")


@pytest.mark.parametrize(
    "effort", ["Force", "Force_N", "Torque_A", "Force_L", "brakeTorque", "Force_ACT"]
)
def test_names_without_such_a_unit_are_not_asked_about(effort: str) -> None:
    assert not doubted(planned("velocity", effort), "effort")


def with_a_unit(effort: str, unit: str, slip: str, told: ColumnMap | None = None) -> Plan:
    columns: dict[str, Array] = {"time": TIME, "velocity": RATE, effort: EFFORT}
    known: dict[str, str | None] = {"time": "s", "velocity": slip, effort: unit}
    return plan_of(Table("a.csv", columns, known, "x", path="a.csv"), told or ColumnMap())


@pytest.mark.parametrize(
    ("effort", "unit"),
    [("torque_Nm", "Nmm"), ("Force_kN", "N"), ("torque_mNm", "N*m"), ("force [N]", "kN")],
)
def test_a_unit_that_contradicts_the_name_is_asked_and_the_answer_is_taken(
    effort: str, unit: str
) -> None:
    slip = "rad/s" if "orque" in effort else "m/s"
    plan = with_a_unit(effort, unit, slip)
    assert doubted(plan, "effort")
    settled = with_a_unit(
        effort, unit, slip, ColumnMap.from_labels({"effort": f"{effort} [{unit}]"})
    )
    assert not doubted(settled, "effort")


@pytest.mark.parametrize(
    ("effort", "unit"),
    [("torque_Nm", "N*m"), ("torque_Nm", "Nm"), ("Force_kN", "kN"), ("Force_N", "kN")],
)
def test_a_unit_that_the_name_repeats_or_does_not_say_is_taken(effort: str, unit: str) -> None:
    slip = "rad/s" if "orque" in effort else "m/s"
    assert not doubted(with_a_unit(effort, unit, slip), "effort")


@pytest.mark.parametrize(
    ("unit", "likely"),
    [("rads", "rad/s"), ("deg", "deg/s"), ("degs", "deg/s"), ("ms", "m/s"), ("rad", "rad/s")],
)
def test_a_speed_in_the_unit_of_an_angle_is_offered_as_a_speed(unit: str, likely: str) -> None:
    """A stroke was forgotten: as a position it would be differentiated once more."""
    columns: dict[str, Array] = {"time": TIME, "Speed": RATE, "Torque": EFFORT}
    known: dict[str, str | None] = {"time": "s", "Speed": unit, "Torque": "N*m"}
    plan = plan_of(Table("a.csv", columns, known, "x", path="a.csv"), ColumnMap())
    assert f'--slip "Speed [{likely}]"' in plan.command()
    assert "--position" not in plan.command()


@pytest.mark.parametrize(
    ("effort", "unit"),
    [("TORQUE_MNM", "UNIT"), ("TorqueMNm", "UNIT"), ("ForcedaN", "daN"), ("Loadlbf", "lbf")],
)
def test_the_command_has_the_unit_of_a_name_that_is_not_read(effort: str, unit: str) -> None:
    """As printed, it took such a column as logged."""
    assert f'--effort "{effort} [{unit}]"' in planned("velocity", effort).command()


def test_a_shear_stress_beside_the_speed_of_a_rotor_is_asked_about() -> None:
    """The rotor of a viscometer turns at a speed; its shear rate is another number."""
    units = {"Rotor": "rpm", "Напряж": "mN/m^2"}
    assert planned("Rotor", "Напряж", units=units).doubts
    of_a_rate = {"shear_rate": "1/s", "Напряж": "mN/m^2"}
    assert not doubted(planned("shear_rate", "Напряж", units=of_a_rate), "effort")
