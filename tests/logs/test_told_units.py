"""Units that texts beside the columns tell are read: on another sheet, in a first line, in one text. SYNTHETIC."""

from __future__ import annotations

import json
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pyarrow
import pytest
from openpyxl import Workbook
from pyarrow import parquet
from scipy.io import savemat

from erclutch.logs import read, read_table
from erclutch.logs.columns.labels import split_label
from erclutch.logs.readers.declared_attributes import with_declared_names
from erclutch.logs.readers.stated_units import units_of_a_list
from erclutch.logs.readers.told_units import texts_in, units_told
from erclutch.logs.readers.units_on_a_sheet import texts_of_sheet
from tests.logs.test_units_beside_vectors import LOGGED, UNITS, assert_read_in_si
from tests.support.pace import within

pytestmark = pytest.mark.usefixtures("read_here")

ROWS = [[float(cell) for cell in row] for row in zip(*LOGGED.values(), strict=True)]
IN_ORDER = ", ".join(UNITS.values())
MEANINGS = {"t": "time", "I": "coil current", "v": "piston velocity", "F": "damper force"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "listed",
    [
        [["Name", "Unit", "Description"], *([k, u, MEANINGS[k]] for k, u in UNITS.items())],
        [["Column", "Description"], *([k, f"{MEANINGS[k]} [{u}]"] for k, u in UNITS.items())],
        [[k, f"{MEANINGS[k]} in {u}"] for k, u in UNITS.items()],
        [[*UNITS], [*UNITS.values()]],
    ],
)
def test_units_that_another_sheet_lists(tmp_path: Path, listed: list[list[str]]) -> None:
    # They were passed over in silence, and numbers in mm/s and kN taken as logged.
    book = Workbook(write_only=True)
    of_data = book.create_sheet("Data")
    for row in ([*LOGGED], *ROWS):
        of_data.append(row)
    of_channels = book.create_sheet("Channels")
    for row in listed:
        of_channels.append(row)
    book.save(tmp_path / "log.xlsx")
    assert_read_in_si(tmp_path / "log.xlsx")


@pytest.mark.parametrize(
    "head",
    [
        UNITS,
        {"units": UNITS},
        {"type": "header", "units": UNITS, "device": "damper 3"},
        {"columns": [*UNITS], "units": [*UNITS.values()]},
        {"units": IN_ORDER},
    ],
)
def test_units_in_the_first_line_of_json_lines(tmp_path: Path, head: dict[str, Any]) -> None:
    lines = [head, *(dict(zip(LOGGED, row, strict=True)) for row in ROWS)]
    path = tmp_path / "log.jsonl"
    path.write_text("\n".join(map(json.dumps, lines)), encoding="utf-8")
    assert_read_in_si(path)


@pytest.mark.slow
@pytest.mark.parametrize(
    "texts",
    [
        {"units": IN_ORDER},
        {"units": "[ms] [mA] [mm/s] [kN]"},
        {"units": json.dumps(UNITS)},
        {"info": "t in ms, I in mA, v in mm/s, F in kN"},
        {"description": "; ".join(f"{k}: {MEANINGS[k]} [{u}]" for k, u in UNITS.items())},
    ],
)
def test_units_in_one_text(tmp_path: Path, texts: dict[str, str]) -> None:
    arrays: dict[str, Any] = {**LOGGED, **{k: np.array(text) for k, text in texts.items()}}
    np.savez(tmp_path / "log.npz", **arrays)
    savemat(tmp_path / "log.mat", {"log": {**LOGGED, **texts}})
    lists = {name: numbers.tolist() for name, numbers in LOGGED.items()}
    (tmp_path / "log.json").write_text(json.dumps({"about": texts, "data": lists}))
    for name in ("log.npz", "log.mat", "log.json"):
        assert_read_in_si(tmp_path / name)


def test_vectors_of_units_and_names_beside_numpy_arrays(tmp_path: Path) -> None:
    vectors: dict[str, Any] = {**LOGGED, "units": np.array([*UNITS.values()])}
    np.savez(tmp_path / "vectors.npz", **vectors)
    matrix: dict[str, Any] = {"data": np.array(ROWS), "columns": np.array(", ".join(UNITS))}
    np.savez(tmp_path / "matrix.npz", **matrix, units=np.array(IN_ORDER))
    assert_read_in_si(tmp_path / "vectors.npz")
    assert_read_in_si(tmp_path / "matrix.npz")


@pytest.mark.slow
def test_units_of_matlab_descriptions(tmp_path: Path) -> None:
    said = {k: f"{MEANINGS[k]} [{u}]" for k, u in UNITS.items()}
    signals = {k: {"data": LOGGED[k], "description": said[k]} for k in UNITS}
    savemat(tmp_path / "signals.mat", {"data": signals})
    savemat(tmp_path / "beside.mat", {"log": LOGGED, "info": said})
    in_order = np.array([*UNITS.values()], dtype=object)
    savemat(tmp_path / "cell.mat", {"log": {**LOGGED, "units": in_order}})
    for name in ("signals", "beside", "cell"):
        assert_read_in_si(tmp_path / f"{name}.mat")


@pytest.mark.parametrize("across", [False, True])
def test_channels_of_json_beside_their_numbers(tmp_path: Path, across: bool) -> None:
    channels = [{"name": name, "unit": unit} for name, unit in UNITS.items()]
    numbers = [[*column] for column in zip(*ROWS, strict=True)] if across else ROWS
    (tmp_path / "log.json").write_text(json.dumps({"channels": channels, "data": numbers}))
    assert_read_in_si(tmp_path / "log.json")


