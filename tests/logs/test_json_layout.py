"""JSON in the forms that programs write: at any depth, signals with units, tables with columns, runs, two rates."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError
from erclutch.logs import ColumnMap, plan_of, read, read_all, read_table, recordings_in
from tests.support.examples import examples

TIME = [k / 100 for k in range(50)]
SPEED = [round(float(np.sin(9 * t)), 6) for t in TIME]
TORQUE = [round(s**3, 6) for s in SPEED]
TABLE = [list(row) for row in zip(TIME, SPEED, TORQUE, strict=True)]

#: Documents that hold the three columns above, with units where the last word says so.
FORMS: dict[str, Any] = {
    "lists below data, beside settings": {
        "meta": {"who": "x", "gains": [1, 2, 3]},
        "data": {"time": TIME, "speed": SPEED, "torque": TORQUE},
    },
    "rows at depth": {
        "a": {
            "b": {
                "rows": [dict(zip(("time", "speed", "torque"), row, strict=True)) for row in TABLE]
            }
        }
    },
    "columns and data": {
        "columns": ["time", "speed", "torque"],
        "index": list(range(50)),
        "data": TABLE,
    },
    "columns and data at depth": {
        "x": {"columns": ["time", "speed", "torque"], "rows": TABLE},
        "note": "n",
    },
    "columns with units": {
        "Results": [
            {
                "Data": {
                    "columns": [
                        {"name": "time", "unit": "s"},
                        {"name": "speed", "unit": "rad/s"},
                        {"name": "torque", "unit": "N*m"},
                    ],
                    "values": TABLE,
                }
            }
        ]
    }["Results"][0]["Data"],
    "signals with units": {
        "signals": [
            {"name": "time", "unit": "s", "values": TIME},
            {"name": "speed", "unit": "rad/s", "values": SPEED},
            {"name": "torque", "unit": "N*m", "values": TORQUE},
        ]
    },
    "signals by name with units": {
        "time": {"unit": "s", "values": TIME},
        "speed": {"unit": "rad/s", "values": SPEED},
        "torque": {"unit": "N*m", "values": TORQUE},
    },
    "a list of units": {
        "units": {"time": "s", "speed": "rad/s", "torque": "N*m"},
        "data": {"time": TIME, "speed": SPEED, "torque": TORQUE},
    },
}


def written(folder: Path, document: Any) -> Path:
    path = folder / "log.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


@pytest.mark.parametrize("form", FORMS)
def test_a_document_is_read(tmp_path: Path, form: str) -> None:
    table = read_table(written(tmp_path, FORMS[form]))
    assert table.columns["time"].tolist() == TIME
    assert table.columns["speed"].tolist() == SPEED
    assert table.columns["torque"].tolist() == TORQUE
    if "unit" in form:
        assert [table.units[name] for name in ("time", "speed", "torque")] == ["s", "rad/s", "N*m"]


def test_runs_are_recordings_under_their_names(tmp_path: Path) -> None:
    runs = [
        {"name": "one", "time": TIME, "F": SPEED},
        {"name": "two", "time": TIME[:30], "F": TORQUE[:30]},
    ]
    path = written(tmp_path, {"runs": runs})
    assert recordings_in(path) == ["runs.one", "runs.two"]
    assert read_table(path, variable="runs.two").columns["F"].tolist() == TORQUE[:30]


def test_of_two_signals_or_runs_with_one_name_none_is_lost(tmp_path: Path) -> None:
    time = list(range(20))
    speed = [{"name": "speed", "values": [factor * t for t in time]} for factor in (1, 2)]
    path = written(tmp_path, [{"name": "t", "values": time}, *speed])
    table = read_table(path)
    assert [*table.columns] == ["t", "speed (1)", "speed (2)"]
    np.testing.assert_array_equal(table.columns["speed (1)"], time)

    runs = [{"name": "brake", "t": time, "F": [factor] * 20} for factor in (1, 2)]
    path = written(tmp_path, {"runs": runs})
    assert recordings_in(path) == ["runs.brake (1)", "runs.brake (2)"]
    np.testing.assert_array_equal(read_table(path, variable="runs.brake (1)").columns["F"], 1)


@pytest.mark.parametrize(
    "text",
    [
        '{"t": 0.0, "torque": 1, "torque": 2}\n{"t": 0.1, "torque": 1, "torque": 2}\n',
        '[{"t": 0.0, "torque": 1, "torque": 2}, {"t": 0.1, "torque": 1, "torque": 2}]',
        '{"t": [0, 0.1, 0.2],\n "torque": [1, 2, 3],\n "torque": [4, 5, 6]}',
    ],
)
def test_two_values_of_one_name_are_refused(tmp_path: Path, text: str) -> None:
    """The last of them was the torque."""
    log = tmp_path / "log.json"
    log.write_text(text, encoding="utf-8")
    with pytest.raises(LogError, match="two values of one name: 'torque' stands in it twice"):
        read_table(log)


def test_of_two_objects_of_a_run_with_times_of_their_own_none_is_lost(tmp_path: Path) -> None:
    time = list(range(20))
    motor = {"t": time, "speed": [3] * 20}
    cell = {"t": time[:9], "torque": [0.1] * 9}
    runs = [{"name": day, "motor": motor, "cell": cell} for day in ("first", "second")]
    names = recordings_in(written(tmp_path, {"runs": runs}))
    assert names == [
        "runs.first.motor",
        "runs.first.cell",
        "runs.second.motor",
        "runs.second.cell",
    ]


def test_objects_of_two_rates_are_joined_where_that_is_asked_for(tmp_path: Path) -> None:
    slow = {"time": TIME[::5], "current": [0.0] * 5 + [1.0] * 5}
    path = written(
        tmp_path, {"fast": {"time": TIME, "speed": SPEED, "torque": TORQUE}, "slow": slow}
    )
    with pytest.raises(LogError, match=r"join them by time: --variable 'fast \+ slow'"):
        read_table(path)
    table = read_table(path, variable="fast + slow")
    assert table.columns["current"].tolist() == [0.0] * 25 + [1.0] * 21
    assert table.columns["speed"].tolist() == SPEED[:46]


def test_a_signal_that_is_a_row_short_is_no_missing_field(tmp_path: Path) -> None:
    path = written(
        tmp_path, {"time": TIME, "speed": SPEED, "torque": TORQUE, "current": [0.5] * 49}
    )
    with pytest.raises(ErclutchError, match="list current has 49 values, not 50"):
        read(path)


@pytest.mark.parametrize(
    ("document", "names"),
    [
        (TABLE, ("c_1", "c_2", "c_3")),
        (
            {"data": [[0.1, 3, 4], [0.2, 4, 5], [0.3, 5, 6]], "dt": 0.1},
            ("data_1", "data_2", "data_3"),
        ),
        ({"run": {"rows": [[0.1, 0.2, 0.3], [3, 4, 5]]}}, ("rows_1", "rows_2")),  # on its side
    ],
)
def test_a_matrix_without_names_has_columns_by_their_place(
    tmp_path: Path, document: object, names: tuple[str, ...]
) -> None:
    table = read_table(written(tmp_path, document))
    assert tuple(table.columns) == names


@pytest.mark.parametrize(
    "document", [{"data": [[1, 2], [3]]}, {"data": [[[1, 2]], [[3, 4]]]}, [[1], [2]]]
)
def test_lists_of_lists_that_are_no_matrix_are_refused(tmp_path: Path, document: object) -> None:
    with pytest.raises(LogError):
        read_table(written(tmp_path, document))


_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 3) | st.sampled_from(["time", "s", "x"]),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["time", "columns", "data", "unit", "units", "name", "a"]),
            inner,
            max_size=4,
        )
    ),
    max_leaves=25,
)


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(_VALUES)
def test_any_document_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, document: Any
) -> None:
    path = written(tmp_path_factory.getbasetemp(), document)
    try:
        table = read_table(path)
    except ErclutchError:
        return
    assert len({values.size for values in table.columns.values()}) == 1


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(
    form=st.sampled_from(list(FORMS)),
    place=st.integers(0, 3000),
    damage=st.sampled_from('0-,.]["{}:x'),
)
def test_a_changed_byte_never_makes_more_than_the_value_it_stands_in(
    tmp_path_factory: pytest.TempPathFactory, form: str, place: int, damage: str
) -> None:
    """Each column is as it was but for one value, or the file is refused, or a column is missing by name."""
    text = json.dumps(FORMS[form])
    place %= len(text)
    path = tmp_path_factory.getbasetemp() / "changed.json"
    path.write_text(text[:place] + damage + text[place + 1 :], encoding="utf-8")
    try:
        table = read_table(path)
    except ErclutchError:
        return
    for name, right in (("time", TIME), ("speed", SPEED), ("torque", TORQUE)):
        if name in table.columns:
            values = table.columns[name]
            assert values.size == 50
            assert int(np.count_nonzero(values != np.array(right))) <= 1


def test_a_step_of_a_rheometer_holds_its_columns_with_units(tmp_path: Path) -> None:
    columns = [
        {"Name": "Shear rate", "Unit": "1/s", "Values": TIME},
        {"Name": "Stress", "Unit": "Pa", "Values": SPEED},
    ]
    steps = [{"StepName": name, "Columns": columns} for name in ("Flow sweep", "Peak hold")]
    path = tmp_path / "log.json"
    path.write_text(json.dumps({"Properties": {"Sample": "gel"}, "Results": steps}))
    assert recordings_in(path) == ["Results.Flow sweep", "Results.Peak hold"]
    table = read_table(path, variable="Results.Peak hold")
    assert table.labels == ("Shear rate [1/s]", "Stress [Pa]")
    assert table.columns["Stress"].tolist() == SPEED


@pytest.mark.parametrize(("intervals", "period"), [((0.02, 0.02), 0.02), ((0.02, 0.01), None)])
def test_a_sampling_interval_of_all_signals_is_that_of_the_log(
    tmp_path: Path, intervals: tuple[float, float], period: float | None
) -> None:
    signals: list[dict[str, Any]] = []
    for interval, (name, values) in zip(
        intervals, {"speed": SPEED, "torque": TORQUE}.items(), strict=True
    ):
        signals.append({"name": name, "unit": "-", "sampleInterval": interval, "values": values})
    path = tmp_path / "log.json"
    path.write_text(json.dumps({"channels": signals}))
    assert read_table(path).constants.get("sampleInterval") == period


def _screwing(lengths: tuple[int, ...]) -> dict[str, object]:
    """A screwdriver's report: settings, and for each step lists of its angle and its torque under a key."""
    steps: list[dict[str, object]] = []
    for number, length in enumerate(lengths, start=1):
        times = [round(0.01 * k, 4) for k in range(length)]
        graph = {
            "angle values": [5.0 * number * time for time in times],
            "torque values": [0.2 + 0.1 * number * time for time in times],
            "torqueRed values": [0] * length,
            "time values": times,
        }
        functions = [{"nom": 1.5, "act": 2}, {"nom": 2.5, "act": 3}]
        steps.append(
            {"name": f"Step {number}", "speed": 150, "functions": functions, "graph": graph}
        )
    return {"torque unit": "Nm", "location": ["1", "2", "3"], "steps": steps}


