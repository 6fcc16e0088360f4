"""A table of speeds and torques without a time is read as points; a log of a motion is asked for its rate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError, MappingError
from erclutch.logs import read
from tests.support.command import good

SPEED = np.arange(40) * 100.0 + 1000.0
MANY = np.arange(80) * 50.0 + 1000.0  # enough for a fit


def written(folder: Path, header: str, *columns: np.ndarray) -> Path:
    path = folder / "points.csv"
    rows = "\n".join(
        ",".join(f"{number:g}" for number in row) for row in zip(*columns, strict=True)
    )
    path.write_text(f"{header}\n{rows}\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("speed", [SPEED, SPEED[::-1], -SPEED, np.repeat(SPEED[::4], 4)])
def test_a_speed_that_goes_one_way_makes_points(tmp_path: Path, speed: np.ndarray) -> None:
    log = read(
        written(tmp_path, "Current [A],Speed [rpm],Torque [N*m]", SPEED % 7, speed, SPEED % 9)
    )
    np.testing.assert_allclose(log.signals["slip"], speed * np.pi / 30)
    assert any(
        "column Speed goes one way through the table, so its rows are points" in note
        for note in log.notes
    )
    assert any("a lag or a rate of change means nothing" in note for note in log.notes)


@pytest.mark.parametrize("speed", [SPEED, SPEED[::-1]])
def test_a_sweep_with_the_noise_of_a_sensor_makes_points(tmp_path: Path, speed: np.ndarray) -> None:
    wobble = np.where(np.arange(40) % 10 == 0, 130.0 * np.sign(speed[1] - speed[0]), 0.0)
    log = read(
        written(
            tmp_path, "Current [A],Speed [rpm],Torque [N*m]", SPEED % 7, speed + wobble, SPEED % 9
        )
    )
    assert any("column Speed goes one way" in note for note in log.notes)
    with pytest.raises(MappingError, match="no time column and no sampling rate"):
        read(
            written(
                tmp_path,
                "Current [A],Speed [rpm],Torque [N*m]",
                SPEED % 7,
                speed + 2.0 * wobble,
                SPEED % 9,
            )
        )


@pytest.mark.slow
def test_a_long_sweep_with_noise_is_a_log(tmp_path: Path) -> None:
    rows = np.arange(1001.0)
    wobble = np.where(rows % 10 == 0, 1.5, 0.0)
    columns = [rows % 7, 1000.0 + rows + wobble, rows % 9]
    with pytest.raises(MappingError, match="no time column and no sampling rate"):
        read(written(tmp_path, "Current [A],Speed [rpm],Torque [N*m]", *columns))
    short = [column[:1000] for column in columns]
    assert read(written(tmp_path, "Current [A],Speed [rpm],Torque [N*m]", *short)).rows == 1000


@pytest.mark.slow
@pytest.mark.parametrize("hole", [0, 17, 39])
def test_a_point_without_a_number_is_left_out_with_a_word(tmp_path: Path, hole: int) -> None:
    torque = SPEED % 9
    torque[hole] = np.nan
    header = "Current [A],Speed [rpm],Torque [N*m]"
    log = read(written(tmp_path, header, SPEED % 7, SPEED, torque))
    assert log.rows == 39
    np.testing.assert_allclose(log.signals["effort"], np.delete(torque, hole))
    assert any(f"in data row {hole + 1}: 1 row dropped" in note for note in log.notes)
    refused = "column Torque has 1 value missing"
    with pytest.raises(LogError, match=refused):
        read(written(tmp_path, header, SPEED % 7, SPEED, torque), invalid="error")
    in_time = read(
        written(tmp_path, header, SPEED % 7, SPEED, torque), rate=50
    )  # the rows are a log, which is cut
    assert len(in_time.segments) == (2 if hole == 17 else 1)
    torque[20:25] = np.nan  # another table than it seems
    with pytest.raises(LogError, match="values missing"):
        read(written(tmp_path, header, SPEED % 7, SPEED, torque))


def test_a_set_speed_that_goes_one_way_makes_points_of_the_measured_one(tmp_path: Path) -> None:
    header = "input_speed [rpm],output_speed [rpm],output_torque [N*m]"
    path = written(tmp_path, header, np.repeat(SPEED[::4], 4), SPEED + SPEED % 7, SPEED % 9)
    log = read(path, slip="output_speed [rpm]")
    assert any("column input_speed goes one way" in note for note in log.notes)


@pytest.mark.parametrize(
    ("header", "speed", "further"),
    [
        ("q", SPEED % 7 - 3.0, SPEED % 11),  # it turns back
        ("q", 900.0 * np.sin((SPEED - 2950.0) / 1300.0), SPEED % 11),  # through rest, as in a swing
        ("q", SPEED, np.cumsum(1.0 + SPEED % 3)),  # another column may be the time
    ],
)
def test_a_motion_is_asked_for_its_rate(
    tmp_path: Path, header: str, speed: np.ndarray, further: np.ndarray
) -> None:
    path = written(tmp_path, f"Speed [rpm],Torque [N*m],{header}", speed, SPEED % 9, further)
    with pytest.raises(MappingError, match="no time column and no sampling rate"):
        read(path, field="none")


@pytest.mark.parametrize("speed", [SPEED - 2950.0, 2950.0 - SPEED, 7.85 * np.arange(-20, 21)])
def test_a_speed_that_goes_through_zero_by_equal_steps_was_set(
    tmp_path: Path, speed: np.ndarray
) -> None:
    path = written(tmp_path, "omega [rad/s],m [N*m]", speed, -np.tanh(speed / 9.0))
    log = read(path, field="none")
    assert any("column omega goes one way through the table" in note for note in log.notes)


def test_a_measured_ramp_through_zero_is_asked_for_its_rate(tmp_path: Path) -> None:
    speed = SPEED - 2950.0 + np.random.default_rng(0).normal(0.0, 0.5, SPEED.size)
    path = written(tmp_path, "Speed [rpm],Torque [N*m]", speed, -np.tanh(speed / 900.0))
    with pytest.raises(MappingError, match="no time column and no sampling rate"):
        read(path, field="none")


@pytest.mark.slow
def test_rows_are_points_where_the_user_says_that_there_is_no_time(tmp_path: Path) -> None:
    path = written(tmp_path, "Speed [rpm],Torque [N*m]", MANY % 700, MANY % 9)
    log = read(path, time="none")
    assert any("no time (given): the rows are points" in note for note in log.notes)
    asked = good("inspect", "points.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert asked == "What settles it: erclutch inspect points.csv --time none"
    settled = good("inspect", "points.csv", "--time", "none", cwd=tmp_path).splitlines()[-1]
    assert settled == "Understood. Fit it: erclutch fit points.csv --time none --out RUN"


def test_a_column_that_is_called_none_is_the_time(tmp_path: Path) -> None:
    log = read(
        written(tmp_path, "none,Speed [rpm],Torque [N*m]", SPEED / 1000, SPEED % 700, SPEED % 9),
        time="none",
    )
    assert log.period == pytest.approx(0.1)


def test_a_rate_that_is_given_counts_for_points_too(tmp_path: Path) -> None:
    log = read(written(tmp_path, "Speed [rpm],Torque [N*m]", SPEED, SPEED % 9), rate=50)
    assert log.period == pytest.approx(0.02)


@pytest.mark.slow
def test_inspect_understands_points(tmp_path: Path) -> None:
    written(tmp_path, "RPM,Torque (ft-lbs)", MANY, 30.0 + MANY % 9)
    assert good("inspect", "points.csv", cwd=tmp_path).splitlines()[-1].startswith("Understood.")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("word", "answer"),
    [
        ("cell", "--field none --time none"),
        ("trial", "--time none"),  # which numbers the parts of a test
        ("well", "--field none --time none"),
        ("order", "--field none --time none"),  # of interference fringes, or of runs
    ],
)
def test_a_time_that_no_row_follows_is_told_and_the_rows_are_taken_as_points(
    tmp_path: Path, word: str, answer: str
) -> None:
    times = 12.0 + MANY % 7  # s, of each point by itself
    path = written(
        tmp_path, f"{word},Elapsed_Time_s,RPM,Torque [N*m]", MANY // 1000, times, MANY, MANY % 9
    )
    said = good("inspect", path.name, cwd=tmp_path, code=1).splitlines()
    assert said[-1] == f"What settles it: erclutch inspect points.csv {answer}"
    said = good("inspect", path.name, *answer.split(), cwd=tmp_path).splitlines()
    assert said[-1] == f"Understood. Fit it: erclutch fit points.csv {answer} --out RUN"


@pytest.mark.slow
def test_a_sweep_that_wanders_beside_the_numbers_of_its_points_makes_points(tmp_path: Path) -> None:
    wobble = np.where(np.arange(40) % 10 == 0, 150.0, 0.0)
    number = np.arange(1.0, 41.0)
    columns = (number, SPEED % 7, SPEED + wobble, SPEED % 9)
    log = read(written(tmp_path, "Point No,Current [A],Speed [rpm],Torque [N*m]", *columns))
    assert any("column Speed goes one way" in note for note in log.notes)
    with pytest.raises(
        MappingError, match="no time column and no sampling rate"
    ):  # a logger counts samples
        read(written(tmp_path, "Sample,Current [A],Speed [rpm],Torque [N*m]", *columns))


def test_points_say_the_option_for_rows_that_were_sampled(tmp_path: Path) -> None:
    log = read(
        written(tmp_path, "Current [A],Speed [rpm],Torque [N*m]", SPEED % 7, SPEED, SPEED % 9)
    )
    assert any('--rate "RATE Hz"' in note for note in log.notes)


def test_positions_swept_anew_for_each_current_are_said_to_be_a_map_at_rest(tmp_path: Path) -> None:
    angle = np.tile(np.linspace(10.0, 55.0, 40), 5)
    current = np.repeat(np.arange(5.0) * 40, 40)
    header = "Position [deg],I [A],Torque [N*m]"
    with pytest.raises(
        MappingError, match="Position goes one way anew for each I, as in a map of efforts at rest"
    ):
        read(written(tmp_path, header, angle, current, current * np.sin(angle)))
    with pytest.raises(MappingError) as told:
        read(written(tmp_path, header, np.sin(angle), current, current * np.sin(angle)))
    assert "at rest" not in str(told.value)


@pytest.mark.slow
def test_a_time_that_stands_still_is_told_with_the_command_that_takes_the_rows_as_points(
    tmp_path: Path,
) -> None:
    stands = np.full(MANY.size, 1687087821438.0)
    written(tmp_path, "TIME,RPM,Torque [N*m]", stands, MANY % 700, MANY % 9)
    said = good("inspect", "points.csv", cwd=tmp_path, code=1).splitlines()
    assert said[-1] == "What settles it: erclutch inspect points.csv --time none"
    assert "Understood." in good("inspect", "points.csv", "--time", "none", cwd=tmp_path)


@pytest.mark.parametrize(
    ("speeds", "levels", "are_points"), [(8, 5, True), (12, 3, True), (3, 2, False)]
)
def test_short_sweeps_make_points_where_there_are_too_many_for_chance(
    tmp_path: Path, speeds: int, levels: int, are_points: bool
) -> None:
    current = np.repeat(np.arange(levels) * 0.5, speeds)
    speed = np.tile(np.linspace(100.0, 800.0, speeds), levels)
    path = written(tmp_path, "Current [A],Speed [rpm],Torque [N*m]", current, speed, current + 1)
    if are_points:
        assert any("its rows are points" in note for note in read(path).notes)
    else:
        with pytest.raises(MappingError, match="no time column"):
            read(path)


def test_points_without_an_effort_are_points_where_none_is_needed(tmp_path: Path) -> None:
    path = written(tmp_path, "Current [A],Speed [rpm]", SPEED % 7, SPEED)
    log = read(path, {"constants": {"effort": "0 N*m"}})
    assert any("its rows are points" in note for note in log.notes)
