"""Names on test benches: pounds and shares behind a name, letters of sides, parts of an effort that a model adds up."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.columns.name_ends import split_end
from erclutch.signals import units
from erclutch.signals.array import Array

ROWS = np.arange(400.0)
LEVELS = 0.5 * (ROWS // 40 % 3)
TURN = np.sin(ROWS / 9)
DRAG = np.tanh(10 * TURN) * (1 + LEVELS)
PLAIN = {"time_s": ROWS / 100, "current_A": LEVELS, "speed_rpm": 100 * TURN}


def planned(**columns: Array) -> Plan:
    return of_labels({**PLAIN, **columns})


def of_labels(columns: dict[str, Array]) -> Plan:
    names, own_units, _ = name_columns(list(columns))
    values = dict(zip(names, columns.values(), strict=True))
    known = dict(zip(names, own_units, strict=True))
    return plan_of(Table("a.csv", values, known, "0" * 64, path="a.csv"), ColumnMap())


def effort_of(plan: Plan) -> tuple[str, float]:
    (effort,) = [each for each in plan.signals if each.signal == "effort"]
    return effort.column, effort.factor


@pytest.mark.parametrize(
    ("name", "newtons"),
    [
        ("torque_ftlbs", 1.3558179483314004),
        ("torque_lbft", 1.3558179483314004),
        ("torque_in_lbs", 0.1129848290276167),
        ("torque_ozin", 0.007061551814226045),
        ("torque_oz_in", 0.007061551814226045),
        ("torque_kg_cm", 0.0980665),
        ("torque_gcm", 0.0000980665),
    ],
)
def test_pounds_and_weights_at_an_arm_behind_a_name_are_its_unit(name: str, newtons: float) -> None:
    plan = planned(**{name: DRAG})
    assert not plan.questions
    assert effort_of(plan) == (name, pytest.approx(newtons))


@pytest.mark.parametrize(
    ("name", "unit"), [("force_lb", "lbf"), ("load_lbs", "lbf"), ("duty_pct", "%")]
)
def test_pounds_and_shares_behind_a_name_are_its_unit(name: str, unit: str) -> None:
    assert split_end(name)[1] == unit


@pytest.mark.parametrize("name", ["torque_pct", "torque_percent"])
def test_a_share_of_a_torque_behind_a_name_is_asked_for_what_it_means(name: str) -> None:
    (question,) = planned(**{name: DRAG}).questions
    assert question.signal == "effort"
    assert "--scale" in question.remedy


@pytest.mark.parametrize(
    ("unit", "newtons"), [("g.cm", 0.0000980665), ("kg-cm", 0.0980665), ("kg m", 9.80665)]
)
def test_a_mass_at_an_arm_is_the_torque_of_its_weight(unit: str, newtons: float) -> None:
    assert units.fits(unit, ("N*m",)) == (pytest.approx(newtons), "N*m")


@pytest.mark.parametrize("unit", ["kg*m^2", "kg.m2", "kg*m/s", "kg m²", "g*cm^2"])
def test_an_inertia_or_a_momentum_is_no_torque(unit: str) -> None:
    assert units.fits(unit, ("N*m", "N")) is None


@pytest.mark.parametrize("unit", ["kg.m.s-2", "kg m s^-2", "kg·m·s⁻²", "kg m/s^2"])
def test_a_newton_in_base_units_is_no_torque(unit: str) -> None:
    # It was kilograms of force times a metre over seconds squared.
    assert units.fits(unit, ("N*m", "N")) == (pytest.approx(1.0), "N")


@pytest.mark.parametrize("name", ["Torque_A", "Force_A", "torque_C", "Torque_L", "Torque_Nm_A"])
def test_the_letter_of_a_side_behind_an_effort_is_no_unit(name: str) -> None:
    plan = planned(**{name: DRAG})
    assert not plan.questions
    column, factor = effort_of(plan)
    assert (column, factor) == (name, 1.0)


def test_two_sides_are_asked_about() -> None:
    (question,) = planned(Torque_A=DRAG, Torque_B=1.2 * DRAG + 0.01 * np.cos(ROWS)).questions
    assert question.problem.startswith("effort may be any of the columns Torque_A, Torque_B")


@pytest.mark.parametrize(
    ("name", "end"),
    [("coil_A", "A"), ("current_A", "A"), ("load_A", "A"), ("position_m", "m"), ("torque_V", "V")],
)
def test_a_letter_that_may_be_a_unit_stays_one(name: str, end: str) -> None:
    assert split_end(name)[1] == end


PARTS = {
    "Gravity Torque [Nm]": 0.3 * np.cos(ROWS / 9),
    "Friction Torque [Nm]": 0.1 * DRAG,
    "Damping Torque [Nm]": 0.1 * TURN,
}


def test_the_parts_that_a_model_adds_are_no_effort_beside_that_which_was_applied() -> None:
    applied = {
        **PLAIN,
        **PARTS,
        "Target Torque [Nm]": DRAG,
        "Applied Torque [Nm]": DRAG + 0.01 * np.cos(70 * ROWS),
    }
    plan = of_labels(applied)
    assert not plan.questions
    assert effort_of(plan) == ("Applied Torque", 1.0)


def test_a_friction_torque_alone_is_the_effort() -> None:
    assert effort_of(of_labels({**PLAIN, "Friction Torque [Nm]": DRAG})) == ("Friction Torque", 1.0)


def test_parts_without_the_effort_that_they_make_are_not_left_out() -> None:
    plan = of_labels({**PLAIN, **PARTS})
    named = [each.column for each in plan.signals] + [each.problem for each in plan.questions]
    assert any("Friction Torque" in each for each in named)


@pytest.mark.parametrize("estimate", ["tau_est", "tau_pred"])
def test_an_estimate_beside_what_was_calculated_or_calibrated_is_asked_about(estimate: str) -> None:
    plan = of_labels({**PLAIN, "tau_cal [N*m]": DRAG, f"{estimate} [N*m]": 1.1 * DRAG})
    assert [each.signal for each in plan.questions] == ["effort"]
    assert estimate in plan.questions[0].problem


@pytest.mark.parametrize(
    ("unit", "factor"), [("dps", np.pi / 180), ("DPS", np.pi / 180), ("ips", 0.0254)]
)
def test_speeds_in_degrees_and_inches_are_known(unit: str, factor: float) -> None:
    found = units.fits(unit, ("rad/s", "m/s"))
    assert found is not None
    assert found[0] == pytest.approx(factor)


MARK = np.round(ROWS // 90 % 2)
PULL = {"time_s": ROWS / 100, "displacement_mm": 0.01 * ROWS, "force_N": 3 * ROWS * (ROWS < 350)}


@pytest.mark.parametrize("name", ["Is Holding", "endstop", "limiter_active", "fault"])
def test_a_mark_of_rows_is_no_field(name: str) -> None:
    plan = of_labels({**PULL, name: MARK})
    assert not plan.questions
    assert any(f"{name} marks rows by 0 and 1" in note for note in plan.notes)


@pytest.mark.parametrize("name", ["coil_on", "state", "magnet"])
def test_a_column_of_0_and_1_that_may_switch_a_coil_is_asked_about(name: str) -> None:
    assert [each.signal for each in of_labels({**PULL, name: MARK}).questions] == ["field"]


def test_steps_of_a_motor_count_what_a_displacement_measures() -> None:
    assert not of_labels({**PULL, "steps": np.floor(2 * ROWS)}).questions
    (question,) = of_labels({**PULL, "steps": np.floor(50 * np.sin(ROWS / 30))}).questions
    assert question.signal == "field"


@pytest.mark.parametrize("name", ["valve_cmd_pct", "brake [%]"])
def test_the_share_that_a_valve_is_told_is_proposed_before_a_mark(name: str) -> None:
    other = {"relay_mode": MARK, "level": np.round(ROWS // 50 % 3)}
    plan = of_labels(
        {"time_s": ROWS / 100, "rpm": 100 * TURN, "torque_ftlbs": DRAG, name: 30 * LEVELS, **other}
    )
    assert plan.examples == (f'--field "{name}"',)


@pytest.mark.parametrize("names", [("Fn", "vs", "Ff"), ("F_n", "v_rel", "F_f")])
def test_a_table_of_friction_points_is_asked_about_once(names: tuple[str, str, str]) -> None:
    presses, slides, rubs = names
    drawn = np.random.default_rng(7).normal(size=400)
    plan = of_labels(
        {presses: 100 + drawn**2, slides: drawn[::-1], rubs: 40 * np.tanh(9 * drawn[::-1])}
    )
    assert [each.column for each in plan.signals] == [rubs]
    assert plan.examples == ("--time none", "--field none", f'--slip "{slides}"')


@pytest.mark.parametrize(
    "name", ["Elongation", "Allongement [mm]", "Verlängerung [mm]", "elongación [mm]", "伸び [mm]"]
)
def test_how_far_a_specimen_is_stretched_is_a_position(name: str) -> None:
    plan = of_labels({"Time [s]": ROWS / 100, name: np.cumsum(TURN), "Force [N]": DRAG})
    assert [each.signal for each in plan.signals if each.column] == ["position", "effort"]
    assert not plan.questions
