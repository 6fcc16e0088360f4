"""What is read from made-up logs, and every word that is said of them, stays as it is kept beside this file.

A log is read by dozens of small rules, and each rule speaks: in a note, in an error, in a number. A rule that changes
is to be seen here and meant (`tests/conftest.py` says how to pin anew).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ErclutchError
from erclutch.logs import ColumnMap, read, read_table
from erclutch.logs.applied import apply
from erclutch.logs.clock import time_stamps
from erclutch.logs.clock.resample import resampled
from erclutch.logs.columns.labels import split_label
from erclutch.logs.dataset import build_dataset
from erclutch.logs.held_out import hold_out, time_folds
from erclutch.logs.keywords import HERTZ, SECONDS, number_of
from erclutch.logs.planning.draft import scaled
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.readers.header_pairs import header_pairs, sample_period
from erclutch.logs.saved_plan import mapping_text, save_plan
from erclutch.logs.table import Table
from erclutch.logs.time_window import within
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording
from erclutch.signals.speed import Derivative
from tests.support.pinning import Pinned, summed

N = 60
ROWS = np.arange(float(N))
WAVE, TURN, PUSH = (
    0.5 + 0.4 * np.sin(0.2 * ROWS),
    np.cos(0.31 * ROWS),
    3.0 * np.sin(0.17 * ROWS) + 0.5,
)


_FOLDER = re.compile(r"(?<=erclutch inspect )\S*/")  # of the file in a command


def told(of: Callable[[], Any]) -> Any:
    """What comes of it in numbers and words, or the words of the error."""
    try:
        found = of()
    except ErclutchError as error:
        return f"{type(error).__name__}: {_FOLDER.sub('', str(error))}"
    if isinstance(found, Table):
        names = (
            "units",
            "numbers",
            "sample_period",
            "clock_name",
            "constants",
            "metadata",
            "notes",
        )
        clock = None if found.clock is None else summed(found.clock)
        return {"columns": {k: summed(v) for k, v in found.columns.items()}, "clock": clock} | {
            name: getattr(found, name) for name in names
        }
    if isinstance(found, Recording):
        groups = {name: getattr(found, name) for name in ("signals", "extras", "spare")}
        names = ("units", "period", "segments", "uniform", "constants", "origin", "notes")
        sums = {name: {k: summed(v) for k, v in group.items()} for name, group in groups.items()}
        return {
            **sums,
            "time": summed(found.time),
            **{name: getattr(found, name) for name in names},
        }
    return found


# --- text ------------------------------------------------------------------------------------------------------------


def lines(
    columns: Mapping[str, Array], between: str = ",", form: str = "{:.4f}", point: str = "."
) -> str:
    return "".join(
        between.join(form.format(x).replace(".", point) for x in row) + "\n"
        for row in zip(*columns.values(), strict=True)
    )


def csv(columns: Mapping[str, Array], between: str = ",", **more: str) -> str:
    return between.join(columns) + "\n" + lines(columns, between, **more)


TIME = {"t [s]": ROWS / 100.0}
SINGLE = {**TIME, "field [V]": WAVE, "slip [rad/s]": TURN, "torque [N*m]": PUSH}
COAXIAL = {**TIME, "E1": np.maximum(WAVE - 0.5, 0.0), "E2": np.maximum(0.5 - WAVE, 0.0)} | {
    **{"theta_dot [rad/s]": TURN, "alpha_dot [deg/s]": 40.0 * PUSH, "T [N*mm]": 1e3 * PUSH},
}
HEADED = "Device: damper 3\nSample rate: 200 Hz\nOperator; anybody\n\n"
TEXTS: dict[str, str | bytes] = {
    "comma": csv(SINGLE),
    "semicolon and decimal comma": csv(SINGLE, ";", point=","),
    "tab": csv(SINGLE, "\t"),
    "white space": "  ".join(("t", "Y", "V", "F")) + "\n" + lines(SINGLE, "   "),
    "no names": lines(SINGLE),
    "no names, white space": lines(SINGLE, "  ", form="{:12.5e}"),
    "header block": HEADED + csv(SINGLE, ";"),
    "row of units": "t,field,slip,torque\ns,V,rad/s,N*m\n" + lines(SINGLE),
    "row of units in brackets": "t,field,slip,torque\n[s],[mV],[rpm],[kN*m]\n" + lines(SINGLE),
    "comments": "# a rig\n# 100 Hz\n" + csv(SINGLE) + "# the end\n",
    "quoted": '"time, s";"the field";"the ""slip""";F [N]\n' + lines(SINGLE, ";"),
    "byte order mark": b"\xef\xbb\xbf" + csv(SINGLE).encode(),
    "utf-16": csv({"t [ms]": ROWS, "Temp. [°C]": 20.0 + TURN, "F [N]": PUSH}).encode("utf-16"),
    "latin-1": csv({"t [ms]": ROWS, "Temp. [°C]": 20.0 + TURN, "F [N]": PUSH}).encode("latin-1"),
    "empty cells": csv(SINGLE).replace("0.0300,", "0.0300,,", 1).replace(",1.0000,", ",,", 1),
    "one cell more": csv(SINGLE).replace("\n0.2000,", "\n0.2000,1,", 1),
    "cells of text": csv(SINGLE).replace("\n0.2000,0.", "\n0.2000,off", 1),
    "an empty column": csv({**SINGLE, "spare": ROWS}).replace(".0000\n", "\n"),
    "equal names": csv(SINGLE).replace("slip [rad/s]", "field [V]", 1),
    "a column of a constant": csv({**SINGLE, "gap [mm]": np.full(N, 1.5)}),
    "a number once": "t,F,lead\n"
    + "".join(f"{x / 100:.2f},{x},{'2.5' if x == 0 else ''}\n" for x in range(N)),
    "dates": "when,F [N]\n" + "".join(f"2024-03-01 12:00:{x:02d}.5,{x % 7}\n" for x in range(N)),
    "time of day": "time;F\n" + "".join(f"23:59:{x:02d},25;{x % 7}\n" for x in range(N)),
    "thousands": "t,F\n" + "".join(f'{x},"1,{x:03d}.5"\n' for x in range(N)),
    "nothing": b"",
    "names alone": "t,F\n",
    "a letter": "once upon a time\nthere was a clutch\n",
    "two rows": "t,F\n0,1\n1,2\n",
    "nan and inf": csv(SINGLE).replace("\n0.2000,", "\nnan,", 1).replace("\n0.3000,", "\ninf,", 1),
    "cut in its last row": csv(SINGLE)[:-9],
    "Windows": csv(SINGLE).replace("\n", "\r\n"),
    "old Mac": csv(SINGLE).replace("\n", "\r"),
    "NUL bytes": csv(SINGLE).replace("\n0.2000", "\n\x00.2000", 1),
    "LVM": "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\t\n"
    "Channels\t2\t\nSamples\t60\t60\t\nY_Unit_Label\tN\tV\t\nDelta_X\t0.01\t0.01\t\n***End_of_Header***\t\n"
    "X_Value\tF\tU\tComment\n" + lines({**TIME, "F": PUSH, "U": WAVE}, "\t"),
    "JSON lines": "".join(
        f'{{"t": {x / 100}, "F": {x % 7}, "more": {{"Y": {x % 3}}}}}\n' for x in range(N)
    ),
    "JSON lines that differ": '{"t": 1, "F": 2}\n{"t": 2}\n' * 30,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", list(TEXTS))
