"""`inspect FOLDER` and `fit-many` say which logs teach nothing new, and what no log has, in the words of the rig."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch import registry
from erclutch.cli.log_advice import GROUP, advice_on
from erclutch.logs.dataset import Dataset, joined
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.wings.design.advice.which_logs import which_logs
from tests.support.command import good

RATE = 200.0  # rows a second


def log_of(name: str, largest_field: float, largest_slip: float, seconds: float = 4.0) -> Dataset:
    """A SYNTHETIC log of a damper, whose field and slip go through all of their ranges, apart from each other."""
    time = np.arange(round(seconds * RATE)) / RATE
    field = largest_field * 0.5 * (1.0 - np.cos(2.0 * np.pi * 0.5 * time))
    slip = largest_slip * np.sin(2.0 * np.pi * 4.3 * time)
    noise = 0.02 * np.random.default_rng(list(name.encode())).standard_normal(time.size)
    effort = 2.0 * field**2 * np.sign(slip) + 0.1 * slip + noise
    clock = Clock(time, (Span(0, time.size, 1.0 / RATE),))
    return Dataset(
        "single", (Element(field, slip),), effort, clock, Units("N", "A", "m/s"), (name,)
    )


def write(folder: Path, data: Dataset) -> None:
    (element,) = data.elements
    columns = np.column_stack([data.clock.time, element.field, element.slip, data.effort])
    np.savetxt(
        folder / f"{data.sources[0]}.csv",
        columns,
        delimiter=",",
        comments="",
        header="time [s],field [A],slip [m/s],effort [N]",
    )


@pytest.mark.slow
def test_a_log_beside_its_copies_teaches_nothing_new() -> None:
    said = which_logs(joined([log_of(f"run{number}", 2.0, 0.4) for number in range(12)]))
    assert len(said) == 2
    assert said[0].startswith("Of 12 logs 2 teach nothing new about field and motion: run")
    assert which_logs(joined([log_of("slow", 2.0, 0.1), log_of("fast", 1.0, 0.4)]))[0] == (
        "Each of the 2 logs shows what the others do not."
    )


@pytest.mark.slow
def test_what_no_log_has_is_said_in_the_units_of_the_rig() -> None:
    """A slow log has the large field, a fast log the small field: no log has both."""
    said = which_logs(joined([log_of("slow", 2.0, 0.1), log_of("fast", 0.9, 0.4)]))
    assert "No log has field 1 .. 2 A with slip -0.4 .. -0.133 m/s." in said
    assert "No log has field 1 .. 2 A with slip 0.133 .. 0.4 m/s." in said


@pytest.mark.slow
def test_of_two_logs_of_the_same_motion_neither_is_said_to_show_what_the_other_does_not() -> None:
    said = which_logs(joined([log_of("monday", 2.0, 0.4), log_of("tuesday", 2.0, 0.4)]))
    assert len(said) == 1
    assert said[0].startswith("Other logs have the field and the motion of ")
    assert "monday" in said[0] or "tuesday" in said[0]


@pytest.mark.slow
def test_a_gap_over_all_fields_is_said_once() -> None:
    slow, fast = log_of("slow", 0.5, 1.0), log_of("fast", 0.5, 1.0)
    apart = [
        replace(log, elements=(Element(log.elements[0].field, slip),))
        for log, slip in (
            (slow, 1.0 + 0.5 * slow.elements[0].slip),
            (fast, 15.0 + 2.0 * fast.elements[0].slip),
        )
    ]
    said = which_logs(joined(apart))
    assert [line for line in said if line.startswith("No log has")] == [
        "No log has field 0 .. 0.5 A with slip 3.25 .. 11.5 m/s."
    ]


@pytest.mark.slow
def test_logs_of_one_field_each_are_told_that_no_field_changes() -> None:
    logs = [log_of(name, 2.0, 0.4) for name in ("low", "high")]
    still = [
        replace(log, elements=(Element(np.full(log.rows, field), log.elements[0].slip),))
        for log, field in zip(logs, (0.5, 2.0), strict=True)
    ]
    assert any(line.startswith("The field changes in no log") for line in which_logs(joined(still)))
    assert not any(
        line.startswith("The field changes in no log") for line in which_logs(joined(logs))
    )


@pytest.mark.parametrize(("field", "slip"), [(0.0, 0.4), (2.0, 0.0)])
def test_logs_of_one_field_or_at_rest_say_nothing(field: float, slip: float) -> None:
    assert which_logs(joined([log_of("a", field, slip), log_of("b", field, slip)])) == []


@pytest.mark.slow
def test_without_the_wing_nothing_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = joined([log_of("slow", 2.0, 0.1), log_of("fast", 0.9, 0.4)])
    assert advice_on(rows) == which_logs(rows)
    monkeypatch.setattr(registry, "plugins", lambda group: {GROUP: ()}[group])
    assert advice_on(rows) == []


@pytest.mark.slow
def test_inspect_of_a_folder_and_fit_many_say_it(tmp_path: Path) -> None:
    logs = tmp_path / "logs"
    logs.mkdir()
    for number in range(12):
        write(logs, log_of(f"run{number}", 2.0, 0.1))
    write(logs, log_of("fast", 0.9, 0.4))
    told = " ".join(good("inspect", "logs", cwd=tmp_path).split())
    assert "Of 13 logs 2 teach nothing new about field and motion: run" in told
    assert "No log has field 1 .. 2 A with slip" in told
    advice = json.loads(good("inspect", "logs", "--json", cwd=tmp_path))["advice"]
    assert advice[0].startswith("Of 13 logs 2")
    assert "advice" not in json.loads(good("inspect", "logs/fast.csv", "--json", cwd=tmp_path))

    few = ("logs/run0.csv", "logs/run1.csv", "logs/fast.csv")
    fleet = good(
        "fit-many",
        *few,
        "--models",
        "bingham",
        "--lag",
        "none",
        "--out",
        "fleet",
        "--json",
        cwd=tmp_path,
    )
    said = json.loads(fleet)["advice"]
    assert said[0].startswith("Other logs have the field and the motion of run")
    assert any(line.startswith("No log has field 1 .. 2 A") for line in said)
