"""Logs of robots and motors: several joints, commands of a drive, arrays of objects, channels on one clock.

The data are SYNTHETIC.
"""

from __future__ import annotations

import pickle
import shlex
import zipfile
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import (
    ColumnMap,
    plan_of,
    read,
    read_table,
    recording_from_arrays,
    recordings_in,
)
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.names import words_of
from erclutch.logs.plan import Plan
from tests.support.slow_params import slow_behind

# What is read from sound files is asked here, and not the child process that reads them.
pytestmark = pytest.mark.usefixtures("read_here")

TIME = np.arange(400) / 100
ANGLE = np.sin(3 * TIME)
RATE = 3 * np.cos(3 * TIME)
JOINTS = np.linspace(0.1, 0.7, 7)
REST = np.full(TIME.size, 0.01) + 1e-3 * np.sin(40 * TIME)


def robot(moving: int, *, still: str = "q qd tau_measured") -> dict[str, np.ndarray]:
    """A robot of seven joints, one of which moves; all others rest."""
    courses = {
        "q": ANGLE,
        "qd": RATE,
        "tau_measured": np.tanh(4 * RATE) + 0.3 * ANGLE,
        "qd_cmd": RATE + 0.02,
    }
    arrays: dict[str, np.ndarray] = {"time": TIME}
    for name in (*still.split(), "qd_cmd"):
        columns = [courses[name] if joint == moving else JOINTS[joint] * REST for joint in range(7)]
        arrays[name] = np.stack(columns, axis=1)
    return arrays


def saved(path: Path, arrays: dict[str, np.ndarray]) -> Path:
    np.savez(path, allow_pickle=False, **arrays)
    return path


def planned(path: Path) -> Plan:
    return plan_of(read_table(path), ColumnMap())


def told_by(plan: Plan) -> ColumnMap:
    """What the printed command says."""
    words = shlex.split(plan.command())[3:]
    return ColumnMap.from_options(
        dict(zip((word.removeprefix("--") for word in words[::2]), words[1::2], strict=True))
    )


def answered(plan: Plan) -> Plan:
    """The plan that the printed command makes."""
    words = shlex.split(plan.command())[3:]
    told = dict(zip((word.removeprefix("--") for word in words[::2]), words[1::2], strict=True))
    return plan_of(read_table(plan.path), ColumnMap.from_dict({"columns": told}))


@pytest.mark.slow
@pytest.mark.parametrize("moving", slow_behind(1, [1, 3, 6]))
def test_of_several_joints_the_one_that_moves_is_proposed_and_one_command_settles_it(
    tmp_path: Path, moving: int
) -> None:
    plan = planned(saved(tmp_path / "run.npz", robot(moving)))
    assert "slip may be any of the columns" in str(plan.questions)
    assert f'--slip "qd_{moving + 1}" --effort "tau_measured_{moving + 1}"' in plan.command()
    assert not answered(plan).questions


@pytest.mark.slow
def test_the_joint_in_the_name_of_the_file_is_proposed_first(tmp_path: Path) -> None:
    plan = planned(saved(tmp_path / "friction_joint_5.npz", robot(2)))
    assert '--slip "qd_5" --effort "tau_measured_5"' in plan.command()


@pytest.mark.slow
@pytest.mark.parametrize("names", [("dq", "tau"), ("vel", "torque"), ("velocity", "effort")])
def test_joints_in_a_text_are_asked_about_by_their_numbers(
    tmp_path: Path, names: tuple[str, str]
) -> None:
    speed, effort = names
    heads = ["time", *(f"{speed}{k}" for k in range(3)), *(f"{effort}{k}" for k in range(3))]
    rest = [0.2 * REST, 0.3 * REST]
    columns = [TIME, rest[0], RATE, rest[1], rest[0] + 1, np.tanh(RATE), rest[1] + 2]
    rows = "\n".join(
        ",".join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True)
    )
    (tmp_path / "arm.csv").write_text(",".join(heads) + "\n" + rows + "\n")
    plan = planned(tmp_path / "arm.csv")
    assert {question.signal for question in plan.questions} >= {"slip", "effort"}
    assert f'--slip "{speed}1" --effort "{effort}1"' in plan.command()
    assert not answered(plan).questions