def test_text(name: str, tmp_path: Path, pinned: Pinned) -> None:
    text = TEXTS[name]
    path = (
        tmp_path
        / f"log{'.lvm' if name == 'LVM' else '.jsonl' if name.startswith('JSON') else '.csv'}"
    )
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    pinned(
        [
            told(lambda: read_table(path)),
            told(lambda: read(path)),
            told(lambda: read(path, invalid="drop")),
        ]
    )


# --- columns ---------------------------------------------------------------------------------------------------------

PLAIN = {"t": ROWS / 100.0, "field": WAVE, "slip": TURN, "effort": PUSH}
#: Columns, their units, the mapping, the device.
MAPPED: dict[str, Any] = {
    "plain": (PLAIN, {}, {}, "single"),
    "coaxial": (dict(COAXIAL), {}, {}, "coaxial"),
    "a missing effort": ({k: v for k, v in PLAIN.items() if k != "effort"}, {}, {}, "single"),
    "a missing field": ({k: v for k, v in PLAIN.items() if k != "field"}, {}, {}, "single"),
    "a missing slip": ({k: v for k, v in PLAIN.items() if k != "slip"}, {"x": "m"}, {}, "single"),
    "two efforts": ({**PLAIN, "torque": -PUSH, "force": PUSH}, {}, {}, "single"),
    "a choice among two": (
        {**PLAIN, "torque": -PUSH},
        {},
        {"columns": {"effort": "torque"}},
        "single",
    ),
    "no such column": (PLAIN, {}, {"columns": {"effort": "efort"}}, "single"),
    "a column twice": (PLAIN, {}, {"columns": {"field": "slip", "slip": "slip"}}, "single"),
    "a column twice, the effort": (
        PLAIN,
        {},
        {"columns": {"effort": "slip", "slip": "slip"}},
        "single",
    ),
    "units turned": (
        PLAIN,
        {"slip": "rpm", "effort": "kN*m", "field": "mV", "t": "ms"},
        {},
        "single",
    ),
    "a unit of another kind": (PLAIN, {"slip": "kg"}, {}, "single"),
    "an unknown unit": (PLAIN, {"effort": "blub"}, {}, "single"),
    "a position": ({**PLAIN, "position": np.cumsum(TURN) / 100}, {"position": "deg"}, {}, "single"),
    "only a position": (
        {"t": ROWS / 100, "field": WAVE, "position": TURN, "effort": PUSH},
        {},
        {},
        "single",
    ),
    "a rate": ({k: v for k, v in PLAIN.items() if k != "t"}, {}, {"rate": 250.0}, "single"),
    "no time": ({k: v for k, v in PLAIN.items() if k != "t"}, {}, {}, "single"),
    "a rate beside a time": (PLAIN, {}, {"rate": 250.0}, "single"),
    "a constant": (PLAIN, {}, {"constants": {"gap": "1.5 mm", "field": 0.3}}, "single"),
    "a signed field": ({**COAXIAL, "E": WAVE - 0.5}, {}, {"columns": {"E": "E"}}, "coaxial"),
    "both fields and a sign": ({**COAXIAL, "E": WAVE - 0.5}, {}, {}, "coaxial"),
    "a lead": (
        {k: v for k, v in COAXIAL.items() if k != "alpha_dot [deg/s]"} | {"alpha_raw": TURN},
        *({"alpha_raw": "mm"}, {"constants": {"lead": "20 mm"}}, "coaxial"),
    ),
    "no lead": (
        {k: v for k, v in COAXIAL.items() if "alpha" not in k} | {"alpha_raw": TURN},
        {},
        {},
        "coaxial",
    ),
    "temperature": ({**PLAIN, "temperature": 20.0 + TURN}, {"temperature": "°C"}, {}, "single"),
    "temperature without a unit": ({**PLAIN, "temperature": 20.0 + TURN}, {}, {}, "single"),
    "cold below nought": (
        *({**PLAIN, "W": -300.0 + TURN}, {}),
        *({"columns": {"temperature": {"column": "W", "unit": "°C"}}}, "single"),
    ),
    "extras": ({**PLAIN, "u": TURN, "v": WAVE}, {}, {"inputs": ["u"]}, "single"),
    "a scale and an offset": (PLAIN, {"effort": "V"}, {"scales": {"effort": "-2.5 N/V"}}, "single"),
    "missing values": (
        {**PLAIN, "effort": np.where(ROWS % 6 == 3, np.nan, PUSH)},
        {},
        {},
        "single",
    ),
    "missing values, dropped": (
        *(
            {**PLAIN, "effort": np.where(ROWS % 20 == 7, np.nan, PUSH)},
            {},
            {"invalid": "drop"},
            "single",
        ),
    ),
    "a field that never changes": ({**PLAIN, "field": np.full(N, 0.3)}, {}, {}, "single"),
    "an effort that never changes": ({**PLAIN, "effort": np.full(N, 0.3)}, {}, {}, "single"),
    "an unknown key": (PLAIN, {}, {"colums": {}}, "single"),
    "an unknown device": (PLAIN, {}, {}, "triple"),
    "the time of another column": ({**PLAIN, "clock": ROWS}, {}, {"time": "clock"}, "single"),
    "time in microseconds": ({**PLAIN, "t": ROWS * 1e4}, {"t": "us"}, {}, "single"),
    "time backwards": ({**PLAIN, "t": ROWS[::-1] / 100}, {}, {}, "single"),
    "eight spare columns": ({**PLAIN, **{f"s{i}": TURN + i for i in range(8)}}, {}, {}, "single"),
    "nine spare columns": ({**PLAIN, **{f"s{i}": TURN + i for i in range(9)}}, {}, {}, "single"),
    "nine rows": ({k: v[:9] for k, v in PLAIN.items()}, {}, {}, "single"),
    "ten rows": ({k: v[:10] for k, v in PLAIN.items()}, {}, {}, "single"),
}


