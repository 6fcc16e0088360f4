"""One field after another in one log, without a gap between: a share of each is held out, not the last field alone."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import hold_out
from erclutch.logs.rows.field_plateaus import plateaus
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

EACH = 1000  # rows of a field
RANDOM = np.random.default_rng(5)
STAIRS = np.repeat([0.0, 0.5, 1.0, 1.5, 1.0, 0.5, 0.0], EACH)
UP = np.repeat([0.0, 0.5, 1.0], EACH)


def through_coil(field: np.ndarray, rows: float = 15.0) -> np.ndarray:
    """The field as a coil follows it, with a time constant of so many rows."""
    current = np.empty_like(field)
    held = field[0]
    for row, asked in enumerate(field):
        held += (asked - held) / rows
        current[row] = held
    return current


def noisy(field: np.ndarray) -> np.ndarray:
    return field + RANDOM.normal(0.0, 0.004, field.size)


def log_of(field: np.ndarray, gaps: tuple[int, ...] = ()) -> Dataset:
    slip = np.sin(np.arange(field.size) / 7)
    edges = [0, *gaps, field.size]
    spans = tuple(Span(a, b, 1e-3) for a, b in pairwise(edges))
    clock = Clock(np.arange(field.size, dtype=np.float64) * 1e-3, spans)
    return Dataset("single", (Element(field, slip),), slip, clock, Units("N", "A", "m/s"))


@pytest.mark.parametrize(
    "measured", [np.asarray, noisy, through_coil, lambda field: noisy(through_coil(field))]
)
@pytest.mark.parametrize("field", [UP, STAIRS, UP[::-1] - 3.0], ids=["up", "stairs", "below zero"])
def test_a_share_of_each_field_is_held_out(
    field: np.ndarray, measured: Callable[[np.ndarray], np.ndarray]
) -> None:
    held = hold_out(log_of(measured(field)), 0.3)
    shares = [held[field == level].mean() for level in np.unique(field)]
    np.testing.assert_allclose(shares, 0.3, atol=0.03)
    assert not held[:300].any()  # nobody knows what the fluid remembers there


def test_a_gap_cuts_a_field_too() -> None:
    held = hold_out(log_of(UP, gaps=(500,)), 0.3)
    np.testing.assert_array_equal(
        np.flatnonzero(held),
        [*range(175, 325), *range(675, 825), *range(1000, 1300), *range(2000, 2300)],
    )


def test_the_fields_of_a_pair_are_looked_at_together() -> None:
    both = plateaus([np.repeat([0.0, 1.0, 0.0], EACH), np.repeat([1.0, 0.0, 0.0], EACH)])
    assert both == [(0, EACH), (EACH, 2 * EACH), (2 * EACH, 3 * EACH)]
    assert plateaus([UP, np.zeros(UP.size)]) == plateaus([UP])


@pytest.mark.parametrize(
    "field",
    [
        np.zeros(3000),
        np.linspace(0.0, 1.0, 3000),
        np.sin(np.arange(3000) / 100),
        np.repeat(RANDOM.integers(0, 2, 60).astype(np.float64), 50),
        np.repeat(RANDOM.random(60), 50),
        np.r_[np.zeros(2990), np.ones(10)],
        np.zeros(0),
    ],
    ids=["constant", "ramp", "sine", "switched", "random levels", "a blip", "no rows"],
)
def test_other_fields_have_no_plateaus(field: np.ndarray) -> None:
    assert plateaus([field]) == []


def test_a_field_that_sweeps_is_cut_at_the_end() -> None:
    held = hold_out(log_of(np.sin(np.arange(3000) / 100)), 0.3)
    np.testing.assert_array_equal(np.flatnonzero(held), range(2100, 3000))
