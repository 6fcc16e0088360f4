"""Pairs of columns, the X of a channel and its Y, are a time and a signal, and joined by time. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, apply, plan_of, read_table
from erclutch.logs.table import Table
from erclutch.signals.array import Array

SLOW = np.arange(400) / 200.0
FAST = np.arange(800) / 400.0 + 0.0005
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 100)
SPEED = 5.0 * np.sin(6.0 * SLOW)
TORQUE = (0.3 + 1.7 * CURRENT) * np.tanh(4.0 * SPEED) + 0.02 * SPEED
#: Torque, speed and current, each behind its time.
PAIRS = [SLOW, TORQUE, FAST, 5.0 * np.sin(6.0 * FAST), SLOW, CURRENT]


def table_of(path: Path, names: list[str], columns: list[Array], delimiter: str = ",") -> Table:
    lines = [delimiter.join(names)]
    for row in range(max(map(len, columns))):
        cells = [f"{each[row]:.9g}" if row < len(each) else "" for each in columns]
        lines.append(delimiter.join(cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_table(path)


@pytest.mark.parametrize(
    ("names", "delimiter"),
    [
        (
            "Torque X (s),Torque Y (Nm),Speed X (s),Speed Y (rad/s),Current X (s),Current Y (A)",
            ",",
        ),
        ("Torque_X [s];Torque_Y [Nm];Speed_X [s];Speed_Y [rad/s];I_X [s];I_Y [A]", ";"),
        (
            "X_Value (Torque)\tTorque\tX_Value (Speed)\tSpeed\tX_Value (Current)\tCurrent",
            "\t",
        ),
        ("Torque:X,Torque:Y,Speed:X,Speed:Y,Current:X,Current:Y", ","),
    ],
)
def test_channels_at_times_of_their_own_are_joined_by_time(
    tmp_path: Path, names: str, delimiter: str
) -> None:
    table = table_of(tmp_path / "scope.csv", names.split(delimiter), PAIRS, delimiter)
    plan = plan_of(table, ColumnMap())
    plan.require_sureness()
    recording = apply(plan, table)
    # The speed begins behind the first torque.
    assert recording.rows == SLOW.size - 1
    assert np.allclose(recording.signals["slip"], SPEED[1:], atol=1e-3)
    assert np.allclose(recording.signals["effort"], TORQUE[1:])


def test_channels_that_share_one_time_keep_all_rows(tmp_path: Path) -> None:
    names = ["Force X (s)", "Force Y (N)", "Speed X (s)", "Speed Y (mm/s)"]
    table = table_of(tmp_path / "scope.csv", names, [SLOW, TORQUE, SLOW, SPEED])
    assert [*table.columns] == ["time", "Force", "Speed"]
    assert table.rows == SLOW.size


@pytest.mark.parametrize(
    ("names", "columns"),
    [
        # Components of two vectors.
        (["Force X (N)", "Force Y (N)", "Speed X (m/s)", "Speed Y (m/s)"], PAIRS[:4]),
        (["Force X", "Force Y", "Speed X", "Speed Y"], [TORQUE, TORQUE, SPEED, SPEED]),
        # Curves that were read off a picture.
        (["0 A X", "0 A Y", "1 A X", "1 A Y"], [SLOW, TORQUE, SLOW, 2.0 * TORQUE]),
        (["Torque X", "Torque Y", "Speed X", "Speed Y"], [SLOW**2, TORQUE, SLOW**2, SPEED]),
    ],
)
def test_vectors_and_curves_are_no_channels(
    tmp_path: Path, names: list[str], columns: list[Array]
) -> None:
    table = table_of(tmp_path / "other.csv", names, columns)
    assert "time" not in table.columns
    assert not any(note.startswith("pairs of columns") for note in table.notes)
