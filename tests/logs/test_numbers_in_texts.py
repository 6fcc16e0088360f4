"""Numbers that a DataFrame, Parquet, Feather or JSON holds as texts are read, or asked about. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from erclutch.errors import ErclutchError, LogError
from erclutch.logs import ColumnMap, read, table_of_log
from erclutch.logs.readers.numbers_in_texts import numbers_in_texts
from erclutch.signals.recording import Recording

ROWS = np.arange(300)
FRAME = pd.DataFrame(
    {
        "Time [s]": ROWS / 100.0,
        "Speed [rpm]": np.round(50.0 * np.sin(ROWS / 20.0), 4),
        "Current [A]": 0.5 * (ROWS // 50 % 3),
        "Torque [Nm]": np.round(np.tanh(np.sin(ROWS / 20.0)) * (0.2 + 0.5 * (ROWS // 50 % 3)), 4),
    }
)
WRITERS: dict[str, Callable[[pd.DataFrame, Path], Any]] = {
    "parquet": lambda frame, path: frame.to_parquet(path),
    "feather": lambda frame, path: frame.to_feather(path),
    "jsonl": lambda frame, path: frame.to_json(path, orient="records", lines=True),
    "json": lambda frame, path: frame.to_json(path, orient="records"),
}
KINDS = ["frame", *WRITERS]


def read_as(kind: str, frame: pd.DataFrame, folder: Path) -> Recording:
    if kind == "frame":
        return read(frame)
    path = folder / f"log.{kind}"
    WRITERS[kind](frame, path)
    return read(path)


def with_texts(column: str, written: Callable[[float], str]) -> pd.DataFrame:
    texts = [written(value) for value in FRAME[column]]
    return FRAME.assign(**{column: pd.Series(texts, dtype=object)})


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("column", ["Time [s]", "Speed [rpm]", "Current [A]", "Torque [Nm]"])
def test_decimal_commas_are_numbers(kind: str, column: str, tmp_path: Path) -> None:
    """A current in such texts was left out, and the log was read as one without a field."""
    log = read_as(
        kind, with_texts(column, lambda value: f"{value:.4f}".replace(".", ",")), tmp_path
    )
    plain = read_as(kind, FRAME, tmp_path)
    assert log.units == {"field": "A", "slip": "rad/s", "effort": "N*m"}
    assert log.period == pytest.approx(0.01)
    for signal in log.signals:
        assert log.signals[signal] == pytest.approx(plain.signals[signal], abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_units_in_the_cells_and_switches_are_read(kind: str, tmp_path: Path) -> None:
    log = read_as(kind, with_texts("Current [A]", lambda value: f"{1e3 * value:.0f} mA"), tmp_path)
    assert log.signals["field"].max() == pytest.approx(1.0)
    switch = with_texts("Current [A]", lambda value: "ON" if value else "OFF")
    assert set(read_as(kind, switch, tmp_path).signals["field"]) == {0.0, 1.0}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("column", ["Speed [rpm]", "Torque [Nm]"])
def test_a_signal_of_words_is_named_in_the_error(kind: str, column: str, tmp_path: Path) -> None:
    """The error said that there is no such column, and not that one holds words."""
    words = with_texts(column, lambda value: "low" if value < 0 else "mid" if value < 1 else "hi")
    with pytest.raises(LogError, match=column.split(" ")[0]) as error:
        read_as(kind, words, tmp_path)
    assert "called like the" in str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_mark_that_nobody_can_tell_is_asked_about(kind: str, tmp_path: Path) -> None:
    doubtful = with_texts("Torque [Nm]", lambda value: f"{100 + abs(value):.0f},250")
    with pytest.raises(ErclutchError, match=r"Torque.*100,250"):
        read_as(kind, doubtful, tmp_path)


def test_a_column_that_tells_no_mark_takes_that_of_the_others() -> None:
    three = pd.Series(["1,500", "2,250"] * 20)
    sure = pd.Series(["0,5", "1,25"] * 20)
    assert numbers_in_texts({"a": three, "b": sure}).columns["a"][0] == 1.5
    assert "1,500" in numbers_in_texts({"a": three}).unreadable["a"]
    assert numbers_in_texts({"a": three}, ",").columns["a"][0] == 1.5
    assert numbers_in_texts({"a": three}, ".").columns["a"][0] == 1500.0


def test_last_rows_in_thousands_below_a_decimal_comma(tmp_path: Path) -> None:
    """The last rows read as whole numbers, 700,123, and the first row, 0,000, as no number: the file was refused."""
    torque = [0.0, *np.linspace(100.0, 700.0, 299)]
    rows = [
        f"{row}\t{value:.3f}\t{row / 10:.3f}".replace(".", ",")
        for row, value in zip(ROWS, torque, strict=True)
    ]
    path = tmp_path / "log.txt"
    path.write_text("\n".join(["row\tTorque [Nm]\tSpeed [rad/s]", *rows, ""]), encoding="utf-8")
    log = read(path, rate=100.0, field="none")
    assert log.signals["effort"].max() == pytest.approx(700.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("decimal", "first"), [(",", 1.5), (".", 1500.0)])
def test_a_mark_that_the_user_names_is_taken(
    kind: str, decimal: str, first: float, tmp_path: Path
) -> None:
    frame = with_texts("Current [A]", lambda value: f"{1.5 + value:.3f}".replace(".", ","))
    path = tmp_path / f"log.{kind}"
    if kind == "frame":
        log = read(frame, decimal=decimal)
    else:
        WRITERS[kind](frame, path)
        log = read(path, decimal=decimal)
    assert log.signals["field"][0] == first


@pytest.mark.parametrize("name", ["Current [A]", "Current"])
def test_two_columns_of_texts_with_one_name_are_both_kept(name: str) -> None:
    """The last alone was kept, in silence."""
    frame = FRAME.assign(more=[f"{0.25 * value:.3f}".replace(".", ",") for value in ROWS % 7])
    first = [f"{value:.3f}".replace(".", ",") for value in FRAME["Current [A]"]]
    frame["Current [A]"] = pd.Series(first, dtype=object)
    frame.columns = [*frame.columns[:2], name, frame.columns[3], name]
    table = table_of_log(frame, ColumnMap(), None)
    np.testing.assert_allclose(table.columns["Current"], FRAME["Current [A]"])
    np.testing.assert_allclose(table.columns["Current (2)"], 0.25 * (ROWS % 7))
    assert table.units["Current (2)"] == table.units["Current"]
    assert any("renamed 'Current (2)'" in note for note in table.notes)
