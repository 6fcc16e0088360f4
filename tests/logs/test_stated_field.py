"""A field that no column holds is read from what the file states beside its columns, or asked about; never left out."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from erclutch.errors import MappingError
from erclutch.logs import read, read_all, read_table
from erclutch.logs.columns.levels_in_names import stated_in
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.table import Table
from tests.support.command import good
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(400) / 100
PLACE = np.sin(7 * TIME)
FORCE = np.tanh(20 * np.cos(7 * TIME))
HEADER = "t [s],x [m],F [N]"


def written(path: Path, above: str = "", header: str = HEADER) -> Path:
    rows = "\n".join(f"{t:g},{x:.6g},{f:.6g}" for t, x, f in zip(TIME, PLACE, FORCE, strict=True))
    path.write_text(f"{above}{header}\n{rows}\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("above", "field", "unit"),
    [
        ("Current: 0.5 A\nOperator: me\n", 0.5, "A"),
        ("Coil current [mA]: 250\nOperator: me\n", 0.25, "A"),
        ("Strom: 1.5 A\nSpannung: 12 V\n", 1.5, "A"),  # a voltage beside a current drives it
        ("Voltage: 2 kV\nOperator: me\n", 2000.0, "V"),
        ("field: 0.5 A\nOperator: me\n", 0.5, "A"),
        ("Field: 2 kV/mm\nOperator: me\n", 2e6, "V/m"),
        ("excitation current 0.5 A\nOperator: me\n", 0.5, "A"),
        ("Magnet current (mA),500\nOperator: me\n", 0.5, "A"),
    ],
)
def test_the_header_states_the_field(tmp_path: Path, above: str, field: float, unit: str) -> None:
    log = read(written(tmp_path / "log.csv", above))
    assert np.unique(log.signals["field"]).tolist() == [pytest.approx(field)]
    assert log.units["field"] == unit
    assert any("stated in the file beside its columns" in note for note in log.notes)


@pytest.mark.parametrize(
    "above",
    [
        "Current limit: 5 A\nOperator: me\n",
        "Excitation: 10 V\nOperator: me\n",  # of a load cell
        "Supply voltage: 24 V\nOperator: me\n",
        "Current: high\nOperator: me\n",
        "Motor current: 2 A\nOperator: me\n",
        "Rated current: 3 A\nOperator: me\n",
        "Fuse: 5 A\nOperator: me\n",
        "Range: 10 V\nOperator: me\n",
        "Sample: 3A\nOperator: me\n",
        "Coil resistance: 5 ohm\nOperator: me\n",
        "Duty cycle: 3 min\nOperator: me\n",
    ],
)
def test_numbers_of_instruments_are_no_field(tmp_path: Path, above: str) -> None:
    log = read(written(tmp_path / "log.csv", above))
    assert not np.any(log.signals["field"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "quoted", "field"),
    [
        ("Command: 0.5 A", "Command: 0.5 A", "0.5 A"),
        ("Excitation: 0.5 A", "Excitation: 0.5 A", "0.5 A"),
        ("Set current: 2 A", "Set current: 2 A", "2 A"),  # told to a supply in all rows
        ("Current: 5", "Current: 5", "5"),  # of nobody knows what
        ("B = 0.2 T", "B: 0.2 T", "0.2 T"),
        ("Stromstärke: 0,5 A", "Stromstärke: 0,5 A", "0.5 A"),
        ("PWM duty: 50 %", "PWM duty: 50 %", "50 %"),
        ("Field: 500 V", "Field: 500 V", "500 V"),
        ("Test at I = 0.5 A, 25 C", "Test at I: 0.5 A, 25 C", "0.5 A"),
        ("Notes: coil driven with 0.5 A", "Notes: coil driven with 0.5 A", "0.5 A"),
        ("brake test with 0.5 A in the coil", "brake test with ... in the coil: 0.5 A", "0.5 A"),
        ("0.5 A in the coil", "in the coil: 0.5 A", "0.5 A"),
    ],
)
def test_a_line_that_may_state_the_field_is_quoted_and_asked_about(
    tmp_path: Path, line: str, quoted: str, field: str
) -> None:
    """It was passed over in silence, and logs at several fields were fitted as if all had the same."""
    written(tmp_path / "log.csv", f"{line}\nOperator: me\n")
    printed = good("inspect", "log.csv", cwd=tmp_path, code=1)
    assert f"a line above the rows says '{quoted}'" in " ".join(printed.split())
    answer = f'--constant "field={field}"'
    last = printed.splitlines()[-1]
    assert last.endswith(answer)
    assert "Understood" in good("inspect", "log.csv", *shlex.split(answer), cwd=tmp_path)


@pytest.mark.slow
def test_two_lines_that_may_state_the_field_are_both_quoted(tmp_path: Path) -> None:
    written(tmp_path / "log.csv", "Command: 0.5 A\nB = 0.2 T\n")
    printed = good("inspect", "log.csv", cwd=tmp_path, code=1)
    assert "lines above the rows say 'Command: 0.5 A', 'B: 0.2 T'" in " ".join(printed.split())


def test_two_currents_are_asked_about(tmp_path: Path) -> None:
    with pytest.raises(
        MappingError,
        match=r"any of the numbers that the file states: Current = 0\.5 A, Coil current = 2 A",
    ):
        read(written(tmp_path / "log.csv", "Current: 0.5 A\nCoil current: 2 A\n"))


@pytest.mark.slow
def test_a_column_goes_before_the_header(tmp_path: Path) -> None:
    log = read(written(tmp_path / "log.csv", "Current: 0.5 A\nOperator: me\n"), field="none")
    assert not np.any(log.signals["field"])
    columns = {"t": TIME, "x": PLACE, "F": FORCE, "I": np.repeat([0.0, 1.0], 200)}
    units = {"t": "s", "x": "m", "F": "N", "I": "A"}
    plan = plan_of(
        Table("a.csv", columns, units, "0" * 64, metadata={"Current": "0.5 A"}), ColumnMap()
    )
    field = plan.signal("field")
    assert field is not None
    assert field.column == "I"


@pytest.mark.slow
def test_a_number_of_each_recording_is_its_field(tmp_path: Path) -> None:
    runs = np.empty(3, dtype=object)
    for place in range(3):
        runs[place] = {"I": float(place), "x": PLACE, "F": (1 + place) * FORCE}
    savemat(tmp_path / "runs.mat", {"run": runs, "fs": 100.0})
    last = good("inspect", "runs.mat", "--variable", "all", cwd=tmp_path).splitlines()[-1]
    assert last == "Understood. Fit it: erclutch fit runs.mat --variable all --out RUN"
    logs = read_all(tmp_path / "runs.mat", ColumnMap())
    assert [np.unique(log.signals["field"]).tolist() for log in logs] == [[0.0], [1.0], [2.0]]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "pattern"),
    slow_behind(
        4,
        [
            ("run_2A.csv", "run_{field}A"),
            ("10mm1Hz0x25A.csv", "{n1}mm{n2}Hz{field}A"),
            ("2021-03-04 test 1.5kV.csv", "{n1}-{n2}-{n3} test {field}kV"),
            ("300mA sine.v2.csv", "{field}mA sine.v{n1}"),
            ("2Ampere.csv", "{field:A}Ampere"),
            ("ER_2kVmm.csv", "ER_{field:kV/mm}kVmm"),
            ("brake-2A.csv", "brake-{field}A"),  # the dash parts words
            ("brake_-2A.csv", "brake_{field}A"),
            (
                "brake_12V_0.5A.csv",
                "brake_{n1}V_{field}A",
            ),  # a voltage beside a current is that of the supply
        ],
    ),
)
def test_a_number_in_the_name_of_the_file_is_asked_about(
    tmp_path: Path, name: str, pattern: str
) -> None:
    written(tmp_path / name)
    last = good("inspect", name, cwd=tmp_path, code=1).splitlines()[-1]
    assert last.endswith(f'--name-pattern "{pattern}"')
    log = read(tmp_path / name, name_pattern=pattern)
    assert np.unique(log.signals["field"]).size == 1
    assert not np.any(read(tmp_path / name, field="none").signals["field"])


@pytest.mark.parametrize("name", ["run 3.csv", "A380.csv", "2Axes.csv", "v2.csv", "0A to 1A.csv"])
def test_other_names_state_no_field(tmp_path: Path, name: str) -> None:
    assert not np.any(read(written(tmp_path / name)).signals["field"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("folder", "field", "pattern"),
    slow_behind(
        2,
        [
            ("current_1A", 1.0, "current_{field}A/run{n1}"),
            ("0.5A", 0.5, "{field}A/run{n1}"),
            ("2V_50Hz", 2.0, "{field}V_{n1}Hz/run{n2}"),
            ("test 3, 250mA", 0.25, "test {n1}, {field}mA/run{n2}"),
        ],
    ),
)
def test_a_number_in_the_name_of_the_folder_is_asked_about(
    tmp_path: Path, folder: str, field: float, pattern: str
) -> None:
    (tmp_path / folder).mkdir()
    written(tmp_path / folder / "run1.csv")
    with pytest.raises(MappingError, match="the name of the folder says") as asked:
        read(tmp_path / folder / "run1.csv")
    assert f'--name-pattern "{pattern}"' in asked.value.remedy
    log = read(tmp_path / folder / "run1.csv", name_pattern=pattern)
    assert np.unique(log.signals["field"]).tolist() == [pytest.approx(field)]
    # From inside the folder the command is the same.
    said = good("inspect", "run1.csv", cwd=tmp_path / folder, code=1).splitlines()[-1]
    assert said.endswith(f'erclutch inspect run1.csv --name-pattern "{pattern}"')
    good("inspect", "run1.csv", "--name-pattern", pattern, cwd=tmp_path / folder)


@pytest.mark.slow
def test_so_is_a_number_in_the_name_of_the_folder_above(tmp_path: Path) -> None:
    for current in ("0.5A", "1A"):
        for pace in ("1Hz", "2Hz"):
            (tmp_path / current / pace).mkdir(parents=True)
            log = written(tmp_path / current / pace / "log.csv")
    said = good("inspect", log, cwd=tmp_path, code=1).splitlines()[-1]
    assert said.endswith('--name-pattern "{field}A/{n1}Hz/log"')
    assert set(read(log, name_pattern="{field}A/{n1}Hz/log").signals["field"]) == {1.0}


@pytest.mark.slow
def test_logs_of_one_name_are_told_apart_by_the_folders_above(tmp_path: Path) -> None:
    for current, size in (("0.5A", 1.0), ("1A", 3.0)):
        for pace in ("1Hz", "2Hz"):
            (tmp_path / current / pace).mkdir(parents=True)
            rows = zip(TIME, PLACE, size * FORCE, strict=True)
            text = "\n".join(f"{t:g},{x:.6g},{f:.6g}" for t, x, f in rows)
            (tmp_path / current / pace / "log.csv").write_text(f"{HEADER}\n{text}\n")
    logs = sorted(tmp_path.glob("*/*/log.csv"))
    said = good("inspect", *logs, cwd=tmp_path, code=1).splitlines()[-1]
    assert said.endswith('--name-pattern "{field}A/{n1}Hz/log"')


@pytest.mark.parametrize("folder", ["run 5", "v2", "brake_A", "2024-05-01", "5V_12V_rails"])
def test_other_names_of_folders_state_no_field(tmp_path: Path, folder: str) -> None:
    (tmp_path / folder).mkdir()
    log = read(written(tmp_path / folder / "run1.csv"))
    assert np.unique(log.signals["field"]).tolist() == [0.0]


def test_the_name_of_the_file_goes_before_that_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "12V").mkdir()
    with pytest.raises(MappingError, match="the name of the file says"):
        read(written(tmp_path / "12V" / "brake_0.5A.csv"))


@pytest.mark.parametrize(
    ("line", "amperes"),
    [
        ('"Coil current",0.5,"A"', 0.5),
        ("Coil current;0,5;A", 0.5),
        ("Coil current\t500\tmA", 0.5),
        ('"I",2,"A"', 2.0),
    ],
)
def test_a_field_in_the_cells_of_a_header_is_not_passed_over(
    tmp_path: Path, line: str, amperes: float
) -> None:
    log = read(written(tmp_path / "a.csv", f'"Operator","Me"\n{line}\n'))
    assert (log.units["field"], set(log.signals["field"])) == ("A", {amperes})


MOTION_AT_FIELDS = np.sin(np.arange(300) / 15)


@pytest.mark.slow
def test_efforts_whose_names_differ_by_the_field_are_logs_at_these_fields(tmp_path: Path) -> None:
    columns = [
        np.arange(300) / 100,
        MOTION_AT_FIELDS,
        *(MOTION_AT_FIELDS * (1 + amps) for amps in (0.0, 0.5, 1.0)),
    ]
    head = "Time (s),Displacement (mm),F_0A (N),F_0.5A (N),F_1.0A (N)"
    log = tmp_path / "wide.csv"
    np.savetxt(log, np.column_stack(columns), delimiter=",", header=head, comments="")
    plan = plan_of(read_table(log), ColumnMap())
    assert plan.command().endswith("--variable all")
    fields = [
        recording.signals["field"][0] for recording in read_all(log, ColumnMap(variable="all"))
    ]
    assert fields == [0.0, 0.5, 1.0]
    one = read(log, effort="F_0.5A")
    assert set(one.signals["field"]) == {0.5}
    assert one.units["field"] == "A"


@pytest.mark.slow
def test_sheets_whose_names_differ_by_the_field_are_logs_at_these_fields(tmp_path: Path) -> None:
    log = tmp_path / "sheets.xlsx"
    with pd.ExcelWriter(log) as book:
        for name, amps in (("0A", 0.0), ("0p5A", 0.5), ("1 A", 1.0)):
            rows = {"Time (s)": np.arange(300) / 100, "Displacement (mm)": MOTION_AT_FIELDS}
            pd.DataFrame({**rows, "Force (N)": MOTION_AT_FIELDS * (1 + amps)}).to_excel(
                book, sheet_name=name, index=False
            )
    logs = read_all(log, ColumnMap(variable="all"))
    assert [recording.signals["field"][0] for recording in logs] == [0.0, 0.5, 1.0]
    without = read_all(log, ColumnMap.from_labels({"field": "none"}, variable="all"))
    assert [recording.signals["field"][0] for recording in without] == [0.0, 0.0, 0.0]
    with pytest.raises(
        MappingError, match=r"the name of the recording says 0.5 A.*--constant \"field=0.5 A\""
    ):
        read(log, variable="0p5A")
    assert set(read(log, variable="0p5A", constant=["field=0.5 A"]).signals["field"]) == {0.5}


@pytest.mark.slow
def test_sheets_with_a_current_of_their_own_keep_it(tmp_path: Path) -> None:
    log = tmp_path / "sheets.xlsx"
    with pd.ExcelWriter(log) as book:
        for name, amps in (("1A", 0.9), ("2A", 1.8)):
            rows = {
                "Time (s)": np.arange(300) / 100,
                "Displacement (mm)": MOTION_AT_FIELDS,
                "Current (A)": amps,
            }
            pd.DataFrame({**rows, "Force (N)": MOTION_AT_FIELDS}).to_excel(
                book, sheet_name=name, index=False
            )
    assert [log.signals["field"][0] for log in read_all(log, ColumnMap(variable="all"))] == [
        0.9,
        1.8,
    ]


@pytest.mark.parametrize(
    ("name", "number", "unit"),
    [
        ("F_0.5A", 0.5, "A"),
        ("damper_0p5A", 0.5, "A"),
        ("0x25A", 0.25, "A"),
        ("F 100 mT", 100.0, "mT"),
        ("amp5A", 5.0, "A"),
    ],
)
def test_a_name_holds_a_field(name: str, number: float, unit: str) -> None:
    stated = stated_in(name)
    assert stated is not None
    assert (stated.number, stated.unit) == (number, unit)


@pytest.mark.parametrize("name", ["joint2", "F_1A_2A", "2Axis", "run 5", "0.5Nm"])
def test_a_name_without_one_field_holds_none(name: str) -> None:
    assert stated_in(name) is None


@pytest.mark.parametrize(
    ("name", "field", "unit"), [("I_A", 1.2, "A"), ("I_mA", 1.2e-3, "A"), ("U_kV", 1200.0, "V")]
)
def test_a_letter_and_its_unit_beside_vectors_is_the_field(
    tmp_path: Path, name: str, field: float, unit: str
) -> None:
    savemat(tmp_path / "a.mat", {"t": TIME, "x_m": PLACE, "F_N": FORCE, name: 1.2})
    log = read(tmp_path / "a.mat")
    assert log.signals["field"][0] == pytest.approx(field)
    assert log.units["field"] == unit
