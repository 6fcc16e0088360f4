"""A unit in a header is read, or the question names its column with a place for the unit; never passed over."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnitError
from erclutch.logs import plan_of, read, read_table
from erclutch.logs.columns.labels import own_unit, split_label
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.mapping import ColumnChoice, ColumnMap
from erclutch.logs.plan import Plan
from erclutch.signals import units

ROWS = np.arange(400)
TIME = ROWS / 100.0
SPEED = 50.0 * np.sin(5.0 * TIME)
CURRENT = 0.5 * (ROWS // 50 % 3)
TORQUE = np.tanh(SPEED) * (0.2 + CURRENT) + 0.001 * SPEED


def log(path: Path, head: str, *columns: np.ndarray) -> Path:
    rows = "\n".join(
        ",".join(f"{value:.5f}" for value in row) for row in zip(*columns, strict=True)
    )
    path.write_text(f"{head}\n{rows}\n", encoding="utf-8")
    return path


def brake(path: Path, speed: str) -> Path:
    return log(path, f"Time (s),{speed},Current (A),Torque (Nm)", TIME, SPEED, CURRENT, TORQUE)


def planned(path: Path) -> Plan:
    return plan_of(read_table(path), ColumnMap())


@pytest.mark.parametrize(
    "speed", ["Hız (dev/dak)", "Скорость (об/мин)", "Speed rev/min", "Vitesse [tr.min-1]"]
)
def test_turns_a_minute_are_converted(tmp_path: Path, speed: str) -> None:
    recording = read(brake(tmp_path / "b.csv", speed))
    assert recording.signals["slip"] == pytest.approx(SPEED * 2.0 * np.pi / 60.0, abs=1e-4)


@pytest.mark.parametrize(
    "speed",
    [
        "Fordulatszám [1/perc]",
        "Частота вращения [мин-1]",
        "Скорость вращения [1/мин]",
        "Rotational speed [1/minute]",
        "회전수 [1/분]",
        "Hız (devir) [1/dk]",
        "Speed [rotations/min]",
        "Velocità [giri/minuto]",
    ],
)
def test_a_minute_of_any_language_counts_turns(tmp_path: Path, speed: str) -> None:
    """All but 1/min and min-1 were taken for a rate without turns: a speed 6.28 times too low, in silence."""
    path = brake(tmp_path / "log.csv", speed)
    assert read(path).signals["slip"] == pytest.approx(SPEED * np.pi / 30.0, abs=1e-4)


def test_a_rate_that_may_count_turns_is_asked_about(tmp_path: Path) -> None:
    path = brake(tmp_path / "log.csv", "w [1/perc]")
    with pytest.raises(UnitError, match="may mean turns or plain 1/s"):
        read(path, ColumnMap({"slip": ColumnChoice("w")}))


@pytest.mark.parametrize("unit", ["RPM/1000", "A/10", "(V/100)", "N*m / 1000"])
def test_a_unit_over_a_number_is_asked_about(tmp_path: Path, unit: str) -> None:
    """RPM/1000 was a thousandth of a turn, in silence; most people mean thousands of turns."""
    with pytest.raises(UnitError, match="may be a part of"):
        units.parse(unit)
    assert units.parse("1/10 mm").factor == pytest.approx(1e-4)
    assert units.parse("m/s2").factor == 1.0
    if unit.startswith("RPM"):
        with pytest.raises(MappingError, match="Speed"):
            read(brake(tmp_path / "log.csv", f"Speed ({unit})"))


def test_degrees_of_a_german_bench_are_no_thousand_million_radians(tmp_path: Path) -> None:
    path = log(
        tmp_path / "b.csv",
        "Zeit [s],Winkel [Grad],Strom [A],Drehmoment [Nm]",
        *(TIME, SPEED, CURRENT, TORQUE),
    )
    recording = read(path)
    assert recording.signals["position"] == pytest.approx(np.radians(SPEED), abs=1e-6)


@pytest.mark.parametrize(
    ("speed", "asked"),
    [
        ("Speed [xyz/abc]", "Speed [UNIT]"),
        ("Speed (xyz/abc)", "Speed (xyz/abc) [UNIT]"),
        ("Speed [grad/s]", "Speed [deg/s]"),  # or gons, which nobody uses
    ],
)
def test_a_unit_that_nobody_knows_is_asked_about_where_it_stands(
    tmp_path: Path, speed: str, asked: str
) -> None:
    path = brake(tmp_path / "b.csv", speed)
    plan = planned(path)
    assert plan.examples == (f'--slip "{asked}"',)
    with pytest.raises(MappingError, match="erclutch does not know its unit"):
        read(path)


def test_a_remark_in_brackets_is_no_unit(tmp_path: Path) -> None:
    plan = planned(brake(tmp_path / "b.csv", "Speed (Motor)"))
    assert plan.choices["slip"].column == "Speed (Motor)"


@pytest.mark.parametrize("name", ["Speed cmd/act", "Force L/R", "Torque in/out"])
def test_a_pair_of_words_is_no_unit(name: str) -> None:
    assert split_end(name) == (name, None)


def test_a_torque_sensor_beside_the_torque_of_a_joint_is_asked_about(tmp_path: Path) -> None:
    head = "time [s],a1 velocity [rad/s],a1 torque [Nm],a2 torque [Nm],trs605 torque [Nm]"
    columns = (TIME, SPEED, 1.1 * TORQUE, 0.0 * TIME, TORQUE)
    question = planned(log(tmp_path / "b.csv", head, *columns)).questions
    assert "a1 torque, trs605 torque" in next(iter(question)).problem


def test_torques_of_two_joints_that_move_apart_are_not_asked_about(tmp_path: Path) -> None:
    head = "time [s],a1 velocity [rad/s],a2 velocity [rad/s],a1 torque [Nm],a2 torque [Nm]"
    other = 30.0 * np.cos(3.0 * TIME)
    columns = (TIME, SPEED, 0.0 * TIME, TORQUE, np.tanh(other))
    assert planned(log(tmp_path / "b.csv", head, *columns)).choices["effort"].column == "a1 torque"


@pytest.mark.parametrize("dash", ["-", "–", "—"])
def test_a_unit_behind_a_dash_is_that_of_the_name_in_front(tmp_path: Path, dash: str) -> None:
    # Of "Velocity - m/s" seconds were made, and the column was no speed.
    names = (f"Time {dash} s", f"Speed {dash} deg/s", f"Current {dash} mA", f"Torque {dash} Nm")
    recording = read(log(tmp_path / "b.csv", ",".join(names), TIME, SPEED, CURRENT, TORQUE))
    assert recording.signals["slip"] == pytest.approx(np.radians(SPEED), abs=1e-6)
    assert recording.signals["field"] == pytest.approx(CURRENT / 1000, abs=1e-6)
    assert recording.units["effort"] == "N*m"


def test_a_speed_whose_name_ends_in_hertz_is_settled_by_the_command_for_it(tmp_path: Path) -> None:
    # The command was refused, and offered again without end.
    path = log(tmp_path / "b.csv", "time_s,speed_hz,field_kv,torque_nm", *brake_columns())
    (example,) = planned(path).examples
    assert example == """--slip "speed_hz" --scale "slip=1 turn/s/Hz\""""
    told = ColumnMap.from_options({"slip": "speed_hz", "scale": ["slip=1 turn/s/Hz"]})
    recording = read(path, told)
    assert recording.signals["slip"] == pytest.approx(SPEED * 2 * np.pi, abs=1e-3)


