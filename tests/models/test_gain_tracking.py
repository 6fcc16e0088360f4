"""A tracked gain follows a device that changes, and never costs more than 2 % whatever the sensor does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.models.gain_tracking import BASE, REACH, GainTracking, Tracked
from erclutch.signals.array import Array
from tests.support.examples import examples
from tests.support.slow_params import slow_but

LIMIT = 2.0
ALLOWED = 1.02 + 1e-9  # of the RMSE, with room for rounding
TRACKING = GainTracking(LIMIT, -5.0, 5.0)


def given_out(state: Tracked, effort: Array) -> Array:
    """The effort that is given out for that of the model, before the sensor is read."""
    moved, cost = TRACKING.moved(state, effort)
    return np.where(cost < state.account, moved, effort)


def ran(
    efforts: Array, sensor: Callable[[int, Array], Array], state: Tracked = BASE
) -> tuple[Array, Array, Tracked]:
    """Sums of squares of the clipped errors after each row, given out and of the base, and the last state.

    Args:
        efforts: of the model, shape (rows, streams).
        sensor: what it says at a row, in the knowledge of the effort that was given out.
        state: to begin with.
    """
    mine, base = np.zeros(efforts.shape), np.zeros(efforts.shape)
    state = Tracked(*(np.broadcast_to(x, efforts.shape[1:]) for x in state))
    for k, effort in enumerate(efforts):
        out = given_out(state, effort)
        said = sensor(k, out)
        finite = np.isfinite(said)
        with np.errstate(all="ignore"):
            after = TRACKING.after(state, effort, out, said)
            errors = [
                np.where(finite, np.clip(said - value, -LIMIT, LIMIT), 0.0) ** 2
                for value in (out, effort)
            ]
        state = Tracked(
            *(np.where(finite, new, old) for new, old in zip(after, state, strict=True))
        )
        mine[k], base[k] = errors
        assert np.all(np.abs(state.gain - 1.0) <= REACH + 1e-12)
        assert np.all(np.abs(state.offset) <= REACH)
        assert np.all(state.account >= 0.0)
    return np.cumsum(mine, axis=0), np.cumsum(base, axis=0), state


def efforts_of(seed: int, rows: int = 3000) -> Array:
    rng = np.random.default_rng(seed)
    t = np.arange(rows) / 1000.0
    return np.sin(2 * np.pi * rng.uniform(0.3, 5.0) * t) + 0.3 * np.sin(
        2 * np.pi * rng.uniform(1.0, 9.0) * t
    )


@pytest.mark.slow
def test_a_gain_and_an_offset_are_followed() -> None:
    efforts, rng = efforts_of(0, 4000)[:, None], np.random.default_rng(0)
    truth = 1.15 * efforts + 0.1 + 0.01 * rng.normal(size=efforts.shape)
    mine, base, state = ran(efforts, lambda k, _: truth[k])
    assert state.gain == pytest.approx(1.15, abs=0.005)
    assert state.offset * LIMIT == pytest.approx(0.1, abs=0.005)
    assert mine[-1] - mine[2000] < 0.02 * (base[-1] - base[2000])


@pytest.mark.slow
def test_what_is_right_is_left_alone() -> None:
    efforts = efforts_of(1, 500)[:, None]
    _, _, state = ran(efforts, lambda k, _: efforts[k])
    assert tuple(x.item() for x in state) == BASE


@pytest.mark.slow
def test_after_a_long_good_time_a_wrong_estimate_is_left_soon() -> None:
    efforts = np.abs(efforts_of(2, 4000))[:, None] + 0.5
    _, _, good = ran(efforts[:3000], lambda k, _: 1.2 * efforts[k])
    lost, _, _ = ran(efforts[3000:], lambda k, _: efforts[3000 + k], good)
    assert 0.0 < lost[-1] <= 10.0 * LIMIT**2


def test_the_adapted_effort_keeps_to_the_limits() -> None:
    state = BASE._replace(gain=1.3, offset=0.3, account=10.0)
    assert given_out(state, np.array([-4.0, 4.9])).tolist() == [1.3 * -4.0 + 0.6, 5.0]


KINDS = (
    "stuck",
    "spikes",
    "drift",
    "flipped",
    "missing",
    "noise",
    "jumps",
    "adversary",
    "late adversary",
)


def said_of(kind: str, efforts: Array, rng: np.random.Generator) -> tuple[Array, int]:
    """What a broken or hostile sensor says, and the row from which it turns."""
    rows, turn = efforts.size, int(rng.integers(1, efforts.size))
    said = rng.uniform(0.7, 1.3) * efforts + rng.uniform(-0.3, 0.3)
    if kind == "stuck":
        said[turn:] = said[turn]
    elif kind == "spikes":
        said[rng.integers(0, rows, rows // 20)] = rng.choice([-1e9, 1e9, 1e300, 3.0])
    elif kind == "drift":
        said += np.linspace(0.0, rng.uniform(-5.0, 5.0), rows)
    elif kind == "flipped":
        said *= np.where(np.arange(rows) // max(1, turn // 4) % 2, -1.0, 1.0)
    elif kind == "missing":
        said[rng.random(rows) < 0.3] = rng.choice([np.nan, np.inf, -np.inf])
    elif kind == "noise":
        said = rng.normal(0.0, rng.uniform(0.0, 3.0), rows)
    elif kind == "jumps":
        said = said * np.repeat(rng.uniform(0.0, 2.0, rows // 50 + 1), 50)[:rows]
    return said, 0 if kind == "adversary" else turn


def never_worse(kind: str, seeds: range, rows: int) -> float:
    """The largest RMSE over that of the base after any row of the streams of a kind."""
    rngs = [np.random.default_rng(seed) for seed in seeds]
    efforts = [efforts_of(seed, rows) for seed in seeds]
    found: list[Any] = [said_of(kind, e, rng) for e, rng in zip(efforts, rngs, strict=True)]
    effort, said, turn = (
        np.array(efforts).T,
        np.array([s for s, _ in found]).T,
        np.array([t for _, t in found]),
    )

    def worst(k: int, out: Array) -> Array:
        """Teach a wrong gain while the base is given out, and side with the base once the estimate is."""
        return np.where(
            (out != effort[k]) & (k >= turn), effort[k] - 1e3 * (out - effort[k]), said[k]
        )

    mine, base, _ = ran(effort, worst if "adversary" in kind else lambda k, _: said[k])
    some = base > 1e-9
    assert np.all(mine[~some] <= 1e-8)
    return float(np.sqrt((mine[some] / base[some]).max(initial=0.0)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", slow_but(("stuck", "missing", "jumps", "adversary"), KINDS))
def test_a_thousand_hostile_streams_cost_at_most_two_per_cent_after_any_row(kind: str) -> None:
    assert never_worse(kind, range(120), 600) <= ALLOWED


@pytest.mark.slow
@settings(max_examples=examples(40), deadline=None)
@given(
    st.lists(st.tuples(st.floats(-3.0, 3.0), st.floats(allow_nan=True)), min_size=1, max_size=60)
)
def test_no_stream_at_all_costs_more(rows: list[tuple[float, float]]) -> None:
    efforts, said = np.array(rows).T[:, :, None]
    mine, base, _ = ran(efforts, lambda k, _: said[k])
    assert np.all(mine <= ALLOWED**2 * base + 1e-9)
