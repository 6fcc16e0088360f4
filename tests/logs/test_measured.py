"""The readers on logs that nobody here made."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read

pytestmark = pytest.mark.slow

NEES = {"field": "Y [V]", "slip": "V [cm/s]", "position": "D [cm]", "effort": "F [N]"}
SMOOTHED = {
    "time": 1,
    "columns": {"position": "2 [mm]", "slip": "3 [mm/s]", "effort": "4 [N]"},
    "name_pattern": "{amplitude}mm{frequency}Hz{field}A",
}


def test_the_nees_damper(shared: Path) -> None:
    recording = read(shared / "mr_damper_nees" / "ranran_50_converted.csv", NEES)
    assert recording.rows == 74_068
    assert recording.segments == ((0, 74_068),)
    assert recording.uniform
    assert recording.period == 1 / 3004.8
    assert recording.constants == {"fs": 3004.8}
    assert recording.units == {"field": "V", "slip": "m/s", "position": "m", "effort": "N"}
    assert np.isclose(recording.signals["effort"].min(), -1910, atol=1)
    assert "each row ends in a delimiter: the empty last column is left out" in recording.notes


def test_all_smoothed_logs_by_one_name_pattern(shared: Path) -> None:
    paths = sorted((shared / "mr_damper_utfsm" / "preprocessed").glob("*.txt"))
    recordings = [read(path, SMOOTHED) for path in paths]
    assert len(recordings) == 30
    assert {recording.constants["field"] for recording in recordings} == {0, 0.25, 0.5, 0.75, 1}
    assert {recording.period for recording in recordings} == {1e-3, 5e-3}
    assert all(recording.uniform and len(recording.segments) == 1 for recording in recordings)


def test_daq_exports_with_pauses(shared: Path) -> None:
    folder = shared / "mr_damper_utfsm" / "raw"
    columns = {"position": "CHANNEL0 [cm]", "effort": "CHANNEL1 [980.665 N]"}
    recording = read(folder / "ME5mm3Hz.txt", {"columns": columns, "constants": {"field": "0.5 A"}})
    assert recording.segments == (
        (0, 9300),
        (9300, 17600),
        (17600, 25200),
        (25200, 32400),
        (32400, 39800),
    )
    assert recording.period == 1e-3
    assert (
        "4 gaps in Date/Time (longest 17.5 s after 9.299 s): cut into 5 segments" in recording.notes
    )
    recording = read(
        folder / "15Hz0x5A.txt", {"columns": columns, "name_pattern": "{frequency}Hz{field}A"}
    )
    assert recording.segments == ((0, 48_000),)