def test_numbered_columns_without_an_effort_for_each_are_no_joints(tmp_path: Path) -> None:
    rows = "\n".join(
        f"{t:.2f},{a:.5f},{r:.5f},{np.tanh(r):.5f}"
        for t, a, r in zip(TIME, ANGLE, RATE, strict=True)
    )
    (tmp_path / "log.csv").write_text(
        "time [s],angle [rad],speed [rad/s],torque [Nm]\n" + rows + "\n"
    )
    assert not planned(tmp_path / "log.csv").questions


@pytest.mark.parametrize("effort", ["torque_feedback", "torque_fb", "feedback torque", "TorqueFbk"])
def test_what_a_drive_feeds_back_is_its_effort(effort: str) -> None:
    table_ = {"time": TIME, "velocity": RATE, effort: np.tanh(RATE)}
    assert plan_from(table_).signal("effort").column == effort  # type: ignore[union-attr]


def plan_from(columns: dict[str, np.ndarray]) -> Plan:
    from erclutch.logs.table import Table

    return plan_of(Table("a.csv", columns, dict.fromkeys(columns), "x", path="a.csv"), ColumnMap())


@pytest.mark.parametrize(
    "other", ["velocity_cmd", "position_setpoint", "torque_ref", "target_speed"]
)
def test_a_command_beside_those_of_a_motion_is_doubted_as_the_field(other: str) -> None:
    command = np.sign(np.sin(TIME))
    plan = plan_from(
        {
            "time": TIME,
            "velocity": RATE,
            "torque": np.tanh(RATE),
            "command": command,
            other: command,
        }
    )
    assert any(f"beside {other}" in doubt and "no field then" in doubt for doubt in plan.doubts)
    assert plan.command().endswith("--field none")


def test_a_command_alone_is_the_field() -> None:
    plan = plan_from(
        {"time": TIME, "velocity": RATE, "torque": np.tanh(RATE), "command": np.sign(np.sin(TIME))}
    )
    assert not plan.doubts
    assert plan.signal("field").column == "command"  # type: ignore[union-attr]


def test_several_encoders_are_asked_about_as_positions() -> None:
    columns = {
        "time": TIME,
        **{
            f"{place} encoder": ANGLE * k for k, place in enumerate(("first", "second", "third"), 1)
        },
    }
    plan = plan_from({**columns, "torque": np.tanh(RATE)})
    assert "position may be any of the columns first encoder" in str(plan.questions)
    assert '--position "first encoder"' in plan.command()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("XVelocity", ["x", "velocity"]),
        ("YawVelocity", ["yaw", "velocity"]),
        ("a_ZForce", ["a", "z", "force"]),
    ],
)
def test_an_axis_in_front_of_a_word_is_a_word(name: str, words: list[str]) -> None:
    assert words_of(name) == words


def test_the_yaw_beside_the_way_forward_is_asked_about() -> None:
    plan = plan_from(
        {
            "time": TIME,
            "XVelocity": RATE,
            "YawVelocity": 0.3 * RATE + ANGLE,
            "Torque": np.tanh(RATE),
        }
    )
    assert "slip may be any of the columns XVelocity, YawVelocity" in str(plan.questions)


# --- arrays -----------------------------------------------------------------------------------------------------------


def test_tables_of_the_same_columns_in_one_archive_are_recordings(tmp_path: Path) -> None:
    kind = np.dtype([("time", "f8"), ("speed", "f8"), ("torque", "f8")])
    runs = {
        f"run{factor}": np.rec.fromarrays([TIME, factor * RATE, np.tanh(RATE)], dtype=kind)
        for factor in (1, 2)
    }
    path = tmp_path / "runs.npz"
    np.savez(path, allow_pickle=False, mass=3.0, noise=RATE, **runs)
    assert recordings_in(path) == ["run1", "run2"]
    table = read_table(path, variable="run1")
    np.testing.assert_array_equal(table.columns["speed"], RATE)
    assert table.constants == {"mass": 3.0}
    assert "left out: noise: arrays beside several tables" in table.notes


def test_arrays_of_python_objects_are_said_and_left_out(tmp_path: Path) -> None:
    objects = np.array([{"gain": 1}, None], dtype=object)
    np.savez(tmp_path / "a.npz", time=TIME, speed=RATE, torque=np.tanh(RATE), settings=objects)
    table = read_table(tmp_path / "a.npz")
    assert (
        "left out: settings: Python objects, which may run programs and are never opened"
        in table.notes
    )
    assert list(table.columns) == ["time", "speed", "torque"]


