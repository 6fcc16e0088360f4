"""The parts of the search for a clock against brute force, and one whole answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from erclutch.errors import LogError
from erclutch.wings.align import coarse_search as cs
from erclutch.wings.align import fine_steps as fs
from erclutch.wings.align.clock_match import match_clocks
from erclutch.wings.align.track import Track, track_of

RNG = np.random.default_rng(0)


def wave(rows: int, seed: int, pole: float = 0.9) -> np.ndarray:
    return np.asarray(lfilter([1.0], [1.0, -pole], np.random.default_rng(seed).normal(size=rows)))


def test_gaps_of_five_periods_are_bridged_and_longer_ones_cut() -> None:
    step = np.array([1, 1, 5, 1, 1, 6, 1, 1, 2, 1])
    time = 3.0 + 0.1 * np.concatenate([[0], np.cumsum(step)])
    values = time**2
    values[1] = np.nan
    track = track_of(time, values, 0.1)
    expected = 3.0 + 0.1 * np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 15, 16, 17, 18, 19, 20])
    first = 3.0 + 0.1 * np.arange(10)  # 5 periods are four more rows
    np.testing.assert_allclose(track.time[:10], first, rtol=1e-12)
    assert track.stretches == ((0, 10), (10, 16))
    np.testing.assert_allclose(track.time, expected, rtol=1e-12)
    np.testing.assert_allclose(track.values[[0, 1, 2]], [9.0, 0.5 * (9.0 + 3.2**2), 3.2**2])
    assert track.ends == (time[0], time[-1])
    assert track_of(np.array([0.0, 1.0]), np.ones(2), 1.0).stretches == ((0, 2),)
    with pytest.raises(LogError, match="1 finite samples"):
        track_of(np.arange(3.0), np.array([np.nan, 1.0, np.nan]), 1.0)


def holed(seed: int = 1) -> Track:
    values = wave(300, seed)
    return Track(0.5 + 0.01 * np.arange(300.0), values, 0.01, ((0, 100), (140, 300)))


def test_means_are_those_of_the_straight_lines() -> None:
    track = holed()
    found, there = track.means(0.2, 0.04, 90)
    scaled = (track.values - track.values.mean()) / track.values.std()
    for cell in range(90):
        fine = 0.2 + 0.04 * (cell + (np.arange(4000) + 0.5) / 4000)
        parts = [np.interp(fine[inside], track.time[a:b], scaled[a:b]) for a, b in track.stretches
                 if (inside := (fine >= track.time[a]) & (fine <= track.time[b - 1])).any()]  # fmt: skip
        some = np.concatenate(parts) if parts else np.zeros(0)
        if abs(some.size - 2000) > 3:
            assert there[cell] == (some.size >= 2000)
        if there[cell]:
            assert found[cell] == pytest.approx(some.mean(), abs=2e-3)
        else:
            assert found[cell] == 0.0


@pytest.mark.parametrize("plain", [True, False])
def test_samples_are_the_values_where_there_are_any(plain: bool) -> None:
    track = holed()
    values = track.values if plain else (track.values - track.values.mean()) / track.values.std()
    found, there = track.sampler(0.01, plain=plain)(track.time)
    rows = np.r_[0:100, 140:300]
    np.testing.assert_allclose(found[rows], values[rows], atol=1e-9)
    np.testing.assert_array_equal(np.flatnonzero(there), rows)
    assert not found[~there].any()
    slower, there = track.sampler(0.02)(track.time)
    assert 0 < np.count_nonzero(there) < rows.size
    assert np.std(np.diff(slower[there])) < 0.9 * np.std(np.diff(values[there]))
    line = replace(track, values=3.0 * track.time)
    found, there = line.sampler(0.02, plain=True)(line.time)
    np.testing.assert_allclose(found[there], 3.0 * line.time[there], rtol=1e-9)


def test_correlations_are_those_of_every_lag() -> None:
    x, y = wave(60, 2, 0.3), wave(90, 3, 0.3)
    y[20:70] += 2 * x[:50]
    x_there, y_there = RNG.random(60) > 0.1, RNG.random(90) > 0.1
    x, y = np.where(x_there, x, 0.0), np.where(y_there, y, 0.0)
    scan = cs.scanned(x, x_there, y, y_there, 0.0)
    least = 0.1 * min(x_there.sum(), y_there.sum())
    worth = []
    for k, (r, independent) in enumerate(zip(scan.correlation, scan.independent, strict=True)):
        shift = k - 59
        i = np.array(
            [i for i in range(60) if 0 <= i + shift < 90 and x_there[i] and y_there[i + shift]], int
        )
        if i.size == 0:
            assert (r, independent) == (0.0, 0.0)
            continue
        a, b = x[i], y[i + shift]
        power = max(a @ a, 0.1 * i.size * np.mean(x[x_there] ** 2)) * max(
            b @ b, 0.1 * i.size * np.mean(y[y_there] ** 2)
        )
        assert r == pytest.approx(np.clip(a @ b / power**0.5, -1.0, 1.0), abs=1e-9)
        assert (independent > 0) == (i.size >= least and i.size >= 8)
        worth += [independent / i.size] * int(independent > 0)
    assert np.ptp(worth) < 1e-12
    auto = [np.abs(np.fft.fft(v, 256)) ** 2 for v in (x, y)]
    assert worth[0] == pytest.approx(
        1.0 / (128 * (auto[0] @ auto[1]) / auto[0].sum() / auto[1].sum() * 2), rel=0.2
    )
    assert scan.correlation.size == 60 + 90 - 1
    assert int(np.argmax(scan.scores)) - 59 == 20
    peak = int(np.argmax(scan.scores))
    assert scan.heights[peak] == pytest.approx(np.arctanh(abs(scan.correlation[peak])))
    assert scan.scores[peak] == pytest.approx(
        scan.heights[peak] * np.sqrt(max(scan.independent[peak], 4.0) - 3.0)
    )


def test_a_drifting_clock_is_turned_back() -> None:
    y = wave(4000, 4, 0.99)
    fast = np.interp(np.arange(4000) / 1.01, np.arange(4000), y)
    every = np.ones(4000, np.bool_)
    right, none = (
        cs.scanned(y, every, fast, every, drift).correlation.max() for drift in (0.01, 0.0)
    )
    assert right > 0.99 > 0.9 > none


@pytest.mark.parametrize("reach", [0, 1, 4])
def test_rows_far_from_gaps(reach: int) -> None:
    there = RNG.random(200) > 0.05
    found = fs.rows_far_from_gaps(there, reach)
    for row in range(200):
        around = [there[k] if 0 <= k < 200 else False for k in range(row - reach, row + reach + 1)]
        assert found[row] == all(around)


def test_a_filter_and_its_derivative() -> None:
    weights = fs.flat(np.zeros(1), np.zeros(1), np.ones(1, np.bool_))
    frequency = np.linspace(0, 1, 33)
    np.testing.assert_allclose(
        weights[1:], np.interp(frequency[1:], [0.7, 0.9], [1.0, 0.0]), atol=1e-12
    )
    assert weights[0] == 0.0
    even, odd = fs.taps_of(weights)
    np.testing.assert_allclose(even, even[::-1], atol=1e-12)
    np.testing.assert_allclose(odd, -odd[::-1], atol=1e-12)
    row = np.arange(even.size) - even.size // 2
    for omega in (0.3, 0.9, 1.6):
        plain, turned = even @ np.cos(omega * row), -odd @ np.sin(omega * row)
        assert plain == pytest.approx(1.0, abs=0.02)
        assert abs(turned) == pytest.approx(omega * plain, rel=2e-3)
    assert abs(even @ np.cos(3.1 * row)) < 0.02


def test_weights_follow_what_agrees() -> None:
    slow, every = lfilter([1.0], [1.0, -0.8], RNG.normal(size=8000)), np.ones(8000, np.bool_)
    x, y = slow + 0.3 * RNG.normal(size=8000), 2.0 * slow + 0.6 * RNG.normal(size=8000)
    weights = fs.by_agreement(x, y, every)
    assert weights.size == 65
    assert weights.max() == 1.0
    assert weights[0] == 0.0
    # With signal S, and noise N in both: coherence C = S^2/(S+N)^2, and the weight is sqrt(C / (1 - C) / S).
    omega = np.linspace(0, np.pi, 65)
    signal = 1.0 / np.abs(1.0 - 0.8 * np.exp(-1j * omega)) ** 2
    coherence = (signal / (signal + 0.09)) ** 2
    expected = np.sqrt(coherence / (1 - coherence) / signal)
    np.testing.assert_allclose(
        weights[2:] / weights[2:].mean(), expected[2:] / expected[2:].mean(), rtol=0.25
    )
    flat = fs.flat(x, y, every)
    np.testing.assert_array_equal(fs.by_agreement(x, RNG.normal(size=8000), every), flat)
    np.testing.assert_array_equal(fs.by_agreement(x[:100], y[:100], every[:100]), flat)


def test_where_the_autocorrelation_falls_to_a_half() -> None:
    values = np.repeat(np.random.default_rng(5).normal(size=400), 20)
    track = Track(0.01 * np.arange(8000.0), values, 0.01, ((0, 8000),))
    assert cs.width_of(track, 0.01, 80.0) == pytest.approx(0.1, abs=0.02)


def pair(
    offset: float = 0.123, drift: float = 80e-6, noise: float = 0.2, seed: int = 7
) -> tuple[Track, Track]:
    """A smooth signal at 100 Hz on two clocks, twice as large on B."""
    fine = lfilter([1.0], [1.0, -1.9, 0.9025], np.random.default_rng(seed).normal(size=42_000))
    fine /= np.std(fine)
    rng = np.random.default_rng(seed + 1)
    a = 0.01 * np.arange(3000.0)
    on_a = (a - offset) / (1.0 + drift)
    true = 0.001 * np.arange(42_000) - 5.0
    one = np.interp(a, true, fine) + noise * rng.normal(size=3000)
    other = 2.0 * (np.interp(on_a, true, fine) + noise * rng.normal(size=3000)) + 1.0
    whole = ((0, 3000),)
    return Track(a, one, 0.01, whole), Track(a, other, 0.01, whole)


@pytest.mark.slow
def test_the_whole_answer() -> None:
    """Offset and drift are the true ones within their intervals; the figures stay as they are."""
    a, b = pair()
    found = match_clocks(a, b)
    assert found.origin == pytest.approx(0.0, abs=1e-12)
    at = found.offset - (0.123 + 80e-6 * found.origin)
    assert found.offset_interval[0] < found.offset - at < found.offset_interval[1]
    assert found.drift_interval[0] < 80e-6 < found.drift_interval[1]
    assert found.gain == pytest.approx(2.0, abs=0.1)
    assert found.overlap == pytest.approx((found.origin, 0.01 * 2999 - found.offset), abs=0.01)
    figures = [
        found.offset, *found.offset_interval, found.drift, *found.drift_interval, found.gain, found.correlation,
        found.independent, found.centres.size, found.centres[3], float(found.residuals @ np.arange(found.centres.size)),
    ]  # fmt: skip
    assert figures == pytest.approx(
        [
            0.122923738, 0.122560505, 0.12328697, 0.00010458271, 7.74456643e-05, 0.000131719997, 1.93536937, 0.96740531,
            310.750507, 20, 5.765, -6.46608947e-05,
        ],
        rel=1e-5,
    )  # fmt: skip


@pytest.mark.slow
def test_the_other_way_round() -> None:
    a, b = pair()
    there = match_clocks(a, b)
    back = there.turned()
    for t in (1.0, 17.0, 25.0):
        assert back.on_b(there.on_b(np.array([t]))) == pytest.approx(t, abs=1e-9)
        assert there.on_a(there.on_b(np.array([t]))) == pytest.approx(t, abs=1e-9)
    assert back.gain == pytest.approx(1.0 / there.gain)
    assert back.offset == pytest.approx(-there.offset)
    assert back.offset_interval == pytest.approx(
        (-there.offset_interval[1], -there.offset_interval[0])
    )
    width = there.drift_interval[1] - there.drift_interval[0]
    assert back.drift_interval[1] - back.drift_interval[0] == pytest.approx(
        width / (1 + there.drift)
    )
    assert back.drift_interval[0] < back.drift < back.drift_interval[1]
    np.testing.assert_allclose(back.residuals, -there.residuals)
    np.testing.assert_allclose(back.centres, there.on_b(there.centres))
    assert back.overlap == pytest.approx(tuple(there.on_b(np.array(there.overlap))))
    slower = replace(b, time=b.time[::3], values=b.values[::3], period=0.03, stretches=((0, 1000),))
    coarse = match_clocks(a, slower)
    assert coarse.on_b(np.array([15.0])) == pytest.approx(there.on_b(np.array([15.0])), abs=2e-3)
    near = 0.123 if coarse.offset > 0 else -0.123
    assert match_clocks(a, slower, near=near).offset == pytest.approx(coarse.offset)


def test_between_two_offsets_nothing_is_chosen() -> None:
    lags = np.array([0.0, 1.0, 2.0, 3.0])
    places = np.array([1, 3])
    assert cs.nearest_of(places, lags, 1.7) == 1
    assert cs.nearest_of(places, lags, 2.3) == 3
    for near in (1.8, 2.2):
        with pytest.raises(LogError, match="lies between two offsets that fit equally well, "):
            cs.nearest_of(places, lags, near)
