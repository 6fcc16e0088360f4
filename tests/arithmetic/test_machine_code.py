"""Recursions in machine code against loops, and their derivatives against differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.arithmetic.dual import Dual, partial_of
from erclutch.arithmetic.recursion import machine_code, recur, step_of, switched
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span

lengths = st.lists(st.integers(1, 40), min_size=1, max_size=4)


def clock_of(rows: list[int], periods: list[float | None] | None = None) -> Clock:
    ends = np.cumsum([0, *rows]).tolist()
    steps = periods or [1e-3] * len(rows)
    spans = tuple(Span(a, b, p) for a, b, p in zip(ends, ends[1:], steps, strict=False))
    return Clock(np.arange(float(ends[-1])) * 1e-3, spans)


def noise(seed: int, rows: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, 1.0, rows), rng.normal(size=rows), rng.normal(size=rows)


@pytest.mark.slow
@settings(deadline=None)
@given(lengths, st.integers(0, 99))
def test_arrays_have_the_bits_of_a_loop_over_the_rows(rows: list[int], seed: int) -> None:
    clock = clock_of(rows)
    keep, drive, first = noise(seed, sum(rows))
    assert np.array_equal(
        recur(keep, drive, first, clock),
        np.asarray(recur(keep, array_as_in_c(drive), first, clock)),
    )


@pytest.mark.slow
@settings(deadline=None)
@given(lengths, st.integers(0, 99))
def test_duals_pass_with_the_derivatives_of_differences(rows: list[int], seed: int) -> None:
    clock, h = clock_of(rows), 1e-6
    keep, drive, first = noise(seed, sum(rows))

    def moved(a: float, b: float) -> Array:
        return np.asarray(recur(keep * (1.0 + a), drive + b, first * (1.0 + a * b), clock))

    found = recur(Dual(keep, {0: keep}), Dual(drive, {3: 1.0}), Dual(first, {}), clock)
    assert np.array_equal(found.value, moved(0.0, 0.0))
    np.testing.assert_allclose(
        partial_of(found, 0), (moved(h, 0.0) - moved(-h, 0.0)) / (2 * h), rtol=1e-4, atol=1e-6
    )
    np.testing.assert_allclose(
        partial_of(found, 3), (moved(0.0, h) - moved(0.0, -h)) / (2 * h), rtol=1e-4, atol=1e-6
    )


@pytest.mark.slow
@settings(deadline=None)
@given(lengths, st.integers(0, 99))
def test_rising_rows_are_those_of_a_loop(rows: list[int], seed: int) -> None:
    clock = clock_of(rows)
    up, u, _ = noise(seed, sum(rows))
    down = up[::-1].copy()
    rising = switched(u, up, down, clock)
    for span in clock.spans:
        x = u[span.start]
        assert rising[span.start]
        for i in range(span.start + 1, span.stop):
            assert rising[i] == ((u[i] - x) * x >= 0.0)
            share = up[i] if rising[i] else down[i]
            x += share * (u[i] - x)


def test_one_step_stands_for_all_rows_only_where_all_spans_have_it() -> None:
    assert step_of(clock_of([5, 6])) == 1e-3
    for periods in ([1e-3, 2e-3], [1e-3, None], [None, None]):
        clock = clock_of([5, 6], list(periods))
        assert np.array_equal(step_of(clock), clock.steps)


@pytest.mark.slow
def test_where_nothing_can_be_kept_a_function_is_compiled_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def without_folder(self: object) -> None:
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr("numba.core.dispatcher.Dispatcher.enable_caching", without_folder)

    def doubled(x: float) -> float:
        return 2.0 * x

    assert machine_code(doubled)(3.0) == 6.0
