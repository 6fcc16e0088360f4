"""Columns without names are asked about, and the command that is printed has the likely ones in it. SYNTHETIC."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from erclutch.logs import ColumnMap, plan_of, read, read_table
from erclutch.logs.planning.nameless_columns import _CHANNEL
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned
from tests.support.slow_params import slow_behind

RNG = np.random.default_rng(6)
TIME: Array = 0.002 * np.arange(4000, dtype=np.float64)
PLACE = 8.0 * np.sin(9.0 * TIME) + 3.0 * np.sin(4.1 * TIME)
SPEED = 72.0 * np.cos(9.0 * TIME) + 12.3 * np.cos(4.1 * TIME)
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 1000)
FORCE = (20.0 + 250.0 * CURRENT) * np.tanh(SPEED / 8.0) + 0.6 * SPEED + RNG.normal(0.0, 2.0, 4000)
FRICTION = 30.0 * np.tanh(SPEED / 8.0) + 0.3 * SPEED + RNG.normal(0.0, 1.0, 4000)
MEASURED = CURRENT + RNG.normal(0.0, 0.01, 4000)  # keeps no levels
FEW_DIGITS = np.round(TIME / 6.0, 4)  # steps of 0.0003 and 0.0004
TURNS = 30.0 + 12.0 * np.sin(3.1 * TIME)  # one way
BRAKE = 0.5 + 12.0 * CURRENT + 0.02 * TURNS + RNG.normal(0.0, 0.05, 4000)

KINDS = [
    ([TIME, PLACE, SPEED, FORCE, CURRENT], "--time 'c1 [s]' --field c5 --slip c3 --effort c4"),
    ([TIME, CURRENT, FORCE, SPEED, PLACE], "--time 'c1 [s]' --field c2 --slip c4 --effort c3"),
    ([TIME, PLACE, FRICTION], "--time 'c1 [s]' --field none --position c2 --effort c3"),
    ([TIME, FRICTION, PLACE], "--time 'c1 [s]' --field none --position c3 --effort c2"),
    ([PLACE, SPEED, FRICTION], "--rate '500 Hz' --field none --slip c2 --effort c3"),
    ([SPEED, FRICTION], "--rate 'RATE Hz' --field none --slip c1 --effort c2"),
    (
        [FEW_DIGITS, PLACE, SPEED, FORCE, MEASURED],
        "--time 'c1 [s]' --field c5 --slip c3 --effort c4",
    ),
    ([TIME, CURRENT, TURNS, BRAKE], "--time 'c1 [s]' --field c2 --slip c3 --effort c4"),
    ([TIME, BRAKE, TURNS, CURRENT], "--time 'c1 [s]' --field c4 --slip c3 --effort c2"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("columns", "wanted"), slow_behind(3, KINDS))
def test_the_command_has_the_columns_that_the_numbers_speak_for(
    tmp_path: Path, columns: list[Array], wanted: str
) -> None:
    path = tmp_path / "log.txt"
    np.savetxt(path, np.column_stack(columns), fmt="%.7g")
    plan = plan_of(read_table(path), ColumnMap())
    assert plan.questions  # nothing is taken in silence
    words = shlex.split(plan.command())
    assert shlex.join(words[3:]) == wanted
    assert any("by the numbers alone" in question.problem for question in plan.questions)


@pytest.mark.slow
def test_stamps_of_a_busy_logger_are_the_time_and_no_effort(tmp_path: Path) -> None:
    late = RNG.uniform(-0.05, 0.05, TIME.size) * 0.002
    with_gaps = late + np.where(TIME > 2.0, 0.5, 0.0)
    for off in (late, with_gaps):
        path = tmp_path / "log.txt"
        np.savetxt(path, np.column_stack([TIME + off, PLACE, SPEED, FORCE, CURRENT]), fmt="%.7g")
        command = plan_of(read_table(path), ColumnMap()).command()
        assert '--time "c1 [s]"' in command
        assert '--effort "c1"' not in command


@pytest.mark.slow
def test_the_time_is_proposed_though_the_others_are_not(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    others = RNG.normal(size=(TIME.size, 3))
    np.savetxt(path, np.column_stack([TIME, others]), fmt="%.7g")
    command = plan_of(read_table(path), ColumnMap()).command()
    assert '--time "c1 [s]"' in command
    assert '--effort "COLUMN' in command


@pytest.mark.slow
def test_a_first_column_that_stands_still_or_counts_is_no_time(tmp_path: Path) -> None:
    for first in (np.round(TIME, 2), np.arange(TIME.size), TIME[::-1]):
        path = tmp_path / "log.txt"
        np.savetxt(path, np.column_stack([first, PLACE, FRICTION]), fmt="%.7g")
        assert "--time" not in plan_of(read_table(path), ColumnMap()).command().replace(
            '--time "COLUMN [s]"', ""
        )


@pytest.mark.usefixtures("read_here")
def test_a_matrix_of_matlab_is_asked_about_so_too(tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    savemat(path, {"data": np.column_stack([TIME, PLACE, SPEED, FRICTION])})
    command = plan_of(read_table(path), ColumnMap()).command()
    assert command.endswith('--field none --slip "data_3" --effort "data_4"')


@pytest.mark.usefixtures("read_here")
def test_an_array_beside_a_time_is_asked_about_so_too(tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    values = np.column_stack([PLACE, SPEED, FRICTION])
    savemat(path, {"simout": {"time": TIME, "signals": {"values": values}}})
    command = plan_of(read_table(path), ColumnMap()).command()
    assert command.endswith('--field none --slip "simout_2" --effort "simout_3"')


@pytest.mark.slow
@pytest.mark.parametrize(
    "columns",
    [
        [TIME, PLACE],
        [TIME, PLACE, PLACE * 2.0],
        [TIME, RNG.standard_normal(4000), RNG.standard_normal(4000)],
        [TIME, np.ones(4000), np.zeros(4000)],
        [np.full(4000, np.nan), PLACE, FRICTION],
    ],
)
def test_where_the_numbers_tell_nothing_a_place_is_left_to_fill_in(
    tmp_path: Path, columns: list[Array]
) -> None:
    path = tmp_path / "log.txt"
    np.savetxt(path, np.column_stack(columns), fmt="%.7g")
    plan = plan_of(read_table(path), ColumnMap())
    assert "COLUMN" in plan.command() or "position" in plan.command()


@pytest.mark.slow
def test_columns_with_names_are_none_of_these(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = np.column_stack([TIME, PLACE, SPEED, FRICTION])
    np.savetxt(path, rows, fmt="%.7g", delimiter=",", header="k1,k2,k3,m4", comments="")
    plan = plan_of(read_table(path), ColumnMap())
    assert not any("by the numbers alone" in question.problem for question in plan.questions)


SET_SPEED = np.repeat([5.0, 10.0, 20.0, 50.0, 100.0, 200.0], 5)
SET_CURRENT = np.tile([0.0, 0.5, 1.0, 1.5, 2.0], 6)
AT_POINTS = 0.2 + 1.5 * SET_CURRENT + 0.002 * SET_SPEED + RNG.normal(0.0, 0.01, 30)


@pytest.mark.parametrize(
    ("columns", "wanted"),
    [
        (
            {"x": SET_SPEED, "I": SET_CURRENT, "y": AT_POINTS},
            "--time none --slip x --effort y",
        ),
        (
            {"I [A]": SET_CURRENT, "X": SET_SPEED, "Y": AT_POINTS},
            "--time none --slip X --effort Y",
        ),
        (
            {"x": SET_SPEED, "y": SET_CURRENT, "z": AT_POINTS},
            "--time none --field y --slip x --effort z",
        ),
        (
            {"c1": SET_CURRENT, "c2": AT_POINTS, "c3": SET_SPEED},
            "--time none --field c1 --slip c3 --effort c2",
        ),
    ],
)
def test_points_under_the_names_of_axes_are_asked_about_in_one_command(
    columns: dict[str, Array], wanted: str
) -> None:
    words = shlex.split(planned(columns).command())
    assert shlex.join(words[3:]) == wanted


def test_where_two_axes_may_be_the_field_none_is_proposed() -> None:
    plan = planned({"x": SET_SPEED, "y": 1.0 + SET_CURRENT, "z": AT_POINTS})
    assert "--slip x" not in plan.command()
    assert "--field y" not in plan.command()


@pytest.mark.slow
def test_the_question_says_how_the_numbers_of_each_column_run(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    np.savetxt(path, np.column_stack([TIME, SPEED, FRICTION, CURRENT]), fmt="%.7g")
    plan = plan_of(read_table(path), ColumnMap())
    said = " ".join(question.problem for question in plan.questions)
    assert "c1 rises by steps of 0.002, as a time in s does" in said
    assert "c4 has 4 levels from 0 to 1" in said
    assert "c2 changes its sign" in said
    assert "c3 changes its sign" in said


@pytest.mark.slow
@pytest.mark.parametrize(("times", "unit"), [(1.0, "s"), (1000.0, "ms")])
def test_a_time_that_begins_anew_at_each_level_is_offered(
    tmp_path: Path, times: float, unit: str
) -> None:
    path = tmp_path / "log.txt"
    again = np.tile(TIME[:1000], 4) * times
    np.savetxt(path, np.column_stack([again, CURRENT, PLACE, SPEED, FORCE]), fmt="%.7g")
    plan = plan_of(read_table(path), ColumnMap())
    words = shlex.split(plan.command())
    wanted = f"--time 'c1 [{unit}]' --field c2 --slip c4 --effort c5"
    assert shlex.join(words[3:]) == wanted
    assert "begins anew 3 times" in " ".join(question.problem for question in plan.questions)
    log = read(path, time=f"c1 [{unit}]", field="c2", slip="c4", effort="c5")
    assert len(log.segments) == 4


def test_a_sweep_of_speeds_at_each_level_is_no_time_that_begins_anew(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    speeds = np.tile(np.linspace(0.1, 4.0, 40), 3)
    levels = np.repeat([0.0, 1.0, 2.0], 40)
    forces = (1.0 + levels) * np.tanh(speeds) + RNG.normal(0.0, 0.01, 120)
    np.savetxt(path, np.column_stack([speeds, levels, forces]), fmt="%.7g")
    command = plan_of(read_table(path), ColumnMap()).command()
    assert "--time none" in command
    assert "--slip" in command
    assert '--time "c1' not in command


LEARNT = [
    ({"X_train_1": [TIME, PLACE, SPEED, CURRENT], "y_train_1": [FORCE]}, "y_train_1"),
    ({"X": [TIME, PLACE, SPEED, CURRENT], "y": [FORCE]}, "y"),
    ({"X_1": [TIME, PLACE, SPEED], "y_1": [FORCE], "u": [CURRENT]}, "y_1"),
    ({"inputs": [TIME, PLACE, SPEED, CURRENT], "targets": [FORCE]}, "targets"),
]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["mat", "npz"])
@pytest.mark.parametrize(("arrays", "effort"), slow_behind(2, LEARNT))
def test_arrays_of_learning_are_offered_by_their_numbers(
    tmp_path: Path, arrays: dict[str, list[Array]], effort: str, suffix: str
) -> None:
    path = tmp_path / f"log.{suffix}"
    stacked = {name: np.squeeze(np.column_stack(columns)) for name, columns in arrays.items()}
    if suffix == "mat":
        savemat(path, stacked)
    else:
        np.savez(path, allow_pickle=True, **stacked)
    words = shlex.split(plan_of(read_table(path), ColumnMap()).command())
    first = next(iter(arrays))
    field = "u" if "u" in arrays else f"{first}_4"
    wanted = f"--time '{first}_1 [s]' --field {field} --slip {first}_3 --effort {effort}"
    assert shlex.join(words[3:]) == wanted


@pytest.mark.slow
def test_two_inputs_and_an_output_are_no_places_of_a_motion(tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    np.savez(path, X=np.column_stack([SPEED, CURRENT]), y=FORCE)
    command = plan_of(read_table(path), ColumnMap()).command().replace('"', "")
    assert "--field X_2 --slip X_1 --effort y" in command


TOLD_PLACE = PLACE + 0.01
OPEN_LOOP = FRICTION.copy()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("columns", "wanted"),
    [
        (
            {"time": TIME, "CH1in": TOLD_PLACE, "CH1out": PLACE, "CH1sig": FRICTION},
            "--field none --position CH1out --effort CH1sig",
        ),
        (
            {"time": TIME, "AI0_sig": FRICTION, "AI0_out": PLACE, "AI0_in": OPEN_LOOP},
            "--field none --position AI0_out --effort AI0_sig",
        ),
        (
            {"time": TIME, "ch2 input": SPEED * 1.02, "ch2 output": SPEED, "ch2 sig": FRICTION},
            "--field none --slip 'ch2 output' --effort 'ch2 sig'",
        ),
        (
            {"time": TIME, "Kanal 1": PLACE, "Kanal 3": FRICTION},
            "--field none --position 'Kanal 1' --effort 'Kanal 3'",
        ),
    ],
)
def test_channels_of_a_loop_have_no_better_names(columns: dict[str, Array], wanted: str) -> None:
    words = shlex.split(planned(columns).command())
    assert shlex.join(words[3:]) == wanted


def test_of_a_step_of_a_loop_no_position_is_told_from_a_speed() -> None:
    step = np.repeat([0.0, 1.0, 0.0, 1.0], 1000)
    answer = np.convolve(step, np.full(200, 0.005))[:4000]
    columns = {"time": TIME, "CH1in": step, "CH1out": answer, "CH1sig": 5.0 * (step - answer)}
    command = planned({**columns, "CH1sig": columns["CH1sig"] + 0.7 * answer}).command()
    assert '"COLUMN' in command


@pytest.mark.slow
def test_a_word_behind_the_number_of_a_channel_is_a_name() -> None:
    columns = {"time": TIME, "CH1 strain": PLACE, "CH2 oil": SPEED, "CH3 lamp": FRICTION}
    assert "by the numbers alone" not in str(planned(columns).questions)


def test_names_of_channels_take_linear_time() -> None:
    for sign in ("[", " ", "_", "1"):
        assert _CHANNEL.fullmatch("ch" + sign * 20_000) is None


UNEVEN = np.cumsum(RNG.uniform(0.05, 0.15, 400))
TWICE_A_STAMP = np.round(0.01 * np.arange(400), 2)
TWICE_A_STAMP[[57, 211]] = TWICE_A_STAMP[[56, 210]]
FADING = 90.0 * np.exp(-0.01 * np.arange(400))


@pytest.mark.parametrize("stamps", [TIME[:400], UNEVEN, TWICE_A_STAMP])
@pytest.mark.parametrize("other", [FADING, PLACE[:400], np.tanh(UNEVEN - 20.0)])
def test_of_two_columns_one_that_rises_all_through_is_no_signal(
    stamps: Array, other: Array
) -> None:
    for time, columns in (("c1", [stamps, other]), ("c2", [other, stamps])):
        command = planned(dict(zip(("c1", "c2"), columns, strict=True))).command()
        for option in ("--slip", "--position", "--effort"):
            assert f'{option} "{time}"' not in command
        assert "COLUMN" in command  # a time and one course are no motion with its effort


def test_a_speed_that_is_swept_through_zero_is_no_time() -> None:
    speeds = np.linspace(-49.3, 51.0, 400)
    efforts = 0.2 * np.sign(speeds) + 0.004 * speeds
    command = planned({"c1": speeds, "c2": efforts}).command()
    assert command.endswith('--time none --field none --slip "c1" --effort "c2"')
    # A scope's time begins before its trigger, and what it shows has signs of its own.
    command = planned({"c1": speeds, "c2": np.sin(0.3 * speeds) + 0.2}).command()
    assert '"c1" --effort' not in command


def test_an_uneven_time_is_no_effort_beside_a_motion() -> None:
    place = 8.0 * np.sin(0.9 * UNEVEN) + 3.0 * np.sin(0.41 * UNEVEN)
    command = planned({"c1": UNEVEN, "c2": place, "c3": np.gradient(place, UNEVEN)}).command()
    assert '"c1"' not in command


def test_few_points_under_a_rising_speed_are_still_offered() -> None:
    speeds = np.array([1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0])
    command = planned({"c1": speeds, "c2": 3.0 + speeds**0.3}).command()
    assert '"c1" --effort "c2"' in command


@pytest.mark.parametrize("time", ["t", "time", "Time"])
@pytest.mark.parametrize("axes", [("x", "y"), ("X", "Y"), ("x", "y", "z"), ("y", "z")])
def test_places_of_a_point_in_time_are_no_motion_with_its_effort(
    time: str, axes: tuple[str, ...]
) -> None:
    courses = [0.1 * TIME, 0.2 * TIME - 0.05 * TIME**2, np.cos(TIME)]
    columns = {time: TIME} | dict(zip(axes, courses, strict=False))
    plan = planned(columns)
    assert not any("by the numbers alone" in question.problem for question in plan.questions)
    assert '--effort "COLUMN [N]"' in plan.command()
