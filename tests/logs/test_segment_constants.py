"""A signal that was not logged and had another value in each stretch between gaps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import ErclutchError
from erclutch.logs import ColumnMap, read


def log_of(folder: Path) -> Path:
    """Three stretches of 20, 30 and 10 rows at 1 kHz."""
    time = np.concatenate([np.arange(20), 500 + np.arange(30), 900 + np.arange(10)]) * 1e-3
    rows = "".join(f"{t:.3f},{i},{2 * i}\n" for i, t in enumerate(time))
    path = folder / "log.csv"
    path.write_text("t [s],slip [rad/s],effort [N*m]\n" + rows, encoding="utf-8")
    return path


def constant(text: str) -> ColumnMap:
    return ColumnMap.from_dict({"constants": {"field": text}})


def test_one_number_a_segment_in_its_unit(tmp_path: Path) -> None:
    log = read(log_of(tmp_path), constant("0, 250,500 mA"))
    assert log.segments == ((0, 20), (20, 50), (50, 60))
    assert log.units["field"] == "A"
    np.testing.assert_allclose(log.signals["field"], np.repeat([0.0, 0.25, 0.5], [20, 30, 10]))
    assert any("one number a segment" in note for note in log.notes)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0, 1 A", "2 numbers for field and 3 segments"),
        ("0, 1, 2, 3 A", "4 numbers for field and 3 segments"),
        ("0, much, 1 A", "the constant field is"),
        ("0,,1 A", "the constant field is"),
        ("0, 1, 2 kg", "does not fit field"),
    ],
)
def test_numbers_that_do_not_fit(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ErclutchError) as caught:
        read(log_of(tmp_path), constant(text))
    assert said in str(caught.value)


def test_other_names_take_one_number_only(tmp_path: Path) -> None:
    values = {"constants": {"field": "1 A", "temperature": "1, 2, 3"}}
    with pytest.raises(ErclutchError, match="temperature is no signal"):
        read(log_of(tmp_path), ColumnMap.from_dict(values))
