"""A text under the name of a workbook is read, and numbers of devices and settings of amplifiers are no signals."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read, read_table
from tests.support.plans_of_columns import planned

ROWS = np.arange(80.0)
TEXT = "t [s]\tspeed [rad/s]\ttorque [N*m]\n" + "".join(
    f"{k / 100}\t{k % 7}\t{k % 5 - 2}\n" for k in range(80)
)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_a_text_under_the_name_of_an_old_workbook_is_read(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "log.xls").write_text(TEXT.replace("t [s]", "t° [s]"), encoding=encoding)
    table = read_table(tmp_path / "log.xls")
    assert table.rows == ROWS.size
    assert "torque" in table.columns


@pytest.mark.parametrize(
    "data", [b"<html><table><tr><td>1</td></tr></table></html>", b"\0\1" * 900]
)
def test_a_page_and_a_damaged_workbook_of_that_name_are_refused(
    tmp_path: Path, read_here: None, data: bytes
) -> None:
    (tmp_path / "log.xls").write_bytes(data)
    with pytest.raises(LogError, match=r"XML or HTML, not a table|no row of numbers"):
        read_table(tmp_path / "log.xls")


def test_the_number_of_a_device_is_no_field() -> None:
    """It was offered in the command that is printed, as the current along an axis is."""
    columns = {"id": ROWS // 20 + 1.0, "angle [deg]": 90.0 * (ROWS % 3), "force": np.sin(ROWS)}
    assert "id" not in " ".join(planned(columns).examples)


def test_the_current_along_an_axis_may_be_whole_numbers_beside_that_across_it() -> None:
    beside = {"id": ROWS // 20 + 1.0, "iq": np.sin(ROWS), "speed": np.sin(ROWS / 3)}
    field = planned(beside | {"torque": np.sin(ROWS)}).signal("field")
    assert field is not None
    assert field.column == "id"


def test_the_gain_of_an_amplifier_is_neither_a_motion_nor_an_effort() -> None:
    columns = {"gain displacement": ROWS % 3 + 0.3, "gain load": ROWS % 2 * 100.0 + 400.0}
    plan = planned(columns | {"sample rate": 0 * ROWS + 20000.0})
    assert not [each.column for each in plan.signals if each.column]


@pytest.mark.slow
@pytest.mark.parametrize(
    "stamp", [lambda second: f"2024-06-03 18:32:{10 + second}", lambda second: f"{second}"]
)
def test_whole_seconds_over_unlike_numbers_of_rows_are_refused_with_the_mean_rate(
    tmp_path: Path, stamp: Callable[[int], str]
) -> None:
    """The steps were called 0 s, below the shortest."""
    counts = [68, 73, 46, 43, 62, 81, 79, 85, 85, 63]
    rows = [
        f"{stamp(second)},{np.sin(k):.4f},{np.cos(k):.4f}"
        for second, count in enumerate(counts)
        for k in range(count)
    ]
    text = "Time,speed [rad/s],torque [N*m]\n" + "\n".join(rows) + "\n"
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    with pytest.raises(LogError, match=r"10 stamps for 685 rows, not evenly.*--rate 76"):
        read(tmp_path / "log.csv")
