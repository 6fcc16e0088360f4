"""Channels of several rates in one table are joined by time; values that a sensor missed are missing as before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read, read_table
from erclutch.logs.clock.channel_times import unwoven
from erclutch.logs.clock.one_time import with_whole_stamps
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from tests.support.command import good

TIME = np.arange(600) / 100
SPEED = np.sin(3 * TIME)
EFFORT = np.tanh(10 * SPEED)
CURRENT = np.repeat([0.0, 0.5, 1.0], 200)


def table(columns: dict[str, Array]) -> Table:
    return Table("a.csv", columns, dict.fromkeys(columns), "0" * 64, path="a.csv")


def woven(late: float = 0.002, every: int = 4) -> Table:
    """Torque and speed in rows of their own, and the current in rows between them, every fourth of them."""
    times = np.concatenate([TIME, TIME[::every] + late])
    order = np.argsort(times, kind="stable")
    holes = np.full(TIME[::every].size, np.nan)
    columns = {
        "time": times,
        "torque": np.concatenate([EFFORT, holes]),
        "velocity": np.concatenate([SPEED, holes]),
        "current": np.concatenate([np.full(TIME.size, np.nan), CURRENT[::every]]),
    }
    return table({name: values[order] for name, values in columns.items()})


def test_channels_in_rows_of_their_own_are_joined_at_the_times_of_the_effort() -> None:
    joined = unwoven(woven())
    time = joined.columns["time"]
    np.testing.assert_array_equal(
        joined.columns["torque"], EFFORT[1:597]
    )  # as far as all channels go
    np.testing.assert_array_equal(joined.columns["velocity"], SPEED[1:597])
    held = CURRENT[::4][np.searchsorted(TIME[::4] + 0.002, time, side="right") - 1]
    np.testing.assert_array_equal(joined.columns["current"], held)
    assert any(
        "2 channels that were sampled at times of their own" in note for note in joined.notes
    )
    assert any("each value held until the next" in note for note in joined.notes)


@pytest.mark.parametrize("every", [2, 5, 20])
def test_a_slow_channel_beside_whole_columns_is_joined_too(every: int) -> None:
    angle = np.full(TIME.size, np.nan)
    angle[::every] = TIME[::every] ** 2
    joined = unwoven(table({"time": TIME, "torque": EFFORT, "angle": angle, "current": CURRENT}))
    assert np.isfinite(joined.columns["angle"]).all()
    last = joined.columns["time"]
    assert (
        np.abs(joined.columns["angle"] - last**2).max() <= (0.01 * every) ** 2
    )  # straight lines between samples


def test_a_slow_effort_is_never_made_up_between_its_samples() -> None:
    effort = np.full(TIME.size, np.nan)
    effort[::2] = EFFORT[::2]
    joined = unwoven(table({"time": TIME, "torque": effort, "velocity": SPEED, "current": CURRENT}))
    np.testing.assert_array_equal(joined.columns["torque"], EFFORT[::2])
    np.testing.assert_allclose(joined.columns["velocity"], SPEED[::2])


@pytest.mark.parametrize("missed", [slice(100, 500), slice(5, 6), slice(0, 595)])
def test_values_that_a_sensor_missed_are_missing_as_before(missed: slice) -> None:
    effort = EFFORT.copy()
    effort[missed] = np.nan
    before = table({"time": TIME, "torque": effort, "velocity": SPEED, "current": CURRENT})
    assert unwoven(before) is before


def test_without_a_time_nothing_is_joined() -> None:
    columns = {name: values for name, values in woven().columns.items() if name != "time"}
    before = table(columns)
    assert unwoven(before) is before


@pytest.mark.slow
def test_a_woven_file_is_understood_at_once(tmp_path: Path) -> None:
    columns = woven().columns
    cells = [
        "" if np.isnan(value) else f"{value:.6g}"
        for row in zip(*columns.values(), strict=True)
        for value in row
    ]
    rows = [",".join(cells[at : at + 4]) for at in range(0, len(cells), 4)]
    (tmp_path / "log.csv").write_text(
        "\n".join(["__time,/joint/torque,/joint/velocity,/brake/current", *rows, ""])
    )
    assert (
        good("inspect", "log.csv", cwd=tmp_path).splitlines()[-1]
        == "Understood. Fit it: erclutch fit log.csv --out RUN"
    )


def test_a_file_with_a_value_missing_is_not_woven(tmp_path: Path) -> None:
    rows = [f"{t:g},{e:.4g},{v:.4g}" for t, e, v in zip(TIME, EFFORT, SPEED, strict=True)]
    rows[50] = f"{TIME[50]:g},,{SPEED[50]:.4g}"
    (tmp_path / "log.csv").write_text("\n".join(["time,torque,velocity", *rows, ""]))
    log = read(tmp_path / "log.csv", field="none")
    assert log.segments == ((0, 50), (50, len(rows) - 1))
    assert any("1 value missing" in note for note in log.notes)


@pytest.mark.parametrize(
    ("seconds", "beyond", "factor"),
    [
        ("header.stamp.sec", "header.stamp.nanosec", 1e9),
        ("stamp_secs", "stamp_nsecs", 1e9),
        ("sec", "nsec", 1e9),
        ("time.sec", "time.usec", 1e6),
    ],
)
def test_seconds_and_what_is_beyond_them_are_one_time(
    seconds: str, beyond: str, factor: float
) -> None:
    stamps = 1.7e9 + TIME * 1.7
    whole = np.floor(stamps)
    columns = {seconds: whole, beyond: np.round((stamps - whole) * factor), "torque": EFFORT}
    made = with_whole_stamps(table(columns))
    assert list(made.columns) == [seconds, "torque"]
    np.testing.assert_allclose(made.columns[seconds], stamps, rtol=0, atol=2e-6)


@pytest.mark.parametrize("beyond", [EFFORT + 2.0, np.arange(600) * 1e7, np.full(600, np.nan)])
def test_other_columns_are_no_part_of_a_stamp(beyond: Array) -> None:
    before = table({"sec": np.floor(TIME), "nsec": beyond, "torque": EFFORT})
    assert with_whole_stamps(before) is before


def parts_of_a_day(seconds: Array, names: str, finer: bool = False) -> Table:
    """The time of day of seconds since midnight in columns of their own, beside the signals."""
    parts = [seconds // 3600 % 24, seconds // 60 % 60, seconds % 60]
    if finer:
        parts = [*parts[:2], np.floor(parts[2]), np.round(parts[2] % 1 * 1000) % 1000]
    columns = dict(zip(names.split(), parts, strict=False))
    return table({**columns, "speed": SPEED, "torque": EFFORT})


NOON = 12 * 3600.0
BEFORE_MIDNIGHT = 24 * 3600.0 - 60.0


@pytest.mark.parametrize("begin", [NOON, BEFORE_MIDNIGHT])
@pytest.mark.parametrize("names", ["Hour Minute Second", "hh mm ss", "Stunde Minute Sekunde"])
def test_hours_minutes_and_seconds_are_one_time(begin: float, names: str) -> None:
    whole = with_whole_stamps(parts_of_a_day(begin + 0.5 * np.arange(600.0), names))
    assert list(whole.columns) == ["time", "speed", "torque"]
    assert whole.units["time"] == "s"
    np.testing.assert_allclose(np.diff(whole.columns["time"]), 0.5)
    assert any("one time of day" in note for note in whole.notes)


def test_milliseconds_beside_whole_seconds_belong_to_the_time() -> None:
    whole = with_whole_stamps(
        parts_of_a_day(NOON + 0.125 * np.arange(600.0), "hour min sec ms", finer=True)
    )
    assert list(whole.columns) == ["time", "speed", "torque"]
    np.testing.assert_allclose(np.diff(whole.columns["time"]), 0.125)


@pytest.mark.parametrize(
    "columns",
    [
        {"min": np.full(600, 3.0), "sec": TIME},  # the least of a minute, and a time
        {"hour": np.full(600, 30.0), "minute": np.full(600, 3.0), "second": TIME},
        {"hour": np.full(600, 3.5), "minute": np.full(600, 3.0), "second": TIME},
        {"hour": np.full(600, 3.0), "minute": np.full(600, 3.0), "second": TIME[::-1]},
        {"hour": np.full(600, np.nan), "minute": np.full(600, 3.0), "second": TIME},
    ],
)
def test_columns_called_so_that_are_no_time_of_day_stay(columns: dict[str, Array]) -> None:
    before = table({**columns, "speed": SPEED, "torque": EFFORT})
    assert list(with_whole_stamps(before).columns) == list(before.columns)


def two_rates(path: Path, head: str, ends: tuple[int, int] = (600, 150)) -> Path:
    """Speed and torque at 100 Hz beside a current at another rate, each behind a time, as spreadsheets hold them."""
    whole, slow = ends
    lines = [head]
    for k in range(max(ends)):
        fast = f"{TIME[k]:.4f},{SPEED[k]:.5f},{EFFORT[k]:.5f}" if k < whole else ",,"
        lines.append(fast + (f",{0.04 * k:.4f},{0.5 * (k // 50)}" if k < slow else ",,"))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    "head",
    [
        "Time [s],Velocity [m/s],Force [N],Time [s],Current [A]",
        "Time1 [s],Velocity [m/s],Force [N],Time2 [s],Current [A]",
        "Force Time [s],Velocity [m/s],Force [N],Current Time [s],Current [A]",
        "t_fast,velocity_m_s,force_N,t_slow,current_A",
    ],
)
def test_channels_of_two_rates_behind_times_of_any_name_are_joined_by_time(
    tmp_path: Path, head: str
) -> None:
    recording = read(two_rates(tmp_path / "log.csv", head))
    inside = TIME <= 0.04 * 149
    np.testing.assert_allclose(recording.signals["effort"], np.round(EFFORT[inside], 5))
    held = 0.5 * (np.floor(TIME[inside] / 0.04 + 1e-6) // 50)
    np.testing.assert_allclose(recording.signals["field"], held)


def test_a_second_stamp_of_the_same_rows_stays_beside_the_first(tmp_path: Path) -> None:
    head = "Time [s],Velocity [m/s],Force [N],Video Time [s],Current [A]"
    path = two_rates(tmp_path / "log.csv", head, (600, 600))
    np.testing.assert_allclose(
        read(path, field="Current [A]").signals["field"], 0.5 * (np.arange(600) // 50)
    )


def test_a_temperature_that_ends_early_is_no_time(tmp_path: Path) -> None:
    path = two_rates(tmp_path / "log.csv", "t [s],Velocity [m/s],Force [N],T1,Current [A]")
    assert "T1" in read_table(path).columns
