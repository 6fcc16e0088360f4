"""Bands hold the share of rows that they promise, on data whose truth is known (SYNTHETIC)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.bands.band_pieces import kind_of_pieces, pieces
from erclutch.fit.bands.prediction_bands import LEVEL, calibrated, coverage, judged
from erclutch.fit.comparison import Settings, compare
from erclutch.logs.dataset import Dataset
from erclutch.models.adaptive_band import (
    NARROWEST,
    SETTLED,
    WIDEST,
    Adapted,
    adapted,
    after,
)
from erclutch.models.band import Band
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD = 1e-3
TRUTH = 3.0


def _noise(rng: np.random.Generator, rows: int, kept: float = 0.0) -> Array:
    """Standard normal noise, each row keeping a share of the row before."""
    from scipy.signal import lfilter

    white = rng.standard_normal(rows) * np.sqrt(1.0 - kept**2)
    return np.asarray(lfilter([1.0], [1.0, -kept], white))


def _rows(rng: np.random.Generator, rows: int, kept: float = 0.0) -> tuple[Dataset, Array, Array]:
    """Rows, the errors of a model of them, and the true standard deviation of each error.

    The error is four times as large at high field, three times while the field is new, twice against the slip.
    """
    field = np.repeat(rng.choice([0.0, 100.0], rows // 100), 100)
    slip = 5.0 * _noise(rng, rows, 0.99)
    new = np.arange(rows) % 100 < 20
    new &= np.repeat(np.diff(field[::100], prepend=field[0]) != 0, 100)
    size = np.where(field > 50, 4.0, 1.0) * np.where(new, 3.0, 1.0)
    noise = _noise(rng, rows, kept)
    error = size * noise * np.where(noise * slip < 0, 2.0, 1.0)
    clock = Clock(PERIOD * np.arange(float(rows)), (Span(0, rows, PERIOD),))
    data = Dataset("single", (Element(field, slip),), TRUTH + error, clock, Units("N", "V", "m/s"))
    return data, error, size


@pytest.mark.slow
@pytest.mark.parametrize("kept", [0.0, 0.9])
def test_fresh_rows_lie_inside_as_often_as_promised_in_each_class(kept: float) -> None:
    shares: list[list[float]] = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        seen, error, _ = _rows(rng, 20_000, kept)
        found = calibrated(seen, np.ones(seen.rows, np.bool_), [error], [4])[0]
        assert found is not None
        fresh, _, size = _rows(rng, 20_000, kept)
        low, high = found[0].around(np.full(fresh.rows, TRUTH), fresh.elements, fresh.clock)
        inside = (low <= fresh.effort) & (fresh.effort <= high)
        shares.append(
            [float(np.mean(inside)), *(float(np.mean(inside[size == s])) for s in (1.0, 4.0))]
        )
        assert np.mean(high - low) < 0.85 * found[1]
    mean = np.mean(shares, axis=0)
    assert np.all(np.abs(mean - LEVEL) < (0.012, 0.02, 0.02))


@pytest.mark.slow
def test_the_width_follows_the_direction_of_the_slip() -> None:
    seen, error, _ = _rows(np.random.default_rng(1), 40_000)
    found = calibrated(seen, np.ones(seen.rows, np.bool_), [error], [4])[0]
    assert found is not None
    quiet = [
        np.array(ends).reshape(found[0].shape)[0, 0] for ends in (found[0].behind, found[0].ahead)
    ]
    assert np.allclose(quiet, [[2 * 1.96], [1.96]], rtol=0.12)


@pytest.mark.slow
def test_few_rows_for_many_parameters_widen_the_band() -> None:
    rng = np.random.default_rng(2)
    seen, _, size = _rows(rng, 2000)
    error = size * rng.standard_normal(
        2000
    )  # uncorrelated: the errors of `_rows` follow the sign of the slip
    every = np.ones(seen.rows, np.bool_)
    one, many, lost, wild = calibrated(
        seen, every, [error, error, error, error * np.nan], [1, 400, 10_000, 1]
    )
    assert wild is None
    assert one is not None
    assert many is not None
    assert lost is not None
    assert many[1] / one[1] == pytest.approx((2400 / 1600) ** 0.5, rel=0.02)
    assert lost[1] / one[1] == pytest.approx(3**0.5, rel=0.02)


@pytest.mark.slow
def test_a_band_says_which_part_of_the_estimate_its_errors_seldom_follow() -> None:
    rng = np.random.default_rng(9)
    seen, _, _ = _rows(rng, 80_000)  # 40 blocks of 2 s, of which every tenth is another
    gain = np.repeat(np.where(np.arange(40) % 10 == 0, 0.1, 0.0), 2000)
    estimate = 10.0 * np.sin(np.arange(80_000) / 100.0)
    parts: list[float] = []
    for share in (0.0, 1.0, 4.0):
        error = share * gain * estimate + rng.standard_normal(80_000)
        data = replace(seen, effort=estimate + error)
        found = calibrated(data, np.ones(80_000, np.bool_), [error], [4])[0]
        assert found is not None
        assert found[0].part is not None
        parts.append(found[0].part)
    none, some, more = parts
    assert none < 0.02 < some < 0.1
    assert some < more
    short = replace(seen.take(np.arange(80_000) < 20_000), effort=seen.effort[:20_000])
    few = calibrated(short, np.ones(20_000, np.bool_), [seen.effort[:20_000] - TRUTH], [4])[0]
    assert few is not None
    assert few[0].part is None


@pytest.mark.slow
def test_rows_held_out_have_no_say() -> None:
    seen, error, _ = _rows(np.random.default_rng(3), 10_000)
    train = np.arange(seen.rows) < 7000
    other = np.where(train, error, 1e6)
    assert calibrated(seen, train, [error], [4]) == calibrated(seen, train, [other], [4])


def test_a_field_that_never_changes_needs_no_classes_of_it() -> None:
    rng = np.random.default_rng(4)
    error = _noise(rng, 5000)
    clock = Clock(PERIOD * np.arange(5000.0), (Span(0, 5000, PERIOD),))
    data = Dataset(
        "single",
        (Element(np.full(5000, 2.0), rng.normal(size=5000)),),
        error,
        clock,
        Units("N", "A", "m/s"),
    )
    found = calibrated(data, np.ones(5000, np.bool_), [error], [1])[0]
    assert found is not None
    assert found[0].field_edges == ()
    assert (
        coverage(data, found[0].around(np.zeros(5000), data.elements, clock), error < np.inf).share
        > 0.94
    )


def test_pieces_are_seconds_of_one_log_and_logs_of_several() -> None:
    data, _, _ = _rows(np.random.default_rng(5), 3200)
    held = np.arange(3200) >= 700
    assert [(name, at.size) for name, at in pieces(data, held)] == [
        ("the second from 0.7 s on", 1000),
        ("the second from 1.7 s on", 1000),
        ("the second from 2.7 s on", 500),
    ]
    assert kind_of_pieces(data) == "second"
    two = replace(data, sources=("a", "b"), source_rows=((0, 1000), (1000, 3200)))
    assert kind_of_pieces(two) == "log"
    assert [(name, at.size) for name, at in pieces(two, held | True)] == [("a", 1000), ("b", 2200)]
    short = [(name, at.size) for name, at in pieces(two, held)]
    assert short == [("a", 300), ("b", 2200)]  # and a short log may be the worst


@pytest.mark.parametrize(
    ("period", "kind", "rows"),
    [
        (0.05, "second", 20),
        (0.05001, "second", 20),
        (0.1, "2 s", 20),
        (1.0, "20 s", 20),
        (3.0, "100 s", 34),
    ],
)
def test_a_piece_has_rows_enough_to_tell_a_share(period: float, kind: str, rows: int) -> None:
    data, _, _ = _rows(np.random.default_rng(5), 400)
    clock = Clock(period * np.arange(400.0), (Span(0, 400, period),))
    slow = replace(data, clock=clock)
    assert kind_of_pieces(slow) == kind
    first, at = pieces(slow, np.arange(400) >= 0)[0]
    assert first.startswith(f"the {kind} from 0")
    assert at.size == rows


BAND = Band(0.95, 0.01, 1.0, (0.0, 1.0), (-1.0, 1.0), (), (), (1.0, 1.0), (1.0, 1.0))


@pytest.mark.slow
def test_a_sensor_brings_any_band_to_its_level() -> None:
    """Bands five times too wide and too narrow, around an effort that is off by a constant, and then by another."""
    rng = np.random.default_rng(6)
    rows = 40_000
    clock = Clock(PERIOD * np.arange(float(rows)), (Span(0, rows, PERIOD),))
    off = np.where(np.arange(rows) < rows // 2, 7.0, -3.0)
    measured = off + _noise(rng, rows)
    effort = np.zeros(rows)
    for width in (5.0 * 1.96, 0.2 * 1.96):
        low, high = adapted(BAND, (effort - width, effort + width), effort, measured, clock)
        for part in (slice(5000, rows // 2), slice(rows // 2 + 5000, rows)):
            assert abs(np.mean((low <= measured)[part] & (measured <= high)[part]) - 0.95) < 0.01
            assert np.mean((high - low)[part]) == pytest.approx(2 * 1.96, rel=0.15)
        assert np.mean(0.5 * (low + high)[5000 : rows // 2]) == pytest.approx(7.0, abs=0.05)


def test_each_row_of_a_sensor_counts_from_the_next_row_on_and_a_gap_forgets() -> None:
    clock = Clock(
        np.array([0.0, 0.001, 0.002, 5.0, 5.001]), (Span(0, 3, PERIOD), Span(3, 5, PERIOD))
    )
    measured = np.array([0.0, 10.0, 0.0, 0.0, 0.0])
    low, high = adapted(BAND, (-np.ones(5), np.ones(5)), np.zeros(5), measured, clock)
    assert (low[0], high[0]) == (low[3], high[3]) == (-1.0, 1.0)
    assert high[1] < 1.0
    second = after(SETTLED, 0.0, 1.0, 1.0, 0.95, PERIOD)
    third = after(second, 10.0, 1.0, 1.0, 0.95, PERIOD)
    assert (low[2], high[2]) == pytest.approx(
        (third.offset - third.scale, third.offset + third.scale)
    )
    assert third.offset == pytest.approx(10.0 * (1.0 - np.exp(-0.001 / 0.05)))
    assert third.scale > second.scale


@pytest.mark.slow
def test_a_band_over_rows_has_the_bits_of_the_step_that_is_exported() -> None:
    """Whatever the sensor says: too much until the band is widest, nothing until it is narrowest, what is no number."""
    rng = np.random.default_rng(8)
    rows = 6000
    measured = rng.normal(size=rows) * rng.choice([0.1, 1.0, 9.0], rows)
    measured[100:300] = 1e6 * np.sign(measured[100:300])
    measured[300:5600] = 0.0
    measured[5800::7] = np.nan
    measured[5900] = np.inf
    clock = Clock(PERIOD * np.arange(float(rows)), (Span(0, 100, PERIOD), Span(100, rows, PERIOD)))
    ends = (-np.ones(rows), 2.0 * np.ones(rows))
    low, high = adapted(BAND, ends, np.zeros(rows), measured, clock)
    period = np.diff(clock.time, prepend=clock.time[:1])
    scales: list[float] = []
    for span in clock.spans:
        state = SETTLED
        for row in range(span.start, span.stop):
            scales.append(state.scale)
            wanted = (state.offset - state.scale, state.offset + 2.0 * state.scale)
            assert np.array_equal(wanted, (low[row], high[row]), equal_nan=True), row
            to_next = float(period[min(row + 1, span.stop - 1)])
            state = after(state, float(measured[row]), 1.0, 2.0, BAND.level, to_next)
    assert (min(scales), max(scales)) == (NARROWEST, WIDEST)


@pytest.mark.slow
def test_the_width_stays_within_its_limits_whatever_the_sensor_says() -> None:
    n = 20_000
    clock = Clock(0.005 * np.arange(float(n)), (Span(0, n, 0.005),))
    wild = 1e6 * np.sign(np.sin(np.arange(float(n))))
    for measured, limit in ((wild, 20.0), (np.zeros(n), 0.2)):
        low, high = adapted(BAND, (-np.ones(n), np.ones(n)), np.zeros(n), measured, clock)
        assert (high - low)[-1] == pytest.approx(limit)


@pytest.mark.slow
@pytest.mark.parametrize("period", [5e-4, 2e-3, 2e-2, 1e-1])
def test_the_wanted_share_is_inside_in_the_long_run_at_any_period(period: float) -> None:
    error, state, outside = np.random.default_rng(3).standard_normal(20_000).tolist(), SETTLED, 0
    for e in error:
        outside += abs(e - state.offset) > state.scale
        state = Adapted(*map(float, after(state, e, 1.0, 1.0, 0.95, period)))
    assert outside / len(error) == pytest.approx(0.05, abs=0.003)


@pytest.mark.slow
def test_a_comparison_gives_each_model_a_band_and_judges_it() -> None:
    rng = np.random.default_rng(7)
    n = 6000
    field, slip = np.repeat(rng.uniform(0, 100, n // 50), 50), 5.0 * _noise(rng, n, 0.99)
    effort = 0.05 * field * np.tanh(slip / 0.1) + 0.3 * slip + 0.2 * _noise(rng, n, 0.5)
    clock = Clock(PERIOD * np.arange(float(n)), (Span(0, n, PERIOD),))
    data = Dataset("single", (Element(field, slip),), effort, clock, Units("N", "V", "m/s"))
    comparison = compare(data, Settings(models=("bingham", "fnn-4"), lag="none"))
    for entry in comparison.entries:
        band, figures = entry.outcome.model.band, entry.band
        assert band is not None
        assert figures is not None
        assert figures.held.rows == comparison.test.sum()
        assert 0.92 < figures.held.share < 0.98
        assert figures.held.worst <= figures.held.share
        again = judged(data, comparison.test, entry.predicted, band, figures.plain, sensor=True)
        assert again.held == figures.held
        assert (figures.with_sensor is not None) == (entry.name == comparison.recommended)
