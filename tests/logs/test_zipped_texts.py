"""Archives of text logs: each text is a recording. SYNTHETIC."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import LogError, SeveralRecordingsError
from erclutch.logs import read, read_table
from erclutch.logs.log_file import recordings_in
from erclutch.logs.log_reader import log_suffixes, may_be_log, reader_of

STAMPS = np.arange(200) / 100.0
SPEED = np.round(8.0 * np.sin(5.0 * STAMPS), 4)
TORQUE = np.round(np.tanh(SPEED), 5)
LOG = "time [s],speed [rad/s],torque [N m]\n" + "".join(
    f"{time:g},{speed:g},{torque:g}\n"
    for time, speed, torque in zip(STAMPS, SPEED, TORQUE, strict=True)
)


def packed(path: Path, **texts: str) -> Path:
    """An archive with the texts by their names, "__" for a slash and "_csv" for an ending."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in texts.items():
            archive.writestr(name.replace("__", "/").replace("_csv", ".csv"), text)
    return path


@pytest.mark.parametrize("name", ["log.zip", "log.ZIP", "download"])
def test_the_only_text_is_read_as_it_is_alone(tmp_path: Path, name: str) -> None:
    alone = tmp_path / "run_csv"
    alone.with_suffix(".csv").write_text(LOG, encoding="utf-8")
    of_archive = read(packed(tmp_path / name, run_csv=LOG), field="none")
    itself = read(alone.with_suffix(".csv"), field="none")
    for signal, values in itself.signals.items():
        np.testing.assert_array_equal(of_archive.signals[signal], values)
    np.testing.assert_array_equal(of_archive.time, itself.time)
    assert any("run.csv in the archive" in note for note in of_archive.notes)


def test_each_of_several_texts_is_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "log.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.mkdir("day") if hasattr(archive, "mkdir") else archive.writestr("day/", "")
        archive.writestr("day/first.csv", LOG)
        archive.writestr("day/second.csv", LOG.replace("0.01,", "0.011,"))
        archive.writestr("day/notes.pdf", "no log")
        archive.writestr("__MACOSX/day/._first.csv", "of macOS")
    assert recordings_in(path) == ["day/first.csv", "day/second.csv"]
    with pytest.raises(SeveralRecordingsError, match="several recordings"):
        read_table(path)
    table = read_table(path, variable="day/second.csv")
    assert table.columns["time"][1] == 0.011
    assert "left out of the archive, no text: day/notes.pdf" in table.notes


def test_other_archives_and_folders_are_as_before(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", time=STAMPS, speed=SPEED, torque=TORQUE)
    plugin, _ = reader_of((tmp_path / "log.npz").read_bytes()[:1024], ".npz")
    assert plugin.name == "numpy-arrays"
    assert read_table(tmp_path / "log.npz").rows == 200
    assert not may_be_log(packed(tmp_path / "log.zip", run_csv=LOG), log_suffixes())
    with pytest.raises(LogError, match="a zip archive"):
        read_table(packed(tmp_path / "other.zip", picture=LOG, run_csv=LOG))


@pytest.mark.slow
def test_a_workbook_is_no_archive_of_texts(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["time [s]", "speed [rad/s]", "torque [N m]"])
    for row in np.column_stack((STAMPS, SPEED, TORQUE)).tolist():
        book.active.append(row)
    book.save(tmp_path / "log.xlsx")
    plugin, _ = reader_of((tmp_path / "log.xlsx").read_bytes()[:1024], ".xlsx")
    assert plugin.name == "spreadsheet"
    assert read_table(tmp_path / "log.xlsx").rows == 200


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    twice = tmp_path / "twice.zip"
    with zipfile.ZipFile(twice, "w") as archive:
        archive.writestr("run.csv", LOG)
        with pytest.warns(UserWarning, match="Duplicate name"):
            archive.writestr("run.csv", LOG)
    with pytest.raises(LogError, match=r"holds two files run\.csv"):
        read_table(twice)

    locked = packed(tmp_path / "locked.zip", run_csv=LOG)
    data = bytearray(locked.read_bytes())
    data[6] |= 1  # flags in front of the part, and in the directory behind
    data[data.index(b"PK\x01\x02") + 8] |= 1
    locked.write_bytes(data)
    with pytest.raises(LogError, match=r"run\.csv is encrypted"):
        read_table(locked)

    with pytest.raises(LogError) as refused:
        read_table(packed(tmp_path / "words.zip", run_csv="no numbers\n"))
    assert str(refused.value).startswith("words.zip, run.csv: ")

    tables = packed(tmp_path / "tables.zip", run_csv=f"{LOG}\n\n{LOG}")
    with pytest.raises(LogError, match=r"run\.csv.*Unpack it"):
        read_table(tables)


@pytest.mark.slow
def test_a_bomb_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    bomb = packed(tmp_path / "bomb.zip", run_csv="0," * (50 << 20))
    assert bomb.stat().st_size < 1 << 20
    with pytest.raises(LogError, match="unpacks to more than"):
        read_table(bomb)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(
    places=st.lists(st.tuples(st.integers(0, 5000), st.integers(0, 255)), min_size=1, max_size=4)
)
def test_a_damaged_archive_is_refused_or_gives_the_same_numbers(
    tmp_path_factory: pytest.TempPathFactory, places: list[tuple[int, int]]
) -> None:
    path = packed(tmp_path_factory.mktemp("damaged") / "log.zip", run_csv=LOG)
    data = bytearray(path.read_bytes())
    for place, value in places:
        data[place % len(data)] = value
    path.write_bytes(data)
    try:
        table = read_table(path)
    except LogError:
        return
    np.testing.assert_array_equal(table.columns["torque"], TORQUE)
