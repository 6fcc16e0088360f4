"""What loggers and people write above, beside and in place of a header is told apart from rows and names. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, apply, plan_of, read_table
from erclutch.logs.table import Table

_ROWS = [f"{0.01 * row:.2f},{row % 7}.5,{row % 5 - 2}.25" for row in range(40)]


def table_of(tmp_path: Path, lines: Sequence[str], name: str = "log.csv") -> Table:
    path = tmp_path / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_table(path)


@pytest.mark.parametrize(
    "settings",
    [
        ["Calibration,2.71,0.2983", "Offset,0,0", "Units,g,g"],
        ["Range,5,2", "Filter,FLAT,FLAT", "Factor,1.5,2.5", "Label,a,b"],
        ["Serial,4711,4712", "Gain,1,10"],
    ],
)
def test_settings_of_each_channel_above_the_names_are_no_rows(tmp_path: Path, settings: list[str]) -> None:
    table = table_of(tmp_path, [*settings, "Time,CH1,CH2", *_ROWS])
    assert list(table.columns) == ["Time", "CH1", "CH2"]
    assert table.rows == len(_ROWS)


@pytest.mark.parametrize("word", ["Unit", "単位", "Einheit", "Units"])
def test_a_line_that_is_called_unit_gives_the_units_of_the_names_below(tmp_path: Path, word: str) -> None:
    table = table_of(tmp_path, ["Offset,0,0", f"{word},N,mm", "Time(sec),Force,Stroke", *_ROWS])
    assert table.units == {"Time": "sec", "Force": "N", "Stroke": "mm"}


def test_a_line_that_is_called_unit_and_holds_none_gives_none(tmp_path: Path) -> None:
    table = table_of(tmp_path, ["Unit,left,right", "Time(sec),Force,Stroke", *_ROWS])
    assert table.units["Force"] is None


@pytest.mark.parametrize(
    "labels",
    ["0775,,0758,", "a,,b,", '"5 A",,"10 A",', "0.5,,1.5,"],
)
def test_labels_over_pairs_of_x_and_y_name_the_curves(tmp_path: Path, labels: str) -> None:
    rows = [f"{x},{x * x},{x + 0.5},{x * 3}" for x in range(1, 13)]
    table = table_of(tmp_path, [labels, "X,Y,X,Y", *rows])
    first, second = (label.strip('"') for label in labels.split(",")[::2])
    assert list(table.columns) == [first, "c2", second, "c4"]
    assert table.rows == len(rows)


def test_a_row_between_two_headers_is_not_skipped(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="line 3, column t is 't' where a number is expected"):
        table_of(tmp_path, ["t,x,F", "0.00,,1.25", "t,x,F", *_ROWS])


@pytest.mark.parametrize("remarks", ["Press,3140,Release,3120", "Date,2024", "operator: me"])
def test_remarks_beside_the_names_are_left_out(tmp_path: Path, remarks: str) -> None:
    rows = [f"{10 * row},{row % 9}.5" for row in range(30)]
    table = table_of(tmp_path, [f"Displacement,Force,,{remarks}", *rows])
    assert list(table.columns)[:2] == ["Displacement", "Force"]


@pytest.mark.parametrize("unit", ["s", "ms"])
def test_an_oscilloscope_writes_a_unit_alone_over_its_time(tmp_path: Path, unit: str) -> None:
    table = table_of(tmp_path, [f"in {unit},C1 in V,C2 in V", *_ROWS])
    assert table.units == {f"in {unit}": unit, "C1": "V", "C2": "V"}


def log_of(time: str, times: Sequence[str]) -> list[str]:
    rows = [f"{at},{np.sin(0.3 * row):.6f},{0.5 + row % 3}" for row, at in enumerate(times)]
    return [f"{time},speed [rad/s],torque [Nm]", *rows]


@pytest.mark.parametrize(
    ("time", "times"),
    [
        ("t [s]", [f"{0.01 * row:.2f}" for row in range(60)]),
        ("Timestamp", [f"2024-05-06 10:00:{0.1 * row:06.3f}" for row in range(60)]),
        ("time [ms]", [f"{5 * row}" for row in range(60)]),
    ],
)
def test_a_log_whose_newest_row_stands_first_is_turned_round(tmp_path: Path, time: str, times: list[str]) -> None:
    head, *rows = log_of(time, times)
    forward = table_of(tmp_path, [head, *rows], "forward.csv")
    backward = table_of(tmp_path, [head, *rows[::-1]], "backward.csv")
    told = ColumnMap.from_options({"field": "none"})
    right = apply(plan_of(forward, told), forward)
    turned = apply(plan_of(backward, told), backward)
    np.testing.assert_allclose(turned.signals["slip"], right.signals["slip"])
    np.testing.assert_allclose(np.diff(turned.time), np.diff(right.time), atol=1e-9)
    assert any("the rows are turned round" in note for note in turned.notes)
    assert not any("the rows are turned round" in note for note in right.notes)


@pytest.mark.parametrize("other", ["T_on [s]", "delay [s]"])
def test_dates_to_the_second_give_way_to_the_same_time_in_finer_steps(tmp_path: Path, other: str) -> None:
    seconds = [498.8 + 0.01 * row for row in range(300)]
    rows = [
        f"2024-05-06 10:00:{int(at - 490.0):02d},{at:.2f},{row % 2},{np.sin(row):.5f},{row % 3}"
        for row, at in enumerate(seconds)
    ]
    table = table_of(tmp_path, [f"Time,stop [s],{other},speed [rad/s],torque [Nm]", *rows])
    clock = plan_of(table, ColumnMap.from_options({"field": "none"})).clock
    assert clock is not None
    assert clock.column == "stop"
