"""Lines above the rows state how often samples were taken, in the words of loggers. A sine's frequency does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import read

pytestmark = pytest.mark.usefixtures("read_here")


def _log(folder: Path, *lines: str) -> Path:
    rows = "".join(f"{k % 2},{np.sin(k / 9):.6f},{k % 7}\n" for k in range(200))
    path = folder / "log.csv"
    path.write_text("\n".join([*lines, "field [A],slip [rad/s],effort [N*m]", rows]), "utf-8")
    return path


@pytest.mark.parametrize(
    "line",
    [
        "Sampling: 200 Hz",
        "sampling = 200 Hz",
        "# Sampled at 200 Hz",
        "logged at 200 Hz",
        "DAQ rate: 200 S/s",
        "recording rate: 0.2 kHz",
        "Ts = 5 ms",
        "Ts=0.005",
        "Frequency: 200 Hz",
        "sample frequency: 200 Hz",
    ],
)
def test_a_rate_is_read(tmp_path: Path, line: str) -> None:
    assert read(_log(tmp_path, line)).period == pytest.approx(0.005)


@pytest.mark.parametrize(
    "lines",
    [
        ("Frequency: 2 Hz",),
        ("freq = 0.5",),
        ("Frequency: 15 Hz", "Amplitude: 5 mm"),
        ("Waveform: sine", "Frequency: 20 Hz"),
        ("stroke: 50 mm", "Frequency: 12 Hz"),
    ],
)
def test_the_frequency_of_a_motion_is_no_rate(tmp_path: Path, lines: tuple[str, ...]) -> None:
    """A sine of 2 Hz made rows of 2 Hz, in silence."""
    with pytest.raises(MappingError, match="no sampling rate"):
        read(_log(tmp_path, *lines))


@pytest.mark.parametrize(
    "lines",
    [
        ("Sampling rate: 2000 Hz", "Decimation: 10"),
        ("Sample rate: 2 kHz", "Averaging: 10 samples"),
        ("Sampling time: 8 s",),
    ],
)
def test_a_rate_of_other_rows_and_the_time_of_the_whole_log_are_no_rate(
    tmp_path: Path, lines: tuple[str, ...]
) -> None:
    """Of ten samples one was kept, or the log lasted 8 s: both were taken for the rate of the rows, in silence."""
    with pytest.raises(MappingError, match="no sampling rate"):
        read(_log(tmp_path, *lines))


@pytest.mark.parametrize(
    "lines",
    [
        ("Sample time: 8 s", "Sample rate: 200 Hz"),
        ("Sampling rate: 200 Hz", "Decimation: 1"),
        ("Sample rate: 200 Hz per channel",),
        ("Scan rate: 200 Hz, 3 channels",),
    ],
)
def test_what_stands_beside_a_rate_hides_it_not(tmp_path: Path, lines: tuple[str, ...]) -> None:
    assert read(_log(tmp_path, *lines)).period == pytest.approx(0.005)


def test_a_slow_rate_that_is_called_one_of_samples_is_read(tmp_path: Path) -> None:
    assert read(_log(tmp_path, "sample frequency: 2 Hz")).period == pytest.approx(0.5)


@pytest.mark.parametrize("word", ["NoValue", "no data", "NODATA"])
def test_where_a_logger_has_no_value_it_is_missing(tmp_path: Path, word: str) -> None:
    log = _log(tmp_path, "Sampling: 200 Hz")
    log.write_text(
        log.read_text("utf-8").replace("\n0,0.000000,0\n", f"\n0,0.000000,{word}\n"), "utf-8"
    )
    assert any("1 value missing" in note for note in read(log).notes)


@pytest.mark.parametrize(
    "lines",
    [
        ("Samples: 200", "Duration: 1 s"),
        ("Number of samples = 200", "Measurement time = 1000 ms"),
        ("Anzahl Werte: 200", "Messdauer (s): 1"),
        ("Points: 200", "Test duration: 0.995 s"),  # from the first row to the last
        ("Acquisition: 200 points in 1 s",),
    ],
)
def test_a_count_and_a_duration_make_a_rate(tmp_path: Path, lines: tuple[str, ...]) -> None:
    # --time none was printed, which makes points of the rows.
    assert read(_log(tmp_path, *lines)).period == pytest.approx(0.005)


@pytest.mark.parametrize(
    "lines",
    [
        ("Samples: 201", "Duration: 1 s"),
        ("Samples: 200", "Length: 100 mm"),
        ("Duration: 1 s",),
        ("Samples: 200", "Duration: 1 s", "Test time: 4 s"),
    ],
)
def test_a_count_of_other_rows_makes_no_rate(tmp_path: Path, lines: tuple[str, ...]) -> None:
    with pytest.raises(MappingError, match="no sampling rate"):
        read(_log(tmp_path, *lines))