@pytest.mark.parametrize("name", list(MAPPED))
def test_columns(name: str, pinned: Pinned) -> None:
    columns, units, mapping, device = MAPPED[name]
    names = {
        k: (k.partition(" [")[0], k.partition("[")[2].rstrip("]") or units.get(k)) for k in columns
    }
    table = Table(
        "a.csv", {names[k][0]: v for k, v in columns.items()}, {n: u for n, u in names.values()}, "0" * 64,
        {n: i + 1 for i, (n, _) in enumerate(names.values())},
    )  # fmt: skip
    invalid = mapping.get("invalid")
    mapping = {k: v for k, v in mapping.items() if k != "invalid"}
    pinned(
        told(
            lambda: apply(
                plan_of(table, ColumnMap.from_dict(mapping), device=device, invalid=invalid), table
            )
        )
    )


def test_words(pinned: Pinned) -> None:
    """Of labels, headers, scales, rates and times."""
    labels = (
        "V [cm/s]",
        "F (N)",
        "F",
        "a/b",
        "T_N",
        "speed rad/s",
        "t/s",
        "x [",
        "[N]",
        "Kraft in N",
        "ω [1/s]",
        "q_°C",
    )
    headers = (
        "Sample rate: 200 Hz",
        "dt = 0.5 ms",
        "Sampling interval;1e-3;s",
        "rate: 0",
        "Period: 2",
        "f=1 kHz",
    )
    scales = ("2.5 N/V", "-1e3", "0", "1/0", "N", "3 mm", "", "2 N / V", "inf", "1e400")
    times = ("5s", "250ms", "1.5", "-2", "2 h", "3min", "x", "", "1e400 s", "nan")
    rates = ("1000", "2 kHz", "0", "-1", "1e-9", "1e13", "x", "10 ms", "nan")
    pinned(
        {
            "labels": [split_label(label) for label in labels],
            "headers": [sample_period(header_pairs([header])) for header in headers],
            "scales": [told(lambda text=text: scaled(text, "effort")) for text in scales],
            "times": [told(lambda text=text: number_of("--from", text, SECONDS)) for text in times],
            "rates": [told(lambda text=text: number_of("resample", text, HERTZ)) for text in rates],
        }
    )


