"""Exports of tribometers hold steps under each other: each step with a table is a log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, read_all, read_table, recordings_in

NAMES = "Step Time (s)\tTraction Coeff (-)\t\tStep Time (s)\tBall Load (N)\tRolling Speed (mm/s)\tSliding Speed (mm/s)"


def export(steps: int) -> str:
    lines = [
        "MTM999 Test Data File",
        "Lubricant name:\tan oil",
        "",
        "Step 1 started at 01/02/2020 10:00:00",
        "Zero = 0.1",
    ]
    for step in range(2, 2 + steps):
        lines += [
            "",
            f'Step {step} "a step" started at 01/02/2020 10:0{step}:00',
            "Step type\tTIMED\tStep description\tnew",
        ]
        lines += [f"{NAMES}\tTraction Force (N)\tEmpty (N)"]
        for k in range(20):
            slip = step * np.sin(k / 3)
            lines.append(
                f"{k}\t0.05\t\t{k}\t{20 + 0.01 * k:.3f}\t200.0\t{slip:.4f}\t{np.tanh(slip):.5f}\t"
            )
    return "\n".join(
        [*lines, "", "All steps completed, test completed normally at 01/02/2020 11:00"]
    )


@pytest.mark.slow
def test_each_step_with_a_table_is_a_log(tmp_path: Path) -> None:
    path = tmp_path / "steps.txt"
    path.write_text(export(3), encoding="latin-1")
    assert recordings_in(path) == ["Step 2", "Step 3", "Step 4"]
    table = read_table(path, variable="Step 3")
    assert [name for name in table.columns if "Step Time" in name] == ["Step Time"]
    assert "Empty (N)" not in table.labels
    logs = read_all(path, ColumnMap.from_labels({"field": "none"}))
    assert [log.name for log in logs] == [
        "steps.txt: Step 2",
        "steps.txt: Step 3",
        "steps.txt: Step 4",
    ]
    np.testing.assert_allclose(logs[1].signals["slip"], 3e-3 * np.sin(np.arange(20) / 3), atol=1e-7)
    np.testing.assert_allclose(
        logs[1].signals["effort"], np.tanh(3 * np.sin(np.arange(20) / 3)), atol=1e-5
    )


def test_an_export_of_one_step_is_one_log(tmp_path: Path) -> None:
    path = tmp_path / "step.txt"
    path.write_text(export(1), encoding="latin-1")
    assert recordings_in(path) == ["Step 2"]
    assert read_table(path).rows == 20


def test_a_row_with_a_cell_too_many_is_refused(tmp_path: Path) -> None:
    """A tab too many moves all numbers behind it by a column; the last cell was cut off in silence."""
    path = tmp_path / "step.txt"
    lines = export(1).split("\n")
    lines[12] = lines[12].replace("\t200.0", "\t\t200.0").rstrip("\t") + "\t1"
    path.write_text("\n".join(lines), encoding="latin-1")
    with pytest.raises(LogError, match="has 8 cells where 7 are expected"):
        read_table(path)