@pytest.mark.parametrize(
    "above",
    [
        "# units = ms,mA,mm/s,kN\n",
        "# units: ms mA mm/s kN\n",
        "# t - time, ms\n# I - current, mA\n# v - velocity, mm/s\n# F - force, kN\n",
        "# %ECSV 1.0\n" + "".join(f"# - {{name: {k}, unit: {u}}}\n" for k, u in UNITS.items()),
        "# columns:\n" + "".join(f"#   - name: {k}\n#     unit: {u}\n" for k, u in UNITS.items()),
    ],
)
def test_units_in_remarks_and_in_yaml(tmp_path: Path, above: str) -> None:
    lines = [",".join(LOGGED), *(",".join(f"{cell:.12g}" for cell in row) for row in ROWS)]
    (tmp_path / "log.csv").write_text(above + "\n".join(lines))
    assert_read_in_si(tmp_path / "log.csv")


@pytest.mark.parametrize("quote", ["", "'", '"'])
def test_names_that_arff_declares(tmp_path: Path, quote: str) -> None:
    names = ["time_ms", "current_mA", "velocity_mm_s", "force_kN"]
    declared = "".join(f"@ATTRIBUTE {quote}{name}{quote} numeric\n" for name in names)
    rows = "\n".join(",".join(f"{cell:.12g}" for cell in row) for row in ROWS)
    text = f"% a damper\n@relation damper\n\n{declared}\n@data\n{rows}\n"
    (tmp_path / "log.arff").write_text(text)
    assert_read_in_si(tmp_path / "log.arff")
    assert with_declared_names(text)[0].count("\n") == text.count("\n")


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("AI1 (Disp mm)", "AI1 (Disp)", "mm"),
        ("AI2 (Velocity mm/s)", "AI2 (Velocity)", "mm/s"),
        ("AI3 (Load cell, kN)", "AI3 (Load cell)", "kN"),
        ("AI4 (Current A)", "AI4 (Current)", "A"),
        ("AI4 (coil A)", "AI4 (coil A)", None),
        ("Speed (low min)", "Speed (low min)", None),
        ("Force (test 2)", "Force (test 2)", None),
    ],
)
def test_units_behind_words_in_brackets(label: str, name: str, unit: str | None) -> None:
    assert split_label(label) == (name, unit)


def test_units_of_signals_in_the_settings_of_json(tmp_path: Path) -> None:
    signals = [{"id": name, "unit": unit} for name, unit in UNITS.items()]
    samples = [dict(zip(LOGGED, row, strict=True)) for row in ROWS]
    document = {"settings": {"signals": signals}, "samples": samples}
    (tmp_path / "log.json").write_text(json.dumps(document))
    assert_read_in_si(tmp_path / "log.json")


def test_descriptions_of_the_fields_of_parquet(tmp_path: Path) -> None:
    said = [(k, {"description": f"{MEANINGS[k]} [{u}]"}) for k, u in UNITS.items()]
    fields = [pyarrow.field(name, pyarrow.float64(), metadata=of_one) for name, of_one in said]
    table = pyarrow.table([*LOGGED.values()], schema=pyarrow.schema(fields))
    parquet.write_table(table, tmp_path / "log.parquet")
    assert_read_in_si(tmp_path / "log.parquet")


def test_json_in_a_text_and_settings_on_a_sheet() -> None:
    about = json.dumps({"units": {"v": "mm/s", "F": "kN"}})
    assert units_told([*UNITS], texts_in({"meta": about}))[0] == {"v": "mm/s", "F": "kN"}
    settings = [["Parameter", "Value", "Unit"], ["F", "2", "kN"], ["1", "v", "mm/s"]]
    assert [*texts_of_sheet(settings, ["v", "F"])] == [("v unit", "mm/s")]


@pytest.mark.parametrize(
    "said",
    [
        {"units": "A, ms, mm/s, kN"},  # another order
        {"units": "ms, mA, mm/s"},
        {"v": "3 mm/s", "F": "-2 N"},
        {"info": "t [ms], v [mm/s], G [N]"},
        {"info": "v is the velocity"},
        {"v_sensor": "mm/s"},
        {"I": "m a", "F": "s/t"},
    ],
)
def test_texts_that_tell_no_unit(said: dict[str, str]) -> None:
    assert units_told([*UNITS], said.items())[0] == {}


def test_lists_that_do_not_fit_are_told(tmp_path: Path) -> None:
    arrays: dict[str, Any] = {**LOGGED, "units": np.array("mA, ms, mm/s, kN")}
    np.savez(tmp_path / "log.npz", **arrays)
    table = read_table(tmp_path / "log.npz")
    assert not any(table.units.values())
    assert any("do not fit" in note for note in table.notes)
    log = read(tmp_path / "log.npz", time="t [ms]")
    assert log.units["slip"] == "?"


@pytest.mark.parametrize("sign", "[ _,:({")
def test_long_texts_take_no_long_time(sign: str) -> None:
    begin = process_time()
    units_told(["v", "v ("], [("units", sign * 20_000), (sign * 20_000, "v" + sign * 20_000)])
    units_of_a_list([sign * 20_000, "- name: " + sign * 20_000])
    with_declared_names("@relation" + sign * 20_000 + "\n@attribute " + sign * 20_000)
    split_label("AI1 (" + sign * 900 + "x)")
    assert within(process_time() - begin, 0.5)
