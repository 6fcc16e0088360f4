"""Names and units that stand beside the numbers in a file of arrays: in cells, lines of characters, arrays of texts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, plan_of, read_table

pytestmark = pytest.mark.usefixtures("read_here")

ROWS = 200
TIME = np.arange(ROWS) / 100
MATRIX = np.column_stack([TIME, np.sin(TIME), TIME % 1.0 > 0.5, np.cos(TIME)])
NAMES = ("time", "speed", "current", "torque")
UNITS = ("s", "rpm", "A", "N*m")


def cell(*texts: str) -> np.ndarray[Any, Any]:
    return np.array(texts, object)


@pytest.mark.parametrize(
    ("names", "units"),
    [(NAMES, UNITS), (("t", "n", "I", "T"), UNITS), (NAMES, ("s", "rpm", "A", "-"))],
)
def test_one_cell_names_the_columns_of_a_matrix_and_another_gives_their_units(
    tmp_path: Path, names: tuple[str, ...], units: tuple[str, ...]
) -> None:
    savemat(
        tmp_path / "a.mat", {"Data": MATRIX, "ChannelNames": cell(*names), "Units": cell(*units)}
    )
    table = read_table(tmp_path / "a.mat")
    assert [*table.columns] == [*names]
    wanted = [None if unit == "-" else unit for unit in units]
    assert [table.units[name] for name in names] == wanted


def test_units_are_told_from_names_where_no_name_of_a_variable_tells_them(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"Data": MATRIX, "a": cell(*UNITS), "b": cell(*NAMES)})
    assert read_table(tmp_path / "a.mat").units["speed"] == "rpm"


def test_a_single_cell_of_letters_that_are_units_too_is_of_names(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"Data": MATRIX, "names": cell("t", "w", "A", "T")})
    assert [*read_table(tmp_path / "a.mat").columns] == ["t", "w", "A", "T"]


def test_two_cells_of_names_are_not_chosen_from(tmp_path: Path) -> None:
    other = cell("a one", "b one", "c one", "d one")
    savemat(tmp_path / "a.mat", {"Data": MATRIX, "one": cell(*NAMES), "two": other})
    assert "Data_1" in read_table(tmp_path / "a.mat").columns


def test_lines_of_an_array_of_characters_are_names(tmp_path: Path) -> None:
    lines = np.array(["time (s)   ", "speed (rpm)", "current (A)", "torque (Nm)"])
    savemat(tmp_path / "a.mat", {"Data": MATRIX, "header": lines})
    table = read_table(tmp_path / "a.mat")
    assert [*table.columns] == [*NAMES]
    assert table.units["torque"] == "Nm"


@pytest.mark.parametrize("has_units", [False, True])
def test_arrays_of_texts_name_the_columns_of_a_matrix_of_numpy(
    tmp_path: Path, has_units: bool
) -> None:
    if has_units:
        units = np.array(UNITS)
        np.savez(tmp_path / "a.npz", data=MATRIX, columns=np.array(NAMES), units=units)
    else:
        np.savez(tmp_path / "a.npz", data=MATRIX, columns=np.array(NAMES))
    table = read_table(tmp_path / "a.npz")
    assert [*table.columns] == [*NAMES]
    assert table.units["speed"] == ("rpm" if has_units else None)


@pytest.mark.parametrize("longer", ["current_A", "t", "force_N"])
def test_a_sample_more_at_the_end_of_one_vector_is_left_out_and_no_signal_is(
    tmp_path: Path, longer: str
) -> None:
    signals = {"t": TIME, "v_mm_s": np.sin(TIME), "force_N": np.cos(TIME), "current_A": TIME % 1.0}
    signals[longer] = np.append(signals[longer], 2.0)
    savemat(tmp_path / "a.mat", signals)
    table = read_table(tmp_path / "a.mat")
    assert [*table.columns] == [*signals]
    assert table.rows == ROWS
    assert any("the first 200 of each are taken" in note for note in table.notes)
    assert plan_of(table, ColumnMap()).signal("field") is not None


@pytest.mark.parametrize("length", [20, 1000])
def test_a_current_of_another_length_is_not_left_out_in_silence(
    tmp_path: Path, length: int
) -> None:
    signals = {"t": TIME, "v_mm_s": np.sin(TIME), "force_N": np.cos(TIME)}
    savemat(tmp_path / "a.mat", {**signals, "current_A": np.linspace(0, 2, length)})
    table = read_table(tmp_path / "a.mat")
    with pytest.raises(LogError, match=f"current_A has {length} samples, not 200"):
        plan_of(table, ColumnMap())
    assert plan_of(table, ColumnMap.from_labels({"field": "none"})).signal("effort") is not None


def channel(name: str, unit: str, rate: float, values: Any) -> dict[str, Any]:
    return {"Name": name, "Unit": unit, "SampleRate": rate, "Values": values}


def test_a_rate_in_a_struct_of_settings_is_that_of_the_signals_beside_it(tmp_path: Path) -> None:
    signals = {
        name: {"data": MATRIX[:, place], "unit": unit}
        for place, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True))
        if place
    }
    settings = {"fs": 250.0, "operator": "N. N."}
    savemat(tmp_path / "a.mat", {"daq": {"info": settings, "ch": signals}})
    table = read_table(tmp_path / "a.mat")
    assert [*table.columns] == [*NAMES[1:]]
    clock = plan_of(table, ColumnMap()).clock
    assert clock is not None
    assert clock.period == pytest.approx(1 / 250)


@pytest.mark.parametrize("rates", [(500.0, 500.0), (500.0, 250.0)])
def test_a_rate_of_each_channel_counts_where_all_channels_have_it(
    tmp_path: Path, rates: tuple[float, float]
) -> None:
    channels = [
        channel("speed", "rpm", rates[0], MATRIX[:, 1]),
        channel("torque", "N*m", rates[1], MATRIX[:, 3]),
    ]
    savemat(tmp_path / "a.mat", {"Channels": channels})
    table = read_table(tmp_path / "a.mat")
    is_one = len({*rates}) == 1
    assert table.constants.get("SampleRate") == (rates[0] if is_one else None)
