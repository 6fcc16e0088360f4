"""A table with a row for each test is points: its peaks and means are proposed, and no rate of sampling. SYNTHETIC."""

from __future__ import annotations

import shlex
import time
from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read, read_table
from erclutch.logs.columns.sums_of_tests import sum_of_a_test, sums_of
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned

FREQUENCY = np.tile([0.5, 1.0, 2.0, 4.0], 9)  # Hz
AMPLITUDE = np.repeat([5.0, 10.0, 20.0], 12)  # mm
CURRENT = np.tile(np.repeat([0.0, 1.0, 2.0], 4), 3)  # A
SPEED = 2e-3 * np.pi * FREQUENCY * AMPLITUDE  # m/s
PEAK = 200 + 300 * CURRENT + 800 * SPEED  # N


def written(folder: Path, columns: dict[str, Array]) -> Path:
    path = folder / "log.csv"
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, header=",".join(columns), comments="", delimiter=",", fmt="%.6g")
    return path


@pytest.mark.parametrize(
    ("columns", "wanted"),
    [
        (
            {"Amplitude": AMPLITUDE, "Frequency": FREQUENCY, "I": CURRENT, "Fmax": PEAK},
            "--time none --slip 'peak speed' --effort Fmax",
        ),
        (
            {
                "Amplitude [mm]": AMPLITUDE,
                "Freq": FREQUENCY,
                "Current [A]": CURRENT,
                "Peak force [N]": PEAK,
                "Mean force [N]": 0.02 * PEAK,
                "Std force [N]": 0.7 * PEAK,
            },
            "--effort 'Peak force [N]' --slip 'peak speed [mm/s]' --time none",
        ),
        (
            {"v_max [m/s]": SPEED, "I [A]": CURRENT, "F_max [N]": PEAK, "F_min [N]": -PEAK},
            "--effort 'F_max [N]' --slip 'v_max [m/s]' --time none",
        ),
        (
            {"I": CURRENT, "Vpeak": SPEED, "Fpeak": PEAK, "Frms": 0.7 * PEAK},
            "--effort Fpeak --slip Vpeak --time none",
        ),
    ],
)
def test_the_peaks_of_tests_are_proposed_as_points(
    tmp_path: Path, columns: dict[str, Array], wanted: str
) -> None:
    plan = plan_of(read_table(written(tmp_path, columns)), ColumnMap())
    assert any("each row sums up a test" in question.problem for question in plan.questions)
    words = shlex.split(plan.command())[3:]
    pairs = sorted(zip(words[::2], words[1::2], strict=True))
    expected = shlex.split(wanted)
    assert pairs == sorted(zip(expected[::2], expected[1::2], strict=True))


def test_a_peak_speed_is_that_of_a_sine_in_the_unit_of_the_amplitude(tmp_path: Path) -> None:
    columns = {"Amplitude [mm]": AMPLITUDE, "Frequency [Hz]": FREQUENCY}
    path = written(tmp_path, {**columns, "I [A]": CURRENT, "F_max [N]": PEAK})
    log = read(path, slip="peak speed [mm/s]", effort="F_max [N]", time="none")
    assert log.signals["slip"] == pytest.approx(SPEED, rel=1e-5)


def test_where_no_speed_can_be_made_it_is_asked_for() -> None:
    plan = planned({"Freq [Hz]": FREQUENCY, "I [A]": CURRENT, "Mean torque [N*m]": PEAK})
    assert "--time none" in plan.command()
    assert '--slip "COLUMN' in plan.command()


@pytest.mark.parametrize("time_of_log", ["t [s]", "time"])
def test_a_log_with_a_time_is_no_table_of_tests(tmp_path: Path, time_of_log: str) -> None:
    columns = {time_of_log: np.arange(36) / 10, "Amplitude [mm]": AMPLITUDE, "Freq": FREQUENCY}
    path = written(tmp_path, {**columns, "I [A]": CURRENT, "F_max [N]": PEAK})
    assert "peak speed" not in read_table(path).columns


def test_a_log_of_speed_and_force_keeps_its_question_about_the_rate() -> None:
    plan = planned({"v [m/s]": np.sin(np.arange(36.0)), "I [A]": CURRENT, "force [N]": PEAK})
    assert "sums up" not in " ".join(question.problem for question in plan.questions)


@pytest.mark.parametrize(
    ("name", "called", "word"),
    [("Fmax", "F", "max"), ("Peak force", "force", "peak"), ("speed_mean", "speed", "mean")],
)
def test_a_name_says_what_a_test_is_summed_up_by(name: str, called: str, word: str) -> None:
    assert sum_of_a_test(name) == (called, word)


def test_words_that_end_so_sum_up_nothing() -> None:
    assert sums_of(["climax", "max", "stamp", "pump", "torque_std", "format"], "effort") == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a" * 20_000, "max" * 7_000, "a_" * 10_000, "F max " * 4_000])
def test_a_name_of_20_000_letters_is_looked_at_in_no_time(name: str) -> None:
    began = time.process_time()
    sum_of_a_test(name)
    assert time.process_time() - began < 2.0
