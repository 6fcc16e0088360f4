"""A voltage or a current is a field, the output of a sensor, or what a supply was told: by its name and its numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.fit.checks.data_check import check
from erclutch.logs import ColumnMap, Plan, Table, plan_of, read, read_table
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.dataset import build_dataset
from erclutch.logs.held_out import hold_out

TIME = np.arange(2000) * 0.005
ANGLE = np.sin(6.0 * TIME)
SPEED = 6.0 * np.cos(6.0 * TIME)
LEVELS = np.repeat([0.0, 0.5, 1.0, 1.5, 2.0], 400)
EFFORT = (0.2 + LEVELS) * np.tanh(SPEED)
MOTION = {"time": TIME, "angle": ANGLE, "speed": SPEED, "torque": EFFORT}


def _plan(columns: Mapping[str, Any], units: Mapping[str, str] | None = None, **more: Any) -> Plan:
    return plan_of(Table("a", columns, dict(units or {}), "0" * 64, **more), ColumnMap())


def _field(plan: Plan) -> str | None:
    field = plan.signal("field")
    return None if field is None else field.column


@pytest.mark.parametrize(
    "name", ["hall voltage", "LVDT voltage", "pot_voltage", "tacho voltage", "gauge voltage"]
)
def test_the_voltage_of_a_sensor_is_no_field(name: str) -> None:
    plan = _plan({**MOTION, name: 2.5 + 0.1 * np.cos(3.0 * TIME)}, {name: "V"})
    assert _field(plan) is None
    assert [question.signal for question in plan.questions] == ["field"]
    assert plan.examples == ("--field none",)


@pytest.mark.parametrize("name", ["strain gauge force", "Strain Gage Force", "force straingauge"])
def test_a_force_of_a_strain_gauge_is_a_force_and_no_strain(name: str) -> None:
    motion = {"time": TIME, "angle": np.sin(TIME)}
    plan = _plan({**motion, name: np.cos(TIME)}, {"angle": "rad", name: "N"})
    effort = plan.signal("effort")
    assert effort is not None
    assert effort.column == name


@pytest.mark.parametrize("motion", ["angle", "speed"])
def test_a_voltage_that_goes_straight_with_a_motion_to_and_fro_is_doubted(motion: str) -> None:
    output = 2.5 - 0.3 * MOTION[motion]
    plan = _plan({**MOTION, "voltage": output}, {"voltage": "V"})
    expected = f"field may be column voltage which goes straight with {motion}, as the output of its sensor does"
    assert [doubt.partition(":")[0] for doubt in plan.doubts] == [expected]
    assert plan.command().endswith("--field none")  # what is likely is printed


def test_a_voltage_raised_while_the_device_goes_one_way_is_a_field() -> None:
    ramp = {"time": TIME, "speed": 1.0 + TIME, "torque": 0.2 + TIME, "voltage": 0.5 * TIME}
    plan = _plan(ramp, {"voltage": "V"})
    assert plan.doubts == ()
    assert _field(plan) == "voltage"


@pytest.mark.slow
def test_a_bare_v_beside_a_velocity_is_a_voltage_where_it_keeps_levels() -> None:
    columns = {"t": TIME, "x": ANGLE, "xdot": SPEED, "F": EFFORT}
    assert _field(_plan({**columns, "V": LEVELS})) == "V"
    # A V that swings may be another velocity, and a V alone may be the only one: both are asked about.
    assert _field(_plan({**columns, "V": np.sin(9.0 * TIME)})) is None
    assert _field(_plan({"t": TIME, "x": ANGLE, "F": EFFORT, "V": LEVELS})) is None


def test_of_a_duty_and_the_current_that_it_drives_the_current_is_the_field() -> None:
    columns = {**MOTION, "pwm": 100.0 * LEVELS, "current": LEVELS}
    assert _field(_plan(columns, {"current": "A"})) == "current"
    other_current = {**columns, "current": np.abs(ANGLE)}
    plan = _plan(other_current, {"current": "A"})
    assert "field may be any of the columns pwm, current" in plan.questions[0].problem


@pytest.mark.parametrize(("unit", "weight"), [("g", "gf"), ("kg", "kgf")])
def test_a_load_cell_in_grams_is_asked_about_with_the_weight_that_it_shows(
    unit: str, weight: str
) -> None:
    columns = {"time": TIME, "speed": SPEED, "current": LEVELS, "load cell": EFFORT}
    plan = _plan(columns, {"current": "A", "load cell": unit, "speed": "mm/s"})
    assert plan.examples == (f'--effort "load cell [{weight}]"',)


@pytest.mark.parametrize(
    ("name", "value", "period"),
    [
        ("fs", 200.0, 0.005),
        ("sample_rate_hz", 200.0, 0.005),
        ("sampling_frequency [kHz]", 0.2, 0.005),
        ("Sampling Rate (Hz)", 200.0, 0.005),
        ("Ts", 0.005, 0.005),
        ("dt_ms", 5.0, 0.005),
        ("rate [N]", 200.0, None),  # a rate of something else
        ("dt", 5.0, None),  # may be ms
        ("fs", -1.0, None),
    ],
)
def test_the_rate_that_a_file_states_is_read_in_its_unit(
    name: str, value: float, period: float | None
) -> None:
    columns = {"speed": SPEED, "current": LEVELS, "torque": EFFORT}
    plan = _plan(columns, constants={name: value})
    clock = plan.clock
    assert (
        clock.period if clock is not None and clock.kind == "header" else None
    ) == pytest.approx(period)


def _json(folder: Path, document: Any) -> Table:
    path = folder / "log.json"
    path.write_text(json.dumps(document))
    return read_table(path)


@pytest.mark.slow
def test_numbers_beside_the_lists_of_a_json_log_are_constants_of_it(tmp_path: Path) -> None:
    lists = {"speed": SPEED.tolist(), "current": LEVELS.tolist(), "torque": EFFORT.tolist()}
    assert _json(tmp_path, {"fs": 200, **lists}).constants == {"fs": 200.0}
    nested = _json(
        tmp_path, {"meta": {"fs": 200, "ok": True, "by": "me", "gap": None}, "data": lists}
    )
    assert nested.constants == {"fs": 200.0}
    plan = plan_of(nested, ColumnMap())
    assert plan.clock is not None
    assert plan.clock.period == pytest.approx(0.005)


def test_numbers_of_another_run_in_a_json_log_are_none_of_this_run(tmp_path: Path) -> None:
    def run(rate: int, rows: int) -> dict[str, Any]:
        return {"fs": rate, "t": TIME[:rows].tolist(), "speed": SPEED[:rows].tolist()}

    path = tmp_path / "log.json"
    path.write_text(
        json.dumps({"rig": {"arm": 0.1}, "first": run(200, 50), "second": run(100, 80)})
    )
    assert read_table(path, variable="second").constants == {"arm": 0.1, "fs": 100.0}


def test_a_friction_torque_beside_a_motor_torque_is_asked_about() -> None:
    columns = {
        "time": TIME,
        "Joint Velocity": SPEED,
        "Motor Torque": 1.2 * EFFORT,
        "Friction Torque": EFFORT,
    }
    questions = {question.signal: question.problem for question in _plan(columns).questions}
    assert questions["effort"].startswith(
        "effort may be any of the columns Motor Torque, Friction Torque"
    )


def test_counts_in_round_brackets_and_the_cell_of_a_torque_are_asked_for_their_scale() -> None:
    columns = {
        "Time": TIME,
        "Torque Cell": EFFORT,
        "Encoder": 600.0 * ANGLE,
        "Coil Current": LEVELS,
    }
    name, unit = split_label("Encoder (ticks)")
    plan = _plan(columns, {"Torque Cell": "mV", name: str(unit)})
    assert plan.examples == (
        '--position "Encoder" --scale "position=NUMBER rad/ticks"',
        '--effort "Torque Cell" --scale "effort=NUMBER N*m/mV"',
    )


@pytest.mark.parametrize(
    ("label", "unit"), [("load_gf", "gf"), ("load_kgf", "kgf"), ("rate_hz", "Hz")]
)
def test_weights_and_rates_end_a_name(label: str, unit: str) -> None:
    assert split_end(label)[1] == unit


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "warned"),
    [
        (
            {"effort": "torque [Nm]"},
            "the effort is read in Nm, though the file says Ncm (column torque)",
        ),
        (
            {"field": "current [V]"},
            "the field is read in V, though the file says mA (column current)",
        ),
        (
            {"rate": 1000.0},
            "time from the sampling rate of 1000 Hz (given), though the file says 200 Hz",
        ),
        ({"effort": "torque [N*cm]"}, ""),
    ],
)
def test_a_unit_or_rate_given_otherwise_than_the_file_says_is_warned_of(
    tmp_path: Path, options: dict[str, Any], warned: str
) -> None:
    lines = ["date;speed [rad/s];current [mA];torque [Ncm]"]
    for row in range(600):
        stamp = f"2026-11-27 10:00:{row // 200:02d}.{row % 200 * 5:03d}"
        lines.append(f"{stamp};{SPEED[row]:.5f};{1000 * LEVELS[row]:g};{100 * EFFORT[row]:.5f}")
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    data = build_dataset(read(path, **options))
    findings = check(data, hold_out(data, 0.3))
    assert [finding.message for finding in findings if finding.subject == "given"] == (
        [warned] if warned else []
    )


def test_of_two_currents_the_one_that_goes_along_with_the_effort_is_the_drives() -> None:
    drive = 3.0 * EFFORT + 0.05 * np.sin(40.0 * TIME)
    columns = {**MOTION, "motor_current_A": drive, "brake_current_A": LEVELS}
    plan = _plan(columns)
    assert plan.questions == ()
    assert _field(plan) == "brake_current_A"
    # Where both take signs, both may be the coil's.
    both = _plan({**columns, "brake_current_A": LEVELS * np.sign(np.sin(0.5 * TIME))})
    assert [question.signal for question in both.questions] == ["field"]


@pytest.mark.parametrize(
    ("sensor", "option"),
    [
        ("LVDT", '--position "LVDT" --scale "position=NUMBER m/V"'),
        ("potentiometer", '--position "potentiometer" --scale "position=NUMBER rad/V"'),
        ("tacho", '--slip "tacho" --scale "slip=NUMBER rad/s/V"'),
    ],
)
def test_a_sensor_in_volts_is_proposed_with_a_scale_for_what_it_measures(
    sensor: str, option: str
) -> None:
    columns = {"time": TIME, sensor: 2.5 + ANGLE, "torque": EFFORT, "current": LEVELS}
    plan = _plan(columns, {sensor: "V", "torque": "N*m", "current": "A"})
    assert option in " ".join(plan.examples)


def test_a_load_cell_in_volts_is_proposed_with_a_force() -> None:
    columns = {"time": TIME, "travel": ANGLE, "load cell": EFFORT, "current": LEVELS}
    plan = _plan(columns, {"travel": "mm", "load cell": "V", "current": "A"})
    assert plan.examples == ('--effort "load cell" --scale "effort=NUMBER N/V"',)


def test_of_two_places_one_is_proposed_for_all_signals() -> None:
    columns = {"time": TIME}
    for place, share in (("front", 1.0), ("rear", 0.9)):
        columns |= {
            f"F_{place}": share * EFFORT,
            f"v_{place}": share * SPEED,
            f"i_{place}": share * LEVELS,
        }
    plan = _plan(columns)
    assert plan.examples == ('--field "i_front"', '--slip "v_front"', '--effort "F_front"')


@pytest.mark.parametrize("options", [{}, {"slip": "Drehzahl [rpm]"}])
def test_turns_a_minute_that_a_file_writes_as_1_min_are_no_doubt(
    tmp_path: Path, options: dict[str, Any]
) -> None:
    lines = ["time [s];Drehzahl [1/min];Strom [A];Moment [Nm]"]
    for row in range(600):
        lines.append(f"{row / 200:.3f};{60 * SPEED[row]:.5f};{LEVELS[row]:g};{EFFORT[row]:.5f}")
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    data = build_dataset(read(path, **options))
    assert [
        finding for finding in check(data, hold_out(data, 0.3)) if finding.subject == "given"
    ] == []
    assert any("converted to rad/s (the file says 1/min)" in note for note in data.notes)


@pytest.mark.parametrize(
    ("raw", "scaled", "signal"),
    [
        ("torque", "torque_Nm", "effort"),
        ("angle", "angle_deg", "position"),
        ("current", "current_A", "field"),
    ],
)
def test_of_a_count_and_what_it_stands_for_the_column_with_a_unit_is_taken(
    raw: str, scaled: str, signal: str
) -> None:
    columns = {
        name: values for name, values in {**MOTION, "current": LEVELS}.items() if name != "speed"
    }
    numbers = columns.pop(raw)
    columns |= {raw: np.round(2048.0 + 500.0 * numbers), scaled: numbers}
    plan = _plan(columns)
    assert plan.questions == ()
    taken = plan.signal(signal)
    assert taken is not None
    assert taken.column == scaled


def test_two_efforts_of_which_one_has_no_unit_are_asked_about_where_they_differ() -> None:
    columns = {**MOTION, "current": LEVELS, "torque_Nm": EFFORT + 0.3 * np.sin(11.0 * TIME)}
    assert [question.signal for question in _plan(columns).questions] == ["effort"]


def test_a_bare_v_that_the_effort_follows_is_a_velocity_beside_a_current() -> None:
    columns = {"t": TIME, "v": SPEED, "F": EFFORT, "I": LEVELS}
    slip = _plan(columns).signal("slip")
    assert slip is not None
    assert slip.column == "v"
    # A bridge may turn the voltage with the motion, and the current with it.
    both = _plan({**columns, "I": LEVELS * np.sign(SPEED)})
    assert [question.signal for question in both.questions] == ["slip"]


def test_a_current_that_leaks_is_no_field() -> None:
    columns = {**MOTION, "voltage": 1e3 * LEVELS, "leakage current": 1e-6 * LEVELS**2}
    plan = _plan(columns, {"voltage": "V", "leakage current": "A"})
    assert plan.questions == ()
    assert _field(plan) == "voltage"


@pytest.mark.parametrize(
    "name", ["stroke_velocity", "displacement rate velocity", "crosshead speed"]
)
def test_the_velocity_of_a_stroke_is_a_velocity(name: str) -> None:
    columns = {"time": TIME, name: SPEED, "force": EFFORT, "current": LEVELS}
    slip = _plan(columns).signal("slip")
    assert slip is not None
    assert slip.column == name


@pytest.mark.parametrize(("name", "unit"), [("Moment", "lbs"), ("torque", "N"), ("force", "N*m")])
def test_a_torque_in_a_unit_of_force_is_doubted(name: str, unit: str) -> None:
    columns = {"time": TIME, "speed": SPEED, name: EFFORT, "current": LEVELS}
    plan = _plan(columns, {name: unit, "current": "A"})
    (doubt,) = plan.doubts
    assert f"is called {name.lower()} and is in {unit}" in doubt
    assert f'--effort "{name} [UNIT]"' in plan.command()  # the file's unit would be read wrong
    assert _plan(columns, {name: "N" if name == "force" else "N*m", "current": "A"}).doubts == ()


@pytest.mark.parametrize(("name", "unit", "share"), [("Voltage", "mV", 3.0), ("U", "V", 0.003)])
def test_the_volts_of_a_bridge_that_go_straight_with_the_effort_are_no_field(
    name: str, unit: str, share: float
) -> None:
    columns = {**MOTION, name: share * EFFORT, "Measured Voltage": 0.003 * EFFORT}
    plan = _plan(columns, {name: unit, "Measured Voltage": "V", "torque": "N*m"})
    assert _field(plan) in (None, "")  # asked about, or none
    assert not any(name in example or "Measured" in example for example in plan.examples)
    assert any("goes straight with torque" in note for note in plan.notes)


def test_a_small_voltage_that_does_not_go_with_the_effort_is_asked_about() -> None:
    plan = _plan({**MOTION, "U": 0.009 * LEVELS}, {"U": "V", "torque": "N*m"})
    field = plan.signal("field")
    assert field is not None
    assert field.doubt.startswith("which never exceeds 0.018, as the output of a sensor")


@pytest.mark.parametrize("name", ["slip", "Schlupf", "slip %"])
def test_a_slip_in_per_cent_is_no_speed(name: str) -> None:
    share = np.round(np.minimum(100.0, 3.0 + 104.0 * np.exp(-TIME)), 2)
    plan = _plan({"time": TIME, "temperature": 200.0 + ANGLE, "force": EFFORT, name: share})
    (question,) = plan.questions
    assert question.signal == "slip"
    assert f"column {name} is a share in per cent" in question.problem
    assert not any(f'"{name}' in example for example in plan.examples)


@pytest.mark.parametrize("levels", [np.floor(LEVELS) * 50.0, 100.0 + 0.5 * SPEED, SPEED])
def test_a_slip_at_whole_levels_or_beyond_100_is_a_speed(levels: Any) -> None:
    slip = _plan({"time": TIME, "force": EFFORT, "slip": levels}).signal("slip")
    assert slip is not None
    assert slip.column == "slip"


@pytest.mark.parametrize("name", ["Time", "time", "Zeit"])
def test_minutes_are_no_position(name: str) -> None:
    columns = {f"{name} (m)": np.floor(TIME / 4.0), f"{name} (s)": TIME, "torque": EFFORT}
    units = {f"{name} (m)": "m", f"{name} (s)": "s", "torque": "N*m"}
    plan = _plan(columns, units)
    assert plan.signal("position") is None
    assert not any("(m)" in example for example in plan.examples)
    assert not any("(m)" in question.remedy for question in plan.questions)
