"""Of a file that holds several recordings the log of a device is aligned, or the one that the user names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from openpyxl import Workbook

from erclutch.signals.array import Array
from tests.support.command import good, refused

pytestmark = pytest.mark.slow

LATE = 0.123  # s that B's clock shows less than A's


def book(path: Path, columns: dict[str, Array]) -> None:
    """A workbook with a sheet of settings in front of the rows."""
    workbook = Workbook()
    workbook.remove(workbook.worksheets[0])
    settings = workbook.create_sheet("Settings")
    for row in ([name, number] for number, name in enumerate(["name", *"abcdefghijkl"])):
        settings.append(row)
    rows = workbook.create_sheet("Data")
    rows.append([*columns])
    for row in zip(*columns.values(), strict=True):
        rows.append([float(cell) for cell in row])
    workbook.save(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("two")
    rng = np.random.default_rng(1)
    time: Array = 0.005 * np.arange(2000.0)
    speed: Array = np.convolve(rng.standard_normal(2020), np.ones(21) / 5.0, mode="valid")
    torque = np.tanh(speed)
    book(made / "a.xlsx", {"time [s]": time, "speed [rad/s]": speed, "torque [N*m]": torque})
    time_of_b: Array = 0.01 * np.arange(1000.0)
    speed_by_b = np.interp(time_of_b + LATE, time, speed)
    book(made / "b.xlsx", {"time [s]": time_of_b, "speed [rad/s]": speed_by_b})
    both = np.column_stack([time_of_b, speed_by_b])
    header = "time [s],speed [rad/s]"
    np.savetxt(made / "b.csv", both, delimiter=",", header=header, comments="")
    return made


@pytest.mark.parametrize(
    "words",
    [
        ("b.csv",),  # a.xlsx holds one log of a device
        ("b.csv", "--variable", "Data", "none"),
        ("b.xlsx", "--variable", "Data"),
        ("b.xlsx", "--variable", "none", "Data"),
    ],
)
def test_the_recording_is_found_or_named(words: tuple[str, ...], folder: Path) -> None:
    said = good("align", "a.xlsx", *words, "--out", "joined.csv", "--force", cwd=folder)
    (offset,) = [line for line in said.splitlines() if "against" in line]
    assert float(offset.partition("offset ")[2].split()[0]) == pytest.approx(-1e3 * LATE, abs=1.0)


def test_the_option_that_the_error_names_is_one_of_the_command(folder: Path) -> None:
    said = refused("align", "a.xlsx", "b.xlsx", "--out", "new.csv", cwd=folder)
    assert "Choose one, such as --variable Data" in said


def test_three_recordings_of_two_logs_are_refused(folder: Path) -> None:
    words = ("--variable", "Data", "Data", "Data")
    said = refused("align", "a.xlsx", "b.xlsx", *words, "--out", "new.csv", cwd=folder)
    assert said.startswith("error: --variable: more than two values")
