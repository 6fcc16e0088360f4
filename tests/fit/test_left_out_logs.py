"""Errors on new motions, without a second fit, and the bands that they make (SYNTHETIC, truth known)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.bands.prediction_bands import LEVEL, calibrated, coverage
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.left_out_logs import unseen_errors
from erclutch.fit.networks.fit_network import fit_network
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.networks import network_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD, ROWS = 0.01, 300


def _logs(
    rng: np.random.Generator, motions: int, fields: tuple[float, ...] = (1.0,)
) -> tuple[Dataset, Array]:
    """Sines of random speed and frequency at each field, and what the effort is made of, shape (n, 4).

    Each motion has gains of its own around those that are common to all, so a motion that was fitted says little of the
    next one.
    """
    t = PERIOD * np.arange(float(ROWS))
    slips, columns, efforts, levels = [], [], [], []
    for _ in range(motions):
        turns, speed, gains = (
            rng.uniform(0.5, 4.0),
            rng.uniform(0.5, 2.0),
            1.0 + 0.3 * rng.standard_normal(4),
        )
        for level in fields:
            slip = speed * np.sin(2 * np.pi * turns * t + rng.uniform(0, 6))
            x = np.column_stack(
                [
                    level * np.tanh(3 * slip),
                    slip,
                    slip * np.abs(slip),
                    np.gradient(slip, PERIOD) / 20,
                ]
            )
            slips.append(slip)
            columns.append(x)
            levels.append(np.full(ROWS, level))
            efforts.append(x @ gains + 0.02 * rng.standard_normal(ROWS))
    k = len(slips)
    starts = ROWS * np.arange(k)
    spans = tuple(Span(int(a), int(a) + ROWS, PERIOD) for a in starts)
    data = Dataset(
        "single",
        (Element(np.concatenate(levels), np.concatenate(slips)),),
        np.concatenate(efforts),
        Clock(np.tile(t, k), spans),
        Units("N", "A", "m/s"),
        tuple(f"log {i}" for i in range(k)),
        tuple((span.start, span.stop) for span in spans),
    )
    return data, np.concatenate(columns)


def _only(data: Dataset, rows: slice) -> Mask:
    mask = np.zeros(data.rows, np.bool_)
    mask[rows] = True
    return mask


@pytest.mark.slow
def test_new_motions_lie_inside_as_often_as_promised_where_errors_of_the_fit_promise_too_much() -> (
    None
):
    shares: list[list[float]] = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        seen, x = _logs(rng, 10)
        gains = np.linalg.lstsq(x, seen.effort, rcond=None)[0]
        error = seen.effort - x @ gains
        every, unseen = np.ones(seen.rows, np.bool_), unseen_errors(seen, x.__getitem__, error)
        old, new = (calibrated(seen, every, [error], [4], [errors])[0] for errors in (None, unseen))
        assert old is not None
        assert new is not None
        fresh, columns = _logs(rng, 30)
        held = np.ones(fresh.rows, np.bool_)
        bands = (old, new)
        shares.append(
            [
                coverage(fresh, b.around(columns @ gains, fresh.elements, fresh.clock), held).share
                for b, _ in bands
            ]
        )
    without, with_logs_left_out = np.mean(shares, axis=0)
    assert without < LEVEL - 0.03
    assert abs(with_logs_left_out - LEVEL) < 0.025


def test_errors_are_those_of_fits_without_the_motion() -> None:
    data, x = _logs(np.random.default_rng(1), 4, fields=(0.5, 1.0))
    error = data.effort - x @ np.linalg.lstsq(x, data.effort, rcond=None)[0]
    unseen = unseen_errors(data, x.__getitem__, error)
    assert unseen is not None
    for k in range(4):  # the two logs of a motion stand side by side
        own = _only(data, slice(2 * k * ROWS, 2 * (k + 1) * ROWS))
        gains = np.linalg.lstsq(x[~own], data.effort[~own], rcond=None)[0]
        size = np.max(np.abs((data.effort - x @ gains)[own]))
        assert np.allclose(unseen[own], (data.effort - x @ gains)[own], atol=0.02 * size)
    assert np.sum(unseen**2) > 1.5 * np.sum(error**2)


@pytest.mark.slow
def test_laws_and_networks_know_their_errors_on_other_motions() -> None:
    data, _ = _logs(np.random.default_rng(2), 4, fields=(0.5, 1.0))
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "none", True, True
    )
    network = network_from_name("fnn-4", "single")
    for fitted in (
        lambda rows: fit_structure(rows, structure),
        lambda rows: fit_network(rows, network),
    ):
        found = fitted(data)
        own = _only(data, slice(0, 2 * ROWS))
        again = fitted(data.take(~own)).model
        assert found.unseen is not None
        sizes = [
            np.sqrt(np.mean(x[own] ** 2)) for x in (found.unseen, data.effort - again.predict(data))
        ]
        assert sizes[0] == pytest.approx(sizes[1], rel=0.25)


def test_one_log_says_nothing_of_others_and_a_log_with_most_rows_stays() -> None:
    data, x = _logs(np.random.default_rng(3), 3)
    one = data.take(_only(data, slice(0, ROWS)))
    assert unseen_errors(one, x.__getitem__, one.effort) is None
    uneven = replace(
        data, source_rows=((0, 2 * ROWS), (2 * ROWS, 2 * ROWS + 100), (2 * ROWS + 100, 3 * ROWS))
    )
    unseen = unseen_errors(uneven, x.__getitem__, data.effort)
    assert unseen is not None
    assert np.array_equal(unseen[: 2 * ROWS], data.effort[: 2 * ROWS])


@pytest.mark.parametrize("first", [ROWS, 100, 50])  # rows of the first log
def test_of_two_logs_each_is_left_out_unless_hardly_a_row_is_left(first: int) -> None:
    data, x = _logs(np.random.default_rng(4), 2)
    kept = slice(ROWS - first, 2 * ROWS)
    x, data = x[kept], data.take(_only(data, kept))
    error = data.effort - x @ np.linalg.lstsq(x, data.effort, rcond=None)[0]
    unseen = unseen_errors(data, x.__getitem__, error)
    assert unseen is not None
    for own, others in (
        (slice(0, first), slice(first, None)),
        (slice(first, None), slice(0, first)),
    ):
        gains = np.linalg.lstsq(x[others], data.effort[others], rcond=None)[0]
        wanted = (data.effort - x @ gains)[own] if first > 50 or own.start == 0 else error[own]
        assert np.allclose(unseen[own], wanted, atol=0.25 * np.max(np.abs(wanted)))


def test_two_logs_at_a_field_each_say_nothing_of_another_motion() -> None:
    data, x = _logs(np.random.default_rng(5), 1, fields=(0.5, 1.0))
    assert unseen_errors(data, x.__getitem__, data.effort) is None
