"""More names than cells may be those of other columns: what they say is asked about, in one command. SYNTHETIC."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, Plan, apply, plan_of, read_table

ROWS = np.arange(320)
PLACE = np.sin(0.2 * ROWS)
DRAG = 5.0 * np.tanh(4.0 * np.cos(0.2 * ROWS)) + 0.3


def written(path: Path, names: str, stamps: np.ndarray, end: str, mark: str) -> Path:
    rows = (
        mark.join((f"{stamp:.10g}", f"{place:.5f}", f"{drag:.4f}")) + end
        for stamp, place, drag in zip(stamps, PLACE, DRAG, strict=True)
    )
    path.write_text("\n".join([names, *rows, ""]), encoding="utf-8")
    return path


def planned_by(path: Path, command: str) -> Plan:
    words = shlex.split(command)[3:]
    options = dict(zip(words[::2], words[1::2], strict=True))
    told = {name.removeprefix("--"): value for name, value in options.items()}
    return plan_of(read_table(path), ColumnMap.from_options(told))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "stamps", "end", "mark", "unit"),
    [
        ("time, drive_pos, drive_torque, test_pos, test_torque, sensor", ROWS / 100, ",", ",", "s"),
        ("time;angle;torque;speed;current", 1e6 + 4e6 * ROWS, "", ";", "ns"),
        (
            "Time [ms]\tangle [deg]\ttorque [Nm]\ttemperature [C]\tcurrent [A]",
            10.0 * ROWS,
            "",
            "\t",
            "ms",
        ),
    ],
)
def test_the_first_names_are_asked_about_in_one_command(
    tmp_path: Path, names: str, stamps: np.ndarray, end: str, mark: str, unit: str
) -> None:
    path = written(tmp_path / "log.csv", names, stamps, end, mark)
    plan = plan_of(read_table(path), ColumnMap())
    assert len(plan.doubts) == 3
    assert all("may be that of another column" in doubt or unit == "ns" for doubt in plan.doubts)
    with pytest.raises(MappingError, match="may be that of another column"):
        plan.require_sureness()

    settled = planned_by(path, plan.command())
    assert not settled.questions
    assert not settled.doubts
    recording = apply(settled, read_table(path))
    size = {"s": 1.0, "ms": 1e-3, "ns": 1e-9}[unit]
    np.testing.assert_allclose(recording.time, stamps * size, atol=1e-9)
    np.testing.assert_allclose(recording.signals["effort"], np.round(DRAG, 4))


def test_what_was_named_is_taken_and_the_others_stay_in_doubt(tmp_path: Path) -> None:
    path = written(tmp_path / "log.csv", "time,angle,torque,speed,current", ROWS / 100, "", ",")
    plan = planned_by(path, 'erclutch inspect log.csv --effort "torque"')
    assert len(plan.doubts) == 2
    assert not any(doubt.startswith("effort") for doubt in plan.doubts)


@pytest.mark.parametrize(
    "names",
    ["time,angle,torque", "time,angle,torque,", "speed [rad/s],torque [Nm]"],
    ids=["as many", "an empty one more", "fewer"],
)
def test_names_over_as_many_cells_or_fewer_are_as_before(tmp_path: Path, names: str) -> None:
    path = written(tmp_path / "log.csv", names, ROWS / 100, "," * names.endswith(","), ",")
    assert read_table(path).unsure_names == ""


@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("last", ["temperature [C]", "current [A]", "n"])
def test_one_name_more_than_the_cells_of_every_row_is_asked_about(
    tmp_path: Path, last: str, mark: str
) -> None:
    """The rows may lack the angle as well as the last cell: they look the same."""
    names = mark.join(["time [s]", "angle [rad]", "torque [N m]", last])
    path = written(tmp_path / "log.csv", names, ROWS / 100, "", mark)
    table = read_table(path)
    assert "names 4 columns, the rows have 3 cells" in table.unsure_names
    assert table.unsure_names in table.notes
    plan = plan_of(table, ColumnMap())
    assert len(plan.doubts) == 3
    settled = planned_by(path, plan.command())
    assert not settled.doubts
    np.testing.assert_allclose(apply(settled, table).signals["effort"], np.round(DRAG, 4))


@pytest.mark.parametrize("last", ["Comment", "events", "Bemerkung", "备注"])
def test_a_last_column_of_remarks_may_hold_none(tmp_path: Path, last: str) -> None:
    path = written(tmp_path / "log.csv", f"time,angle,torque,{last}", ROWS / 100, "", ",")
    assert read_table(path).unsure_names == ""


def test_a_last_name_that_a_row_has_a_cell_for_stands_over_it(tmp_path: Path) -> None:
    path = written(tmp_path / "log.csv", "time,angle,torque,state", ROWS / 100, "", ",")
    lines = path.read_text(encoding="utf-8").split("\n")
    lines[1] += ",start"
    path.write_text("\n".join(lines), encoding="utf-8")
    assert read_table(path).unsure_names == ""
