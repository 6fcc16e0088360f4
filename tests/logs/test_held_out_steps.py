"""Of a log whose field steps without a gap, some steps are fitted and others judged: else no lag could be told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.comparison import Comparison, compare
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import hold_out, steps_without_a_gap
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

RATE = 500.0
LAG = 0.02  # s
LEVELS = (0.0, 0.2, 0.4, 0.6, 0.4, 0.2, 0.6)
EACH = 1000  # rows


def stepped(gaps: bool) -> Dataset:
    """A brake whose field steps from level to level, with a lag of 20 ms, SYNTHETIC."""
    rng = np.random.default_rng(0)
    command = np.repeat(LEVELS, EACH)
    rows = command.size
    time = np.arange(rows) / RATE
    slip = 10.0 * np.sin(2 * np.pi * 0.7 * time) + 3.0 * np.sin(2 * np.pi * 2.3 * time)
    field = np.empty(rows)
    state = command[0]
    for row in range(rows):
        state += (1.0 - np.exp(-1.0 / (RATE * LAG))) * (command[row] - state)
        field[row] = state
    effort = field**1.5 * np.tanh(slip / 0.3) + 0.012 * slip + 0.01 * rng.standard_normal(rows)
    borders = range(0, rows, EACH) if gaps else [0]
    spans = tuple(
        Span(start, stop, 1 / RATE)
        for start, stop in zip(borders, [*borders[1:], rows], strict=True)
    )
    return Dataset(
        "single", (Element(command, slip),), effort, Clock(time, spans), Units("N*m", "A", "rad/s")
    )


@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
def test_steps_up_and_down_are_fitted_and_judged(share: float) -> None:
    data = stepped(gaps=False)
    assert steps_without_a_gap(data, 0, data.rows)
    test = hold_out(data, share)
    steps = np.cumsum([EACH] * (len(LEVELS) - 1))
    fitted = [
        LEVELS[k] for k, step in enumerate(steps, start=1) if not test[step - 5 : step + 5].any()
    ]
    judged = [
        LEVELS[k] for k, step in enumerate(steps, start=1) if test[step] and not test[step - 1]
    ]
    assert fitted == [0.2, 0.4, 0.2]
    assert judged == [0.4, 0.6, 0.6]
    for level in {*LEVELS}:  # each field is held out as often as it was logged
        assert np.mean(test[data.elements[0].field == level]) == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_the_end_of_each_level_is_held_out_behind_gaps(share: float) -> None:
    data = stepped(gaps=True)
    assert not steps_without_a_gap(data, 0, data.rows)
    held = hold_out(data, share).reshape(len(LEVELS), EACH)
    trained = round((1 - share) * EACH)
    assert not held[:, :trained].any()
    assert held[:, trained:].all()


@pytest.mark.slow
def test_the_lag_of_a_stepped_log_is_found() -> None:
    comparison = compare(stepped(gaps=False), models=("bingham",), lag="lag")
    entry = comparison.entry(comparison.recommended)
    tau = next(estimate for estimate in entry.outcome.estimates if estimate.name == "tau")
    assert tau.value == pytest.approx(LAG, rel=0.05)


@pytest.mark.slow
def test_steps_that_lie_in_rows_held_out_are_told_with_the_remedy() -> None:
    data = stepped(gaps=False)
    rows = ((0, EACH), (EACH, 2 * EACH), (2 * EACH, data.rows))
    spans = tuple(Span(start, stop, 1 / RATE) for start, stop in rows)
    names = ("no field", "a field", "steps")
    logs = replace(data, clock=Clock(data.clock.time, spans), sources=names, source_rows=rows)
    assert "(--test stretches)" in _remedy(compare(logs, models=("bingham",), test="steps"))
    assert "Log with a switching field" in _remedy(compare(stepped(gaps=True), models=("bingham",)))


def _remedy(comparison: Comparison) -> str:
    return " ".join(
        finding.remedy for finding in comparison.findings if finding.subject == "dynamics"
    )
