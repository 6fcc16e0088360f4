"""Columns of strangers' logs are told by name, unit and shape together, in several languages; what is open is asked."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.logs.columns.labels import own_unit
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.two_courses import follows, is_rate_of
from erclutch.signals import units
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned_by_letters

ROWS = np.arange(400.0)
TIME = ROWS / 100
PLACE = np.sin(7 * TIME)
SPEED = 7 * np.cos(7 * TIME)
LEVELS = 0.5 * (ROWS // 40 % 3)
FORCE = np.tanh(SPEED) * (1 + LEVELS)
NOISE = np.random.default_rng(1).normal(size=400)
#: One letter for what the numbers of a column are; what is no signal has none of the first five.
NUMBERS: dict[str, Array] = {
    **{"t": TIME, "p": PLACE, "v": SPEED, "f": LEVELS, "e": FORCE},
    **{
        "c": np.full(400, 3.0),
        "n": ROWS,
        "s": 5 * np.sign(SPEED),
        "x": NOISE,
        "u": 48 + 0.1 * NOISE,
        "T": 20 + TIME,
        "a": -49 * PLACE,
    },
}
SIGNALS = {"t": "time", "p": "position", "v": "slip", "f": "field", "e": "effort"}


planned = partial(planned_by_letters, NUMBERS)


def misread(plan: Plan, letters: dict[str, str]) -> dict[str, str]:
    taken = {each.signal: each.column for each in plan.signals if each.column}
    if plan.clock is not None:
        taken["time"] = plan.clock.column
    return {
        signal: column for signal, column in taken.items() if SIGNALS.get(letters[column]) != signal
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    "header",
    [
        "t:time; p:joint_pos; v:joint_vel; e:joint_torque",
        "t:time; p:roll_position; v:roll_velocity; e:roll_effort",
        "t:Time; p:/states/elbow/position; v:/states/elbow/velocity; e:/states/elbow/effort",
        "t:%time; p:field.position; v:field.velocity; e:field.effort",
        "t:time; v:velocity; e:friction torque",
        "t:time; v:Relative velocity; e:damping force; f:magnetic field",
        "t:time; v:velocity; e:friction_force; p:displacement; x:normal_force",
        "t:time; v:velocity_actual; e:torque_actual; p:position_actual; s:velocity_target",
        "t:Time; v:ActualVelocity; e:ActualTorque; p:ActualPosition; s:TargetVelocity",
        "t:Zeit [s]; v:Motordrehzahl; e:Bremsmoment; f:Spulenstrom",
        "t:temps; v:vitesse de rotation; e:couple résistant; f:courant bobine",
        "t:tiempo; p:desplazamiento del pistón; e:fuerza de amortiguamiento; f:corriente de bobina",
        "t:试验时间(秒); p:20T位移(mm); e:20T载荷(kN)",
        "t:时间; v:转速(r/min); e:扭矩(N·m); f:电流(A)",
        "t:時間[秒]; v:回転数[回転/分]; e:トルク[N·m]; f:電流[A]",
        "t:seconds; v:rpm; e:Nm",
        "t:time; v:velocity; e:load_cell; f:current",
        "t:t; p:x_m; e:F_N; f:u_V",
        "t:时间/s; p:位移/mm; v:速度/(mm/s); e:阻尼力/kN; f:电流/A",
        "t:Time/s; p:Displacement/mm; e:Force/N; f:Current/A",
        "t:t_s; p:x_mm; v:v_mm_s; e:F_kN; f:i_A",
        "t:t_s; v:w_rad_s; e:T_Nm; f:i_A",
        "t:time; v:velocity; e:friction",
        "t:Zeit; v:Geschwindigkeit; e:Reibung",
        "t:time; v:speed; e:torque; f:Current [A]; u:Voltage [V]",
        "t:temps; p:déplacement piston; e:force d'amortissement; f:courant",
    ],
)
def test_a_name_speaks_by_its_head_in_seven_languages(header: str) -> None:
    plan, letters = planned(header)
    assert plan.questions == ()
    assert plan.doubts == ()
    assert misread(plan, letters) == {}
    assert plan.signal("effort") is not None


@pytest.mark.parametrize(
    "header",
    [
        "t:t; p:q; v:dq; e:tau",
        "t:t; p:theta; v:theta_dot; e:tau",
        "t:t; p:x; v:v; e:F",
        "t:t; p:d; v:v; e:M; f:I",
        "t:t; v:w; e:T; f:i",
        "t:Time; p:Extension; e:Load",
    ],
)
def test_short_names_are_told_by_the_shape_of_their_numbers(header: str) -> None:
    plan, letters = planned(header)
    assert plan.questions == ()
    assert misread(plan, letters) == {}
    assert any("shape of its numbers" in note for note in plan.notes) or "F" in letters


@pytest.mark.parametrize(
    "header", ["t:t; p:x; x:v; e:F", "t:t; v:w; T:T; f:i", "t:t; x:q; c:dq; e:tau", "t:t; v:w; c:M"]
)
def test_short_names_of_another_shape_are_asked_about(header: str) -> None:
    plan, letters = planned(header)
    assert plan.questions
    assert misread(plan, letters) == {}


@pytest.mark.parametrize(
    "others",
    [
        "n:index", "n:c1", "a:acceleration", "a:acc", "T:temperature", "c:anything", "x:force_raw", "s:target_speed",
        "x:error", "T:Motor Temp", "x:Vibration", "T:温度", "a:加速度", "n:Messpunkt Nr", "T:system time",
    ],
)  # fmt: skip
def test_no_field_is_settled_where_every_other_column_is_accounted_for(others: str) -> None:
    plan, letters = planned(f"t:time; v:speed; e:torque; {others}")
    assert plan.questions == ()
    assert misread(plan, letters) == {}
    assert any(note.startswith("no field is logged") for note in plan.notes)


@pytest.mark.parametrize("other", ["f:mode", "x:q17", "f:B", "x:Kanal 3", "f:量程"])
def test_a_column_that_nothing_accounts_for_may_be_the_field(other: str) -> None:
    plan, _ = planned(f"t:time; v:speed; e:torque; {other}")
    assert [question.signal for question in plan.questions] == ["field"]


@pytest.mark.parametrize(
    "name",
    [
        "predicted force", "torque limit", "max torque", "Normalkraft", "force error", "torque setpoint", "Sollmoment",
        "normal_force", "压力", "目标扭矩", "Trägheitsmoment", "ball load", "estimated torque", "couple de consigne",
    ],
)  # fmt: skip
def test_what_only_sounds_like_an_effort_is_none(name: str) -> None:
    assert spoken_name(name).heads["effort"] is None


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("rolling speed", "slip"), ("wind speed", "slip"), ("torque speed", "slip"), ("加速度", "slip"),
        ("force voltage", "field"), ("battery voltage", "field"), ("torque command", "field"),
        ("Schubspannung", "field"),
        ("throttle position", "position"), ("E' field", "field"), ("Solldrehzahl", "slip"),
    ],
)  # fmt: skip
def test_what_only_sounds_like_a_signal_is_none(name: str, signal: str) -> None:
    assert spoken_name(name).heads[signal] is None


def test_a_name_that_may_be_the_field_is_not_accounted_for() -> None:
    open_ones = ("cmd", "setpoint", "level", "mode", "Kanal", "励磁")
    accounted = (
        "target_speed",
        "oil temperature",
        "Beschleunigung",
        "piston velocity (2)",
        "位置2",
    )
    assert not any(spoken_name(name).is_accounted for name in open_ones)
    assert all(spoken_name(name).is_accounted for name in accounted)


@pytest.mark.parametrize(
    ("header", "effort"),
    [
        ("v:Speed (rad/s); e:Torque (Nm); x:Force (N)", "Torque"),
        ("v:Velocity (mm/s); e:Force (N); x:Torque (Nm)", "Force"),
        ("v:Shear Rate (1/s); e:Shear Stress (Pa); x:Torque (mNm)", "Shear Stress"),
        ("v:rpm; e:torque; x:thrust force", "torque"),
    ],
)
def test_a_motion_decides_between_torque_force_and_stress(header: str, effort: str) -> None:
    plan, _ = planned(f"t:Time; {header}")
    assert plan.questions == ()
    chosen = plan.signal("effort")
    assert chosen is not None
    assert chosen.column == effort


@pytest.mark.parametrize("other", ["M_2 [Nm]", "T5 (N·m)", "drive side [mNm]"])
def test_a_head_beside_another_column_of_such_a_unit_decides_nothing(other: str) -> None:
    plan, _ = planned(f"t:Time; v:speed [rpm]; e:PA1 Torque [Nm]; x:{other}")
    assert [question.signal for question in plan.questions] == ["effort"]
    plan, _ = planned(f"t:Time; v:speed [rpm]; e:PA1 Torque [Nm]; x:predicted {other}")
    assert plan.questions == ()


def test_a_motion_of_no_known_kind_decides_nothing() -> None:
    plan, _ = planned("t:Time; v:speed; e:Torque (Nm); x:Force (N)")
    assert [question.signal for question in plan.questions] == ["effort"]


def test_the_same_numbers_in_another_unit_are_one_signal() -> None:
    columns = {"angle_deg": np.rad2deg(PLACE), "angle_rad": PLACE, "t": TIME, "torque": FORCE}
    plan = plan_of(Table("a", columns, {}, "0" * 64), ColumnMap())
    assert plan.questions == ()
    other = plan_of(Table("a", {**columns, "angle_rad": NOISE}, {}, "0" * 64), ColumnMap())
    assert [question.signal for question in other.questions] == ["slip"]


@pytest.mark.parametrize("factor", [1.0, 1e-3, 30 / np.pi, 180 / np.pi])
def test_a_rate_is_known_by_what_it_adds_up_to(factor: float) -> None:
    noisy = PLACE + 1e-3 * NOISE
    assert is_rate_of(factor * SPEED + 0.1, noisy, TIME)
    assert not is_rate_of(1.6 * SPEED, noisy, TIME)
    assert not is_rate_of(PLACE, SPEED, TIME)
    assert not is_rate_of(SPEED, noisy, None)
    assert not is_rate_of(np.full(400, 2.0), TIME, TIME)


def test_an_effort_follows_a_motion_and_takes_both_signs() -> None:
    assert follows(FORCE, SPEED)
    assert not follows(20 + FORCE, SPEED)
    assert not follows(NOISE, SPEED)
    assert follows(FORCE, PLACE)
    assert follows(np.where(ROWS == 7, -9999.0, FORCE), SPEED)


@pytest.mark.parametrize(
    ("unit", "usual"),
    [
        ("秒", "s"), ("毫秒", "ms"), ("转/分", "rpm"), ("回転/分", "rpm"), ("N·米", "N*m"), ("千牛", "kN"),
        ("毫米", "mm"), ("米/秒", "m/s"), ("tr/min", "rpm"), ("Umdr./min", "rpm"), ("amps", "A"), ("rads/s", "rad/s"),
        ("seg", "s"),
    ],
)  # fmt: skip
def test_units_of_other_languages_are_the_usual_ones(unit: str, usual: str) -> None:
    assert units.parse(unit).factor == pytest.approx(units.parse(usual).factor)
    assert units.parse(unit).dimension == units.parse(usual).dimension


def _with_field_asked(**others: Array) -> list[str]:
    columns = {"time": TIME, "displacement": PLACE, "force": FORCE, **others}
    units = {"displacement": "mm", "force": "N"}
    plan = plan_of(Table("a", columns, units, "0" * 64), ColumnMap())
    return [question.signal for question in plan.questions]


@pytest.mark.parametrize("unit", [1.0, 0.01, -3.5])
def test_a_column_that_is_another_one_in_other_numbers_is_no_field(unit: float) -> None:
    assert _with_field_asked(AVE2=unit * PLACE + 4.0) == []
    assert _with_field_asked(AVE2=unit * FORCE - 1.0) == []


def test_a_column_that_only_goes_with_another_one_may_be_the_field() -> None:
    wave = PLACE + 0.05 * float(np.ptp(PLACE)) * np.sin(40.0 * TIME)
    assert _with_field_asked(AVE2=wave) == ["field"]
    ramp = np.linspace(0.0, 1.0, TIME.size)
    columns = {"time": TIME, "displacement": ramp, "force": FORCE, "AVE2": 3.0 * ramp}
    plan = plan_of(Table("a", columns, {"displacement": "mm", "force": "N"}, "0" * 64), ColumnMap())
    assert [question.signal for question in plan.questions] == ["field"]


def test_what_two_models_say_of_an_effort_is_no_field_and_neither_is_what_goes_with_them() -> None:
    rate = np.gradient(PLACE)
    assert _with_field_asked(LuGre=0.9 * rate, Light_SVM=np.tanh(9 * rate), CV=np.sign(rate)) == []
    # One name alone may be that of a device, and a column that keeps one sign is no estimate.
    assert _with_field_asked(Dahl=0.9 * rate) == ["field"]
    assert _with_field_asked(LuGre=0.9 * rate, SVM=np.tanh(9 * rate), CV=np.abs(rate)) == ["field"]


@pytest.mark.parametrize("gauge", ["C_1_Déform1", "C_1_LVDT 2"])
def test_a_name_behind_a_channel_s_prefix_is_a_whole_name(gauge: str) -> None:
    columns = {
        "C_1_Temps": TIME,
        "C_1_Force": FORCE,
        gauge: np.sqrt(np.abs(PLACE)),
        "C_1_Déplacement": PLACE,
    }
    units = {"C_1_Temps": "s", "C_1_Force": "kN", gauge: "mm", "C_1_Déplacement": "mm"}
    plan = plan_of(Table("a", columns, units, "0" * 64), ColumnMap())
    position = plan.signal("position")
    assert plan.questions == ()
    assert position is not None
    assert position.column == "C_1_Déplacement"


@pytest.mark.parametrize("name", ["Status_RPM_V1", "RPM motor", "rpm (2)", "M1 rpm meas"])
def test_a_word_for_turns_a_minute_within_a_name_is_its_unit(name: str) -> None:
    assert own_unit(name, None, ("rad/s",)) == "rpm"


@pytest.mark.parametrize("name", ["torque_per_rpm", "erpm", "Nm/rpm", "rpm per volt"])
def test_what_is_counted_against_turns_a_minute_is_none(name: str) -> None:
    assert own_unit(name, None, ("rad/s",)) != "rpm"