# --- time ------------------------------------------------------------------------------------------------------------

MORE = np.arange(400.0)
_NOISE = np.random.default_rng(3).uniform(-1.0, 1.0, 400)
STAMPS: dict[str, Array] = {
    "even": MORE / 1000,
    "printed to ms": np.round(MORE / 300, 3),
    "six digits": np.array([float(f"{x:.6g}") for x in 20 + MORE * 3.328e-4]),
    "float32": (MORE / 777).astype(np.float32).astype(np.float64),
    "since 1970": 1.7e9 + MORE / 100,
    "since 1970 in float64's last digits": 1.7e9 + MORE / 1e6,
    "a tick of 15.6 ms": np.floor(MORE / 1000 / 0.0156) * 0.0156,
    "wandering a little": (MORE + 0.9e-3 * _NOISE) / 100,
    "wandering more": (MORE + 1.2e-3 * _NOISE) / 100,
    "not uniform": (MORE + 0.3 * _NOISE) / 100,
    "a gap of 1.4": np.where(MORE < 200, MORE, MORE + 0.4) / 100,
    "a gap of 1.6": np.where(MORE < 200, MORE, MORE + 0.6) / 100,
    "three gaps": (MORE + 5 * (MORE > 50) + 9 * (MORE > 120) + 3 * (MORE > 300)) / 100,
    "gaps everywhere": np.cumsum(1.0 + 3.0 * (MORE % 8 == 0)) / 100,
    "stray repeats": np.sort(np.append(MORE[:-3], MORE[[17, 120, 233]])) / 100,
    "repeats": np.repeat(MORE[:200], 2) / 100,
    "repeats at equal distances": np.floor(MORE * 0.95) / 100,
    "begins anew": np.where(MORE < 150, MORE, MORE - 150) / 100,
    "one damaged stamp": np.where(MORE == 222, 0.0, MORE) / 100,
    "backwards": np.where(MORE == 222, 220.5, MORE) / 100,
    "twice backwards": np.where((MORE == 222) | (MORE == 300), 100.0, MORE) / 100,
    "one value": np.ones(400),
    "too fine": MORE * 1e-13,
    "too fine with repeats": np.repeat(MORE[:200], 2) * 1.2e-12,
    "nine": MORE[:9],
    "ten": MORE[:10],
}