def brake_columns() -> tuple[np.ndarray, ...]:
    return TIME, SPEED, CURRENT, TORQUE


@pytest.mark.parametrize(
    ("name", "unit"), [("position_um", "um"), ("e_kvmm", "kV/mm"), ("E_kVmm", "kV/mm")]
)
def test_micrometres_and_kilovolts_a_millimetre_end_a_name(name: str, unit: str) -> None:
    assert split_end(name)[1] == unit


@pytest.mark.parametrize(
    ("written", "plain"),
    [
        ("degPerSec", "deg/s"),
        ("degParSec", "deg/s"),
        ("radPerS", "rad/s"),
        ("mmPerMin", "mm/min"),
        ("NPerMm", "N/mm"),
        ("NmPerRad", "N*m/rad"),
        ("revolutionsPerMinute", "rpm"),
    ],
)
def test_a_unit_written_as_a_variable_is_read(written: str, plain: str) -> None:
    ours, theirs = units.parse(plain), units.parse(written)
    assert (theirs.factor, theirs.dimension) == (ours.factor, ours.dimension)
    assert split_label(f"omega({written})") == ("omega", written)


@pytest.mark.parametrize("written", ["Parsec", "ParSec", "degPerSEC2", "PerSec", "degPer"])
def test_what_only_looks_so_is_no_unit(written: str) -> None:
    assert not units.is_unit(written)


