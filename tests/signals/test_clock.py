"""Stretches and spans by brute force, recordings, speeds and slips there and back, how far a filter looks."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

from erclutch.signals.clock import Clock, Span, cut_spans, stretches, within
from erclutch.signals.device import slips_of, speeds_of
from erclutch.signals.recording import Recording
from erclutch.signals.speed import Derivative, differentiate, reach


@pytest.mark.parametrize("seed", range(5))
def test_stretches_of_a_mask(seed: int) -> None:
    mask = np.random.default_rng(seed).random(40) > 0.4
    found = stretches(mask)
    again = np.zeros(40, np.bool_)
    for a, b in found:
        again[a:b] = True
        assert a < b
        assert a == 0 or not mask[a - 1]
        assert b == 40 or not mask[b]
    np.testing.assert_array_equal(again, mask)
    assert stretches(np.zeros(3, np.bool_)) == []


def test_parts_of_spans() -> None:
    spans = (Span(0, 5, 1.0), Span(5, 6, None), Span(6, 12, 2.0))
    assert within(spans, 3, 8) == (Span(0, 2, 1.0), Span(2, 3, None), Span(3, 5, 2.0))
    assert cut_spans(spans, 3, 8) == (Span(0, 2, 1.0), Span(3, 5, 2.0))
    assert within(spans, 5, 5) == ()
    assert cut_spans(spans, 4, 7) == ()
    assert within(spans, 0, 12) == spans


def test_a_recording_is_copied_whole_and_stays_read_only() -> None:
    time = np.array([0.0, 0.5, 1.0, 9.0, 9.5])
    signals = {"slip": np.arange(5.0)}
    log = Recording("a", signals, {"slip": "m/s"}, time, 0.5, ((0, 3), (3, 5)), True, "")
    assert log.rows == 5
    assert log.duration == pytest.approx(1.5 + 1.0)
    for again in (copy.deepcopy(log), pickle.loads(pickle.dumps(log))):
        np.testing.assert_array_equal(again.signals["slip"], signals["slip"])
        assert not again.signals["slip"].flags.writeable
        assert not again.time.flags.writeable
        assert again.units == {"slip": "m/s"}
        with pytest.raises(TypeError):
            again.signals["slip"] = time  # pyright: ignore[reportIndexIssue]


@pytest.mark.parametrize("device", ["single", "coaxial"])
def test_speeds_there_and_back(device: str) -> None:
    speeds = np.random.default_rng(0).normal(size=(1 if device == "single" else 2, 20))
    np.testing.assert_allclose(speeds_of(device, slips_of(device, [*speeds])), speeds, atol=1e-15)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("derivative", "rows"),
    [(Derivative("central"), 1), (Derivative("difference"), 1), (Derivative("savgol", window=9), 9),
     (Derivative("lowpass", cutoff=30.0), None), (Derivative("kalman", cutoff=30.0), None)],
)  # fmt: skip
def test_a_speed_depends_on_no_row_beyond_its_reach(
    derivative: Derivative, rows: int | None
) -> None:
    far = reach(derivative, 1e-3)
    assert rows in (None, far)
    n = 2 * far + 200
    clock = Clock(np.arange(float(n)) * 1e-3, (Span(0, n, 1e-3),))
    x = np.zeros(n)
    x[100 + far // 2] = 1.0
    effect = np.abs(differentiate(x, clock, derivative))
    away = np.abs(np.arange(n) - 100 - far // 2)
    assert effect[away > far].max(initial=0.0) <= 1e-13 * effect.max()
    if rows is None:  # not much further than it must be: half of it would not do
        assert effect[away > far // 2].max() > 1e-13 * effect.max()


def test_the_steps_of_a_clock_are_made_once_and_kept_from_change() -> None:
    """A search for memory asks thousands of times: made anew, they took two thirds of a fit to a log with 74 gaps."""
    time = np.array([0.0, 0.1, 0.3, 7.0, 9.0, 9.5, 10.0])
    clock = Clock(time, (Span(0, 3, None), Span(3, 4, None), Span(4, 7, 0.5)))
    np.testing.assert_allclose(clock.steps, [0.1, 0.1, 0.2, 1.0, 0.5, 0.5, 0.5])
    assert clock.steps is clock.steps
    with pytest.raises(ValueError, match="read-only"):
        clock.steps[0] = 1.0
    later = replace(clock, time=2.0 * time)
    np.testing.assert_allclose(later.steps[:3], [0.2, 0.2, 0.4])
