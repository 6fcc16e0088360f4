"""Clocks as loggers, spreadsheets and consoles write them: in other signs, or in digits. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path
from time import process_time

import numpy as np
import pandas as pd
import pytest

from erclutch.errors import ErclutchError
from erclutch.logs import read
from erclutch.logs.readers.stamp_signs import in_usual_signs
from erclutch.signals.recording import Recording
from tests.support.pace import within

BEGIN = datetime(2024, 5, 3, 14, 7, 52)
ROWS = 300
STEP = 0.1  # s


def written(path: Path, stamp: Callable[[datetime], str], head: str = "Time") -> Recording:
    """A log whose clock crosses a full minute."""
    lines = [f"{head};Speed [rad/s];Current [A];Torque [Nm]"]
    for row in range(ROWS):
        at = BEGIN + timedelta(seconds=STEP * row)
        speed = 20.0 * np.sin(0.1 * row)
        current = 0.5 * (row // 50 % 3)
        torque = np.tanh(speed / 20.0) * (0.2 + current)
        lines.append(f"{stamp(at)};{speed:.4f};{current:.1f};{torque:.4f}")
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return read(path)


def milliseconds(at: datetime) -> str:
    return f"{at.microsecond // 1000:03d}"


def by(form: str, *, end: str = "") -> Callable[[datetime], str]:
    return lambda at: at.strftime(form) + milliseconds(at) + at.strftime(end)


SIGNS = {
    "20240503_140752_250": by("%Y%m%d_%H%M%S_"),
    "20240503T140752.250": by("%Y%m%dT%H%M%S."),
    "2024-05-03-14-07-52-250": by("%Y-%m-%d-%H-%M-%S-"),
    "May 03, 2024 02:07:52.250 PM": by("%b %d, %Y %I:%M:%S.", end=" %p"),
    "Fri May 03 14:07:52.250 2024": by("%a %b %d %H:%M:%S.", end=" %Y"),
    "3 May 2024 14:07:52.250": by("%d %B %Y %H:%M:%S."),
    "2024年05月03日 14時07分52.250秒": by("%Y年%m月%d日 %H時%M分%S.", end="秒"),
    "2024/05/03 下午 02:07:52.250": by("%Y/%m/%d 下午 %I:%M:%S."),
    "2024-05-03 오후 02:07:52.250": by("%Y-%m-%d 오후 %I:%M:%S."),
    "03/05/2024 14h07m52.250s": by("%d/%m/%Y %Hh%Mm%S.", end="s"),
    "[14:07:52.250]": by("[%H:%M:%S.", end="]"),
    "'14:07:52.250": by("'%H:%M:%S."),
}
DIGITS = {
    "140752.250": (by("%H%M%S."), "Time"),
    "140752250": (by("%H%M%S"), "Time"),
    "240503140752.250": (by("%y%m%d%H%M%S."), "Timestamp"),
    "20240503140752.250": (by("%Y%m%d%H%M%S."), "Time"),
    "HHMMSS": (by("%H%M%S."), "HHMMSS"),
    "UTC": (by("%H%M%S."), "UTC"),
}


@pytest.mark.slow
@pytest.mark.parametrize("written_as", SIGNS)
def test_stamps_in_other_signs_are_a_clock(tmp_path: Path, written_as: str) -> None:
    """Such a log was refused: its time was a text."""
    log = written(tmp_path / "log.csv", SIGNS[written_as])
    assert log.rows == ROWS
    assert len(log.segments) == 1
    assert log.time[-1] - log.time[0] == pytest.approx(STEP * (ROWS - 1), abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("written_as", DIGITS)
def test_a_clock_in_the_digits_of_a_number_goes_on_at_full_minutes(
    tmp_path: Path, written_as: str
) -> None:
    """Read as seconds it jumped by 40 at each full minute, and the log fell into pieces, in silence."""
    stamp, head = DIGITS[written_as]
    log = written(tmp_path / "log.csv", stamp, head)
    assert log.rows == ROWS
    assert len(log.segments) == 1
    assert log.time[-1] - log.time[0] == pytest.approx(STEP * (ROWS - 1), abs=5e-3)


@pytest.mark.parametrize(
    "stamps",
    [
        140_700.0 + STEP * np.arange(ROWS),  # s of a machine that has run for two days
        1e5 + 7.0 * np.arange(ROWS),  # ticks
        np.concatenate([np.arange(150) * STEP, 5000.0 + np.arange(150) * STEP]),  # a pause
    ],
    ids=["seconds", "ticks", "pause"],
)
def test_a_number_of_seconds_is_no_clock_in_digits(tmp_path: Path, stamps: np.ndarray) -> None:
    each = iter(stamps)
    try:
        log = written(tmp_path / "log.csv", lambda _: f"{next(each):.3f}")
    except ErclutchError:
        return  # asked about
    assert log.time[-1] - log.time[0] == pytest.approx(stamps[-1] - stamps[0], rel=1e-6)


@pytest.mark.parametrize("text", ["2024", "A" * 39, "[" * 39, "May " * 9, "1" * 39, "下午" * 19])
def test_other_texts_stay_as_they_are_in_linear_time(text: str) -> None:
    texts = pd.Series([text] * 2000)
    begin = process_time()
    found = in_usual_signs(texts)
    assert within(process_time() - begin, 0.5)
    assert len(found) == len(texts)
