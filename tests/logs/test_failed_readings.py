"""Words that a logger writes where a reading failed are no numbers, and the rows without them are read. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError, MappingError
from erclutch.logs import read, read_table

TIME = np.arange(200) / 100
VELOCITY = 0.3 * np.sin(10.7 * TIME)
FORCE = 200 * np.tanh(VELOCITY / 0.02)
FAILED = (37, 38, 150)


def written(path: Path, word: str, mark: str = ".") -> Path:
    force = [f"{number:.6f}".replace(".", mark) for number in FORCE]
    for row in FAILED:
        force[row] = word
    speed = [f"{number:.6f}".replace(".", mark) for number in VELOCITY]
    time = [f"{number:.2f}".replace(".", mark) for number in TIME]
    lines = [";".join(row) for row in zip(time, speed, force, strict=True)]
    path.write_text("\n".join(["time [s];velocity [m/s];force [N]", *lines]), encoding="utf-8")
    return path


@pytest.mark.parametrize("mark", [".", ","])
@pytest.mark.parametrize("word", ["ERR", "#VALUE!", "Over Range", "I/O Timeout", "No Data"])
def test_rows_whose_reading_failed_are_left_out(tmp_path: Path, word: str, mark: str) -> None:
    # The file was refused, though its other rows are whole.
    path = written(tmp_path / "log.csv", word, mark)
    log = read(path)
    np.testing.assert_allclose(log.signals["effort"], np.delete(FORCE, FAILED), atol=1e-6)
    assert any(repr(word) in note and "in 3 rows" in note for note in read_table(path).notes)


@pytest.mark.parametrize("word", ["abc", "1.2.3", "ERR 5"])
def test_other_texts_among_numbers_are_refused(tmp_path: Path, word: str) -> None:
    with pytest.raises((LogError, MappingError), match="where a number is expected"):
        read(written(tmp_path / "log.csv", word))


def test_words_of_a_switch_stay(tmp_path: Path) -> None:
    rows = "".join(f"{t:.2f},{'ok' if k % 5 else 'fail'},1\n" for k, t in enumerate(TIME))
    (tmp_path / "log.csv").write_text(f"time,error,speed\n{rows}")
    assert set(read_table(tmp_path / "log.csv").words["error"].words) == {"ok", "fail"}
