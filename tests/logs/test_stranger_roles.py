"""Columns of strangers' logs are no signals by their unit alone: radii, powers, and volts that are called amperes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnitError
from erclutch.logs import ColumnMap, Table, apply, plan_of, read_table
from erclutch.logs.columns.labels import name_columns
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned, table

ROWS = np.arange(200.0)
LEVELS = 0.5 * (ROWS // 20 % 3)
TURN = np.sin(ROWS / 9)
PLAIN = {"t [s]": ROWS / 100, "current [A]": LEVELS, "speed [rad/s]": TURN, "torque [N*m]": TURN**3}


def without(*labels: str) -> dict[str, Array]:
    return {label: values for label, values in PLAIN.items() if label not in labels}


@pytest.mark.parametrize("name", ["Disk Radius [m]", "inner dia [mm]", "lever [cm]"])
def test_a_length_that_never_changes_is_no_position(name: str) -> None:
    plan = planned({**PLAIN, name: np.full(200, 0.05)})
    assert plan.signal("position") is None
    (question,) = planned({**without("speed [rad/s]"), name: np.full(200, 0.05)}).questions
    assert question.signal == "slip"
    assert "--position" not in question.remedy


@pytest.mark.parametrize("name", ["power [W]", "P_el [kW]", "loss [W]"])
def test_power_is_no_slip(name: str) -> None:
    (question,) = planned({**without("speed [rad/s]"), name: TURN}).questions
    assert question.signal == "slip"


@pytest.mark.parametrize(
    ("name", "unit"), [("commandVoltage_V", "A"), ("coil_mA", "V"), ("coil_kV", "T")]
)
def test_a_unit_at_the_end_of_a_name_is_believed(name: str, unit: str) -> None:
    columns = {**without("current [A]"), name: LEVELS}
    plan = planned(columns, field=f"{name} [{unit}]")
    with pytest.raises(UnitError, match=r"ends in a unit, .*another kind.*--scale"):
        apply(plan, table(columns))
    assert planned(columns, field=name).signal("field") is not None


def test_an_example_names_the_unit_that_the_name_has() -> None:
    columns = {**without("current [A]"), "one_V": LEVELS, "other_V": LEVELS + TURN}
    with pytest.raises(
        MappingError, match=r"may be any of the columns one_V, other_V.*--field \"one_V\""
    ):
        apply(planned(columns), table(columns))


@pytest.mark.parametrize("values", [0.5 + 0.4 * TURN, 2.0 + ROWS / 100])
def test_a_field_by_its_unit_alone_that_keeps_no_level_is_in_doubt(values: Array) -> None:
    plan = planned({**without("current [A]"), "q7 [V]": values})
    assert plan.doubts == (
        "field is column q7 by its unit alone, and its numbers do not look like that",
    )
    assert plan.command() == 'erclutch inspect a.csv --field "q7 [V]"'
    assert planned({**without("current [A]"), "q7 [V]": LEVELS}).doubts == ()
    assert planned({**without("current [A]"), "q7 [V]": values}, field="q7").doubts == ()


def test_a_slip_by_its_unit_alone_that_never_rests_or_turns_back_is_in_doubt() -> None:
    plan = planned({**without("speed [rad/s]"), "q7 [rad/s]": 50.0 + TURN})
    assert [doubt.partition(" is ")[0] for doubt in plan.doubts] == ["slip"]
    assert planned({**without("speed [rad/s]"), "q7 [rad/s]": TURN}).doubts == ()
    assert planned({**without("speed [rad/s]"), "speed [rad/s]": 50.0 + TURN}).doubts == ()


def test_what_is_in_doubt_stops_the_reading_with_the_option_that_settles_it() -> None:
    columns = {**without("current [A]"), "q7 [V]": 2.0 + ROWS / 100}
    with pytest.raises(
        MappingError, match=r'field is column q7 by its unit alone.*say so: --field "q7 \[V\]"'
    ):
        planned(columns).require_sureness()
    planned(columns, field="q7 [V]").require_sureness()


@pytest.mark.parametrize("voltage", ["U_DC [V]", "voltage [mV]", "Spannung [V]"])
@pytest.mark.parametrize("current", ["I_DC [A]", "Iq_meas [A]", "PA1_IRMS_1 [mA]"])
def test_a_voltage_beside_a_current_may_not_be_the_field(voltage: str, current: str) -> None:
    columns = {**without("current [A]"), voltage: LEVELS + 5.0, current: LEVELS}
    (question,) = planned(columns).questions
    assert question.signal == "field"
    assert all(label.partition(" [")[0] in question.problem for label in (voltage, current))


@pytest.mark.parametrize("current", ["I_set [A]", "fan temperature current [A]"])
def test_a_voltage_beside_the_target_of_a_current_is_the_field(current: str) -> None:
    chosen = planned({**without("current [A]"), "voltage [V]": LEVELS, current: LEVELS}).signal(
        "field"
    )
    assert chosen is not None
    assert chosen.column == "voltage"


@pytest.mark.parametrize(("name", "gap"), [("h [mm]", TURN), ("q9 [mm]", 1.5 + 1e-3 * TURN)])
def test_a_gap_is_no_position(name: str, gap: Array) -> None:
    plan = planned({**without("speed [rad/s]"), name: gap})
    assert plan.signal("position") is None or plan.doubts
    assert planned({**without("speed [rad/s]"), "q9 [mm]": 1.5 + TURN}).doubts == ()


@pytest.mark.parametrize("name", ["F' [N]", 'G" [N]', "E' [N]", "T′ [N*m]"])
def test_a_name_with_a_prime_is_another_quantity(name: str) -> None:
    chosen = planned({**PLAIN, name: TURN}).signal("effort")
    assert chosen is not None
    assert chosen.column == "torque"
    assert planned({**without("torque [N*m]"), name: TURN}).signal("field") is not None


def test_a_position_by_its_unit_alone_beside_a_slip_is_taken_where_the_slip_is_its_rate() -> None:
    time = ROWS / 100
    columns = {**without("speed [rad/s]"), "speed [rad/s]": 7 * np.cos(7 * time)}
    assert planned({**columns, "q7 [rad]": np.sin(7 * time)}).signal("position") is not None
    other = planned({**columns, "q7 [rad]": np.sin(3 * time)})
    assert other.signal("position") is None
    assert not other.questions
    assert any(
        "column q7 has the unit of a position, and column speed is not its rate: left out" in n
        for n in other.notes
    )


@pytest.mark.parametrize("factor", [100.0, 0.01, 57.29578])
def test_a_slip_that_is_a_hundred_times_the_rate_of_its_position_is_asked_about(
    factor: float,
) -> None:
    time = ROWS / 100
    columns = {
        **without("speed [rad/s]"),
        "speed [rad/s]": factor * 7 * np.cos(7 * time),
        "angle [rad]": np.sin(7 * time),
    }
    (question,) = planned(columns).questions
    assert (
        f"the slip, column speed, is {factor:.3g} times the rate of the position, column angle"
        in question.problem
    )
    given = planned(columns, slip="speed [rad/s]")
    assert not given.questions
    assert any("times the rate of the position" in note for note in given.notes)


def test_a_slip_beside_its_own_position_is_not_asked_about() -> None:
    time = ROWS / 100
    columns = {
        **without("speed [rad/s]"),
        "speed [rad/s]": 7 * np.cos(7 * time),
        "angle [rad]": np.sin(7 * time),
    }
    assert not planned(columns).questions


@pytest.mark.parametrize(
    ("slip", "effort"),
    [("Belt Velocity [m/s]", "Pitch Moment [Nm]"), ("Rotary.Velocity [rpm]", "Friction Force [N]")],
)
def test_a_guess_that_makes_no_power_is_in_doubt_and_believed_where_it_is_given(
    slip: str, effort: str
) -> None:
    names = [name_columns([label])[0][0] for label in (slip, effort)]
    given = dict(zip(names, (name_columns([label])[1][0] for label in (slip, effort)), strict=True))
    columns = {
        "time": np.arange(200) / 100,
        **{name: np.sin(np.arange(200) / 9 + k) for k, name in enumerate(names)},
    }
    table = Table("a", columns, {"time": "s", **given}, "0" * 64)
    plan = plan_of(table, ColumnMap())
    assert "makes no power" in plan.doubts[0]
    assert plan_of(table, ColumnMap.from_options({"effort": effort, "slip": slip})).doubts == ()


def test_horsepower_is_no_field() -> None:
    columns = {
        "time": np.arange(200) / 100,
        "speed": np.sin(np.arange(200) / 9),
        "torque": np.cos(np.arange(200) / 9),
    }
    plan = plan_of(
        Table("a", {**columns, "Horsepower": np.sin(np.arange(200) / 5)}, {}, "0" * 64), ColumnMap()
    )
    assert plan.questions == ()


def asked_field(columns: dict[str, Array]) -> bool:
    return any(question.signal == "field" for question in planned(columns).questions)


SWING = {"t [s]": ROWS / 100, "x [mm]": 30.0 * TURN, "F [N]": 500.0 * np.sin(ROWS / 9 + 1.0)}


@pytest.mark.slow
@pytest.mark.parametrize("ahead", [0.15, 0.3, 0.6])
def test_the_set_point_of_a_motion_is_no_field(ahead: float) -> None:
    assert not asked_field({**SWING, "control": 30.5 * np.sin(ROWS / 9 + ahead)})
    assert asked_field(
        {**SWING, "control": 2.0 * np.sin(ROWS / 9 + ahead)}
    )  # between ends of its own
    assert asked_field({**SWING, "control": 30.0 * np.sin(ROWS / 31)})  # at a time of its own


@pytest.mark.slow
def test_the_rate_of_a_position_and_a_quotient_are_no_field() -> None:
    assert not asked_field({**SWING, "c5": np.gradient(SWING["x [mm]"], 0.01)})
    rolling, sliding = 200.0 + ROWS % 7, 180.0 + ROWS % 11
    speeds = {"rolling [mm/s]": rolling, "sliding speed [mm/s]": sliding}
    columns = {"t [s]": ROWS / 100, "F [N]": ROWS % 13, **speeds}
    assert not asked_field({**columns, "SRR": np.round(100.0 * sliding / rolling, 3)})
    assert asked_field({**columns, "SRR": 100.0 * sliding / rolling + ROWS % 5})


NOTHING = np.full(200, np.nan)


def test_a_column_without_a_number_is_no_signal() -> None:
    plan = planned(
        {**without("speed [rad/s]"), "motor speed [rad/s]": NOTHING, "disk speed [rad/s]": TURN}
    )
    assert plan.choices["slip"].column == "disk speed"
    assert "no number in any row: column motor speed: left out" in plan.notes


@pytest.mark.parametrize(
    ("label", "signal"), [("speed [rad/s]", "slip"), ("torque [N*m]", "effort")]
)
def test_a_signal_without_a_number_is_told_from_one_that_is_not_there(
    label: str, signal: str
) -> None:
    (question,) = planned({**PLAIN, label: NOTHING}).questions
    assert question.signal == signal
    assert (
        f"column {label.partition(' ')[0]} is called so, but holds no number in any row"
        in question.problem
    )


LOADED = {**PLAIN, "speed [rad/s]": 5.0 + TURN, "torque [N*m]": 2.0 + TURN**2}
POWER = LOADED["speed [rad/s]"] * LOADED["torque [N*m]"]


@pytest.mark.parametrize(
    ("ratio", "label"),
    [(100.0, "P [W]"), (1000.0, "power [W]"), (100.0, "power [kW]"), (60, "P [W]")],
)
def test_a_slip_that_makes_another_power_than_is_logged_is_asked_about(
    ratio: float, label: str
) -> None:
    watt = POWER / ratio
    columns = {**LOADED, label: watt / (1000.0 if "kW" in label else 1.0)}
    (question,) = planned(columns).questions
    assert question.signal == "slip"
    assert "times the power, column" in question.problem
    plan = planned(columns, slip="speed [rad/s]")
    assert not plan.questions
    assert any("times the power, column" in note for note in plan.notes)


@pytest.mark.parametrize(
    "power",
    [
        POWER,
        1.02 * POWER,
        POWER / 0.8,
        POWER / 100.0 * (1.0 + 0.2 * TURN),
        np.zeros(200),
        24.0 * LEVELS,
    ],
    ids=["its own", "a scale off", "behind losses", "of something else", "none", "electric"],
)
def test_a_power_that_tells_nothing_of_the_slip_asks_nothing(power: Array) -> None:
    assert not planned({**LOADED, "P [W]": power}).questions


@pytest.mark.parametrize("name", ["COF", "DAQ.COF", "Friction coefficient", "Traction Coeff"])
def test_a_coefficient_of_friction_tells_the_friction_from_the_force_that_presses(
    name: str,
) -> None:
    pressed, rubbed = 3.0 + 0.1 * (ROWS % 7), 0.5 + 0.1 * (ROWS % 11)
    columns = {"t [s]": ROWS / 100, "speed [mm/s]": TURN, "Fz [N]": pressed, "Fx [N]": rubbed}
    (question,) = planned(columns).questions
    assert question.signal == "effort"
    plan = planned({**columns, name: np.round(rubbed / pressed, 4)})
    assert plan.choices["effort"].column == "Fx"
    assert not plan.questions
    asked = planned({**columns, name: 0.1 + 0.01 * (ROWS % 5)}).questions  # made of something else
    assert "effort" in [question.signal for question in asked]


@pytest.mark.parametrize("name", ["identification_angle", "position [rad]", "Angle"])
def test_a_position_that_never_changes_beside_a_slip_that_does_is_left_out(name: str) -> None:
    plan = planned({**PLAIN, name: np.full(200, np.pi / 2)})
    assert plan.signal("position") is None
    assert any("never changes while speed does" in note for note in plan.notes)


def test_a_steady_voltage_beside_a_current_that_changes_is_a_supply() -> None:
    voltage = 48.0 + 0.1 * np.sin(np.arange(400.0))
    current = np.repeat([0.5, 2.0, 1.0, 4.0], 100)
    columns = {
        "t": np.arange(400) / 100,
        "speed": np.arange(400) % 37 - 18.0,
        "torque": current,
        "Voltage": voltage,
    }
    units = {"t": "s", "speed": "rad/s", "torque": "N*m", "Voltage": "V", "Current": "A"}
    plan = plan_of(Table("a.csv", {**columns, "Current": current}, units, "0" * 64), ColumnMap())
    field = plan.signal("field")
    assert field is not None
    assert field.column == "Current"
    assert any("column Voltage keeps near one level, 47.9 to 48.1 V" in note for note in plan.notes)

    # Where both change, the voltage drives the current through the coil.
    plan = plan_of(
        Table("a.csv", {**columns, "Voltage": 2.0 * current, "Current": current}, units, "0" * 64),
        ColumnMap(),
    )
    field = plan.signal("field")
    assert field is not None
    assert field.column == "Current"


@pytest.mark.parametrize(
    ("voltage", "current"),
    [
        ("Voltage [V]", "Current [A]"),
        ("V3 [V]", "I3 [A]"),
        ("coil voltage [V]", "coil current [mA]"),
        ("Spannung [V]", "Strom [A]"),
    ],
)
def test_of_a_voltage_and_a_current_of_one_coil_the_current_is_the_field(
    voltage: str, current: str
) -> None:
    plan = planned({**without("current [A]"), voltage: 12.0 * LEVELS, current: LEVELS})
    assert not plan.questions
    assert plan.choices["field"].column == current.partition(" [")[0]


@pytest.mark.parametrize(
    ("voltage", "current", "volts"),
    [
        ("Voltage [kV]", "Current [mA]", 2.0),  # across a fluid: the current leaks
        ("Voltage [V]", "Current [µA]", 800.0),
        ("brake voltage [V]", "motor current [A]", 12.0),
        ("voltage", "current", 12.0),
    ],
)
def test_a_voltage_that_drives_no_current_of_its_circuit_is_asked_about(
    voltage: str, current: str, volts: float
) -> None:
    (question,) = planned(
        {**without("current [A]"), voltage: volts * LEVELS, current: LEVELS}
    ).questions
    assert question.signal == "field"


def test_a_block_without_a_number_of_a_voltage_is_no_supply() -> None:
    columns = {
        "t": np.arange(400) / 100,
        "speed": np.arange(400) % 37 - 18.0,
        "torque": np.arange(400) % 5.0,
    }
    fields = {"Voltage": np.full(400, np.nan), "Current": np.repeat([0.5, 2.0], 200)}
    units = {"t": "s", "speed": "rad/s", "torque": "N*m", "Voltage": "V", "Current": "A"}
    plan = plan_of(Table("a.csv", {**columns, **fields}, units, "0" * 64), ColumnMap(), whole=False)
    assert [question.signal for question in plan.questions] == ["field"]


def test_a_column_of_two_meanings_goes_to_the_motion_where_the_log_may_have_no_field() -> None:
    time = np.arange(400.0) / 100
    columns = {"t": time, "F": np.sign(np.cos(time)) + 0.1 * np.sin(40 * time), "V": np.cos(time)}
    plan = plan_of(Table("a.mat", columns, {"t": "s"}, "0" * 64, path="a.mat"), ColumnMap())
    assert plan.command() == 'erclutch inspect a.mat --field none --slip "V"'


@pytest.mark.parametrize(("name", "period"), [("Ts", 0.005), ("dt", 0.005), ("fs", 200.0)])
def test_a_number_beside_the_columns_may_be_their_period(name: str, period: float) -> None:
    columns = {"force": np.sin(np.arange(400.0)), "velocity": np.cos(np.arange(400.0))}
    plan = plan_of(Table("a.mat", columns, {}, "0" * 64, constants={name: period}), ColumnMap())
    assert plan.clock is not None
    assert plan.clock.period == pytest.approx(0.005)


def test_a_period_that_may_be_in_milliseconds_is_asked_about() -> None:
    columns = {"force": np.sin(np.arange(400.0)), "velocity": np.cos(np.arange(400.0))}
    plan = plan_of(Table("a.mat", columns, {}, "0" * 64, constants={"Ts": 5.0}), ColumnMap())
    assert "time" in [question.signal for question in plan.questions]


def test_the_force_along_the_motion_is_told_from_those_across_it() -> None:
    place = np.sin(np.arange(400) / 20)
    noise = np.random.default_rng(3).normal(size=(2, 400))
    columns = {
        "t": np.arange(400) / 100,
        "pos": place,
        "Fx": noise[0],
        "Fy": noise[1],
        "Fz": np.sign(np.gradient(place)),
    }
    plan = plan_of(Table("a.csv", columns, {"t": "s"}, "0" * 64), ColumnMap())
    effort = plan.signal("effort")
    assert effort is not None
    assert effort.column == "Fz"


def test_a_share_of_the_rated_torque_is_asked_for_what_it_means() -> None:
    columns = {
        "t": np.arange(400) / 100,
        "speed": np.sin(np.arange(400) / 20),
        "torque": np.cos(np.arange(400) / 20),
    }
    units = {"t": "s", "speed": "rad/s", "torque": "%"}
    plan = plan_of(Table("a.csv", columns, units, "0" * 64, path="a.csv"), ColumnMap())
    assert plan.command().endswith('--effort "torque" --scale "effort=NUMBER N*m/%"')
    told = ColumnMap.from_dict(
        {"columns": {"effort": "torque"}, "scales": {"effort": "0.02 N*m/%"}}
    )
    effort = plan_of(Table("a.csv", columns, units, "0" * 64), told).signal("effort")
    assert effort is not None
    assert (effort.factor, effort.si) == (0.02, "N*m")


@pytest.mark.parametrize(
    ("name", "signal"),
    [("pos_counts", "position"), ("torque_counts", "effort"), ("pos_count", "position")],
)
def test_a_column_of_counts_is_proposed_with_a_scale_to_fill_in(
    tmp_path: Path, name: str, signal: str
) -> None:
    other = "Force [N]" if signal == "position" else "velocity [rad/s]"
    rows = "".join(f"{k / 100},{(k * 37) % 11},{(k * 13) % 1024}\n" for k in range(40))
    path = tmp_path / "log.csv"
    path.write_text(f"time [s],{other},{name}\n{rows}", encoding="utf-8")
    plan = plan_of(read_table(path), ColumnMap())
    assert any(f'"{name}" --scale' in option for option in plan.examples), plan.examples


@pytest.mark.parametrize(
    "name", ["T_per_rpm_Nm_per_rpm", "torque_per_rpm", "force per speed", "Nm per speed"]
)
def test_one_quantity_per_another_is_neither(tmp_path: Path, name: str) -> None:
    rows = "".join(f"{k / 100},{(k * 37) % 11},{(k * 13) % 17}\n" for k in range(40))
    path = tmp_path / "log.csv"
    path.write_text(f"time [s],h_m,{name}\n{rows}", encoding="utf-8")
    plan = plan_of(read_table(path), ColumnMap())
    assert name not in {each.column for each in plan.signals}


@pytest.mark.parametrize(("current", "noise"), [("i [A]", 0.05), ("current [mA]", 0.02)])
def test_the_current_of_a_motor_is_doubted_as_a_field(current: str, noise: float) -> None:
    """The torque of a joint goes along with the current of its motor, in sign and in course."""
    scatter = noise * np.random.default_rng(3).normal(size=ROWS.size)
    joint = {**without("current [A]"), current: PLAIN["torque [N*m]"] / 1.2 + scatter}
    plan = planned(joint)
    assert any("as the current of a motor does" in doubt for doubt in plan.doubts)
    assert plan.command().endswith("--field none")
    assert planned(joint, field="none").doubts == ()
    assert planned(joint, field=current).doubts == ()


@pytest.mark.parametrize("field", [LEVELS, LEVELS - 0.5, np.abs(PLAIN["torque [N*m]"])])
def test_a_field_of_its_own_course_is_not_doubted(field: Array) -> None:
    assert planned({**without("current [A]"), "current [A]": field}).doubts == ()


@pytest.mark.parametrize(
    "name",
    ["Angular frequency [rad/s]", "Frequency [rad/s]", "Frequenz [rad/s]", "osc freq [rad/s]"],
)
def test_the_frequency_of_an_oscillation_is_no_slip(name: str) -> None:
    columns = {**without("speed [rad/s]"), name: 1.0 + np.abs(TURN)}
    assert [question.signal for question in planned(columns).questions] == ["slip"]


@pytest.mark.slow
@pytest.mark.parametrize("words", [("CW", "CCW"), ("forward", "reverse"), ("Zug", "Druck")])
def test_a_speed_without_a_sign_beside_its_sense_is_doubted(
    tmp_path: Path, words: tuple[str, str]
) -> None:
    rows: list[str] = []
    effort = np.roll(TURN, TURN.size // 3)  # that keeps to no sense
    for k, turn in enumerate(TURN):
        rows.append(
            f"{k / 100:.2f},{LEVELS[k]:g},{abs(turn):.6f},{words[int(turn < 0.0)]},{effort[k]:.6f}"
        )
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(["t [s],current [A],speed [rad/s],direction,torque [N*m]", *rows]) + "\n"
    )
    (doubt,) = plan_of(read_table(path), ColumnMap()).doubts
    assert f"has no sign, while direction says {words[0]} and {words[1]}" in doubt
    parted = read_table(path, variable=f"direction={words[0]}")
    assert plan_of(parted, ColumnMap()).doubts == ()
    assert plan_of(read_table(path), ColumnMap.from_labels({"slip": "speed"})).doubts == ()


@pytest.mark.slow
def test_words_beside_a_speed_that_turns_doubt_nothing(tmp_path: Path) -> None:
    rows: list[str] = []
    for k, turn in enumerate(TURN):
        rows.append(
            f"{k / 100:.2f},{LEVELS[k]:g},{turn:.6f},{'up' if turn > 0 else 'down'},{turn:.6f}"
        )
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(["t [s],current [A],speed [rad/s],direction,torque [N*m]", *rows]) + "\n"
    )
    assert plan_of(read_table(path), ColumnMap()).doubts == ()


@pytest.mark.parametrize(
    "names", [("amplitude", "frequency"), ("ampl", "freq"), ("sine_amplitude", "sine_frequency")]
)
def test_what_a_told_sine_is_made_with_is_no_field(names: tuple[str, str]) -> None:
    told = {"target_position": np.sin(ROWS / 8), names[0]: LEVELS + 0.1, names[1]: 2.0 + ROWS // 40}
    plan = planned({**without("current [A]"), **told})
    assert not plan.questions
    assert plan.signal("field") is not None
    assert any("no field is logged" in note and names[0] in note for note in plan.notes)


@pytest.mark.slow
@pytest.mark.parametrize("told", [{}, {"target_voltage": LEVELS}])
def test_an_amplitude_may_be_that_of_the_field_where_no_motion_alone_was_told(
    told: dict[str, Array],
) -> None:
    plan = planned(
        {**without("current [A]"), **told, "amplitude": LEVELS + 0.1, "frequency": 2.0 + ROWS // 40}
    )
    fields = {each.column for each in plan.signals if each.signal == "field"}
    assert fields == {"target_voltage"} or "field" in {
        question.signal for question in plan.questions
    }


def test_columns_that_share_what_heads_them_are_asked_about_by_name() -> None:
    columns = {
        f"{place} encoder": (number + 1) * np.cumsum(TURN)
        for number, place in enumerate(("first", "second", "third"))
    }
    questions = planned({**without("speed [rad/s]", "current [A]"), **columns}).questions
    (question,) = (each for each in questions if each.signal in ("slip", "position"))
    assert "first encoder" in question.remedy


def test_a_short_name_with_a_word_behind_is_proposed_for_a_speed() -> None:
    plan = planned({**without("speed [rad/s]", "current [A]"), "v Dyno": TURN, "P Dyno": TURN**2})
    assert '--slip "v Dyno"' in plan.examples


@pytest.mark.parametrize("rate", ["gamma_dot", "shear_rate", "Shear Rate"])
def test_tau_beside_a_shear_rate_is_the_stress_and_t_none(rate: str) -> None:
    rates = 50.0 + 40.0 * TURN
    columns = {
        "t": ROWS / 10,
        "T": 20.0 + ROWS / 300,
        rate: rates,
        "tau": 3.0 + 0.01 * rates,
        "mu": 0.01 + 3.0 / rates,
    }
    plan = planned(columns)
    assert {each.signal: each.column for each in plan.signals if each.column} == {
        "slip": rate,
        "effort": "tau",
    }


def test_tau_beside_a_speed_alone_is_asked_about() -> None:
    columns = {"t": ROWS / 10, "T": np.cos(ROWS * 2.7), "speed": TURN, "tau": np.cos(ROWS * 1.9)}
    assert "effort" in {question.signal for question in planned(columns).questions}


def test_a_temperature_called_t_is_not_proposed_for_the_field() -> None:
    rates = 50.0 + 40.0 * TURN
    columns = {
        "t": ROWS / 10,
        "T": 19.0 + LEVELS,
        "kr": TURN**2,
        "gamma_dot": rates,
        "tau": 3.0 + 0.01 * rates,
    }
    assert planned(columns).examples == ("--field none",)


@pytest.mark.parametrize(
    "name", ["payload_ctl_pwm", "led_current_A", "fan_voltage_V", "heater_current_A"]
)
def test_what_drives_another_load_of_the_board_is_no_field(name: str) -> None:
    (question,) = planned({**without("current [A]"), name: LEVELS}).questions
    assert question.signal == "field"


@pytest.mark.slow
def test_of_several_devices_in_one_table_each_has_its_own_levels() -> None:
    columns = {"t [s]": ROWS / 100}
    for device in (1, 2):
        columns |= {
            f"v{device}": TURN / device,
            f"F{device}": (1.0 + LEVELS) * TURN**3,
            f"I{device}": LEVELS,
        }
    # Without its levels the logs of all currents would be one log.
    said = planned(columns).command()
    assert said.endswith('--field "I1" --slip "v1" --effort "F1"')