@pytest.mark.parametrize("name", list(STAMPS))
def test_stamps(name: str, pinned: Pinned) -> None:
    stamps = STAMPS[name]

    def clock(hint: float | None = None) -> Any:
        found = time_stamps.from_stamps(
            stamps, np.arange(stamps.size) % 3 == 0, column="t", hint=hint
        )
        kept = int(found.keep.sum())
        return [
            summed(found.time - found.time[0]),
            found.period,
            found.starts,
            found.uniform,
            kept,
            found.notes,
        ]

    pinned([told(clock), told(lambda: clock(0.010001)), told(lambda: clock(1e-3))])


# --- recordings ------------------------------------------------------------------------------------------------------


def recording(gap: bool = True, name: str = "a.csv", rows: int = 300) -> Recording:
    t = np.arange(float(rows))
    stamps = (t + 40 * (t > 170) * gap) / 100
    columns = {
        "t": stamps,
        "field": np.floor(t / 60),
        "position": np.sin(0.05 * t),
        "effort": np.cos(0.03 * t),
    }
    columns |= {"temperature": 300.0 + 0.01 * t, "u": 0.1 * t}
    table = Table(
        name,
        columns,
        {"t": "s", "temperature": "K", "field": "V"},
        name.encode().hex().ljust(64, "0"),
    )
    return apply(plan_of(table, ColumnMap.from_dict({"inputs": ["u"]})), table)


