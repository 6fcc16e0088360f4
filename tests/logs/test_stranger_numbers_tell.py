"""What a stranger's table is by its numbers: a faint voltage, a smoothed quotient, a steady clock, an empty column."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import LogError, MappingError
from erclutch.logs import ColumnMap, Plan, Table, plan_of, read


def _signals(columns: Mapping[str, Any], units: dict[str, str] | None = None) -> Plan:
    return plan_of(Table("a", columns, units or {}, "0" * 64), ColumnMap())


SPAN = np.arange(300) * 0.01
SWING = np.sin(9.0 * SPAN)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("voltage", "may be"),  # no field, if nobody says otherwise
        ("current", "is"),  # or in another unit
        ("Spannung", "may be"),
        ("电压", "may be"),
    ],
)
def test_an_output_of_a_sensor_is_no_field_without_a_word(name: str, said: str) -> None:
    faint = {
        "time": SPAN,
        "velocity": SWING,
        "force": SWING,
        name: 2e-5 + 1e-6 * np.cos(4.0 * SPAN),
    }
    assert [doubt.partition(",")[0] for doubt in _signals(faint).doubts] == [
        f"field {said} column {name} which never exceeds 2.1e-05"
    ]
    strong = {**faint, name: 2.0 + np.cos(4.0 * SPAN)}
    assert _signals(strong).doubts == ()


@pytest.mark.parametrize("unit", ["mA", "kV"])
def test_a_faint_field_is_told_in_its_own_unit(unit: str) -> None:
    log = {
        "time": SPAN,
        "velocity": SWING,
        "force": SWING,
        "voltage": 2e-5 + 1e-6 * np.cos(4.0 * SPAN),
    }
    plan = _signals(log, {"voltage": "kV"} if unit == "kV" else {})
    assert bool(plan.doubts) == (unit != "kV")


def test_a_smoothed_coefficient_of_friction_tells_which_force_is_the_friction() -> None:
    rng = np.random.default_rng(0)
    pressed = 9.0 + 0.01 * rng.standard_normal(SPAN.size)
    rubbed = 1.4 + 0.1 * SWING + 0.05 * rng.standard_normal(SPAN.size)
    smoothed = np.convolve(rubbed / pressed, np.full(9, 1 / 9), mode="same")
    smoothed[:5] = smoothed[-5:] = np.nan
    columns = {"Timestamp": SPAN, "Fz": pressed, "Fx": rubbed, "COF": smoothed, "Velocity": SWING}
    units = {"Timestamp": "s", "Fz": "N", "Fx": "N", "Velocity": "mm/s"}
    effort = _signals(columns, units).signal("effort")
    assert effort is not None
    assert effort.column == "Fx"
    # Numbers that are no quotient of the two tell nothing: the user is asked.
    plan = _signals({**columns, "COF": 3.0 * smoothed}, units)
    assert "effort" in {question.signal for question in plan.questions}


def test_of_several_columns_in_seconds_the_steady_one_is_the_time() -> None:
    columns = {
        "delay": SWING,
        "storage_t": SPAN,
        "stop": np.cumsum(1.0 + SWING),
        "velocity": SWING,
        "force": SWING,
    }
    units = {"delay": "s", "storage_t": "s", "stop": "s"}
    clock = _signals(columns, units).clock
    assert clock is not None
    assert clock.column == "storage_t"
    # Two samples side by side, of which the second has fewer rows, have two times.
    shorter = np.where(SPAN < 1.0, 2.0 * SPAN, np.nan)
    for other in (2.0 * SPAN, shorter):
        assert _signals({**columns, "other_t": other}, {**units, "other_t": "s"}).clock is None


def test_a_table_that_lies_on_its_side_is_refused() -> None:
    columns = {f"c{i}": np.zeros(20) for i in range(1001)}
    with pytest.raises(LogError, match="20 rows of 1,001 columns: a log has one row a sample"):
        _signals(columns)


def test_the_motion_that_makes_a_power_with_an_effort_is_proposed() -> None:
    speeds = {"V_FZG": SWING, "N_VM": SWING, "PA1_Spd": SWING}
    columns = {"U": SWING, **speeds, "M_HM": SWING, "PA1_Trq": SWING**3, "P": SPAN}
    units = {
        "U": "V",
        "V_FZG": "km/h",
        "N_VM": "rpm",
        "PA1_Spd": "rpm",
        "M_HM": "Nm",
        "PA1_Trq": "Nm",
        "P": "s",
    }
    command = _signals(columns, units).command()
    assert '--slip "PA1_Spd [rpm]"' in command
    assert '--effort "PA1_Trq [Nm]"' in command


@pytest.mark.parametrize("reader", ["csv", "json"])
def test_a_column_without_a_number_says_so_where_it_is_named(tmp_path: Path, reader: str) -> None:
    path = tmp_path / f"log.{reader}"
    names = ("t", "V [cm/s]", "F [N]", "I [A]")
    rows = [
        (time, swing, swing, None)
        for time, swing in zip(SPAN.tolist(), SWING.tolist(), strict=True)
    ]
    if reader == "csv":
        lines = (",".join("" if cell is None else f"{cell:.4f}" for cell in row) for row in rows)
        path.write_text("\n".join([",".join(names), *lines]), encoding="utf-8")
    else:
        path.write_text(
            json.dumps([dict(zip(names, row, strict=True)) for row in rows]), encoding="utf-8"
        )
    with pytest.raises(MappingError, match="column 'I' holds no number in any row"):
        read(path, field="I")


def test_a_signal_s_word_within_a_name_is_proposed_and_never_taken() -> None:
    plan = _signals(
        {"time": SPAN, "act_vel_se": SWING, "act_torque_abs": SWING**3, "torque_limit": 2.0 + SWING}
    )
    assert {question.signal for question in plan.questions} >= {"slip", "effort"}
    assert '--slip "act_vel_se"' in plan.command()
    assert '--effort "act_torque_abs"' in plan.command()


@pytest.mark.parametrize(
    ("time", "unit", "constants", "told"),
    [
        (SPAN, None, {}, "100 Hz"),
        (1e3 * SPAN, "ms", {}, "100 Hz"),
        (None, None, {"fs": 3004.8}, "3004.8 Hz"),
        (1e3 * SPAN, None, {}, ""),  # ms, or seconds: nobody says it
    ],
)
def test_a_rate_that_is_not_that_of_the_file_is_told(
    time: Any, unit: str | None, constants: dict[str, float], told: str
) -> None:
    columns = {"current": 1.0 + SWING, "velocity": SWING, "force": SWING}
    if time is not None:
        columns = {"time": time, **columns}
    table = Table("a", columns, {"time": unit} if unit else {}, "0" * 64, constants=constants)
    clock = plan_of(table, ColumnMap(rate=128.0)).clock
    assert clock is not None
    assert clock.sentence.endswith(f", though the file says {told}" if told else "(given)")


def test_a_rate_that_is_that_of_the_file_is_told_without_a_doubt() -> None:
    columns = {"time": SPAN, "current": 1.0 + SWING, "velocity": SWING, "force": SWING}
    clock = plan_of(Table("a", columns, {}, "0" * 64), ColumnMap(rate=100.0)).clock
    assert clock is not None
    assert "though" not in clock.sentence


@pytest.mark.parametrize(("name", "unit"), [("voltage", None), ("U_lc", "V"), ("Spannung", None)])
def test_a_faint_field_that_goes_straight_with_the_effort_is_the_output_of_its_sensor(
    name: str, unit: str | None
) -> None:
    noise = 0.02 * np.cos(70.0 * SPAN)
    log = {
        "time": SPAN,
        "velocity": np.cos(5.0 * SPAN),
        "force": SWING,
        name: 4e-5 + 1e-5 * (SWING + noise),
    }
    plan = _signals(log, {name: unit} if unit else {})
    assert plan.signal("field") is None or plan.signal("field").column == ""  # type: ignore[union-attr]
    assert (plan.questions, plan.doubts) == ((), ())
    told = f"column {name} never exceeds 5.02e-05 and goes straight with force: taken for the output of its sensor"
    assert any(note.startswith(told) for note in plan.notes)
    # Where it goes another way nothing is known; a faint current may leak through a fluid, and tell the field.
    assert _signals(
        {**log, name: 4e-5 + 1e-5 * np.cos(3.0 * SPAN)}, {name: unit} if unit else {}
    ).doubts
    leak = {each: values for each, values in log.items() if each != name}
    assert _signals({**leak, "leak current": log[name]}, {"leak current": "A"}).questions
    assert _signals({**leak, "current": log[name]}, {"current": "A"}).doubts
    strong = _signals({**log, name: 1e3 * log[name]}, {name: unit} if unit else {}).signal("field")
    assert strong is not None
    assert strong.column == name


@pytest.mark.parametrize(("whole", "unit"), [(1.0, "rpm"), (100.0, "rpm"), (1.0, None)])
def test_the_slip_of_an_electric_machine_is_a_share_of_its_speed(
    whole: float, unit: str | None
) -> None:
    speed = np.round(1500.0 - 400.0 * SPAN / SPAN[-1] - 30.0 * (SWING + 1.0))
    columns = {
        "time": SPAN,
        "speed": speed,
        "slip": np.round(whole * (1.0 - speed / 1500.0), 3),
        "torque": SWING,
    }
    plan = _signals(columns, {"speed": unit} if unit else {})
    slip = plan.signal("slip")
    assert slip is not None
    assert (slip.column, slip.unit) == ("speed", unit)
    assert "slip" not in {question.signal for question in plan.questions}


@pytest.mark.parametrize("driven", [1.0, 98.0, 100.0, 1500.0])
def test_what_a_clutch_lags_behind_its_shaft_is_its_slip(driven: float) -> None:
    slip = 0.4 * driven * (1.0 + SWING) / 2.0
    columns = {"time": SPAN, "output speed": driven - slip, "slip": slip, "torque": SWING}
    taken = _signals(columns).signal("slip")
    assert taken is not None
    assert taken.column == "slip"


@pytest.mark.parametrize("slip", [SWING, 0.2 + 0.1 * SWING, np.abs(SWING)])
def test_a_slip_that_is_no_share_of_a_speed_is_the_slip_or_asked_about(slip: Any) -> None:
    columns = {
        "time": SPAN,
        "speed": 1500.0 - 90.0 * np.cos(4.0 * SPAN),
        "slip": slip,
        "torque": SWING,
    }
    taken = _signals(columns).signal("slip")
    assert taken is not None
    assert taken.column == "slip"
    assert "slip" in {question.signal for question in _signals(columns, {"speed": "rpm"}).questions}


@pytest.mark.parametrize(
    ("effort", "unit", "speeds", "slip"),
    [
        ("stress", "Pa", "ABC", "B"),
        ("torque", "N*m", "AC", "A"),
        ("torque", "N*m", "ABC", ""),  # turns a second, or a shear rate
        ("force", "N", "ABC", "C"),
        ("load", "%", "ABC", ""),
    ],
)
def test_of_several_speeds_the_one_that_makes_a_power_with_the_effort_is_taken(
    effort: str, unit: str, speeds: str, slip: str
) -> None:
    courses = {"A": SWING, "B": np.cos(5.0 * SPAN), "C": np.cos(3.0 * SPAN)}
    columns = {"time": SPAN, **{name: courses[name] for name in speeds}, effort: SWING**3}
    plan = _signals(columns, {"A": "rpm", "B": "1/s", "C": "mm/s", effort: unit})
    found = plan.signal("slip")
    assert (found.column if found else "") == slip
    # Two of its kind are asked about.
    units = {"A": "rpm", "B": "1/s", "C": "mm/s", effort: unit, "D": "rpm", "E": "1/s", "F": "mm/s"}
    more = {"D": np.cos(7.0 * SPAN), "E": np.cos(8.0 * SPAN), "F": np.cos(9.0 * SPAN)}
    assert "slip" in {
        question.signal for question in _signals({**columns, **more}, units).questions
    }


@pytest.mark.parametrize("name", ["G'", 'G"', "E' in Pa", "G′"])
def test_a_modulus_of_an_oscillation_is_no_stress(name: str) -> None:
    columns = {"time": SPAN, "rate": SWING, "sigma": SWING**3, name: 2.0 + SWING}
    effort = _signals(columns, {"rate": "1/s", "sigma": "Pa", name: "Pa"}).signal("effort")
    assert effort is not None
    assert effort.column == "sigma"


@pytest.mark.parametrize("name", ["ω", "omega", "w"])
def test_the_omega_of_an_oscillation_is_no_slip(name: str) -> None:
    columns = {"time": SPAN, name: 6.28 + 0.0 * SPAN, "G'": 2.0 + SWING, "tan(δ)": 1.5 + SWING}
    units = {name: "rad/s", "G'": "Pa"}
    assert _signals(columns, units).signal("slip") is None
    without_moduli = {"time": SPAN, name: 6.28 + SWING, "torque": 2.0 + SWING}
    slip = _signals(without_moduli, {name: "rad/s", "torque": "N*m"}).signal("slip")
    assert slip is not None
    assert slip.column == name


@pytest.mark.parametrize(("prime", "mean", "unit"), [("E'", "E_bar", "V"), ("u'", "u_bar", "m/s")])
def test_a_fluctuation_beside_its_mean_is_asked_about(prime: str, mean: str, unit: str) -> None:
    columns = {"time": SPAN, prime: 0.1 + 0.1 * SWING, mean: 1.0 + SWING, "force": SWING}
    asked = _signals(columns, {prime: unit, mean: unit}).questions
    assert any(
        f"may be any of the columns {prime}, {mean}" in question.problem for question in asked
    )


@pytest.mark.parametrize("name", ["ddq3", "qdd3", "theta_ddot", "d2x", "xddot"])
def test_a_rate_of_a_rate_is_no_field(name: str) -> None:
    noisy = np.cos(40.0 * SPAN) + SWING
    plan = _signals({"time": SPAN, "velocity": SWING, "force": SWING**3, name: noisy})
    assert plan.questions == ()
    other = _signals({"time": SPAN, "velocity": SWING, "force": SWING**3, "ddc3": noisy})
    assert [question.signal for question in other.questions] == ["field"]


@pytest.mark.parametrize(
    ("header", "travel"),
    [
        ("Gage length, standard travel", "Standard travel"),
        ("L0 - course standard", "Course standard"),
        ("Anfangsmesslänge (Standardweg)", "Standardweg"),
    ],
)
def test_of_several_travels_the_one_with_a_gauge_length_is_taken(header: str, travel: str) -> None:
    columns: dict[str, Any] = {
        "time": SPAN,
        "Absolute Position": 3.0 * SPAN + SWING,
        travel: 2.0 * SPAN,
        "force": SWING + 9.0 * SPAN,
    }
    units = {"time": "s", "Absolute Position": "mm", travel: "mm", "force": "N"}

    def planned(**metadata: str) -> Plan:
        return plan_of(Table("a", columns, units, "0" * 64, metadata=metadata), ColumnMap())

    position = planned(**{header: "20 mm"}).signal("position")
    assert position is not None
    assert position.column == travel
    assert "and the header gives the gauge length for it" in position.reason
    # No length, another word, or both of them: the file does not say it.
    for metadata in (
        {header: ""},
        {f"Speed, {travel}": "2 mm"},
        {header: "20 mm", "L0 Absolute Position": "20 mm"},
    ):
        assert [question.signal for question in planned(**metadata).questions] == ["slip"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Step", "RecipeStep", "test segment", "Abschnitt"])
def test_numbers_of_the_steps_of_a_test_are_no_field(name: str) -> None:
    steps = 4.0 + 3.0 * np.floor(SPAN)
    plan = _signals({"time": SPAN, "velocity": SWING, "force": SWING**3, name: steps})
    assert plan.questions == ()
    assert any(f"{name} numbers the parts of the test" in note for note in plan.notes)
    # Steps that go back, or are no whole numbers, may be levels; so may those of something else.
    for other, values in ((name, steps[::-1]), (name, steps / 8.0), (f"coil {name}", steps)):
        asked = _signals({"time": SPAN, "velocity": SWING, "force": SWING**3, other: values})
        assert [question.signal for question in asked.questions] == ["field"]


@pytest.mark.parametrize(("top", "bottom"), [("DAQ.Fx", "DAQ.Fz"), ("Traction Force", "Ball Load")])
def test_a_friction_beside_turns_is_no_doubt_where_a_coefficient_is_made_of_it(
    top: str, bottom: str
) -> None:
    rubbed = 0.6 + 0.05 * SWING
    pressed = 3.0 + 0.02 * np.cos(3.0 * SPAN)
    columns = {
        "time": SPAN,
        "Velocity": 160.0 + 30.0 * SWING,
        top: rubbed,
        bottom: pressed,
        "COF": rubbed / pressed,
    }
    units = {"time": "s", "Velocity": "rpm", top: "N", bottom: "N"}
    plan = _signals(columns, units)
    effort = plan.signal("effort")
    assert effort is not None
    assert (effort.column, plan.doubts) == (top, ())
    lone = {name: values for name, values in columns.items() if name not in ("COF", bottom)}
    assert any("makes no power" in doubt for doubt in _signals(lone, units).doubts)
