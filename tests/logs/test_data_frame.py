"""A DataFrame of any make becomes a table, or is refused in one line."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import erclutch
from erclutch import registry
from erclutch.errors import ErclutchError
from erclutch.logs import Table, read_table
from erclutch.logs.log_reader import GROUP, LogReader, LogSource, claims_nothing
from erclutch.logs.synthetic import synthetic_log
from erclutch.registry import Plugin
from tests.support.examples import examples

_ROWS = 12
_TEXTS = st.sampled_from(["a", "a [mm]", "", "x,y", "t [s]", "a\x00b", "F [N]", "time"])
_COLUMNS: dict[str, Any] = {
    "float32": np.linspace(0, 1, _ROWS, dtype=np.float32),
    "int": np.arange(_ROWS),
    "bool": np.arange(_ROWS) % 2 == 0,
    "nullable": pd.array([*range(_ROWS - 1), None], dtype="Int64"),
    "category": pd.Categorical(np.arange(_ROWS) % 3),
    "text": ["x"] * _ROWS,
    "numbers as text": [str(k) for k in range(_ROWS)],
    "mixed": [1.0, "two", None, *range(_ROWS - 3)],
    "huge": pd.Series([10**400, *range(_ROWS - 1)], dtype=object),
    "lists": [[k] for k in range(_ROWS)],
    "complex": np.arange(_ROWS) * 1j,
    "dates": pd.date_range("2024-01-01", periods=_ROWS, freq="ms", tz="UTC"),
    "durations": pd.timedelta_range(0, periods=_ROWS, freq="ms"),
    "nothing": [None] * _ROWS,
}


def test_a_recording_made_of_arrays_is_copied_and_sent_to_other_processes() -> None:
    """What joblib does: the copy holds the same, and nobody can change it either."""
    time = np.arange(200) * 1e-3
    columns = {
        "time [s]": time,
        "field [V]": np.sin(time),
        "slip [rad/s]": np.cos(time),
        "torque [N*m]": time,
    }
    log = erclutch.read(pd.DataFrame(columns))
    for again in (pickle.loads(pickle.dumps(log)), copy.deepcopy(log), copy.copy(log)):
        assert again.units == log.units
        assert again.notes == log.notes
        assert np.array_equal(again.signals["effort"], log.signals["effort"])
        assert type(again.signals) is type(log.signals)
        assert not any(values.flags.writeable for values in (again.time, *again.signals.values()))
    data = erclutch.build_dataset(pickle.loads(pickle.dumps(log)))
    assert np.array_equal(copy.deepcopy(data).effort, data.effort)


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.lists(st.tuples(_TEXTS, st.sampled_from(sorted(_COLUMNS))), max_size=5))
def test_any_columns_give_numbers_of_one_length_or_one_error(
    columns: list[tuple[str, str]],
) -> None:
    frame = (
        pd.concat([pd.Series(_COLUMNS[kind]) for _, kind in columns], axis=1)
        if columns
        else pd.DataFrame()
    )
    frame.columns = [name for name, _ in columns]
    try:
        table = read_table(frame)
    except ErclutchError:
        assert not any(kind in ("float32", "int", "bool", "category") for _, kind in columns)
        return
    assert all(
        values.dtype == np.float64 and values.shape == (_ROWS,) for values in table.columns.values()
    )
    left = len(columns) - len(table.columns) - (table.clock is not None)
    assert bool(left) == any("left out" in note for note in table.notes)


@pytest.mark.slow
@pytest.mark.parametrize("index", ["dates", "durations", "column"])
def test_the_time_may_be_an_index_or_a_column(index: str) -> None:
    columns = synthetic_log(1.0)
    frame = pd.DataFrame({f"{name} [{unit}]": values for name, (unit, values) in columns.items()})
    if index != "column":
        since = pd.to_timedelta(frame.pop("time [s]"), unit="s")
        frame.index = pd.Index(
            since if index == "durations" else pd.Timestamp("2024-05-01", tz="UTC") + since
        )
    log = erclutch.read(frame)
    assert log.period == pytest.approx(1e-3)
    assert dict(log.units) == {"field": "V", "slip": "rad/s", "effort": "N*m"}
    again = erclutch.read(frame.rename(columns={"torque [N*m]": "M"}), {"effort": "M [N*m]"})
    assert np.array_equal(again.signals["effort"], log.signals["effort"])


def test_a_sensor_in_volts_among_several_missing_things_gets_a_label_and_a_scale() -> None:
    frame = pd.DataFrame({"force [V]": np.sin(np.arange(100.0)), "b": np.cos(np.arange(100.0))})
    with pytest.raises(ErclutchError, match="4 things are missing") as caught:
        erclutch.read(frame)
    assert "'effort': 'force'" in str(caught.value)
    assert "effort=NUMBER N/V" in str(caught.value)


@pytest.mark.parametrize("what", [None, [1, 2], {"a": [1]}, pd.Series([1.0]), np.zeros((20, 3)), 7])
def test_what_is_no_frame_is_refused(what: Any) -> None:
    with pytest.raises(ErclutchError, match="Give the path of a file, or a pandas DataFrame"):
        erclutch.read(what)


def test_a_reader_may_take_any_object_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(source: LogSource) -> Table:
        columns: Any = source.memory
        return Table(source.name, columns, dict.fromkeys(columns), "")

    reader = LogReader((), claims_nothing, read, takes=lambda log: isinstance(log, dict))
    found = registry.plugins(GROUP)
    ours = Plugin(GROUP, "of-dicts", "made:READER")
    vars(ours)["value"] = reader
    monkeypatch.setattr(registry, "plugins", lambda group: (*found, ours))
    table = read_table({"a": np.arange(4.0)})  # type: ignore[arg-type]
    assert table.name == "dict"
    assert table.columns["a"].tolist() == [0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize("words", [("ON", "OFF"), ("yes", "no")])
def test_words_of_a_switch_are_numbers_and_words_of_a_kind_part_the_rows(
    words: tuple[str, str],
) -> None:
    frame = pd.DataFrame(
        {"w": np.arange(40.0), "coil": [*words] * 20, "pad": ["steel"] * 20 + ["cork"] * 20}
    )
    table = read_table(frame)
    np.testing.assert_array_equal(table.columns["coil"], [1.0, 0.0] * 20)
    assert table.words["pad"].words == ("steel", "cork")
