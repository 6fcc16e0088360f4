"""Times of day as loggers write them: milliseconds behind a colon, or without zeros before them. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import ErclutchError
from erclutch.logs import read

pytestmark = pytest.mark.slow

#: ms since 11:59:58; a logger at 100 Hz passes a full second and noon.
MILLISECONDS = [503 + 10 * row for row in range(400)]


def clock(
    of: Callable[[int, int, int, int], str], since: Sequence[int] = MILLISECONDS
) -> list[str]:
    """The times of day in the form of a logger, made of hour, minute, second and millisecond."""
    texts: list[str] = []
    for milliseconds in since:
        seconds = 11 * 3600 + 59 * 60 + 58 + milliseconds // 1000
        hour, rest = divmod(seconds, 3600)
        texts.append(of(hour, rest // 60, rest % 60, milliseconds % 1000))
    return texts


def written(folder: Path, texts: Sequence[str]) -> Path:
    """A log of these times of day; its cells stand between tabs, since a time may hold a comma."""
    rows = [
        f"{text}\t{0.5 * (row % 100 > 50)}\t{np.sin(row / 9):.5f}\t{40 * np.tanh(9 * np.sin(row / 9)):.4f}"
        for row, text in enumerate(texts)
    ]
    path = folder / "log.txt"
    path.write_text("\n".join(["Time\tI [A]\tv [m/s]\tF [N]", *rows, ""]), "utf-8")
    return path


@pytest.mark.parametrize(
    "form",
    [
        lambda h, m, s, ms: f"{h}:{m:02d}:{s:02d}:{ms:03d}",
        lambda h, m, s, ms: f"{h}:{m}:{s}:{ms}",  # without zeros before
        lambda h, m, s, ms: f"2024-03-05 {h:02d}:{m:02d}:{s:02d}:{ms:03d}",
        lambda h, m, s, ms: f"{h:02d}.{m:02d}.{s:02d}.{ms:03d}",
        lambda h, m, s, ms: f"{h:02d}.{m:02d}.{s:02d},{ms:03d}",
        lambda h, m, s, ms: f"{h:02d}:{m:02d}:{s:02d}.{ms}",  # 7 ms is ".7"
        lambda h, m, s, ms: f"{h:02d}:{m:02d}:{s:02d},{ms}",
    ],
)
def test_the_time_of_day_is_read_to_the_millisecond(
    tmp_path: Path, form: Callable[[int, int, int, int], str]
) -> None:
    log = read(written(tmp_path, clock(form)))
    assert log.rows == len(MILLISECONDS)
    assert log.segments == ((0, log.rows),)
    np.testing.assert_allclose(log.time - log.time[0], np.arange(log.rows) / 100, atol=1e-6)


def test_a_share_of_a_second_without_its_zeros_stays_a_share(tmp_path: Path) -> None:
    def shortened(hour: int, minute: int, second: int, milliseconds: int) -> str:
        return f"{hour}:{minute}:{second:02d}.{milliseconds:03d}".rstrip("0").rstrip(".")

    since = [500 + 10 * row for row in range(400)]
    log = read(written(tmp_path, clock(shortened, since)))
    np.testing.assert_allclose(log.time - log.time[0], np.arange(log.rows) / 100, atol=1e-6)


def test_pictures_behind_a_colon_are_no_milliseconds(tmp_path: Path) -> None:
    # Two digits may be pictures of a film, or hundredths of a second.
    texts = clock(lambda h, m, s, ms: f"{h}:{m}:{s:02d}:{ms // 40:02d}")
    with pytest.raises(ErclutchError, match="column Time holds text"):
        read(written(tmp_path, texts))