IN_FRONT = [
    ("ms_time,rpm_speed,mA_current,mNm_torque", (1e-3, np.pi / 30, 1e-3, 1e-3)),
    ("ms time,rpm speed,mA current,mNm torque", (1e-3, np.pi / 30, 1e-3, 1e-3)),
    ("ms:time,rpm:speed,mA:current,Ncm:torque", (1e-3, np.pi / 30, 1e-3, 1e-2)),
    ("us_timestamp,mm_position,mA_coil,kN_force", (1e-6, 1e-3, 1e-3, 1e3)),
    ("Time_ms,Velocity_mmPerS,Current_mA,Force_kN", (1e-3, 1e-3, 1e-3, 1e3)),
    ("timeMs,speedDegPerSec,current_mA,torqueNm", (1e-3, np.pi / 180, 1e-3, 1.0)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("head", "factors"), IN_FRONT)
def test_a_unit_in_front_of_a_name_or_written_into_it_is_read(
    tmp_path: Path, head: str, factors: tuple[float, ...]
) -> None:
    plan = planned(log(tmp_path / "log.csv", head, TIME, SPEED, CURRENT, TORQUE))
    assert not plan.questions
    assert plan.clock is not None
    of_signals = {each.signal: each.factor for each in plan.signals if each.column}
    motion = of_signals.get("slip", of_signals.get("position"))
    read = (plan.clock.factor, motion, of_signals["field"], of_signals["effort"])
    assert read == pytest.approx(factors)


@pytest.mark.parametrize(
    "name", ["ms_count", "mm_count", "Nm_per_rad", "mA_torque", "ms_force", "cm_3", "kN_m", "mm_s"]
)
def test_a_first_word_that_is_no_unit_of_the_next_is_none(name: str) -> None:
    stem, _ = split_end(name)
    assert stem in (name, name.rpartition("_")[0], "kN", "mm")
    assert not stem.startswith(("count", "torque", "force"))


def test_units_in_front_take_linear_time() -> None:
    for name in ("ms_" + "a" * 20_000, "ms " * 7_000 + "x", "mA_current_" + "[" * 20_000):
        assert split_end(name) == (name, None)


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("torque.mNm", "torque", "mN*m"),
        ("torque@mNm", "torque", "mN*m"),
        ("TorquemNm", "Torque", "mN*m"),
        ("brakeTorquekNm", "brakeTorque", "kN*m"),
        ("drehmomentcNm", "drehmoment", "cN*m"),
        ("torque2mNm", "torque2", "mN*m"),
        ("vel.mm_s", "vel", "mm/s"),
        ("motor#rpm", "motor", "rpm"),
        ("data.torque.Nm", "data.torque", "N*m"),
        ("T.Nm", "T", "N*m"),
        ("Torque..N.m.", "Torque", "N*m"),
        ("brakeTorqueNm", "brakeTorque", "N*m"),
        ("currentmA", "current", "mA"),
        ("CoilCurrentmA", "CoilCurrent", "mA"),
        ("brake_forcekN", "brake_force", "kN"),
        ("voltagekV", "voltage", "kV"),
        ("timems", "time", "ms"),
    ],
)
def test_a_prefix_goes_with_its_unit(name: str, stem: str, unit: str) -> None:
    """Nm was read of mNm behind a dot or a word: a torque a thousand times too large, in silence."""
    assert split_end(name) == (stem, unit)


