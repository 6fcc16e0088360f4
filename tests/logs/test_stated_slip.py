"""A speed that no column holds is offered where the header or the file's name states it. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read, read_table
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Plan
from erclutch.logs.planning.whole_plan import plan_of

TIME = np.arange(400) / 100.0
CURRENT = 0.5 * (TIME // 1.0)
TORQUE = 0.3 + 4.0 * CURRENT


def written(folder: Path, name: str, above: str) -> Path:
    path = folder / name
    columns = zip(TIME, CURRENT, TORQUE, strict=True)
    rows = "\n".join(f"{t:.2f},{i:g},{m:.5g}" for t, i, m in columns)
    path.write_text(f"{above}Time (s),Current (A),Torque (Nm)\n{rows}\n", encoding="utf-8")
    return path


def planned(path: Path) -> Plan:
    return plan_of(read_table(path), ColumnMap())


@pytest.mark.parametrize(
    ("name", "above", "stated"),
    [
        ("brake.csv", "# speed: 100 rpm\n", "100 rpm"),
        ("brake.csv", "Drehzahl [1/min];\nSpeed [rad/s]: 12.5\n", "12.5 rad/s"),
        ("brake.csv", "# speed_rpm: 300\n", "300 rpm"),
        ("brake_120rpm.csv", "", "120 rpm"),
        ("brake 20 rad_s.csv", "", "20 rad/s"),
    ],
)
def test_the_one_speed_that_the_file_states_is_offered(
    tmp_path: Path, name: str, above: str, stated: str
) -> None:
    path = written(tmp_path, name, above)
    (question,) = planned(path).questions
    assert question.signal == "slip"
    assert question.option == f'--constant "slip={stated}"'
    log = read(path, constant=[f"slip={stated}"])
    assert log.signals["slip"].size == TIME.size


@pytest.mark.parametrize(
    ("name", "above"),
    [
        ("brake.csv", ""),
        ("brake.csv", "# maximal speed: 100 rpm\n# speed limit: 90 rpm\n"),
        ("brake.csv", "# motor speed: 100 rpm\n# brake speed: 50 rpm\n"),
        ("brake.csv", "# speed: 100\n"),
        ("brake_20rpm_to_50rpm.csv", ""),
    ],
)
def test_no_speed_or_several_or_a_limit_are_not(tmp_path: Path, name: str, above: str) -> None:
    (question,) = planned(written(tmp_path, name, above)).questions
    assert not question.option
