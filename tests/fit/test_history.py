"""An error that depends on where the slip came from is named; an error that does not is left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from erclutch.fit.comparison import Settings, compare
from erclutch.fit.history import HISTORY, effort_finding, history
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

RATE = 1000.0


def made(
    seed: int, *, memory: float = 0.0, inertia: float = 0.0, lag: float = 0.0, rows: int = 8000
) -> Dataset:
    """A device whose yield effort remembers the slip by a share, under a switched field and correlated noise."""
    rng = np.random.default_rng(seed)
    command = np.repeat(rng.uniform(0.0, 1.0, rows // 100) * (rng.random(rows // 100) > 0.3), 100)
    t = np.arange(rows) / RATE
    hertz, phase = rng.uniform(0.3, 8.0, 8), rng.uniform(0.0, 2 * np.pi, 8)
    slip = 0.6 * np.sin(2 * np.pi * hertz[:, None] * t + phase[:, None]).sum(axis=0)
    left = np.exp(-1.0 / (RATE * lag)) if lag else 0.0
    field: Array = np.asarray(lfilter([1.0 - left], [1.0, -left], command))
    turned = memory * _dahl(slip, 0.01) + (1.0 - memory) * np.tanh(slip / 0.1)
    noise = 0.02 * lfilter([(1 - 0.9**2) ** 0.5], [1.0, -0.9], rng.normal(size=rows))
    effort = field**1.3 * turned + 0.3 * slip + 0.2 * np.sign(slip) * np.sqrt(np.abs(slip))
    effort += inertia * np.gradient(slip, t) + noise
    clock = Clock(t, (Span(0, rows, 1 / RATE),))
    return Dataset("single", (Element(command, slip),), effort, clock, Units("N", "V", "m/s"))


def _dahl(slip: Array, travel: float) -> Array:
    """The sum s_k = (1 - g_k) s_(k-1) + g_k sgn w_k, row by row."""
    out, state = np.empty(slip.size), 0.0
    for k, w in enumerate(slip.tolist()):
        gone = -np.expm1(-abs(w) / (RATE * travel))
        state = (1.0 - gone) * state + gone * np.sign(w)
        out[k] = state
    return out


def of_a_wrong_law(data: Dataset) -> Array:
    """What Bingham's law leaves: the device above is another one, and the field lags."""
    (element,) = data.elements
    columns = np.column_stack(
        [element.field * np.tanh(element.slip / 0.1), element.slip, np.ones(data.rows)]
    )
    return data.effort - columns @ np.linalg.lstsq(columns, data.effort, rcond=None)[0]


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_a_wrong_law_or_a_lag_is_not_taken_for_memory(lag: float) -> None:
    fired = [
        bool(history(data, of_a_wrong_law(data)) or history(data))
        for data in (made(k, lag=lag) for k in range(10))
    ]
    assert not any(fired)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("memory", "inertia", "stage"), [(0.6, 0.0, "dahl/field"), (0.0, 0.005, "inertia")]
)
def test_memory_is_found_and_named(memory: float, inertia: float, stage: str) -> None:
    found = [
        history(data, of_a_wrong_law(data))
        for data in (made(k, memory=memory, inertia=inertia) for k in range(10))
    ]
    named = [each.stage for each in found if each is not None]
    assert len(named) >= 9
    assert named.count(stage) >= 8


@pytest.mark.slow
def test_a_model_that_remembers_has_nothing_left() -> None:
    data = made(3, memory=1.0)
    plain = compare(data, Settings(models=("bingham",), lag="none"))
    (finding,) = [f for f in plain.findings if f.subject == HISTORY]
    assert finding.level == "warning"
    assert "the error of Bingham law depends on where the slip came from" in finding.message
    assert finding.remedy == "Fit with --lag dahl/field"
    found = compare(data, Settings(models=("bingham",), lag="dahl/field"))
    assert HISTORY not in {f.subject for f in found.findings}


@pytest.mark.slow
def test_the_effort_alone_tells() -> None:
    found = effort_finding(made(0, memory=1.0))
    assert found is not None
    assert (found.level, found.subject) == ("note", HISTORY)
    assert "dahl/field" in found.message
    assert "--lag auto" in found.remedy
    assert effort_finding(made(0)) is None


def test_few_rows_and_wild_errors_say_nothing() -> None:
    data = made(0, memory=1.0, rows=900)
    assert history(data) is None
    whole = made(0, memory=1.0)
    assert history(whole, np.full(whole.rows, np.inf)) is None


@pytest.mark.slow
def test_a_richer_stage_of_the_family_takes_the_place_of_a_simpler_one() -> None:
    data = made(1, memory=1.0)
    found = history(data, dynamics="lag+dahl/field+inertia")
    assert found is not None
    assert found.stage == "dahl-2/field"
    assert history(data, dynamics="lag+dahl-2/field+inertia/smooth") is None


@pytest.mark.slow
def test_the_share_is_of_what_field_and_slip_leave() -> None:
    """A large viscous effort, which they explain, changes nothing."""
    data = made(3, memory=0.6)
    plain = history(data)
    large = history(replace(data, effort=data.effort + 30.0 * data.elements[0].slip))
    assert plain is not None
    assert large is not None
    assert large.stage == plain.stage
    assert large.share == pytest.approx(plain.share, abs=0.02)