@pytest.mark.parametrize("suffix", [".npz", ".npy"])
def test_a_file_of_python_objects_alone_is_refused_in_plain_words(
    tmp_path: Path, suffix: str
) -> None:
    objects = np.array([{"torque": [1.0, 2.0]}, None], dtype=object)
    path = tmp_path / f"log{suffix}"
    np.save(path, objects, allow_pickle=True) if suffix == ".npy" else np.savez(path, rows=objects)
    with pytest.raises(LogError, match=r"Python objects, which may run programs.*numpy\.savez"):
        read_table(path)


@pytest.mark.parametrize("suffix", [".npz", ".npy"])
def test_a_pickle_that_is_called_an_array_is_told_as_such(tmp_path: Path, suffix: str) -> None:
    """It was called damaged: numpy.save and numpy.load write and open pickles under these names too."""
    path = tmp_path / f"log{suffix}"
    path.write_bytes(pickle.dumps({"torque": list(TIME)}))
    with pytest.raises(
        LogError, match="holds no arrays but Python objects, which may run programs"
    ) as caught:
        read_table(path)
    assert "numpy.savez(NEW, time=..." in caught.value.remedy


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (pickle.dumps({"torque": [1.0]}), "left out: rows: Python objects, which may run programs"),
        (b"measured on Monday", "left out: rows: no array of NumPy"),
    ],
)
def test_a_part_of_an_archive_that_is_no_array_is_left_out(
    tmp_path: Path, content: bytes, said: str
) -> None:
    path = saved(tmp_path / "a.npz", {"time": TIME, "speed": RATE, "torque": np.tanh(RATE)})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("rows.npy", content)
    assert any(said in note for note in read_table(path).notes)
    alone = tmp_path / "alone.npz"
    with zipfile.ZipFile(alone, "w") as archive:
        archive.writestr("rows.npy", content)
    with pytest.raises(LogError, match="the arrays are no numbers: rows: ") as caught:
        read_table(alone)
    assert "numpy.savez(NEW" in caught.value.remedy


@pytest.mark.slow
def test_arrays_in_memory_are_cut_at_a_few_missing_values_as_files_are(tmp_path: Path) -> None:
    torque = np.tanh(RATE)
    torque[200] = np.nan
    signals = {"field": np.ones(TIME.size), "slip": RATE, "effort": torque}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    rows = "\n".join(",".join(map(str, row)) for row in zip(TIME, *signals.values(), strict=True))
    (tmp_path / "a.csv").write_text(
        "time [s],field [A],slip [rad/s],effort [N*m]\n" + rows.replace("nan", "") + "\n"
    )
    of_file = read(tmp_path / "a.csv")
    of_arrays = recording_from_arrays(signals, units, time=TIME)
    assert of_arrays.segments == of_file.segments == ((0, 200), (200, 399))
    with pytest.raises(LogError, match="1 value missing"):
        recording_from_arrays(signals, units, time=TIME, invalid="error")


# --- measurement software ---------------------------------------------------------------------------------------------


def test_a_universal_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "log.uff"
    path.write_text(
        "    -1\n    58\nForce 01.0Scalar\nNONE\n"
        + "  1.00000E-04 -4.31469E-03\n" * 20
        + "    -1\n"
    )
    with pytest.raises(LogError, match=r"universal file \(UFF\)"):
        read_table(path)


