"""Prints of tables by pandas and R, times that lasted, and columns that are numbered in place of names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from erclutch.logs import read
from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(150) / 100
SLIP = np.round(20 * np.sin(8 * TIME), 5)
FIELD = np.where(TIME < 0.75, 0.0, 1.0)
TORQUE = np.round((0.3 + 1.5 * FIELD) * np.tanh(2 * SLIP), 5)
FRAME = pd.DataFrame(
    {"time": TIME, "slip [rad/s]": SLIP, "coil current [A]": FIELD, "torque [Nm]": TORQUE}
)


def assert_is_read(path: Path) -> None:
    log = read(path)
    assert log.time == pytest.approx(TIME)
    assert log.signals["slip"] == pytest.approx(SLIP)
    assert log.signals["field"] == pytest.approx(FIELD)
    assert log.signals["effort"] == pytest.approx(TORQUE)


@pytest.mark.slow
@pytest.mark.parametrize("is_index", [True, False])
@pytest.mark.parametrize("lasted", [True, False])
def test_a_print_of_pandas_is_a_table(tmp_path: Path, is_index: bool, lasted: bool) -> None:
    frame = FRAME.assign(time=pd.to_timedelta(TIME, unit="s")) if lasted else FRAME
    frame = frame.set_index("time") if is_index and not lasted else frame
    path = tmp_path / "log.txt"
    path.write_text(frame.to_string())
    assert_is_read(path)


@pytest.mark.slow
def test_a_print_of_r_has_its_time_in_front(tmp_path: Path) -> None:
    lines = ["Time Series:", "Start = c(0, 1)", "End = c(1, 50)", "Frequency = 100"]
    lines.append(f"{'':4} {'slip_rad_s':>10} {'current_A':>9} {'torque_Nm':>9}")
    for t, slip, field, torque in zip(TIME, SLIP, FIELD, TORQUE, strict=True):
        lines.append(f"{t:4.2f} {slip:10.5f} {field:9.1f} {torque:9.5f}")
    path = tmp_path / "log.txt"
    path.write_text("\n".join(lines) + "\n")
    assert_is_read(path)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["pandas", "iso", "index"])
def test_a_time_that_lasted_is_a_clock(tmp_path: Path, form: str) -> None:
    lasted = pd.to_timedelta(TIME, unit="s")
    texts = [f"P0DT0H0M{t:.2f}S" for t in TIME] if form == "iso" else lasted
    path = tmp_path / "log.csv"
    frame = FRAME.assign(time=texts)
    if form == "index":
        frame = frame.set_index("time").rename_axis(None)
    frame.to_csv(path, index=form == "index")
    assert_is_read(path)


@pytest.mark.slow
def test_a_line_that_counts_the_columns_is_no_row(tmp_path: Path) -> None:
    speeds = np.linspace(-50.0, 50.0, 40)
    frame = pd.DataFrame({0: speeds, 1: np.round(0.2 * np.sign(speeds) + 0.004 * speeds, 5)})
    answer = '--time none --field none --slip "c1" --effort "c2"'
    for index in (False, True):
        frame.to_csv(tmp_path / "map.csv", index=index)
        printed = good("inspect", "map.csv", cwd=tmp_path, code=1)
        assert "40 rows" in printed
        assert printed.splitlines()[-1].endswith(answer)


@pytest.mark.slow
def test_a_first_row_that_looks_like_a_count_stays_a_row(tmp_path: Path) -> None:
    rows = [f"{0.01 * k:g},{1 + 0.02 * k:g}" for k in range(40)]
    (tmp_path / "log.csv").write_text("\n".join(["0,1", *rows[1:]]) + "\n")
    assert "40 rows" in good("inspect", "log.csv", cwd=tmp_path, code=1)


@pytest.mark.slow
def test_two_columns_without_names_are_no_time_and_a_signal(tmp_path: Path) -> None:
    """A speed that was raised by steps was proposed as the time; a map has none."""
    speeds = np.linspace(-49.3, 51.0, 40)
    efforts = 0.2 * np.sign(speeds) + 0.004 * speeds
    rows = [f"{speed:.4f} {effort:.5f}" for speed, effort in zip(speeds, efforts, strict=True)]
    (tmp_path / "map.txt").write_text("\n".join(rows) + "\n")
    last = good("inspect", "map.txt", cwd=tmp_path, code=1).splitlines()[-1]
    assert last.endswith('--time none --field none --slip "c1" --effort "c2"')


@pytest.mark.slow
def test_arrays_without_names_are_proposed_by_their_numbers(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", TIME, SLIP, FIELD, TORQUE)
    last = good("inspect", "log.npz", cwd=tmp_path, code=1).splitlines()[-1]
    assert last.endswith('--time "arr_0 [s]" --field "arr_2" --slip "arr_1" --effort "arr_3"')
