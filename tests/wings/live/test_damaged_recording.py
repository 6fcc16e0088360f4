"""A damaged recording of the live loop is refused, or has the names, units, settings and numbers of the whole one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read_table
from erclutch.wings.live.layout import FRAME
from erclutch.wings.live.recording.mcap_file import FrameFile
from erclutch.wings.live.ring import RingInfo

ROWS, CHUNK = 2000, 40


@pytest.mark.slow
@pytest.mark.parametrize("closed", [True, False])
def test_damage_changes_no_name_unit_or_setting(tmp_path: Path, closed: bool) -> None:
    """Half of the damage goes where the description of the messages stands."""
    rng = np.random.default_rng(12)
    frames = np.zeros(ROWS, FRAME)
    frames["seq"], frames["time_ns"] = np.arange(ROWS), 10**12 + 1_000_000 * np.arange(ROWS)
    for name in ("theta", "alpha_dot", "field1", "estimate", "torque"):
        frames[name] = rng.normal(size=ROWS)
    file = FrameFile(
        tmp_path / "whole.mcap", RingInfo(model="fnn-16", digest="ab" * 32, start_ns=10**12)
    )
    for at in range(0, ROWS, CHUNK):
        file.write(frames[at : at + CHUNK])
    file.close()
    whole, intact = (tmp_path / "whole.mcap").read_bytes(), read_table(tmp_path / "whole.mcap")
    source = whole if closed else whole[: whole.rindex(bytes([0x0F, 4, 0, 0, 0, 0, 0, 0, 0]))]
    for k in range(400):
        data = bytearray(source)
        for _ in range(rng.integers(1, 4)):
            data[int(rng.integers(8, 4000 if rng.random() < 0.5 else len(data)))] ^= int(
                rng.integers(1, 256)
            )
        path = tmp_path / f"{k}.mcap"
        path.write_bytes(data)
        try:
            table = read_table(path)
        except LogError:
            continue
        assert table.units == intact.units
        assert table.metadata["erclutch"] == intact.metadata["erclutch"]
        rows = table.columns["seq"].astype(int)
        assert rows.size == ROWS or any("not closed" in note for note in table.notes)
        gaps = int((np.diff(rows) - 1).sum())
        assert [
            note for note in table.notes if note.startswith(f"{gaps} messages are missing")
        ] or not gaps
        for name, values in intact.columns.items():
            assert np.array_equal(table.columns[name], values[rows], equal_nan=True), name