@pytest.mark.slow
def test_other_rates(pinned: Pinned) -> None:
    log = recording()
    rates = (
        1.0,
        9.9,
        25.0,
        50.0,
        99.0,
        100.0,
        150.0,
        333.0,
        1000.0,
        1010.0,
        5000.0,
        1e5,
        1e-3,
        0.0099,
        0.01,
        0.015,
    )
    pinned([told(lambda rate=rate: resampled(log, rate)) for rate in rates])


def test_windows_of_time(pinned: Pinned) -> None:
    log = recording()
    windows = (
        (None, None),
        (0.5, None),
        (None, 1.0),
        (0.5, 1.5),
        (1.75, 2.0),
        (2.0, 1.0),
        (9.0, None),
        (0.0, 0.05),
    )
    pinned([told(lambda a=a, b=b: within(log, a, b)) for a, b in windows])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["central", "savgol", "difference", "lowpass", "kalman"])
def test_rows_of_logs(name: Any, pinned: Pinned) -> None:
    logs = [recording(), recording(gap=False, name="b.csv", rows=200)]
    data = build_dataset(logs, derivative=Derivative(name, 20.0))
    parts = [data, data.take(np.arange(data.rows) % 50 < 40), data.take(np.arange(data.rows) > 250)]
    found: list[Any] = []
    for part in parts:
        own = [[summed(e.field), summed(e.slip)] for e in part.elements]
        rows = [part.rows, summed(part.effort), {k: summed(v) for k, v in part.extras.items()}]
        found += [
            [
                own,
                rows,
                [tuple(vars(s).values()) for s in part.clock.spans],
                part.source_rows,
                part.notes,
            ]
        ]
    for test in (0.3, 0.0, 0.9, "b*", "c*", "*", ["a*"]):
        found.append(told(lambda test=test: summed(hold_out(data, test))))
    for count in (1, 2, 7, 25, 26):
        found.append(told(lambda count=count: [summed(mask) for mask in time_folds(data, count)]))
    found.append(told(lambda: build_dataset([logs[0], logs[0]])))
    pinned(found)


# --- other files -----------------------------------------------------------------------------------------------------

PAIRS = "0 V,,1 kV,\n0.1,2,0.1,20\n1,3,1,30\n10,8,10,\n100,,100,90\n"


WRITTEN = (
    *(
        "plain",
        "coaxial",
        "a missing effort",
        "two efforts",
        "a rate",
        "no time",
        "no lead",
        "a scale and an offset",
    ),
    *("extras", "a constant"),
)


@pytest.mark.parametrize("name", WRITTEN)
def test_mapping_files(name: str, tmp_path: Path, pinned: Pinned) -> None:
    columns, units, mapping, device = MAPPED[name]
    table = Table(
        "a.csv",
        {k.partition(" [")[0]: v for k, v in columns.items()},
        {"t": "s", **units},
        "0" * 64,
    )

    def made() -> Any:
        plan = plan_of(table, ColumnMap.from_dict(mapping), device=device)
        return [
            mapping_text(plan),
            [each.short for each in plan.questions],
            {k: vars(v) for k, v in plan.choices.items()},
        ]

    pinned(told(made))
    path = tmp_path / "a.toml"
    path.write_text("x = 1\n", encoding="utf-8")
    plan = plan_of(Table("a.csv", TIME, {}, "0" * 64), ColumnMap())
    assert told(lambda: save_plan(plan, path)).startswith("MappingError: ")
    assert path.read_text() == "x = 1\n"


