"""Recordings of one file at different rates are joined by time, where the user asks for it."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read, read_table
from erclutch.logs.columns.labels import split_label
from erclutch.logs.readers import hdf5
from erclutch.logs.readers.found_recordings import Found, chosen, joined_by_time

FAST, SLOW = np.arange(1000) / 1000, np.arange(-10, 80) / 100
SPEED = np.sin(9 * FAST)
LEVELS = np.floor(SLOW * 5) % 2
WARM = 20 + SLOW


def groups() -> dict[str, Found]:
    fast = Found(
        {"t": FAST, "speed": SPEED, "torque": SPEED**3},
        {"t": "s", "speed": "rad/s", "torque": "N*m"},
    )
    slow = Found(
        {"time": SLOW, "current": LEVELS, "oil": WARM, "speed": SLOW}, {"time": "s", "current": "A"}
    )
    return {"fast": fast, "slow": slow}


def test_a_command_is_held_and_a_measurement_joined_by_lines() -> None:
    table = chosen(groups(), "fast + slow", "group", "none")
    rows = SLOW[-1] >= FAST
    assert table.rows == int(rows.sum())
    assert list(table.columns) == ["t", "speed", "torque", "current", "oil", "speed (slow)"]
    np.testing.assert_array_equal(table.columns["speed"], SPEED[rows])
    assert set(table.columns["current"]) == {0.0, 1.0}
    np.testing.assert_allclose(table.columns["oil"], 20 + FAST[rows])
    held = LEVELS[np.searchsorted(SLOW, FAST[rows] + 1e-9) - 1]
    assert np.mean(table.columns["current"] == held) > 0.99
    assert "recordings joined at the times of group fast: fast, slow" in table.notes
    assert f"{int((~rows).sum())} rows of fast before or after the others left out" in table.notes
    assert "column current of slow: each value held until the next" in table.notes
    assert table.units["current"] == "A"


def test_the_first_that_is_named_gives_the_rows() -> None:
    table = chosen(groups(), "slow + fast", "group", "none")
    np.testing.assert_array_equal(table.columns["time"], SLOW[SLOW >= 0.0])


def test_the_question_names_the_way_to_join_them() -> None:
    with pytest.raises(LogError, match=r"or join them by time: --variable 'fast \+ slow'"):
        chosen(groups(), None, "group", "none")


@pytest.mark.parametrize("times", [SLOW[::-1].copy(), SLOW + 100, np.zeros(90)])
def test_times_that_do_not_grow_or_meet_are_refused(times: np.ndarray) -> None:
    both = groups()
    both["slow"].columns["time"] = times
    with pytest.raises(LogError, match="no time that"):
        joined_by_time(both, "group")
    del both["slow"].columns["time"]
    with pytest.raises(LogError, match="group slow has no time"):
        joined_by_time(both, "group")


@pytest.mark.parametrize(
    ("label", "unit", "turn", "first"),
    [
        ("angle", "deg", 360.0, 0.0),
        ("angle", "rad", 2 * np.pi, -np.pi),
        ("shaft", "rev", 1.0, 0.0),
        ("position_deg", None, 360.0, -180.0),
        ("position", None, 2 * np.pi, 0.0),
    ],
)
def test_an_angle_that_starts_again_is_joined_over_its_jumps(
    label: str, unit: str | None, turn: float, first: float
) -> None:
    def wrapped(turns: np.ndarray) -> np.ndarray:
        return (turns * turn - first) % turn + first

    two = groups()
    two["slow"] = Found({"time": SLOW, label: wrapped(1.7 * SLOW)}, {"time": "s", label: unit})
    table = chosen(two, "fast + slow", "group", "none")
    joined = table.columns[split_label(label)[0]]
    off = (joined - wrapped(1.7 * FAST[SLOW[-1] >= FAST]) + turn / 2) % turn - turn / 2
    np.testing.assert_allclose(off, 0.0, atol=1e-9 * turn)
    assert np.ptp(joined) <= turn
    assert any("over its jumps after a full turn" in note for note in table.notes)


@pytest.mark.parametrize(("label", "unit"), [("torque", None), ("speed", "deg/s"), ("x", "mm")])
def test_what_is_no_angle_is_joined_by_lines_whatever_its_jumps(
    label: str, unit: str | None
) -> None:
    two = groups()
    saw = (612.0 * SLOW) % 360.0
    two["slow"] = Found({"time": SLOW, label: saw}, {"time": "s", label: unit})
    joined = joined_by_time(two, "group")
    last = [*joined.columns.values()][-1]
    np.testing.assert_allclose(last, np.interp(FAST[SLOW[-1] >= FAST], SLOW, saw))


@pytest.mark.parametrize("delay", [0.0, 0.4])  # s
def test_a_temperature_once_a_second_cuts_no_row_of_a_quick_log(delay: float) -> None:
    time = np.arange(7500) / 1000  # s
    seconds = np.arange(delay, 7.5)
    quick = Found({"t": time, "torque": np.sin(time)}, {"t": "s"})
    slow = Found({"t": seconds, "oil": 20.0 + seconds}, {"t": "s", "oil": "degC"})
    joined = joined_by_time({"quick": quick, "slow": slow}, "group")
    at = np.clip(time, seconds[0], seconds[-1])
    np.testing.assert_allclose(joined.columns["oil"], 20.0 + at)
    (note,) = (note for note in joined.notes if "held" in note)
    assert note.startswith("slow is slow: its first and last value are held")
    assert note.endswith(f"for up to {max(delay, 7.499 - seconds[-1]):.3g} s")


def test_a_slow_channel_that_ends_long_before_still_ends_the_log() -> None:
    time = np.arange(7500) / 1000  # s
    quick = Found({"t": time, "torque": np.sin(time)}, {"t": "s"})
    slow = Found({"t": np.arange(4.0), "oil": np.arange(4.0)}, {"t": "s"})
    joined = joined_by_time({"quick": quick, "slow": slow}, "group")
    assert joined.columns["t"][-1] == pytest.approx(4.0)  # a step behind its last sample
    assert any("3499 rows of quick before or after the others left out" in n for n in joined.notes)


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_file_of_two_rates_is_one_log(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        for name, group in groups().items():
            for label, values in group.columns.items():
                file.create_dataset(f"{name}/{label}", data=values).attrs["unit"] = (
                    group.units.get(label) or ""
                )
    with pytest.raises(LogError, match="join them by time"):
        read_table(path)
    log = read(path, {"slip": "speed"}, variable="fast + slow")
    assert log.units["field"] == "A"
    assert log.period == pytest.approx(1e-3)


def a_group_for_each_signal(path: Path, **attributes: float) -> Path:
    with h5py.File(path, "w") as file:
        for place, (name, unit) in enumerate(
            {"current": "mA", "speed": "rpm", "torque": "N*m"}.items()
        ):
            data = file.create_dataset(f"measurement/{name}/data", data=np.arange(50.0) + place)
            data.attrs["units"] = unit
            data.attrs["dt"] = 0.02
            for key, number in attributes.items():
                data.attrs[key] = number * place
    return path


def test_groups_of_an_hdf5_file_that_hold_one_signal_each_are_one_recording(tmp_path: Path) -> None:
    table = hdf5.find(str(a_group_for_each_signal(tmp_path / "log.h5")), None)
    assert {name: table.units[name] for name in table.columns} == {
        "current": "mA",
        "speed": "rpm",
        "torque": "N*m",
    }
    assert table.sample_period == pytest.approx(0.02)
    assert table.columns["torque"][0] == 2.0


@pytest.mark.slow
def test_signals_that_begin_at_other_times_stay_apart(tmp_path: Path) -> None:
    path = a_group_for_each_signal(tmp_path / "log.h5", t0=1.0)
    with pytest.raises(LogError, match="several recordings"):
        hdf5.find(str(path), None)
    assert list(hdf5.find(str(path), "measurement/speed").columns) == ["data"]


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("with_time", [False, True])
@pytest.mark.parametrize("form", ["text beside", "attribute of the group", "bytes beside"])
def test_a_group_that_holds_a_signal_and_its_unit_gives_the_unit(
    tmp_path: Path, form: str, with_time: bool
) -> None:
    signals = {"speed": (SPEED, "rpm"), "torque": (SPEED**3, "mN*m")}
    if not with_time:
        signals["time"] = (FAST * 1e3, "ms")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, (values, unit) in signals.items():
            group = file.create_group(f"bench/{name}")
            group["data"] = values
            if with_time:
                group["time"] = FAST
            if form == "text beside":
                group["units"] = unit
            elif form == "bytes beside":
                group["unit"] = np.bytes_(unit)
            else:
                group.attrs["Unit"] = unit
    table = read_table(tmp_path / "a.h5")
    assert {name: table.units[name] for name in signals} == {
        name: unit for name, (_, unit) in signals.items()
    }
    np.testing.assert_array_equal(table.columns["torque"], SPEED**3)