def test_each_step_of_a_screwdriver_is_a_recording(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(_screwing((40, 60, 30))))
    for number, length in enumerate((40, 60, 30), start=1):
        table = read_table(path, variable=f"steps.Step {number}")
        assert table.rows == length
        plan = plan_of(table, ColumnMap())
        assert plan.questions == ()
        assert {each.signal: each.column for each in plan.signals if each.column} == {
            "position": "angle values",
            "effort": "torque values",
        }
    assert "" not in recordings_in(path)


@pytest.mark.parametrize("way", ["columns", "index"])
@pytest.mark.parametrize("first", [0, 300])
def test_rows_under_their_numbers_as_pandas_writes_them_are_rows(
    tmp_path: Path, way: str, first: int
) -> None:
    rows = {
        str(first + place): dict(zip(("time", "speed", "torque"), row, strict=True))
        for place, row in enumerate(TABLE)
    }
    columns = {
        name: {place: row[name] for place, row in rows.items()}
        for name in ("time", "speed", "torque")
    }
    path = tmp_path / "a.json"
    path.write_text(json.dumps(columns if way == "columns" else rows))
    table = read_table(path)
    index = ["index"] if first else []  # which tells that rows are missing
    assert [*table.columns] == [*index, "time", "speed", "torque"]
    assert table.columns["torque"].tolist() == TORQUE


