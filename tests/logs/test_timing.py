from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import TimingError
from erclutch.logs import timing
from erclutch.logs.timing import LogClock

ROWS = np.arange(2000)
_RANDOM = np.random.default_rng(0)
BURSTS = np.repeat(np.cumsum(_RANDOM.integers(1, 9, 1000)), _RANDOM.integers(1, 9, 1000)) * 1e-3


def clock_of(stamps: np.ndarray, same: list[int] | None = None, hint: float | None = None) -> LogClock:
    alike = np.zeros(len(stamps), dtype=np.bool_)
    alike[same or []] = True
    return timing.from_stamps(np.asarray(stamps, dtype=np.float64), alike, column="t", hint=hint)


PERIODS = (1e-3, 0.2, 1 / 3, 1 / 1024, 3.328e-4, 5e-3)


# From 1970 on, a double cannot hold the shorter periods.
@pytest.mark.parametrize(
    ("period", "start"), [(p, s) for p in PERIODS for s in (0.0, 12.5, 1.7e9) if s < 1e9 or p >= 1e-3]
)
def test_exact_stamps_stay_as_they_are(period: float, start: float) -> None:
    stamps = start + ROWS * period
    clock = clock_of(stamps)
    assert clock.uniform
    assert clock.starts == (0,)
    assert clock.period == pytest.approx(period, rel=1e-6)
    np.testing.assert_allclose(clock.time, stamps, rtol=0, atol=1e-3 * period)


@pytest.mark.parametrize("digits", [3, 4, 5])
def test_stamps_rounded_when_printed_go_back_on_the_grid(digits: int) -> None:
    true = ROWS * 3.328e-4 * 10 + 5
    clock = clock_of(np.round(true, digits))
    assert clock.uniform
    assert clock.period == pytest.approx(3.328e-3, rel=1e-5)
    np.testing.assert_allclose(clock.time, true, rtol=0, atol=1.1 * 10.0**-digits)
    assert np.all(np.diff(clock.time) > 0)
    assert any("put on the regular grid" in note for note in clock.notes)


def test_six_significant_digits_are_finer_where_numbers_are_small() -> None:
    true = np.arange(40_000) * 3.328e-4
    clock = clock_of(np.array([float(f"{value:.6g}") for value in true]))
    assert clock.uniform
    assert clock.period == 3.328e-4
    np.testing.assert_allclose(clock.time, true, rtol=0, atol=1e-9)


@pytest.mark.parametrize("tick", [1e-2, 0.0156])
def test_stamps_coarser_than_the_sampling_are_restored(tick: float) -> None:
    clock = clock_of(np.round(np.floor(ROWS * 1e-3 / tick) * tick, 4))
    assert clock.uniform
    assert clock.keep.all()
    assert clock.period == pytest.approx(1e-3, rel=1e-3)
    assert any("coarser than the sampling" in note for note in clock.notes)


def test_float32_stamps() -> None:
    clock = clock_of((1000 + ROWS / 1024).astype(np.float32))
    assert clock.uniform
    assert clock.period == pytest.approx(1 / 1024, rel=1e-5)


def test_repeated_rows_are_dropped_and_counted() -> None:
    stamps = np.insert(ROWS * 1e-3, [100, 200, 650], [0.1, 0.2, 0.65])
    clock = clock_of(stamps, same=[101, 202])
    assert clock.time.size == ROWS.size
    assert np.array_equal(clock.time, ROWS * 1e-3)
    assert clock.notes == (
        "2 rows that repeat the row before were dropped; "
        "1 rows with the t of the row before but other values were dropped, the first kept",
    )


def test_gaps_cut_segments() -> None:
    stamps = np.delete(ROWS * 1e-3, [100, 101, 102, 1500])
    clock = clock_of(stamps)
    assert clock.uniform
    assert clock.starts == (0, 100, 1497)
    assert clock.period == 1e-3
    np.testing.assert_allclose(clock.time, stamps, rtol=0, atol=1e-12)
    assert clock.notes == ("2 gaps in t (longest 0.004 s after 0.099 s): cut into 3 segments",)


def test_a_period_just_above_the_resolution_is_no_row_of_gaps() -> None:
    clock = clock_of(np.round(ROWS * 1.01e-3, 3))
    assert clock.starts == (0,)
    assert clock.period == pytest.approx(1.01e-3, rel=1e-4)


