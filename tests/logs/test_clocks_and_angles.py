"""A slip, its position and the time are held against each other; counters and angles say what they are. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, apply, plan_of, read, read_table
from erclutch.signals import units
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned

TIME: Array = 0.002 * np.arange(800, dtype=np.float64)
PLACE = 0.01 * np.sin(9.0 * TIME)
SPEED = 0.09 * np.cos(9.0 * TIME)
FORCE = 400.0 * np.tanh(SPEED / 0.01) + 900.0 * SPEED
CURRENT = np.where(TIME % 0.8 < 0.4, 0.0, 1.0)


def written(path: Path, names: str, columns: list[Array], above: str = "") -> Path:
    lines = [",".join(f"{number:.9g}" for number in row) for row in np.column_stack(columns)]
    path.write_text("\n".join([*above.splitlines(), names, *lines]) + "\n", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "clocks", "answer"),
    [
        ("Time (s),x (mm),v (mm/s),F (N),I (A)", [TIME * 1e3], '--time "Time [ms]"'),
        ("Time (ms),x (mm),v (mm/s),F (N),I (A)", [TIME], '--time "Time [s]"'),
        (
            "time_s,pc_time_s,x (mm),v (mm/s),F (N),I (A)",
            [TIME * 2.0, TIME + 55.0],
            '--time "pc_time_s"',
        ),
        (
            "time_s,wall [ms],x (mm),v (mm/s),F (N),I (A)",
            [TIME * 0.5, TIME * 1e3],
            '--time "wall [ms]"',
        ),
    ],
)
def test_a_clock_by_which_a_slip_is_the_rate_of_its_position_is_proposed(
    tmp_path: Path, names: str, clocks: list[Array], answer: str
) -> None:
    path = written(tmp_path / "log.csv", names, [*clocks, PLACE * 1e3, SPEED * 1e3, FORCE, CURRENT])
    plan = plan_of(read_table(path), ColumnMap())
    assert plan.command().endswith(f" {answer}")
    recording = read(path, time=answer.removeprefix("--time ").strip('"'))
    assert recording.period == pytest.approx(0.002)
    np.testing.assert_allclose(recording.signals["slip"], SPEED, atol=1e-8)


@pytest.mark.slow
def test_milliseconds_that_the_motion_tells_are_taken_and_not_asked_about(tmp_path: Path) -> None:
    columns = [TIME * 1e3, PLACE * 1e3, SPEED * 1e3, FORCE, CURRENT]
    plan = plan_of(
        read_table(written(tmp_path / "log.csv", "time,x_mm,v_mm_s,F_N,I_A", columns)), ColumnMap()
    )
    assert not plan.questions
    assert plan.clock is not None
    assert (plan.clock.unit, plan.clock.doubt) == ("ms", "")
    assert "taken as ms, in which the speed is the rate of the position" in plan.clock.sentence


@pytest.mark.parametrize("factor", [1e3, 1e2])
def test_a_slip_in_another_unit_than_its_name_is_asked_about_and_no_clock_is_proposed(
    tmp_path: Path, factor: float
) -> None:
    columns = [TIME, PLACE, SPEED * factor, FORCE, CURRENT]
    plan = plan_of(
        read_table(written(tmp_path / "log.csv", "t (s),x (m),v (m/s),F (N),I (A)", columns)),
        ColumnMap(),
    )
    assert [question.signal for question in plan.questions] == ["slip"]
    assert plan.command().endswith(' --slip "v [m/s]"')


@pytest.mark.slow
def test_stamps_in_the_unit_of_the_header_are_in_seconds_for_a_position_too(tmp_path: Path) -> None:
    columns = [TIME * 1e3, PLACE * 1e3, SPEED * 1e3, FORCE, CURRENT]
    path = written(
        tmp_path / "log.csv",
        "time,x (mm),v (mm/s),F (N),I (A)",
        columns,
        above="Sample interval: 2 ms",
    )
    assert read(path).period == pytest.approx(0.002)


@pytest.mark.slow
@pytest.mark.parametrize("names", ["t1,t2,x,x_dot,F,i", "t_1,t_2,x,x_dot,F,i"])
def test_a_numbered_time_that_grows_evenly_is_proposed(tmp_path: Path, names: str) -> None:
    columns = [TIME, TIME + 0.0013, PLACE, SPEED, FORCE, CURRENT]
    plan = plan_of(read_table(written(tmp_path / "log.csv", names, columns)), ColumnMap())
    assert plan.command().endswith(f' --time "{names.split(",")[0]} [s]"')


@pytest.mark.slow
@pytest.mark.parametrize(
    ("above", "name", "counts", "period"),
    [
        ("# Tick: 0.5 ms", "tick", 4.0 * np.arange(800), 0.002),
        ("# Tick size: 500 us", "ticks", 4.0 * np.arange(800) + 100.0, 0.002),
        ("# Sample interval: 1 ms", "Sample", 2.0 * np.arange(800), 0.002),
        ("# Frame rate: 500 fps", "Frame", 1.0 + np.arange(800), 0.002),
        ("Sampling rate: 0.5 kS/s", "n", np.arange(800), 0.002),
        ("Sample rate: 500 SPS", "row", np.arange(800), 0.002),
    ],
)
def test_counters_of_ticks_frames_and_samples_tell_the_time_by_the_header(
    tmp_path: Path, above: str, name: str, counts: Array, period: float
) -> None:
    names = f"{name},v (m/s),F (N),I (A)"
    recording = read(
        written(tmp_path / "log.csv", names, [counts, SPEED, FORCE, CURRENT], above=above)
    )
    assert recording.period == pytest.approx(period)


@pytest.mark.slow
def test_a_frame_that_a_camera_dropped_is_a_gap(tmp_path: Path) -> None:
    frames = np.delete(np.arange(800), [300, 301, 302])
    columns = [frames.astype(np.float64), SPEED[frames], FORCE[frames], CURRENT[frames]]
    path = written(
        tmp_path / "log.csv", "Frame,v (m/s),F (N),I (A)", columns, above="# Frame rate: 500 fps"
    )
    assert len(read(path).segments) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("turn", "unit", "lowest"),
    [
        (360.0, "deg", 0.0),
        (360.0, "deg", -180.0),
        (2.0 * np.pi, "rad", 0.0),
        (2.0 * np.pi, "rad", -np.pi),
    ],
)
def test_an_angle_without_a_unit_that_jumps_by_a_turn_is_asked_for_it(
    tmp_path: Path, turn: float, unit: str, lowest: float
) -> None:
    angle = 3.0 * np.sin(9.0 * TIME) + 9.0 * TIME  # rad
    wrapped = (angle * turn / (2.0 * np.pi) - lowest) % turn + lowest
    path = written(tmp_path / "log.csv", "t,theta,torque,i", [TIME, wrapped, FORCE, CURRENT])
    with pytest.raises(
        MappingError, match=f"jumps by a full turn . times, as an angle in {unit} does"
    ):
        read(path)
    recording = read(path, position=f"theta [{unit}]")
    assert recording.units["position"] == "rad"


def test_a_stroke_that_returns_quickly_is_no_angle(tmp_path: Path) -> None:
    saw = 270.0 * (TIME / 0.4 % 1.0)
    path = written(tmp_path / "log.csv", "t,position,force,i", [TIME, saw, FORCE, CURRENT])
    table = read_table(path)
    assert apply(plan_of(table, ColumnMap()), table).rows == 800


@pytest.mark.parametrize(
    ("written_unit", "means"),
    [
        ("cNm", "0.01 N*m"),
        ("dN m", "0.1 N*m"),
        ("daN·m", "10 N*m"),
        ("kp", "9.80665 N"),
        ("mil", "0.0254 mm"),
        ("mils/s", "0.0254 mm/s"),
        ("d/dk", "1 rpm"),
        ("x1000 rpm", "1000 rpm"),
        ("rpm x100", "100 rpm"),
        ("×0.1 Nm", "0.1 N*m"),
        ("kmph", "1 km/h"),  # pint: a thousand miles an hour
        ("KMH", "1 km/h"),
        ("км/ч", "1 km/h"),
        ("мНм", "1 mN*m"),
        ("мН·м", "1 mN*m"),
        ("мкм", "1 um"),
        ("мкА", "1 uA"),
        ("Гс", "0.1 mT"),
        ("高斯", "0.1 mT"),
        ("毫伏", "1 mV"),
        ("A_rms", "1 A"),
        ("KV", "1 kV"),
        ("º/s", "1 deg/s"),
        ("foot-pounds", "1.3558179483314004 N*m"),
        ("ounce-inches", "7.061551814226043 mN*m"),
        ("rotations", "1 turn"),
    ],
)
def test_units_of_benches_and_their_multiples(written_unit: str, means: str) -> None:
    number, unit = units.quantity(means)
    told = units.parse(str(unit))
    found = units.parse(written_unit)
    assert found.dimension == told.dimension
    assert found.factor == pytest.approx(number * told.factor)


def test_a_speed_in_hertz_is_proposed_in_turns(tmp_path: Path) -> None:
    path = written(
        tmp_path / "log.csv", "t [s],Speed [Hz],Torque [Nm],I [A]", [TIME, SPEED, FORCE, CURRENT]
    )
    assert plan_of(read_table(path), ColumnMap()).command().endswith('--slip "Speed [turn/s]"')


@pytest.mark.slow
@pytest.mark.parametrize("since_1970", [1.7e9, 1.7e12, 1.7e15])
@pytest.mark.parametrize("name", ["ts", "recorded", "when"])
def test_a_time_since_1970_is_known_by_its_numbers(
    tmp_path: Path, name: str, since_1970: float
) -> None:
    stamps = since_1970 + np.round(TIME * since_1970 / 1.7e9 * 1e3) / 1e3
    columns = [stamps, SPEED * 1e3, FORCE, CURRENT]
    lines = [",".join(f"{number:.17g}" for number in row) for row in np.column_stack(columns)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([f"{name},v [mm/s],F [N],I [A]", *lines]) + "\n", encoding="utf-8")
    log = read(path)
    assert log.period == pytest.approx(0.002, rel=1e-3)
    assert any("as a time since 1970 has them" in note for note in log.notes)


@pytest.mark.slow
def test_large_numbers_that_do_not_rise_or_have_a_unit_are_no_time(tmp_path: Path) -> None:
    for name, numbers in (("k", 1.7e9 + 100.0 * SPEED), ("k [N/m]", 1.7e9 + TIME)):
        columns = [numbers, SPEED * 1e3, FORCE, CURRENT]
        path = written(tmp_path / "log.csv", f"{name},v [mm/s],F [N],I [A]", columns)
        with pytest.raises(MappingError, match="no time column"):
            read(path)


@pytest.mark.parametrize(("name", "is_sure"), [("tps", False), ("TPS", False), ("tps [s]", True)])
def test_tps_is_the_time_in_french_or_the_sensor_of_a_throttle(name: str, is_sure: bool) -> None:
    opened = 15.0 + 0.05 * np.arange(TIME.size)  # a throttle that is opened slowly
    speed = 200.0 + 50.0 * np.sin(TIME)
    columns = {name: opened, "w [rad/s]": speed, "M [N*m]": 50.0 + np.sin(TIME)}
    plan = planned(columns)
    assert plan.clock is not None
    assert (not plan.clock.doubt) == is_sure
    # Where the speed is the rate of a position in these seconds, they are a time.
    angle = np.cumsum(speed) * 0.05
    assert not planned({**columns, "angle [rad]": angle}).doubts


@pytest.mark.parametrize("name", ["Operational Hours", "tool_age_min", "Operating hours"])
def test_how_long_machines_have_run_is_no_time_where_it_falls(tmp_path: Path, name: str) -> None:
    hours: Array = 10.0 + (3500.0 * TIME) % 150.0
    speed: Array = 5.0 * np.sin(6.0 * TIME)
    names = f"speed [rad/s],torque [N*m],{name}"
    plan = plan_of(
        read_table(written(tmp_path / "log.csv", names, [speed, np.tanh(speed), hours])),
        ColumnMap(),
    )
    assert "time" not in plan.choices
    assert any("no time column" in question.problem for question in plan.questions)


def test_running_hours_that_rise_are_the_time(tmp_path: Path) -> None:
    speed: Array = 5.0 * np.sin(6.0 * TIME)
    names = "speed [rad/s],torque [N*m],Operating hours"
    path = written(tmp_path / "log.csv", names, [speed, np.tanh(speed), TIME])
    plan = plan_of(read_table(path), ColumnMap())
    assert plan.clock is not None
    assert (plan.clock.column, plan.clock.factor) == ("Operating hours", 3600.0)