def test_numbers_that_begin_like_a_universal_file_are_read(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text("    -1\n    58\n" + "".join(f"    {k}\n" for k in range(20)))
    assert read_table(path).rows == 22


def tdms(path: Path, starts: list[float], values: list[np.ndarray], **properties: int) -> Path:
    nptdms = pytest.importorskip("nptdms")
    channels = [
        nptdms.ChannelObject(
            "bench",
            name,
            numbers,
            properties={
                "wf_increment": 0.01,
                "wf_start_time": np.datetime64("2026-01-01T10:00:00", "us")
                + np.timedelta64(int(1e6 * start), "us"),
                **properties,
            },
        )
        for name, start, numbers in zip(("speed", "torque", "current"), starts, values, strict=True)
    ]
    with nptdms.TdmsWriter(str(path)) as writer:
        writer.write_segment(channels)
    return path


@pytest.mark.slow
def test_channels_that_were_started_within_a_sample_are_on_one_clock(tmp_path: Path) -> None:
    values = [RATE, np.tanh(RATE), np.ones(TIME.size)]
    path = tdms(tmp_path / "a.tdms", [0.0, 14e-6, 28e-6], values)
    assert list(read_table(path).columns) == ["time", "speed", "torque", "current"]


def test_channels_that_were_started_later_are_left_out_with_a_note(tmp_path: Path) -> None:
    values = [RATE, np.tanh(RATE), np.ones(TIME.size)]
    table = read_table(tdms(tmp_path / "a.tdms", [0.0, 14e-6, 0.5], values))
    assert list(table.columns) == ["time", "speed", "torque"]
    assert any(
        note.startswith("channel current has another increment or start") for note in table.notes
    )


def test_channels_without_a_value_are_said(tmp_path: Path) -> None:
    woven = np.column_stack([TIME, RATE, np.tanh(RATE)]).ravel()
    path = tdms(tmp_path / "a.tdms", [0.0] * 3, [woven, np.zeros(0), np.zeros(0)], NI_ArrayColumn=0)
    notes = read_table(path).notes
    assert "channels without a value left out: torque, current" in notes
    assert any("the values of all 3 channels may stand in" in note for note in notes)


def test_units_of_a_log_are_kept_where_its_channels_start_together(tmp_path: Path) -> None:
    path = tdms(tmp_path / "a.tdms", [0.0, 14e-6, 28e-6], [RATE, np.tanh(RATE), np.ones(TIME.size)])
    assert read_table(path).units["time"] == "s"


# --- drives and loggers -----------------------------------------------------------------------------------------------


def drive_export(
    period: str, names: str = ";Position actual value;Torque actual value;Velocity actual value"
) -> str:
    rows = "".join(f"{6.8 * k:.3f};{k % 50};{(k % 9) - 4};{(k % 7) - 3}\n" for k in range(60))
    return f"Date:;2026-10-26 11:46:26\nMax. samples:;60\nSampling period:;{period}\n{names}\nms;inc;inc;inc\n{rows}"


def test_a_line_of_units_that_repeats_a_word_names_nothing(tmp_path: Path) -> None:
    (tmp_path / "drive.csv").write_text(drive_export("6.800"))
    table = read_table(tmp_path / "drive.csv")
    assert list(table.columns)[1:] == [
        "Position actual value",
        "Torque actual value",
        "Velocity actual value",
    ]
    assert list(table.units.values()) == ["ms", "inc", "inc", "inc"]


@pytest.mark.parametrize(
    ("period", "stated"), [("6.800", None), ("6.800 ms", 0.0068), ("0.0068", 0.0068), ("1 s", 1.0)]
)
def test_a_long_period_without_a_unit_in_a_header_is_not_taken_for_seconds(
    tmp_path: Path, period: str, stated: float | None
) -> None:
    (tmp_path / "drive.csv").write_text(drive_export(period))
    assert read_table(tmp_path / "drive.csv").sample_period == stated


@pytest.mark.slow
def test_the_time_of_a_drive_export_is_its_column_in_ms(tmp_path: Path) -> None:
    (tmp_path / "drive.csv").write_text(drive_export("6.800"))
    clock = planned(tmp_path / "drive.csv").clock
    assert clock is not None
    assert clock.factor == 1e-3


@pytest.mark.parametrize("name", ["Tinterval", "sample_interval"])
def test_the_interval_of_a_scope_is_its_sampling_period(tmp_path: Path, name: str) -> None:
    savemat = pytest.importorskip("scipy.io").savemat
    signals = {"speed": RATE, "torque": np.tanh(RATE)}
    savemat(tmp_path / "scope.mat", {**signals, name: 0.01, "Tstart": -0.5, "Length": TIME.size})
    clock = planned(tmp_path / "scope.mat").clock
    assert clock is not None
    assert clock.period == 0.01


@pytest.mark.slow
def test_a_bag_of_ros_1_is_read_and_lists_beside_names_are_columns_of_joints(
    tmp_path: Path,
) -> None:
    path = written_bag(
        tmp_path / "arm.bag",
        "float64[] position\nfloat64[] velocity\nfloat64[] effort",
        joints=True,
    )
    table = read_table(path)
    assert table.rows == TIME.size
    assert [name for name in table.columns if "elbow" in name] == [
        "elbow.position",
        "elbow.velocity",
        "elbow.effort",
    ]
    np.testing.assert_array_equal(table.columns["elbow.velocity"], RATE)
    assert table.clock is not None
    np.testing.assert_allclose(table.clock, TIME, atol=1e-9)
    plan = planned(path)
    assert '--slip "elbow.velocity" --effort "elbow.effort"' in plan.command()
    assert not answered(plan).questions


@pytest.mark.slow
def test_messages_that_hold_a_batch_each_are_rows_on_their_own_milliseconds(tmp_path: Path) -> None:
    fields = (
        "float64[] milliseconds\nfloat64[] position\nfloat64[] velocity\nfloat64[] applied_torque"
    )
    path = written_bag(tmp_path / "joint.bag", fields, joints=False)
    table = read_table(path)
    assert table.rows == 3 * 600
    assert table.clock is None
    assert any("3 messages of several rows each" in note for note in table.notes)
    plan = planned(path)
    assert plan.clock is not None
    assert (plan.clock.column, plan.clock.factor) == ("milliseconds", 1e-3)
    assert {each.signal: each.column for each in plan.signals}["effort"] == "applied_torque"


def written_bag(path: Path, fields: str, *, joints: bool) -> Path:
    """A bag of ROS 1: states of two joints on 100 Hz, or 3 messages of 600 rows each."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    names = "string[] name\n" if joints else ""
    store.register(get_types_from_msg(names + fields, "rig/msg/States"))
    message = store.types["rig/msg/States"]
    with Writer(path) as bag:
        connection = bag.add_connection("/states", "rig/msg/States", typestore=store)
        if joints:
            effort = np.tanh(4 * RATE) + 0.3 * ANGLE
            for row, time in enumerate(TIME):
                lists = [
                    np.array([0.2 + 1e-4 * row, own])
                    for own in (ANGLE[row], RATE[row], effort[row])
                ]
                data = store.serialize_ros1(message(["base", "elbow"], *lists), "rig/msg/States")
                bag.write(connection, round(time * 1e9), data)
        else:
            for number in range(3):
                at = np.arange(600) + 600 * number + 1.0  # ms
                rate = np.cos(at / 100)
                batch = message(
                    at, np.sin(at / 100) / 10, rate, np.tanh(4 * rate) + 0.1 * np.sin(at / 7)
                )
                bag.write(connection, number * 10**9, store.serialize_ros1(batch, "rig/msg/States"))
    return path


def test_an_angle_in_degrees_and_in_radians_is_one_position_whatever_its_unit_is_called(
    tmp_path: Path,
) -> None:
    path = tmp_path / "leg.csv"
    names = "time,force_feedback,force_desired,position_degrees,position_radians,position_prev"
    columns = (
        TIME,
        np.tanh(4 * RATE) + ANGLE,
        np.tanh(4 * RATE),
        np.degrees(ANGLE),
        ANGLE,
        np.roll(ANGLE, 1),
    )
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=names, comments="", fmt="%.9f")
    plan = planned(path)
    assert not plan.questions
    assert not plan.doubts
    taken = {each.signal: (each.column, each.factor) for each in plan.signals}
    assert taken["position"] == ("position_degrees", pytest.approx(np.pi / 180))
    assert taken["effort"] == ("force_feedback", 1.0)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("omega_radians_per_second", "rad/s"),
        ("angle_degrees", "deg"),
        ("stroke_millimeters", "mm"),
        ("load_newtons", "N"),
        ("time_milliseconds", "ms"),
        ("milliseconds", "ms"),
    ],
)
def test_units_in_words_end_names(name: str, unit: str) -> None:
    assert split_end(name)[1] == unit


@pytest.mark.slow
def test_torques_of_a_compensation_that_is_off_are_not_proposed_beside_those_that_were_measured(
    tmp_path: Path,
) -> None:
    measured = np.tanh(4 * RATE) + 0.3 * ANGLE
    nothing = np.zeros(TIME.size)
    columns = {
        "time": TIME,
        "vel_meas1": RATE,
        "vel_meas2": 0.1 * RATE,
        "tau_fric1": nothing,
        "tau_fric2": nothing,
        "tau_meas1": measured,
        "tau_meas2": 0.1 * measured,
    }
    path = tmp_path / "arm.csv"
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9f")
    plan = planned(path)
    assert "tau_fric" not in str(plan.questions[-1].problem.partition(";")[0])
    assert "--effort" in plan.command()
    assert "tau_meas1" in plan.command()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "is_clock"), [("loop_time", True), ("cycle_time", False)])
def test_a_time_of_the_loop_that_rises_in_each_row_is_the_clock(
    tmp_path: Path, name: str, is_clock: bool
) -> None:
    path = drive_log(tmp_path, name, TIME)
    clock = planned(path).clock
    assert (clock is not None and clock.column == name) == is_clock
    lasted = drive_log(tmp_path, name, np.full(TIME.size, 1e-3) + 1e-5 * np.sin(TIME))
    assert planned(lasted).clock is None


def test_a_time_that_counts_the_rows_of_a_long_log_is_asked_for_its_rate(tmp_path: Path) -> None:
    plan = planned(drive_log(tmp_path, "Time", np.arange(TIME.size)))
    assert plan.doubts == (
        "time is column Time in s, though it has no unit and grows by 1 a row, as ms do",
    )
    assert plan.command().endswith('--rate "RATE Hz"')


def test_mean_times_of_few_points_that_go_back_once_are_asked_about_beside_an_open_speed(
    tmp_path: Path,
) -> None:
    at = np.arange(40.0)
    at[1] = at[0] - 0.02
    speed = np.repeat(np.arange(20.0), 2)
    path = tmp_path / "points.csv"
    columns = (at, speed, 1.1 * speed + 0.01 * np.sin(at), 0.3 * speed**2)
    np.savetxt(path, np.column_stack(columns), delimiter=",", comments="", fmt="%.6f",
               header="Time (s),Motor Electrical Speed (rad/s),Motor Optical Speed (rad/s),Torque (N·m)")  # fmt: skip
    plan = planned(path)
    assert "runs backwards 1 time in 40 rows" in str(plan.questions)
    assert '--slip "Motor Electrical Speed [rad/s]"' in plan.command()
    assert "--time none" in plan.command()


def drive_log(folder: Path, time: str, stamps: np.ndarray) -> Path:
    path = folder / "drive.csv"
    columns = (stamps, RATE, np.tanh(4 * RATE) + 0.3 * ANGLE)
    header = f"{time},velocity,torque"
    np.savetxt(
        path, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.9f"
    )
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "second"), [("motor_speed", "output_speed"), ("w1", "w2"), ("velocity", "rpm")]
)
@pytest.mark.parametrize("swapped", [False, True])
def test_of_two_speeds_the_rate_of_the_one_position_is_taken(
    tmp_path: Path, first: str, second: str, swapped: bool
) -> None:
    other = 3.3 * np.cos(3 * TIME + 0.7) + 0.4 * np.sin(11 * TIME)
    speeds = {first: RATE, second: other} if swapped else {first: other, second: RATE}
    plan = planned(two_speeds(tmp_path, speeds))
    assert {each.signal: each.column for each in plan.signals}["slip"] == (
        first if swapped else second
    )


@pytest.mark.slow
def test_two_speeds_that_are_no_rate_of_the_one_position_are_asked_about(tmp_path: Path) -> None:
    other = 3.3 * np.cos(3 * TIME + 0.7) + 0.4 * np.sin(11 * TIME)
    plan = planned(two_speeds(tmp_path, {"motor_speed": other, "output_speed": np.roll(other, 90)}))
    assert "slip may be any of the columns" in str(plan.questions)
    assert "motor_speed, output_speed;" in str(plan.questions)


def two_speeds(folder: Path, speeds: dict[str, np.ndarray]) -> Path:
    path = folder / "bench.csv"
    columns = {"time": TIME, **speeds, "angle": ANGLE, "torque": np.tanh(4 * RATE) + 0.3 * ANGLE}
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9f")
    return path


@pytest.mark.slow
def test_currents_of_as_many_joints_as_torques_are_no_field(tmp_path: Path) -> None:
    columns = {"time": TIME}
    for joint, size in ((1, 0.1), (2, 1.0), (3, 0.2)):
        rate = size * np.cos((2 + joint) * TIME)
        torque = np.tanh(12 * rate) + 0.3 * rate
        columns |= {f"vel{joint}": rate, f"torque{joint}": torque, f"cur{joint}": torque**3}
    path = tmp_path / "arm.csv"
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9f")
    plan = planned(path)
    assert any("cur1 is what the drive of a joint gets" in note for note in plan.notes)
    assert "--field none" in plan.command()
    assert not plan_of(read_table(path), told_by(plan)).questions


@pytest.mark.slow
def test_the_motion_of_the_joint_goes_with_its_torque_where_the_motor_in_front_of_the_gear_is_logged_too(
    tmp_path: Path,
) -> None:
    measured = np.tanh(4 * RATE) + 0.3 * ANGLE
    columns = {
        "t": TIME,
        "motor_pos": 100 * ANGLE,
        "motor_vel": 100 * RATE,
        "joint_pos": ANGLE,
        "joint_vel": RATE,
    }
    plan = planned(written_csv(tmp_path, columns | {"joint_torque": measured}))
    taken = {each.signal: each.column for each in plan.signals if each.column}
    assert taken == {"slip": "joint_vel", "position": "joint_pos", "effort": "joint_torque"}

    plan = planned(written_csv(tmp_path, columns | {"torque": measured}))
    assert "slip may be any of the columns motor_vel, joint_vel" in str(plan.questions)

    of_motor = {
        "t": TIME,
        "motor_velocity": RATE,
        "spring_torque": measured,
        "motor_torque": measured**3,
    }
    taken = {
        each.signal: each.column
        for each in planned(written_csv(tmp_path, of_motor)).signals
        if each.column
    }
    assert taken == {"slip": "motor_velocity", "effort": "motor_torque"}

    of_cell = {
        "t": TIME,
        "motor_velocity": RATE,
        "load_cell": measured,
        "motor_current": np.abs(measured),
    }
    assert {each.signal: each.column for each in planned(written_csv(tmp_path, of_cell)).signals}[
        "effort"
    ] == "load_cell"


@pytest.mark.slow
def test_what_rostopic_writes_before_each_name_is_no_field(tmp_path: Path) -> None:
    stamps = 1_690_000_000_000_000_000 + (TIME * 1e9).astype(np.int64)
    names = "%time,field.header.seq,field.header.stamp,field.name0,field.position0,field.velocity0,field.effort0"
    effort = np.tanh(4 * RATE) + 0.3 * ANGLE
    lines = [names]
    for row, stamp in enumerate(stamps):
        lines.append(
            f"{stamp},{row},{stamp},elbow,{ANGLE[row]:.9f},{RATE[row]:.9f},{effort[row]:.9f}"
        )
    path = tmp_path / "arm.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    plan = planned(path)
    assert {each.signal: each.column for each in plan.signals} == {
        "field": "",  # not logged: the second stamp repeats the first
        "slip": "velocity0",
        "position": "position0",
        "effort": "effort0",
    }
    assert plan.clock is not None
    assert plan.clock.factor == 1e-9
    assert not plan.questions


@pytest.mark.parametrize(("name", "unit"), [("pos_turns", "turn"), ("vel_turns_s", "turn/s")])
def test_turns_end_names_of_drives(name: str, unit: str) -> None:
    assert split_end(name)[1] == unit


def written_csv(folder: Path, columns: dict[str, np.ndarray]) -> Path:
    path = folder / "log.csv"
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9f")
    return path


@pytest.mark.slow
def test_torques_that_the_drives_of_a_robot_estimate_are_offered_where_none_was_measured(
    tmp_path: Path,
) -> None:
    columns = {"time": TIME}
    measured: list[np.ndarray] = []
    for joint, size in ((0, 0.1), (1, 1.0)):
        rate = size * np.cos((3 + joint) * TIME)
        measured.append(size * (np.tanh(4 * rate / size) + 0.3 * rate))
        angle = size / (3 + joint) * np.sin((3 + joint) * TIME)
        own = {"motor_q": angle, "motor_dq": rate, "motor_tauEst": measured[joint]}
        columns |= {f"{name}_{joint}": values for name, values in own.items()}
    plan = planned(written_csv(tmp_path, columns))
    assert {each.signal: each.column for each in plan.signals if each.column} == {
        "slip": "motor_dq_0",
        "effort": "motor_tauEst_0",
    }
    plan = planned(written_csv(tmp_path, columns | {"tau_0": measured[0], "tau_1": measured[1]}))
    assert plan.signal("effort").column == "tau_0"  # type: ignore[union-attr]
