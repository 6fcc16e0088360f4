"""Heads in the manner of INI files name columns by their numbers. The data are SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, plan_of, read_table

pytestmark = pytest.mark.slow

TIME = np.arange(400) / 200.0
CURRENT = np.repeat([0.0, 0.5, 1.0, 0.25], 100)
SPEED = 5.0 * np.sin(6.0 * TIME)
TORQUE = (0.3 + 1.7 * CURRENT) * np.tanh(4.0 * SPEED) + 0.02 * SPEED
CHANNELS = [("Time", "s"), ("Current", "A"), ("Speed", "rad/s"), ("Torque", "Nm")]


def plan_below(path: Path, head: str, delimiter: str) -> Plan:
    rows = [
        delimiter.join(f"{value:.6g}" for value in row)
        for row in zip(TIME, CURRENT, SPEED, TORQUE, strict=True)
    ]
    path.write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    return plan_of(read_table(path), ColumnMap())


def lines(pattern: str, first: int) -> str:
    """A line for each channel, or several."""
    numbered = enumerate(CHANNELS, start=first)
    return "".join(pattern.format(n=n, name=name, unit=unit) for n, (name, unit) in numbered)


@pytest.mark.parametrize(
    ("head", "delimiter"),
    [
        ("[Info]\nOperator=me\n[Channels]\n" + lines("{n}={name},{unit}\n", 1) + "[Data]\n", ","),
        ("[Header]\nNr=7\n[Channels]\n" + lines("Channel{n}={name} [{unit}]\n", 1), "\t"),
        ("[Channels]\n" + lines("Ch{n}={name};{unit}\n", 0) + "[Values]\n", ";"),
        ("[Channels]\n" + lines("Name{n}={name}\nUnit{n}={unit}\n", 1) + "[Data]\n", "\t"),
        (lines("[Channel {n}]\nName={name}\nUnit={unit}\nGain=1.0\n", 1) + "[Data]\n", "\t"),
        (lines("CH{n}_Name: {name}\nCH{n}_Unit: {unit}\n", 0) + "\n", ","),
        ("[Channels]\n" + lines("{n}={name},{unit}\n", 1) + "[Data]\nt,i,n,M\n", ","),
    ],
)
def test_columns_are_named_by_their_numbers(tmp_path: Path, head: str, delimiter: str) -> None:
    plan = plan_below(tmp_path / "brake.txt", head, delimiter)
    plan.require_sureness()
    taken = {each.signal: (each.column, each.si) for each in plan.signals}
    assert taken["field"] == ("Current", "A")
    assert taken["slip"] == ("Speed", "rad/s")
    assert taken["effort"] == ("Torque", "N*m")
    assert plan.clock is not None
    assert plan.clock.column == "Time"


@pytest.mark.parametrize(
    "settings",
    [
        "[Gains]\n" + lines("{n}=10.0\n", 1),
        "[Ranges]\n" + lines("Ch{n}=5 V\n", 1),
        "[Filters]\n" + lines("Name{n}=low\n", 1),
        "[Channels]\n" + lines("{n}={name}\n", 1)[: -len("4=Torque\n")],  # one of them is missing
    ],
)
def test_settings_of_channels_are_no_names(tmp_path: Path, settings: str) -> None:
    head = settings + "[Data]\nt,i,w,M\n"
    plan = plan_below(tmp_path / "brake.txt", head, ",")
    assert [*plan.labels] == ["t", "i", "w", "M"]