@pytest.mark.slow
def test_objects_of_one_set_of_keys_that_are_no_numbers_are_no_rows(tmp_path: Path) -> None:
    joints = {name: {f"q{k}": 0.1 * k for k in range(40)} for name in ("left", "right")}
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"t": 0.1, **joints}))
    table = read_table(path)
    assert table.rows == 1


ROWS_OF_RUN = [
    {"t": round(0.01 * k, 2), "v": 0.1 * (k % 9 - 4), "f": 5.0 * (k % 9 - 4)} for k in range(40)
]


@pytest.mark.parametrize(
    "document",
    [
        {"runs": [{"current_A": level, "samples": ROWS_OF_RUN} for level in (0.5, 1.0)]},
        [{"meta": {"current [A]": level}, "log": ROWS_OF_RUN} for level in (0.5, 1.0)],
    ],
)
def test_rows_of_a_run_have_the_current_of_their_run(tmp_path: Path, document: object) -> None:
    path = tmp_path / "log.json"
    path.write_text(json.dumps(document), "utf-8")
    logs = read_all(path, ColumnMap())
    assert [float(log.signals["field"][0]) for log in logs] == [0.5, 1.0]
    assert [log.signals["effort"].size for log in logs] == [40, 40]


@pytest.mark.parametrize(
    "stated",
    [
        {"current_A": 0.5},
        {"setup": {"coil current [A]": 0.5}},
        {"setup": {"coil_current": {"value": 0.5, "unit": "A"}}},
    ],
)
def test_a_current_beside_the_rows_is_their_field(tmp_path: Path, stated: object) -> None:
    path = tmp_path / "log.json"
    path.write_text(json.dumps({**cast("dict[str, object]", stated), "samples": ROWS_OF_RUN}))
    # A v may be a voltage or a velocity, and stays asked about.
    assert read(path, slip="v [m/s]").signals["field"] == pytest.approx(np.full(40, 0.5))


def test_the_current_of_another_run_is_not_taken(tmp_path: Path) -> None:
    path = tmp_path / "log.json"
    runs = {f"run{level}": {"current_A": level, "samples": ROWS_OF_RUN} for level in (0.5, 1.0)}
    path.write_text(json.dumps(runs))
    log = read(path, slip="v [m/s]", variable="run1.0.samples")
    assert log.signals["field"] == pytest.approx(np.full(40, 1.0))


@pytest.mark.parametrize("levels", [("0A", "0.5A"), ("0 A", "1.5 A"), ("I_1A", "I_2A")])
def test_objects_called_by_their_current_are_runs_at_it(
    tmp_path: Path, levels: tuple[str, str]
) -> None:
    runs = {level: {"t": TIME, "speed_rad_s": SPEED, "torque_Nm": TORQUE} for level in levels}
    path = tmp_path / "log.json"
    path.write_text(json.dumps({"device": "brake", "data": runs}), "utf-8")
    logs = read_all(path, ColumnMap(variable="all"))
    currents = [float(level.strip("I_A ")) for level in levels]
    assert [float(log.signals["field"][0]) for log in logs] == currents
    assert all(log.signals["effort"].tolist() == TORQUE for log in logs)
