"""Logs of test benches in many languages are read by name and unit: duties, coefficients of friction, counts."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from erclutch.logs import Plan
from erclutch.logs.columns.names import spoken_name
from erclutch.signals import units
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned_by_letters

ROWS = np.arange(600.0)
TIME = ROWS / 100
PLACE = np.sin(3 * TIME)
SPEED = 3 * np.cos(3 * TIME)
LEVELS = 0.5 * (ROWS // 150)
EFFORT = np.tanh(5 * SPEED) * (1 + LEVELS)
NOISE = np.random.default_rng(2).normal(size=600)
PRESSING = 50 + 0.1 * NOISE
#: One letter for what the numbers of a column are: signals, a load that presses, the friction over it, a count.
NUMBERS: dict[str, Array] = {
    **{"t": TIME, "p": PLACE, "v": SPEED, "f": LEVELS, "e": EFFORT},
    **{"N": PRESSING, "m": np.abs(EFFORT) / 50, "c": np.floor(TIME) + 1, "x": 0.3 + 0.1 * NOISE},
}
NUMBERS["s"] = np.tanh(5 * SPEED)  # the effort at one field, whatever is counted beside it
SIGNALS = {"t": "time", "p": "position", "v": "slip", "f": "field", "e": "effort", "s": "effort"}


planned = partial(planned_by_letters, NUMBERS)


def factor_and_unit(plan: Plan, name: str) -> tuple[float, str]:
    """By what a signal is multiplied, and the unit that is read."""
    signal = plan.signal(name)
    assert signal is not None
    return signal.factor, signal.unit or ""


def assert_all_are_read(header: str) -> Plan:
    """Each letter of a signal is read as that signal, nothing else is, and nothing is asked."""
    plan, letters = planned(header)
    assert not plan.questions, [question.short for question in plan.questions]
    taken = {each.column: each.signal for each in plan.signals if each.column}
    if plan.clock is not None:
        taken[plan.clock.column] = "time"
    assert taken == {name: SIGNALS[letter] for name, letter in letters.items() if letter in SIGNALS}
    return plan


@pytest.mark.parametrize(
    "header",
    [
        "t:Time [s]; e:Torque [Nm]; v:Speed [rad/s]; f:Duty Cycle [%]",
        "t:time; e:torque; v:omega; f:pwm_duty_cycle",
        "t:Time [s]; e:Torque [Nm]; v:Speed [rad/s]; f:Brake Duty Cycle",
        "t:時間 [s]; e:トルク [N*m]; v:回転速度 [rad/s]; f:デューティサイクル [%]",
        "t:时间 [s]; e:转矩 [N*m]; v:转速 [rad/s]; f:占空比 [%]",
    ],
)
def test_a_duty_cycle_is_the_field_and_no_count_of_cycles(header: str) -> None:
    assert_all_are_read(header)


@pytest.mark.parametrize(
    "name", ["Cycle", "Total Cycles", "Zyklen", "Ciclos", "サイクル", "사이클"]
)
def test_a_count_of_cycles_is_no_field(name: str) -> None:
    assert spoken_name(name).is_accounted


@pytest.mark.parametrize(
    "header",
    [
        "t:Zeit [s]; e:Reibkraft [N]; N:Normalkraft [N]; m:Reibwert; v:Gleitgeschwindigkeit [m/s]",
        "t:Zeit [s]; N:Normalkraft [N]; e:Reibkraft [N]; m:Reibungszahl; p:Weg [m]",
        "t:Temps [s]; e:Force de frottement [N]; N:Force normale [N]; m:Coefficient de frottement; v:Vitesse [m/s]",
        "t:Tempo [s]; e:Forza di attrito [N]; N:Forza normale [N]; m:Coefficiente di attrito; v:Velocità [m/s]",
        "t:Время [s]; e:Сила трения [N]; N:Нормальная сила [N]; m:Коэффициент трения; v:Скорость [m/s]",
        "t:Czas [s]; e:Siła tarcia [N]; N:Siła normalna [N]; m:Współczynnik tarcia; v:Prędkość [m/s]",
        "t:时间 [s]; e:摩擦力 [N]; N:正压力 [N]; m:摩擦系数; v:滑动速度 [m/s]",
        "t:时间 [s]; e:摩擦力矩 [N*m]; N:法向载荷 [N]; x:摩擦因数; v:转速 [rad/s]",
        "t:시간 [s]; e:마찰력 [N]; N:수직하중 [N]; m:마찰계수; v:속도 [m/s]",
    ],
)
def test_the_force_that_rubs_is_told_from_the_one_that_presses(header: str) -> None:
    assert_all_are_read(header)


@pytest.mark.parametrize(
    "header",
    [
        "t:Prüfzeit [s]; p:Traverse absolut [mm]; s:Standardkraft [N]; c:Zyklus",
        "t:Prüfzeit [s]; c:Lastspiele; p:Weg [mm]; s:Kraft [kN]",
        "t:时间 [s]; p:位移 [mm]; s:载荷 [N]; x:压缩应变 [%]; c:循环计数",
        "t:时间 [s]; p:位移 [mm]; s:载荷 [N]; x:应变 [%]; c:循环次数",
        "t:時間 [s]; p:ストローク [mm]; s:試験力 [N]; x:ひずみ [%]; c:サイクル",
        "t:시간 [s]; p:변위 [mm]; s:하중 [N]; x:변형률 [%]; c:사이클",
        "t:Tiempo [s]; p:Carrera [mm]; s:Carga [N]; x:Deformación [%]; c:Ciclos",
        "t:Время [s]; p:Перемещение [mm]; s:Нагрузка [N]; x:Деформация [%]; c:Цикл",
    ],
)
def test_a_testing_machine_has_no_field_in_any_language(header: str) -> None:
    assert_all_are_read(header)


def test_a_column_of_an_open_name_is_asked_about_still() -> None:
    plan, _ = planned("t:时间 [s]; p:位移 [mm]; e:载荷 [N]; f:档位")
    assert [question.signal for question in plan.questions] == ["field"]


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("t:time; p:pos_mm; e:force_N; f:B_mT", 1e-3),
        ("t:time; v:omega_rad_s; e:torque_Nm; f:I_mA", 1e-3),
        ("t:time; p:theta_deg; e:torque_Nm; f:U_mV", 1e-3),
    ],
)
def test_one_symbol_has_a_unit_beside_names_that_end_in_units(header: str, factor: float) -> None:
    multiplied, _ = factor_and_unit(assert_all_are_read(header), "field")
    assert multiplied == pytest.approx(factor)


def test_one_symbol_with_an_index_of_a_letter_has_no_unit_beside_such_names() -> None:
    plan, _ = planned("t:time; p:pos_mm; e:force_N; f:i_A")
    assert factor_and_unit(plan, "field") == (1.0, "")


@pytest.mark.parametrize("written", ["Upm", "U/min", "trs/min"])
def test_turns_a_minute_are_read_as_they_are_written(written: str) -> None:
    assert units.parse(written).factor == pytest.approx(np.pi / 30)


@pytest.mark.parametrize("label", ["Drehzahl_Upm", "Drehzahl [Upm]", "Motordrehzahl [U/min]"])
def test_a_german_speed_in_turns_is_read_so(label: str) -> None:
    plan = assert_all_are_read(f"t:Zeit_s; v:{label}; e:Moment_Nm; f:Strom_A")
    multiplied, _ = factor_and_unit(plan, "slip")
    assert multiplied == pytest.approx(np.pi / 30)


@pytest.mark.parametrize(
    "label",
    [
        "Voltage current sensor [V]",
        "Current sensor voltage [V]",
        "Spannung Stromsensor [V]",
        "Tension capteur courant [V]",
    ],
)
def test_the_volts_of_the_sensor_of_a_current_are_no_field(label: str) -> None:
    plan, _ = planned(f"t:Time [s]; e:Force [N]; p:Position [mm]; f:{label}")
    field = plan.signal("field")
    assert field is None or field.column == ""
    assert_all_are_read(f"t:Time [s]; e:Force [N]; p:Position [mm]; f:Current [A]; x:{label}")


def test_what_the_sensor_of_a_current_measures_is_a_field() -> None:
    assert_all_are_read("t:Time [s]; e:Force [N]; p:Position [mm]; f:Current sensor [A]")
