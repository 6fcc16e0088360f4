"""What a mapping file states is done, told as not used, or refused where it contradicts itself."""

from __future__ import annotations

from pathlib import Path

import pytest

import erclutch
from erclutch.errors import MappingError
from erclutch.logs.mapping import ColumnMap

MAPPING = """time = {column = "time", unit = "s"}
[columns]
slip = {column = "b", unit = "rad/s"}
"""
EFFORT = 'effort = {column = "c", unit = "N*m"}\n'
FIELD = 'field = {column = "a", unit = "A"}\n'


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    rows = (f"{k / 1000},{k % 3},{k % 7 - 3},{k % 5 + 1}" for k in range(60))
    path.write_text("time,a,b,c\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def read(log: Path, text: str) -> erclutch.Recording:
    mapping = log.with_name("mapping.toml")
    mapping.write_text(MAPPING + text, encoding="utf-8")
    return erclutch.read(log, mapping=ColumnMap.from_toml(mapping))


def test_a_scale_that_nothing_takes_is_told(log: Path) -> None:
    """The field is a constant in V: no sensor in V made it."""
    stated = '[constants]\nfield = "2 V"\n[scales]\nfield = "0.5 A/V"\nposition = "2 m/V"\n'
    notes = read(log, EFFORT + stated).notes
    assert "the scale of field, 0.5 A/V, is not used: no column is the field" in notes
    assert "the scale of position, 2 m/V, is not used: no column is the position" in notes
    used = read(log, f'{EFFORT}{FIELD}[scales]\neffort = "2"\n').notes
    assert not any("not used" in note for note in used)


def test_a_factor_is_told_where_it_stands_beside_its_column(log: Path) -> None:
    scaled = EFFORT.replace("}", ", scale = -1000}")
    recording = read(log, FIELD + scaled)
    assert recording.signals["effort"].max() == -1000.0
    told = "effort <- column c [N*m], times 1000, sign turned (mapping.toml)"
    assert told in recording.notes


@pytest.mark.parametrize("column", ['"time"', "1", "-1"])
def test_the_time_is_no_signal(log: Path, column: str) -> None:
    effort = EFFORT.replace('"c"', column)
    with pytest.raises(MappingError, match="column time is both time and effort"):
        read(log, FIELD + effort)


def test_stamps_that_are_not_the_time_may_be_a_signal(log: Path) -> None:
    mapping = log.with_name("mapping.toml")
    timed = MAPPING.replace('time = {column = "time", unit = "s"}', "rate = 1000")
    mapping.write_text(timed + FIELD + EFFORT.replace('"c"', '"time"'), encoding="utf-8")
    assert erclutch.read(log, mapping=ColumnMap.from_toml(mapping)).signals["effort"].max() > 0.0