@pytest.mark.parametrize(
    "name",
    [
        "peakNm",
        "stiffnesskNm",
        "stiffness_N.mm",
        "Rate..mN.m.",
        "torqueMNm",
        "a.min",
        "x.in",
        "programmA",
        "itemms",
    ],
)
def test_what_may_be_two_units_is_none(name: str) -> None:
    assert split_end(name) == (name, None)


def test_units_behind_marks_take_linear_time() -> None:
    for part in (".ms", "_.", "m.", "Nm", "@", "a~b"):
        assert split_end(part * 10_000) is not None


def test_a_log_with_dots_in_its_names_is_read_in_its_units(tmp_path: Path) -> None:
    path = log(
        tmp_path / "log.csv",
        "time.ms,speed.rpm,current.mA,torque.mNm",
        1000.0 * TIME,
        SPEED,
        1000.0 * CURRENT,
        1000.0 * TORQUE,
    )
    recording = read(path)
    np.testing.assert_allclose(recording.time, TIME, atol=1e-8)
    np.testing.assert_allclose(recording.signals["slip"], np.pi / 30.0 * SPEED, atol=1e-5)
    np.testing.assert_allclose(recording.signals["field"], CURRENT, atol=1e-8)
    np.testing.assert_allclose(recording.signals["effort"], TORQUE, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("speed_mrad_s", "mrad/s"),  # its end was a second
        ("velocity_mm_min", "mm/min"),
        ("speed_kmph", "km/h"),
        ("speed_revps", "turn/s"),
        ("elapsed_min", "min"),
        ("time_in_min", "min"),
        ("time_h", "h"),
        ("Time min", "min"),
        ("t_millis", "ms"),
        ("minutes", "min"),
    ],
)
def test_speeds_and_times_in_other_units_end_a_name(name: str, unit: str) -> None:
    """The command that was printed for a time in minutes had it in seconds."""
    assert split_end(name)[1] == unit


@pytest.mark.parametrize("name", ["pos_min", "x_h", "force_min", "Speed min", "current_h"])
def test_the_least_of_a_signal_is_no_time(name: str) -> None:
    assert split_end(name)[1] is None


def test_a_speed_a_minute_counts_turns_by_its_name() -> None:
    assert own_unit("speed_1_min", None, ("rad/s",)) == "turn/min"
    assert own_unit("shear_1_min", None, ("rad/s",)) is None


@pytest.mark.parametrize("name", ["speed_0.1rpm", "rpm_x1000", "speed_rpm_x10", "speed_100rpm"])
def test_tenths_and_thousands_of_turns_are_no_turns(name: str) -> None:
    """They were read as turns a minute, in silence."""
    assert own_unit(name, None, ("rad/s",)) is None
    assert own_unit("Status_RPM_2", None, ("rad/s",)) == "rpm"


@pytest.mark.parametrize(("name", "step"), [("time_10ms", 1.0), ("t_100us", 100.0), ("t_cs", 1.0)])
def test_a_time_in_steps_of_its_own_is_asked_for_its_unit(
    tmp_path: Path, name: str, step: float
) -> None:
    """The command that was printed took steps of 100 us for ms, or the rows for points without a time."""
    path = log(
        tmp_path / "log.csv",
        f"{name},Speed (rad/s),Current (A),Torque (Nm)",
        *(step * ROWS, SPEED, CURRENT, TORQUE),
    )
    assert planned(path).examples == (f'--time "{name} [UNIT]"',)
