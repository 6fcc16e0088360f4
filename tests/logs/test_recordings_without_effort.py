"""A prediction asks for no effort, and takes the recording of a file that a fit takes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from openpyxl import Workbook

from erclutch import read
from erclutch.errors import LogError
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.read_logs import read_all

pytestmark = pytest.mark.slow

#: What `erclutch predict` says of the effort, which it does not need.
WITHOUT_EFFORT = ("effort=0 N",)
PLANNED = {"time [s]": 1.0, "velocity [m/s]": 2.0, "current [A]": 0.5}
MEASURED = {"time [s]": 1.0, "velocity [m/s]": 3.0, "current [A]": 0.5, "force [N]": 40.0}


def workbook(path: Path, **sheets: dict[str, float]) -> Path:
    """A workbook of sheets, each with columns that swing as far as is said; the time runs."""
    book = Workbook()
    book.remove(book.worksheets[0])
    time = np.arange(200) * 0.01
    for name, columns in sheets.items():
        sheet = book.create_sheet(name)
        sheet.append([*columns])
        for place, now in enumerate(time):
            swings = [
                far * np.sin(7.0 * now + place_of) for place_of, far in enumerate(columns.values())
            ]
            levels = [
                float(place >= 100) if "current" in each else swing
                for each, swing in zip(columns, swings, strict=True)
            ]
            sheet.append([float(now), *map(float, levels[1:])])
    book.save(path)
    return path


def test_the_recording_is_the_one_that_a_fit_takes(tmp_path: Path) -> None:
    log = workbook(tmp_path / "log.xlsx", Plan=PLANNED, Run=MEASURED)
    fitted = read(log)
    assert any("recording Run: no other" in note for note in fitted.notes)

    predicted = read(log, constant=WITHOUT_EFFORT)

    np.testing.assert_array_equal(predicted.signals["slip"], fitted.signals["slip"])
    assert not predicted.signals["effort"].any()


def test_of_all_recordings_those_are_taken_that_a_fit_takes(tmp_path: Path) -> None:
    log = workbook(tmp_path / "log.xlsx", Plan=PLANNED, Run=MEASURED, Again=MEASURED)
    said = ColumnMap.from_options({"constant": WITHOUT_EFFORT, "variable": "all"})
    names = [recording.name for recording in read_all(log, said)]
    assert names == ["log.xlsx: Run", "log.xlsx: Again"]


def test_a_motion_is_enough_where_no_recording_has_an_effort(tmp_path: Path) -> None:
    note = {"time [s]": 1.0, "ambient [degC]": 20.0}
    log = workbook(tmp_path / "log.xlsx", Room=note, Plan=PLANNED)
    planned = read(log, constant=WITHOUT_EFFORT)
    assert np.abs(planned.signals["slip"]).max() == pytest.approx(2.0, rel=0.01)


def test_of_several_motions_without_effort_the_user_takes_one(tmp_path: Path) -> None:
    other = PLANNED | {"velocity [m/s]": 5.0}
    log = workbook(tmp_path / "log.xlsx", Plan=PLANNED, Other=other)
    with pytest.raises(LogError, match="2 of 2 recordings of the file are logs: Plan, Other"):
        read(log, constant=WITHOUT_EFFORT)
