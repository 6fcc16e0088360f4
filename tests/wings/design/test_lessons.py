"""A run tells which of its logs repeat the others: a copy does, and the only log of a field does not."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset, joined
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.wings.design.lessons import Lessons, lessons_of
from tests.support.command import good

pytestmark = pytest.mark.slow

RATE = 200.0  # rows a second
SECONDS = 4.0


def log_of(largest_field: float, largest_slip: float, seed: int) -> Dataset:
    """A SYNTHETIC log of a Bingham device; field and slip go through all of their ranges, apart from each other."""
    time = np.arange(round(SECONDS * RATE)) / RATE
    field = largest_field * 0.5 * (1.0 - np.cos(2.0 * np.pi * 0.5 * time))
    slip = largest_slip * np.sin(2.0 * np.pi * 1.75 * time)
    noise = 0.02 * np.random.default_rng(seed).standard_normal(time.size)
    effort = 2.0 * field**2 * np.sign(slip) + 0.1 * slip + noise
    clock = Clock(time, (Span(0, time.size, 1.0 / RATE),))
    return Dataset(
        "single",
        (Element(field, slip),),
        effort,
        clock,
        Units("N*m", "A", "rad/s"),
        (f"log-{seed}",),
    )


def lessons(logs: Sequence[Dataset]) -> Lessons:
    rows = joined(logs)
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "none", False, False
    )
    model = fit_structure(rows, structure, intervals=False).model
    assert isinstance(model, TorqueModel)
    return lessons_of(model, rows)


def test_logs_that_repeat_are_told_until_an_interval_would_grow() -> None:
    told = lessons([log_of(1.0, 10.0, seed) for seed in range(12)])
    # Of twelve logs alike, each interval grows as one over the root of the logs that stay: ten are the least.
    assert len(told.repeat) == 2
    assert told.growth == pytest.approx(np.sqrt(12 / 10), rel=0.02)
    assert set(told.teach) | set(told.repeat) == {f"log-{seed}" for seed in range(12)}


def test_the_only_log_of_a_field_or_of_a_slip_is_kept() -> None:
    alike = [log_of(1.0, 10.0, seed) for seed in range(12)]
    told = lessons([*alike, log_of(2.0, 10.0, 20), log_of(1.0, 30.0, 30)])
    assert {"log-20", "log-30"} <= set(told.teach)
    assert told.repeat


def test_one_log_repeats_nothing() -> None:
    assert lessons([log_of(1.0, 10.0, 0)]) == Lessons(("log-0",), (), (), 1.0)


def test_the_command_says_which_logs_repeat_others(tmp_path: Path) -> None:
    logs = [f"{seed}.csv" for seed in range(10)]
    for seed, name in enumerate(logs):
        write_synthetic_log(tmp_path / name, 2.0, seed)
    good("fit", *logs, "--models", "bingham", "--lag", "none", "--out", "run", cwd=tmp_path)
    told = json.loads(good("excite", "--run", "run", "--seconds", "2", "--json", cwd=tmp_path))[
        "logs"
    ]
    assert sorted(told["teach"] + told["repeat"]) == logs
    assert told["repeat"]
    printed = good("excite", "--run", "run", "--seconds", "2", "--force", cwd=tmp_path)
    assert f"Of 10 logs {len(told['repeat'])} repeat what the others show" in printed
    assert ", ".join(told["repeat"]) in " ".join(printed.split())
