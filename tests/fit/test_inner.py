"""The bounded linear problem against SciPy's."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from erclutch.fit.solver.bounded_least_squares import solve_bounded
from tests.support.examples import examples

Array = NDArray[np.float64]


def triangle_and_vector(matrix: Array, target: Array) -> tuple[Array, Array]:
    p = matrix.shape[1]
    r = np.asarray(np.linalg.qr(np.column_stack([matrix, target]), mode="r"))
    return r[:p, :p], r[:p, p]


def cost_of(matrix: Array, target: Array, c: Array) -> float:
    return float(np.sum((matrix @ c - target) ** 2))


def peer_cost(matrix: Array, target: Array, nonnegative: NDArray[np.bool_]) -> float:
    lower = np.where(nonnegative, 0.0, -np.inf)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    found = lsq_linear(
        matrix / scale, target, (lower, np.full(lower.size, np.inf)), method="bvls", tol=1e-14
    )
    return 2.0 * float(found.cost)


masks = st.lists(st.booleans(), min_size=1, max_size=12)


@pytest.mark.slow
@settings(max_examples=examples(300), deadline=None)
@given(st.integers(0, 2**32 - 1), masks, st.integers(0, 30), st.floats(-6, 6))
def test_random_problems_equal_bvls(seed: int, mask: list[bool], more: int, decades: float) -> None:
    rng = np.random.default_rng(seed)
    p = len(mask)
    matrix = rng.normal(size=(p + 1 + more, p)) * 10.0 ** rng.uniform(
        -abs(decades), abs(decades), p
    )
    target = rng.normal(size=matrix.shape[0])
    nonnegative = np.array(mask)
    c, held = solve_bounded(*triangle_and_vector(matrix, target), nonnegative)
    assert np.all(c[nonnegative] >= 0.0)
    assert np.all(c[held] == 0.0)
    assert not np.any(held & ~nonnegative)
    best = peer_cost(matrix, target, nonnegative)
    assert cost_of(matrix, target, c) <= best * (1 + 1e-8) + 1e-12


def best_of_all_subsets(matrix: Array, target: Array, nonnegative: NDArray[np.bool_]) -> float:
    """Lowest cost over every choice of columns whose least squares is feasible. (BVLS itself fits rounding here.)"""
    p = matrix.shape[1]
    best = float(target @ target)
    for chosen in itertools.product([False, True], repeat=p):
        columns = np.array(chosen)
        c = np.asarray(np.linalg.lstsq(matrix[:, columns], target, rcond=1e-10)[0], np.float64)
        if np.all(c[nonnegative[columns]] >= -1e-12):
            best = min(best, cost_of(matrix[:, columns], target, c))
    return best


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 6), st.integers(1, 4))
def test_rank_deficient_problems_reach_the_lowest_cost(seed: int, p: int, rank: int) -> None:
    rng = np.random.default_rng(seed)
    rank = min(rank, p - 1)
    matrix = rng.normal(size=(3 * p, rank)) @ rng.normal(size=(rank, p))
    target = rng.normal(size=3 * p)
    nonnegative = rng.random(p) < 0.6
    c, held = solve_bounded(*triangle_and_vector(matrix, target), nonnegative)
    assert np.abs(c).max() < 1e9
    assert np.all(c[nonnegative] >= 0.0)
    assert np.all(c[held] == 0.0)
    assert (
        cost_of(matrix, target, c)
        <= best_of_all_subsets(matrix, target, nonnegative) * (1 + 1e-6) + 1e-9
    )


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 10))
def test_the_conditions_of_a_minimum_hold(seed: int, p: int) -> None:
    """Gradient zero over what is free, pointing out of bounds over what is held."""
    rng = np.random.default_rng(seed)
    matrix, target = rng.normal(size=(4 * p, p)), rng.normal(size=4 * p)
    c, held = solve_bounded(*triangle_and_vector(matrix, target), np.ones(p, np.bool_))
    gradient = matrix.T @ (target - matrix @ c)
    assert np.allclose(gradient[~held], 0.0, atol=1e-9)
    assert np.all(gradient[held] <= 1e-9)


def test_all_free_is_least_squares() -> None:
    rng = np.random.default_rng(3)
    matrix, target = rng.normal(size=(20, 5)), rng.normal(size=20)
    c, held = solve_bounded(*triangle_and_vector(matrix, target), np.zeros(5, np.bool_))
    assert not held.any()
    assert np.allclose(c, np.linalg.lstsq(matrix, target)[0])


def test_all_wanted_negative_are_held() -> None:
    matrix = np.eye(4)
    c, held = solve_bounded(matrix, -np.ones(4), np.ones(4, np.bool_))
    assert held.all()
    assert c.tolist() == [0.0] * 4


def test_a_column_of_zeros_and_a_target_of_zeros() -> None:
    triangle = np.diag([1.0, 0.0])
    c, _ = solve_bounded(triangle, np.array([2.0, 0.0]), np.ones(2, np.bool_))
    assert c.tolist() == [2.0, 0.0]
    c, _ = solve_bounded(np.eye(3), np.zeros(3), np.ones(3, np.bool_))
    assert c.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.slow
def test_a_coefficient_that_was_dropped_comes_back() -> None:
    """Two steep opposite columns: dropping all that is negative at first leaves one too few."""
    rng = np.random.default_rng(0)
    dropped_and_back = 0
    for _ in range(400):
        matrix, target = rng.normal(size=(6, 4)), rng.normal(size=6)
        free = np.linalg.lstsq(matrix, target)[0]
        c, _ = solve_bounded(*triangle_and_vector(matrix, target), np.ones(4, np.bool_))
        dropped_and_back += int(np.any((free < 0) & (c > 0)))
        assert (
            cost_of(matrix, target, c)
            <= peer_cost(matrix, target, np.ones(4, np.bool_)) * (1 + 1e-9) + 1e-12
        )
    assert dropped_and_back > 5
