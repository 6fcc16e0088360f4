"""Zeros and gains that differ between logs are found, and nothing where they do not."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pytest

from erclutch.fit.checks.finding import Finding
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.log_zeros import log_differences, per_log
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.signals.array import Array


def truth(field: Array, slip: Array) -> Array:
    return 6 * field**1.5 * np.tanh(slip / 0.2) + 2 * slip


def logs(
    zeros: Sequence[float], gains: Sequence[float], seed: int = 0, *, forward: bool = False
) -> Dataset:
    """Logs of one made-up damper whose sensor has a zero and a gain of its own in each."""
    made = []
    for k, (zero, gain) in enumerate(zip(zeros, gains, strict=True)):
        rng = np.random.default_rng(100 * seed + k)
        t = np.arange(2000) / 1000
        field = np.repeat(np.concatenate([[0.0, 2.0], rng.uniform(0, 2, 38)]), 50)
        slip = 3 * np.sin(2 * np.pi * 1.7 * t + rng.uniform(0, 6)) + np.sin(2 * np.pi * 0.6 * t)
        slip = np.abs(slip) + 0.1 if forward else slip
        noise = np.convolve(0.5 * rng.standard_normal(t.size + 4), np.full(5, 0.447), "valid")
        signals = {"field": field, "slip": slip, "effort": gain * truth(field, slip) + zero + noise}
        units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
        made.append(recording_from_arrays(signals, units, rate=1000.0, name=f"log{k}.csv"))
    return build_dataset(made)


def found(data: Dataset) -> dict[str, Finding]:
    element = data.elements[0]
    return {f.subject: f for f in log_differences(data, truth(element.field, element.slip))}


def test_a_zero_of_one_log_is_found_and_named() -> None:
    findings = found(logs((0.0, 0.0, 1.5, 0.0), (1.0,) * 4))
    assert set(findings) == {"zero"}
    said = re.search(
        r"between logs: log2.csv \+(\S+) \+- (\S+) N\*m; the usual log log",
        findings["zero"].message,
    )
    assert said is not None
    value, width = map(float, said.groups())
    assert abs(value - 1.5) < 1.5 * width < 0.2


def test_a_gain_of_one_log_is_found_and_is_no_zero() -> None:
    findings = found(logs((0.0,) * 4, (1.0, 1.1, 1.0, 1.0)))
    assert set(findings) == {"gain"}
    assert "log1.csv +10" in findings["gain"].message


@pytest.mark.slow
def test_equal_logs_say_nothing() -> None:
    said = sum(len(found(logs((0.0,) * 5, (1.0,) * 5, seed))) for seed in range(1, 41))
    assert said == 0


def test_slips_of_one_sign_cannot_tell_a_zero() -> None:
    assert found(logs((0.0, 1.5), (1.0, 1.0), forward=True)) == {}


def test_one_log_and_wild_predictions_say_nothing() -> None:
    assert found(logs((1.0,), (1.0,))) == {}
    data = logs((0.0, 2.0), (1.0, 1.0))
    assert log_differences(data, np.full(data.rows, np.nan)) == ()


@pytest.mark.slow
def test_the_chance_is_that_of_the_f_test() -> None:
    """Of equal logs with white noise, chances are spread evenly over 0 to 1."""
    rng = np.random.default_rng(0)
    chances = []
    for _ in range(300):
        beside = [rng.standard_normal(300) for _ in range(4)]
        residuals = [rng.standard_normal(300) for _ in range(4)]
        chances.append(per_log(residuals, [np.ones(300)] * 4, beside).chance)
    assert (
        0.3 < np.mean(chances) < 0.6
    )  # correlated rows are allowed for, so rather too small than too large
    assert np.mean(np.array(chances) < 0.05) < 0.12


@pytest.mark.slow
def test_a_comparison_says_it_and_keeps_one_offset() -> None:
    data = logs((0.0, 0.0, 1.5, 0.0), (1.0,) * 4)
    compared = compare(data, Settings(models=("bingham",), lag="none", workers=1))
    assert [f.subject for f in compared.findings if f.subject in ("zero", "gain")] == ["zero"]
    names = [e.name for e in compared.entry("bingham").outcome.estimates]
    assert names.count("T_0") == 1
    rmse = float(
        np.sqrt(np.mean((data.effort - compared.entries[0].predicted)[compared.test] ** 2))
    )
    assert compared.entries[0].test.rmse.value == pytest.approx(rmse)
