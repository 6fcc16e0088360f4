"""Known-truth recovery with fewer repetitions than `studies/recovery.py`, whose table is the statement."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from erclutch.models.laws import ladder
from erclutch.models.stages import GROUP, stages_of
from erclutch.registry import plugins
from tests.support import recovery as study

SCRIPT = Path(__file__).resolve().parents[2] / "studies" / "recovery.py"

REPETITIONS = 60
CASES = (*ladder(), "bingham+lag", "bingham+rise-fall")
LOUD = "cho-choi-jhon (loud)"
#: Each law with noise whose neighbours are correlated, as on a bench. Of white noise the intervals know nothing that
#: depends on the law: one with few shapes, one with many gains, one with a root and one with a lag show its part.
NOISES: list[tuple[str, study.Noise]] = [
    *((name, "ar1") for name in CASES),
    *((name, "white") for name in ("bingham", "rbfm-10", "casson", "bingham+lag")),
]
#: Stages; the least of forms and numbers that show each.
STAGES = (
    *(
        "second-order",
        "two-lags",
        "effort-lag",
        "effort-second-order",
        "inertia",
        "inertia/smooth",
        "stiffness",
        "viscous",
    ),
    *("sides", "knees", "stribeck", "remanence", "self-heating"),
    *(
        "dahl",
        "dahl-2/field",
        "stops",
        "stops-2/field",
        "lugre",
        "lugre/field",
        "lugre/field/sides",
    ),
    *("bouc-wen", "bouc-wen-2", "hysteretic-tanh", "spencer"),
)


def test_the_study_has_the_whole_ladder() -> None:
    assert set(study.TRUTHS) == {*CASES, *(f"bingham+{name}" for name in STAGES), LOUD}
    assert set(ladder()) <= set(CASES)


def test_the_study_has_every_stage() -> None:
    shown = {truth.dynamics for truth in study.TRUTHS.values()}
    apart = ("temperature", "position")
    # Stages of temperature and position need a log with one: test_temperature.py and test_ripple.py find their truth.
    ours = [
        plugin.name
        for plugin in plugins(GROUP)
        if plugin.own and stages_of(plugin.name)[0].place not in apart
    ]
    assert [
        name for name in ours if not any(re.fullmatch(name + r"(-\d)?(/\w+)?", s) for s in shown)
    ] == []


def test_the_truth_lies_well_inside_its_bounds() -> None:
    for truth in study.TRUTHS.values():
        for s in truth.structure.shapes(study.PERIOD):
            scale = np.log if s.scale == "log" else float
            value, lower, upper = (float(scale(v)) for v in (truth.shape[s.name], s.lower, s.upper))
            assert 0.04 < (value - lower) / (upper - lower) < 0.96, (truth.name, s.name)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "noise"), NOISES)
def test_intervals_hold_the_truth(name: str, noise: study.Noise) -> None:
    (found,) = study.study([name], [noise], REPETITIONS)
    assert found.converged == REPETITIONS
    assert found.at_bounds == 0
    # 95 % +- 3 points and twice the standard error of a single parameter's share in 60 repetitions (2.8 points): a
    # law's parameters may all be correlated, so pooling them need not make it smaller.
    assert found.pooled >= 0.95 - 0.03 - 0.056, found
    # No single parameter is beyond three standard errors below that: a wrong interval of one parameter shows.
    least = min(found.inside, key=found.inside.__getitem__)
    assert found.inside[least] / REPETITIONS >= 0.95 - 0.03 - 3 * 0.028, (least, found)
    # The estimates scatter around the truth, and intervals are as wide as that scatter: not too wide either.
    assert max(abs(bias) for bias in found.bias.values()) < 4.5 / REPETITIONS**0.5, found
    assert all(0.65 < width < 1.45 for width in found.width.values()), found


@pytest.mark.slow
def test_intervals_hold_the_truth_beside_a_bound() -> None:
    """Many fits end at a bound, where the curvature of the sum of squares says nothing of the other parameters."""
    (found,) = study.study([LOUD], ["ar1"], REPETITIONS // 2)
    assert found.at_bounds >= 3
    assert 0.95 - 0.03 - 0.08 <= found.pooled <= 0.995, found
    assert min(found.inside.values()) / found.repetitions >= 0.8, found


@pytest.mark.slow
@pytest.mark.parametrize("stage", STAGES)
def test_intervals_hold_the_stage(stage: str) -> None:
    """As for laws, with correlated noise alone, and room for fits that stall on the kinks of a stage that stops.

    The stage is found again: numbers that a log tells badly may be off, but then their intervals say so.
    """
    (found,) = study.study([f"bingham+{stage}"], ["ar1"], REPETITIONS // 2)
    assert found.converged >= 0.8 * found.repetitions
    assert found.pooled >= 0.95 - 0.03 - 0.08, found
    assert found.pooled - min(found.inside.values()) / found.repetitions < 0.2, found
    assert np.median(list(found.error.values())) < 0.05, found


@pytest.mark.slow
def test_the_command_says_whether_laws_hit() -> None:
    words = ("--repetitions", "40", "--laws", "bingham", "--noises", "white", "--workers", "1")
    done = subprocess.run(
        [sys.executable, SCRIPT, *words], capture_output=True, text=True, timeout=120
    )
    assert done.returncode in (0, 1), done.stderr
    assert "bingham" in done.stdout
    assert "40/40" in done.stdout