@pytest.mark.slow
def test_dates(pinned: Pinned) -> None:
    import pandas as pd

    from erclutch.logs.readers import dates

    texts = (
        *(
            "2024-03-01 12:00:00",
            "2024-03-01T12:00:00.5",
            "03/01/2024 12:00:00",
            "31/12/2024 12:00",
            "01.03.2024 1:00:00 PM",
        ),
        *(
            "1-Mar-2024 12:00:00",
            "12:00:01,5",
            "2024-03-01 12:00:00+01:00",
            "2024-03-01T12:00:00Z",
            "noon",
            "12",
            "2024-03-01",
        ),
    )
    found = [
        dates.seconds(pd.Series([text, text.replace(":00", ":01", 1), text])) for text in texts
    ]
    night = pd.Series(["23:59:59", "00:00:01", "00:00:02"])
    days = {"day": pd.Series(["2024-03-01"] * 3), "at": night, "more": pd.Series(["x"] * 3)}
    pinned(
        [
            found,
            dates.seconds(night),
            dates.seconds(pd.Series(["12:00:00", None])),
            dates.clock_of_dates(days),
            dates.clock_of_dates({}),
        ]
    )


def test_vectors_in_files(pinned: Pinned) -> None:
    from erclutch.logs.readers import found_recordings as f
    from erclutch.logs.readers import vectors

    long, short = np.arange(9.0), np.arange(4.0)
    nodes: dict[str, dict[str, Any]] = {
        "vectors": {"t": long, "a": long + 1.0, "gain": np.array([2.0]), "note": "of text"},
        "lengths": {"a": long, "b": short, "c": short + 1.0},
        "time decides": {"time": short, "b": long, "c": long},
        "matrices": {"a": np.ones((9, 2)), "b": np.ones((2, 9)), "c": np.ones((3, 3)), "t": long},
        "square": {"a": np.arange(16.0).reshape(4, 4)},
        "cells": {"a": np.array(["x", "y"]), "b": long, "c": np.ones((2, 2, 2))},
        "nothing": {"a": np.array([1.0])},
        "whole numbers": {"a": np.arange(5), "b": np.array([True, False] * 2 + [True])},
    }
    found: dict[str, Any] = {}
    for name, given in nodes.items():
        made = vectors.of_vectors(given)
        found[name] = None if made is None else told(made.table)
    names = {name: f.Found({"a": long}) for name in ("one", "two", "three")}
    for asked, among in (
        (None, {}),
        (None, names),
        ("two", names),
        ("four", names),
        (None, {"one": names["one"]}),
        ("x", {}),
    ):
        found[f"{asked} of {len(among)}"] = told(
            lambda a=asked, n=among: f.choose(n, a, "group", "no group")[0]
        )
    found["listed"] = [f.listed(map(str, range(n))) for n in (0, 1, 20, 21)]
    found["turned"] = [
        [n, summed(v)] for n, v in vectors.columns_of("m", np.arange(18.0).reshape(2, 9), None)
    ]
    pinned(found)


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_log_in_batches(tmp_path: Path, pinned: Pinned) -> None:
    import erclutch.logs as logs
    from erclutch.logs import batches

    rows = 25_000
    t = np.arange(float(rows))
    columns = {
        "t [s]": (t + 50.0 * (t > 12_345)) / 1000,
        "field [V]": np.sin(t / 300),
        "position [rad]": np.cos(t / 200),
    }
    path = tmp_path / "long.parquet"
    import pandas as pd

    pd.DataFrame({**columns, "torque [N*m]": np.sin(t / 150)}).to_parquet(path)
    found: list[Any] = [
        told(lambda n=n: [1 for _ in logs.read_batches(path, rows=n)]) for n in (9_999, 10_000)
    ]
    made = list(logs.read_batches(path, rows=10_000))
    for batch, block in zip(made, batches.blocks_of(made, "single", Derivative()), strict=True):
        own = [batch.start, batch.stop, summed(batch.rows), batch.recording.segments]
        found.append(
            [own, [summed(block.data.elements[0].slip), [vars(s) for s in block.data.clock.spans]]]
        )
    slow = logs.read_batches(path, rows=10_000)
    found.append(
        told(lambda: sum(1 for _ in batches.blocks_of(slow, "single", Derivative("lowpass", 0.01))))
    )
    pinned(found)