def test_jitter_beyond_rounding_keeps_its_stamps() -> None:
    stamps = np.round(ROWS * 1e-3 + np.random.default_rng(1).uniform(-2e-4, 2e-4, ROWS.size), 7)
    clock = clock_of(stamps)
    assert not clock.uniform
    assert np.array_equal(clock.time, stamps)
    assert any("not uniform" in note for note in clock.notes)


def test_a_period_in_the_header_is_taken_where_the_stamps_agree() -> None:
    stamps = np.round(ROWS / 3004.8, 4)
    assert clock_of(stamps, hint=1 / 3004.8).period == 1 / 3004.8
    assert clock_of(stamps, hint=1 / 2900).period != 1 / 2900


@pytest.mark.parametrize(
    ("stamps", "problem"),
    [
        (np.arange(1), "only 1 row of data, 10 are needed"),
        (np.arange(9), "only 9 rows of data, 10 are needed"),
        (np.full(50, 3.0), "column t is 3 in all 50 rows"),
        (np.r_[ROWS[:500], ROWS[400:]] * 1e-3, r"column t runs backwards at data row 501: 0.4 s after 0.499 s"),
        (BURSTS, "without a pattern"),
    ],
)
def test_time_that_cannot_be_put_right(stamps: np.ndarray, problem: str) -> None:
    with pytest.raises(TimingError, match=problem):
        clock_of(stamps)


def test_a_rate_must_be_positive() -> None:
    assert timing.from_rate(100, 1e-3).period == 1e-3
    with pytest.raises(TimingError, match="sampling period is 0 s"):
        timing.from_rate(100, 0.0)


def test_steps_that_no_logger_makes_are_refused() -> None:
    with pytest.raises(TimingError, match=r"1e-239 s, below the shortest of 1e-12 s"):
        clock_of(1e-239 * np.arange(20))


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.floats(-1e6, 1e6, allow_nan=False) | st.sampled_from([0.0, 1e-3, 1e-300, 5e-324]), max_size=40),
    st.booleans(),
)
def test_any_stamps_give_a_clock_or_a_timing_error(values: list[float], ordered: bool) -> None:
    stamps = np.array(sorted(values) if ordered else values, dtype=np.float64)
    try:
        clock = clock_of(stamps)
    except TimingError:
        return
    assert clock.time.size == clock.keep.sum()
    steps = np.delete(np.diff(clock.time), [start - 1 for start in clock.starts[1:]])
    assert np.all(steps > 0)
    assert clock.period > 0


def test_a_few_stray_repeats_are_dropped_though_a_grid_would_hide_them() -> None:
    """Their distances are no pattern, and the stamps are coarse enough that a grid goes through all of them."""
    stamps = np.round(ROWS * 1e-3, 2)[::10]
    stray = np.insert(stamps, [20, 57, 111], stamps[[19, 56, 110]])
    clock = clock_of(stray, same=[20, 58, 113])
    assert np.count_nonzero(~clock.keep) == 3
    assert clock.period == pytest.approx(1e-2, rel=1e-6)


@pytest.mark.parametrize("start", [1.7e9, 1.7e9 + 0.123])
def test_stamps_since_1970_are_as_fine_as_a_double_lets_them_be(start: float) -> None:
    """What a double adds behind the third decimal is no resolution: rounded stamps go back on the grid."""
    true = start + ROWS * 3.328e-3
    clock = clock_of(np.round(true, 3))
    assert clock.uniform
    assert clock.period == pytest.approx(3.328e-3, rel=1e-5)
    np.testing.assert_allclose(clock.time, true, rtol=0, atol=1.1e-3)
    assert any("rounded" in note or "put on the regular grid" in note for note in clock.notes)


def test_a_clock_that_begins_anew_begins_a_new_stretch() -> None:
    one = np.arange(300, dtype=np.float64) / 1000.0
    clock = timing.from_stamps(np.concatenate([one + 5, one, one]), np.zeros(900, np.bool_), column="t")
    assert clock.starts == (0, 300, 600)
    assert clock.uniform
    assert clock.period == pytest.approx(0.001)
    assert np.all(np.diff(clock.time) > 0)
    assert clock.notes[0] == "t begins anew in data row 301, 601: a new stretch each time, 0.011 s after the last"


def test_a_clock_that_falls_back_a_little_is_refused() -> None:
    stamps = np.arange(300, dtype=np.float64) * 0.001
    stamps[150:] -= 0.02
    with pytest.raises(TimingError, match="runs backwards at data row 151"):
        timing.from_stamps(stamps, np.zeros(300, np.bool_), column="t")
