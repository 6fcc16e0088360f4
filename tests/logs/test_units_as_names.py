"""Names that end in a unit without a bracket, and columns that are called by their units alone. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, plan_of, read_table
from erclutch.logs.columns.labels import name_columns, own_unit
from erclutch.logs.columns.name_ends import split_end

ROWS = np.arange(600.0)
WAVE = np.sin(ROWS / 20)
FIELD = np.repeat([0.0, 1.0, 0.5, 2.0, 1.5, 0.0], 100)
EFFORT = (1.0 + 4.0 * FIELD) * np.tanh(5.0 * WAVE)


def planned(folder: Path, head: str, columns: list[np.ndarray]) -> Plan:
    """The plan of a file with these names and columns."""
    delimiter = next(sign for sign in ";\t," if sign in head)
    path = folder / "log.csv"
    with path.open("w", encoding="utf-8") as file:
        file.write(f"{head}\n")
        np.savetxt(file, np.column_stack(columns), delimiter=delimiter, fmt="%.8g")
    return plan_of(read_table(path), ColumnMap())


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("stroke_in", "in"),
        ("disp_in", "in"),
        ("travel in", None),  # a blank before a word of two letters
        ("stroke_inches", "in"),
        ("vel_inps", "in/s"),
        ("vel_ips", "in/s"),
        ("velocity_in_s", "in/s"),
        ("speed_in_per_s", "in/s"),
        ("vel_cm_s", "cm/s"),
        ("torque_inlb", "in*lbf"),
        ("torque_in_lbs", "in*lbf"),
        ("load_lbf", "lbf"),
        ("load_pounds", "lbf"),
        ("coil_amps", "A"),
        ("coil amps", "A"),
        ("coilAmps", "A"),
        ("coil_volts", "V"),
        ("time_in_s", "s"),
        ("torque_in", None),
        ("speed_in", None),
        ("position_in", None),
        ("current_in", None),
        ("clamps", None),
        ("ramp", None),
    ],
)
def test_the_end_of_a_name_is_its_unit(name: str, unit: str | None) -> None:
    assert split_end(name)[1] == unit


def test_a_name_keeps_amps_since_it_says_that_it_is_a_current() -> None:
    assert split_end("coil_amps") == ("coil_amps", "A")
    assert own_unit("motor_volts", None, ("V",)) == "V"


def test_a_log_in_inches_and_pounds_is_read_in_them(tmp_path: Path) -> None:
    head = "time_s,stroke_in,load_lbf,coil_amps,temp_F"
    place = -np.cos(ROWS / 20)
    plan = planned(tmp_path, head, [ROWS / 100, place, EFFORT, FIELD, 80.0 + ROWS / 100])
    assert not plan.questions
    units = {each.signal: each.unit for each in plan.signals}
    assert (units["position"], units["effort"], units["field"]) == ("in", "lbf", "A")


@pytest.mark.parametrize(
    ("head", "units"),
    [
        ("s,rpm,A,Nm", ("A", "rpm", "Nm")),
        ("t,rpm,A,Nm", ("A", "rpm", "Nm")),
        ("s;U/min;V;Ncm", ("V", "U/min", "Ncm")),
        ("ms;1/min;mA;Nm", ("mA", "rpm", "Nm")),
        ("[s],[rpm],[A],[Nm]", ("A", "rpm", "Nm")),
        ("s\tmm/s\tA\tkN", ("A", "mm/s", "kN")),
    ],
)
def test_columns_that_are_called_by_their_units_alone_are_told_by_them(
    tmp_path: Path, head: str, units: tuple[str, ...]
) -> None:
    plan = planned(tmp_path, head, [ROWS / 100, WAVE, FIELD, EFFORT])
    assert not plan.questions
    signals = ("field", "slip", "effort")
    chosen = [plan.signal(signal) for signal in signals]
    assert tuple(each.unit for each in chosen if each is not None) == units


def test_a_force_beside_turns_is_asked_about_where_units_are_the_names(tmp_path: Path) -> None:
    plan = planned(tmp_path, "rpm,A,N", [10.0 * WAVE, FIELD, EFFORT])
    assert "makes no power" in " ".join(plan.doubts)


@pytest.mark.parametrize(
    "names", [["x", "A", "N"], ["A", "V", "N"], ["A", "V", "T"], ["N", "rpm", "N"], ["rpm", "I"]]
)
def test_letters_that_may_be_symbols_are_no_units(names: list[str]) -> None:
    _, units, _ = name_columns(names)
    assert units[0] is None
