"""Recursions against their rows one by one: values, bits, derivatives, compiled or not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.arithmetic import recursion
from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.arithmetic.dual import Dual, partial_of, seed, value_of
from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.recursion import follow, recur, step_of
from erclutch.signals.clock import Clock, Span

CLOCK = Clock(np.arange(90.0), (Span(0, 40, 1.0), Span(40, 41, 1.0), Span(41, 90, 1.0)))
rng = np.random.default_rng(3)
U = rng.normal(size=90)


def turning(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
    """Two states that are coupled, linear in themselves."""
    x, v, u, a, b = before[0], before[1], given[0], given[1], given[2]
    return a * x + b * v + u, a * v - b * x


def bent(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
    """Two states, the first of which stops at an edge and drives the second one."""
    x, v, u, edge = before[0], before[1], given[0], given[1]
    held = less_select(x + u, edge, x + u, edge)
    held = less_select(-edge, held, held, -edge)
    return held, 0.7 * v + held * held / (1.0 + v * v)


def row_by_row(advance: Any, first: tuple[float, ...], inputs: list[Any]) -> np.ndarray:
    out = []
    for span in CLOCK.spans:
        state = first
        for k in range(span.start, span.stop):
            if k > span.start:
                state = advance(state, tuple(float(np.broadcast_to(x, 90)[k]) for x in inputs))
            out.append(state)
    return np.array(out).T


CASES = pytest.mark.parametrize(
    ("advance", "numbers", "linear"),
    [(turning, [0.8, 0.3], True), (turning, [0.8, 0.3], False), (bent, [0.9], False)],
    ids=["linear", "linear, rolled", "bent"],
)


@CASES
@pytest.mark.parametrize(
    "limit", [pytest.param(0, marks=pytest.mark.slow), 10**9], ids=["compiled", "python"]
)
def test_values_and_bits(
    advance: Any, numbers: list[float], linear: bool, limit: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recursion, "_WORTH_COMPILING", limit)
    expected = row_by_row(advance, (0.2, -0.1), [U, *numbers])
    found = follow(advance, (0.2, -0.1), [U, *numbers], CLOCK, linear=linear)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)
    exact = follow(advance, (0.2, -0.1), [array_as_in_c(U), *numbers], CLOCK, linear=linear)
    np.testing.assert_array_equal(np.array(exact), expected)


@CASES
def test_derivatives_by_numbers_inputs_and_the_first_state(
    advance: Any, numbers: list[float], linear: bool
) -> None:
    at = [*numbers, 1.0, 0.2, -0.1]

    def run(q: list[Any]) -> tuple[Any, ...]:
        *own, scale, first, second = q
        return follow(advance, (first, second), [scale * U, *own], CLOCK, linear=linear)

    found = run(list(seed(at)))
    for i, value in enumerate(at):
        ends = [run([*at[:i], value + h, *at[i + 1 :]]) for h in (1e-7, -1e-7)]
        for state, up, down in zip(found, *ends, strict=True):
            slope = (up - down) / 2e-7
            np.testing.assert_allclose(
                partial_of(state, i) + 0.0 * slope, slope, atol=1e-6 * np.abs(slope).max() + 1e-9
            )


@pytest.mark.slow
@given(
    st.lists(st.floats(-3.0, 3.0), min_size=90, max_size=90),
    st.floats(0.0, 1.0),
    st.floats(-2.0, 2.0),
)
def test_one_linear_state_is_recur(drive: list[float], keep: float, first: float) -> None:
    def advance(before: tuple[Any, ...], given: tuple[Any, ...]) -> tuple[Any, ...]:
        return (given[1] * before[0] + given[0],)

    one = recur(Dual(keep, {0: 1.0}), np.array(drive), first, CLOCK)
    (two,) = follow(advance, (first,), [np.array(drive), Dual(keep, {0: 1.0})], CLOCK, linear=True)
    # Fits go through BLAS, which may fuse a product and a sum. The bits of the C are asked for by an exact drive.
    np.testing.assert_allclose(value_of(one), value_of(two), rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(partial_of(one, 0), partial_of(two, 0), rtol=1e-12, atol=1e-12)
    one = recur(keep, array_as_in_c(np.array(drive)), first, CLOCK)
    (two,) = follow(advance, (first,), [array_as_in_c(np.array(drive)), keep], CLOCK, linear=True)
    np.testing.assert_array_equal(np.array(one), np.array(two))


def test_a_step_that_all_rows_share_is_a_number() -> None:
    assert step_of(CLOCK) == 1.0
    stamps = Clock(CLOCK.time, (Span(0, 40, 1.0), Span(40, 90, None)))
    np.testing.assert_array_equal(step_of(stamps), np.ones(90))


def test_the_loop_in_python_has_the_bits_of_the_compiled_one() -> None:
    drawn = np.random.default_rng(3)
    keep, drives = drawn.uniform(-1.1, 1.1, 3000), drawn.normal(size=(2, 3000)) * 1e150
    plain, compiled = drives.copy(), drives.copy()
    recursion.run_plainly(keep, plain, [0, 1000, 1001])
    recursion.machine_code(recursion.run_all)(keep, compiled, np.array([0, 1000, 1001]))
    assert plain.tobytes() == compiled.tobytes()


def test_the_search_for_modes_in_python_has_the_bits_of_the_compiled_one() -> None:
    drawn = np.random.default_rng(4)
    command, up, down = drawn.normal(size=3000), *drawn.uniform(0.0, 1.0, (2, 3000))
    plain, compiled = np.ones((2, 3000), np.bool_)
    recursion.run_switched_plainly(command, up, down, [0, 1000, 1001], plain)
    recursion.machine_code(recursion.run_switched)(
        command, up, down, np.array([0, 1000, 1001]), compiled
    )
    assert plain.tobytes() == compiled.tobytes()
    assert 500 < np.count_nonzero(plain) < 2500


def test_a_program_that_runs_through_many_rows_is_worth_a_compiler() -> None:
    allowance = recursion._Allowance(100)
    assert [allowance.take(rows) for rows in (40, 40, 40, 1)] == [True, True, False, False]
