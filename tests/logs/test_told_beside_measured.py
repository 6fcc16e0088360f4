"""Of columns of one kind the one is offered that was measured, without its zero, or as a sum. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read, read_table
from tests.support.plans_of_columns import planned

TIME = np.arange(1600) / 200
FIELD = np.repeat([0.0, 0.4, 0.8, 1.2], 400)
SPEED = 15.0 * np.sin(4.4 * TIME)
TORQUE = (0.2 + 2.5 * FIELD) * np.tanh(SPEED / 0.5) + 0.02 * SPEED
BESIDE = {"t [s]": TIME, "omega [rad/s]": SPEED}


def test_a_measured_current_goes_before_what_a_supply_was_told() -> None:
    columns = {**BESIDE, "cmd [%]": FIELD / 0.012, "I_meas [A]": FIELD, "torque [N*m]": TORQUE}
    field = planned(columns).signal("field")
    assert field is not None
    assert field.column == "I_meas"


def test_a_torque_whose_zero_was_taken_goes_before_a_raw_torque() -> None:
    torques = {"torque_raw": TORQUE + 0.35, "torque_zeroed": TORQUE}
    plan = planned({**BESIDE, "current [A]": FIELD, **torques})
    assert plan.command().endswith('--effort "torque_zeroed"')


def test_the_sum_of_two_cells_is_the_effort() -> None:
    torques = {"Torque_A": 0.4 * TORQUE, "Torque_B": 0.6 * TORQUE, "Torque_sum": TORQUE}
    plan = planned({**BESIDE, "current [A]": FIELD, **torques})
    effort = plan.signal("effort")
    assert effort is not None
    assert effort.column == "Torque_sum"


@pytest.mark.parametrize(
    ("name", "step"),
    [("dt_ms", 5.0), ("dt [s]", 0.005), ("delta t [ms]", 5.0), ("loop_time_us", 5000.0)],
)
def test_a_column_of_steps_tells_the_rate(name: str, step: float) -> None:
    steps = step * (1.0 + 0.02 * np.sin(np.arange(TIME.size)))
    columns = {name: steps, "I [A]": FIELD, "omega [rad/s]": SPEED, "torque [N*m]": TORQUE}
    assert '--rate "200' in planned(columns).command()
    # Steps that change much are no rate.
    columns[name] = step * np.where(np.arange(TIME.size) % 2, 1.0, 3.0)
    assert '--rate "200' not in planned(columns).command()


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    [
        ("Tempo", "Segnale", "Valore", "Unità"),
        ("Tiempo", "Señal", "Valor", "Unidad"),
        ("时间", "信号", "数值", "单位"),
        ("Czas", "Sygnał", "Wartość", "Jednostka"),
    ],
)
def test_signals_in_rows_are_known_in_more_languages(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    lines = [";".join(names)]
    for k in range(TIME.size):
        signals = (("current", FIELD, "A"), ("speed", SPEED, "rad/s"), ("torque", TORQUE, "Nm"))
        lines += [f"{TIME[k]:.3f};{name};{values[k]:.6g};{of}" for name, values, of in signals]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    log = read(path)
    np.testing.assert_allclose(log.signals["effort"], TORQUE, rtol=1e-5, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("left", "right"), [("[", "]"), ("(", ")"), ("[", "],")])
def test_lists_that_were_printed_keep_their_first_and_last_column(
    tmp_path: Path, left: str, right: str
) -> None:
    rows = np.column_stack([TIME, FIELD, SPEED, TORQUE])
    lines = [f"{left}{', '.join(f'{cell:.6g}' for cell in row)}{right}" for row in rows]
    path = tmp_path / "log.txt"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    table = read_table(path)
    np.testing.assert_allclose(np.column_stack([*table.columns.values()]), rows, rtol=1e-5)
    assert '--effort "c4"' in plan_of(table, ColumnMap()).command()


@pytest.mark.slow
@pytest.mark.parametrize("form", ["/{}/", "<{}>", "{{{}}}"])
def test_units_of_a_line_may_stand_between_other_signs(tmp_path: Path, form: str) -> None:
    units = ";".join(form.format(unit) for unit in ("ms", "mm", "N", "mA"))
    rows = np.column_stack([1e3 * TIME, 20.0 * np.sin(4 * TIME), TORQUE, 1e3 * FIELD])
    lines = [";".join(f"{cell:.6g}" for cell in row) for row in rows]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["Zeit;Weg;Kraft;Strom", units, *lines]) + "\n", encoding="utf-8")
    log = read(path)
    np.testing.assert_allclose(log.signals["field"], FIELD, rtol=1e-5)
    assert log.period == pytest.approx(0.005)


@pytest.mark.slow
def test_a_unit_behind_a_bar_is_one(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = np.column_stack([TIME, 1e3 * FIELD, SPEED, TORQUE])
    header = "time|s,current|mA,speed|rad/s,torque|Nm"
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.9g")
    np.testing.assert_allclose(read(path).signals["field"], FIELD, atol=1e-9)


def test_a_converter_is_asked_for_its_zero_where_its_scale_is_asked_for() -> None:
    counts = np.round(2048.0 + 300.0 * TORQUE)
    plan = planned({**BESIDE, "current [A]": FIELD, "torque_adc": counts})
    assert "--zero effort=NUMBER" in plan.command().replace('"', "")


def test_a_speed_in_turns_a_second_is_offered_by_the_end_of_its_name() -> None:
    columns = {"t [s]": TIME, "I [A]": FIELD, "rotor speed [Hz]": SPEED, "torque [N*m]": TORQUE}
    assert '--slip "rotor speed [turn/s]"' in planned(columns).command()


@pytest.mark.parametrize(
    ("told", "measured"), [("Iset", "Imeas"), ("I_set", "I_act"), ("Isoll", "Iist")]
)
def test_a_letter_with_what_was_measured_behind_it_is_measured(told: str, measured: str) -> None:
    noise = 0.002 * np.sin(99.0 * TIME)
    columns = {f"{told} [A]": FIELD, f"{measured} [A]": FIELD + noise, "torque [N*m]": TORQUE}
    plan = planned({**BESIDE, **columns})
    field = plan.signal("field")
    assert (
        field is not None and field.column == measured
    ) or f'--field "{measured} [A]"' in plan.command()


def test_ampere_turns_are_a_field_and_no_turns() -> None:
    columns = {**BESIDE, "field_input_A_turns": 400.0 * FIELD, "torque [N*m]": TORQUE}
    field = planned(columns).signal("field")
    assert field is not None
    assert (field.column, field.si) == ("field_input_A_turns", "A")


def test_the_duty_of_a_brake_is_offered_beside_the_current_of_a_motor() -> None:
    current = 2.0 * TORQUE + 0.05 * np.sin(77.0 * TIME)
    columns = {**BESIDE, "Current [A]": current, "PWM brake [%]": 80.0 * FIELD}
    plan = planned({**columns, "torque [N*m]": TORQUE})
    assert plan.command().endswith('--field "PWM brake [%]"')


@pytest.mark.parametrize(
    ("name", "turns"),
    [("n", True), ("Drehzahl", True), ("n_ist", True), ("omega", False), ("w", False)],
)
def test_a_number_of_turns_in_one_over_a_second_counts_turns(name: str, *, turns: bool) -> None:
    columns = {"t [s]": TIME, "I [A]": FIELD, f"{name} [1/s]": SPEED, "M [N*m]": TORQUE}
    slip = planned(columns).signal("slip")
    assert slip is not None
    assert slip.factor == pytest.approx(2.0 * np.pi if turns else 1.0)


@pytest.mark.slow
def test_a_torque_in_percent_of_the_full_scale_asks_for_that_scale(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = np.column_stack([TIME, FIELD, SPEED, 50.0 * TORQUE])
    header = "# full scale: 2 Nm\ntime [s],I [A],w [rad/s],torque [%FS]"
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.9g")
    command = plan_of(read_table(path), ColumnMap()).command()
    assert command.endswith('--effort "torque [%]" --scale "effort=0.02 N*m/%"')
    log = read(path, effort="torque [%]", scale="effort=0.02 N*m/%")
    np.testing.assert_allclose(log.signals["effort"], TORQUE, rtol=1e-6, atol=1e-9)
