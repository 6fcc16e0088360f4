from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import TimingError
from erclutch.logs.clock import time_stamps, timing
from erclutch.logs.clock.timing import LogClock
from tests.support.examples import examples

ROWS = np.arange(2000)
_RANDOM = np.random.default_rng(0)
BURSTS = np.repeat(np.cumsum(_RANDOM.integers(1, 9, 1000)), _RANDOM.integers(1, 9, 1000)) * 1e-3


def clock_of(
    stamps: np.ndarray, same: list[int] | None = None, hint: float | None = None
) -> LogClock:
    alike = np.zeros(len(stamps), dtype=np.bool_)
    alike[same or []] = True
    return time_stamps.from_stamps(
        np.asarray(stamps, dtype=np.float64), alike, column="t", hint=hint
    )


PERIODS = (1e-3, 0.2, 1 / 3, 1 / 1024, 3.328e-4, 5e-3)


# From 1970 on, a double cannot hold the shorter periods.
@pytest.mark.parametrize(
    ("period", "start"),
    [(p, s) for p in PERIODS for s in (0.0, 12.5, 1.7e9) if s < 1e9 or p >= 1e-3],
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


@pytest.mark.slow
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


def test_jitter_about_a_steady_clock_is_put_on_it() -> None:
    stamps = np.round(ROWS * 1e-3 + np.random.default_rng(1).uniform(-2e-4, 2e-4, ROWS.size), 7)
    clock = clock_of(stamps)
    assert clock.uniform
    assert np.allclose(clock.time, ROWS * 1e-3, atol=2e-5)
    assert any("early or late about a steady" in note for note in clock.notes)


def test_steps_of_any_length_keep_their_stamps() -> None:
    stamps = np.round(np.cumsum(np.random.default_rng(1).uniform(6e-4, 1.4e-3, ROWS.size)), 7)
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
        (
            np.r_[ROWS[:500], ROWS[400:]] * 1e-3,
            r"column t runs backwards at data row 501: 0.4 s after 0.499 s",
        ),
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


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(
    st.lists(
        st.floats(-1e6, 1e6, allow_nan=False) | st.sampled_from([0.0, 1e-3, 1e-300, 5e-324]),
        max_size=40,
    ),
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
    clock = time_stamps.from_stamps(
        np.concatenate([one + 5, one, one]), np.zeros(900, np.bool_), column="t"
    )
    assert clock.starts == (0, 300, 600)
    assert clock.uniform
    assert clock.period == pytest.approx(0.001)
    assert np.all(np.diff(clock.time) > 0)
    assert (
        clock.notes[0]
        == "t begins anew in data row 301, 601: a new stretch each time, 0.011 s after the last"
    )


def test_a_clock_that_falls_back_a_little_is_refused() -> None:
    stamps = np.arange(300, dtype=np.float64) * 0.001
    stamps[150:] -= 0.02
    with pytest.raises(TimingError, match="runs backwards at data row 151"):
        time_stamps.from_stamps(stamps, np.zeros(300, np.bool_), column="t")


# --- each limit from both sides, and the parts against their definition -----------------------------------------------


def test_ten_rows_are_enough() -> None:
    assert clock_of(np.arange(10) * 1e-3).time.size == 10
    assert timing.from_rate(10, 0.5).time.tolist() == (0.5 * np.arange(10)).tolist()
    with pytest.raises(TimingError, match="only 9 rows"):
        timing.from_rate(9, 0.5)
    for period in (np.inf, np.nan, -1.0):
        with pytest.raises(TimingError, match="Give a positive rate"):
            timing.from_rate(100, period)


@pytest.mark.parametrize(("step", "starts"), [(1.45, (0,)), (1.55, (0, 100))])
def test_a_gap_is_a_step_and_a_half(step: float, starts: tuple[int, ...]) -> None:
    stamps = np.arange(300) + (step - 1.0) * (np.arange(300) >= 100)
    assert clock_of(stamps * 1e-3).starts == starts


@pytest.mark.parametrize(("share", "uniform"), [(0.9e-3, True), (1.2e-3, False)])
def test_stamps_may_wander_by_a_thousandth(share: float, uniform: bool) -> None:
    wave = share * np.where(ROWS % 2, 1.0, -1.0)
    clock = clock_of(ROWS * 0.1 + 0.1 * wave)
    assert clock.uniform
    assert any("early or late about a steady" in n for n in clock.notes) != uniform
    assert (
        any(
            "wanders by less than 0.1 % of a period: put on the regular grid of 0.1 s" in n
            for n in clock.notes
        )
        == uniform
    )
    np.testing.assert_allclose(clock.time, ROWS * 0.1, atol=1e-4)


def test_many_long_steps_are_no_gaps_but_pauses_among_them_are() -> None:
    steps = np.where(np.arange(999) % 4 == 0, 3.0, 1.0)
    steps[500] = 200.0
    clock = clock_of(np.concatenate([[0.0], np.cumsum(steps)]) * 1e-3)
    assert clock.starts == (0, 501)


@pytest.mark.parametrize(("column", "grain"), [
    (np.array([0.5, 1.25, 3.125, 2.0]), [1e-3, 1e-3, 1e-3, 1e-3]),
    (np.array([0.0003328, 0.25, 24.6492, 124.649]), [1e-7, 1e-4, 1e-4, 1e-3]),
    (np.array([1.0, 2.0, 7.0, 9.0]), [1.0] * 4),
    (np.array([1.0, 2.0, 30.5, 9.0]), [0.1, 0.1, 0.1, 0.1]),
    (np.array([1.0, 2.0, 2.0, 2.0, 2.0, 5.0]), [3.0 - 1.0] * 6),
])  # fmt: skip
def test_how_fine_stamps_are(column: np.ndarray, grain: list[float]) -> None:
    np.testing.assert_allclose(time_stamps.resolution_of(column), grain, rtol=1e-9)


def test_a_double_and_a_float32_are_as_fine_as_their_spacing() -> None:
    stamps = 1000.0 + ROWS / 7.0
    np.testing.assert_allclose(time_stamps.resolution_of(stamps), 4 * np.spacing(stamps.max()))
    single = stamps.astype(np.float32).astype(np.float64)
    np.testing.assert_allclose(
        time_stamps.resolution_of(single), np.spacing(single.astype(np.float32)).astype(np.float64)
    )


def test_the_line_is_as_near_to_all_stamps_as_can_be() -> None:
    rng = np.random.default_rng(3)
    stamps = np.arange(40) + rng.uniform(-0.3, 0.3, 40)
    allowed = rng.uniform(0.2, 0.4, 40)
    spans = [slice(0, 25), slice(25, 40)]
    grid, wander = time_stamps._line(stamps, allowed, spans, 1.0)
    away = []
    for span in spans:
        rest = stamps[span] - np.arange(span.stop - span.start)
        begin = grid[span][0]
        np.testing.assert_allclose(grid[span], begin + np.arange(span.stop - span.start))
        ends = (rest - allowed[span]).max(), (rest + allowed[span]).min()
        assert begin == pytest.approx(rest[0] if ends[0] <= rest[0] <= ends[1] else 0.5 * sum(ends))
        away.append(np.max(np.abs(rest - begin) / allowed[span]))
    assert wander == pytest.approx(max(away))


def test_the_period_is_that_of_a_weighted_straight_line() -> None:
    rng = np.random.default_rng(4)
    stamps = 1.003 * np.arange(60) + rng.uniform(-0.4, 0.4, 60)
    stamps[30:] += 7.0
    grain = rng.uniform(0.01, 0.1, 60)
    _, period, wander = time_stamps.grid_through(stamps, grain, (0, 30), 1.0, None)
    weight = 1.0 / (1.05 * grain + 1e-3)
    second = np.arange(60) >= 30
    design = np.column_stack([np.arange(60) - 30 * second, ~second, second]) * weight[:, None]
    assert wander > 1.0
    assert period == pytest.approx(
        np.linalg.lstsq(design, stamps * weight, rcond=None)[0][0], rel=1e-9
    )


def test_the_mean_step_leaves_gaps_out() -> None:
    stamps = np.cumsum([0.0, 1.0, 1.2, 0.8, 1.4, 9.0, 1.0])
    assert time_stamps.mean_step(stamps, np.zeros(7)) == pytest.approx(
        (1.0 + 1.2 + 0.8 + 1.4 + 1.0) / 5
    )
    assert time_stamps.mean_step(stamps, np.full(7, 9.0)) == pytest.approx(stamps[-1] / 6)


@pytest.mark.parametrize(
    ("rows", "stray"),
    [
        ([10], True),
        ([10, 20], True),
        ([10, 20, 30], False),
        ([10, 20, 32], False),
        ([10, 20, 33], True),
    ],
)
def test_repeats_at_equal_distances_are_no_strays(rows: list[int], stray: bool) -> None:
    repeats = np.zeros(100, np.bool_)
    repeats[rows] = True
    assert time_stamps.are_stray(repeats) == stray
    few = np.zeros(10, np.bool_)
    few[[1, 2, 8]] = True
    assert not time_stamps.are_stray(few)
    assert time_stamps.are_stray(np.concatenate([few, np.zeros(5, np.bool_)]))


def restarted(at: int, to: float, step: float = 1.0, rows: int = 400) -> bool:
    """Whether a clock that falls back in a row, to a time, is taken to have begun anew."""
    stamps = np.arange(float(rows))
    stamps[at:] += to - stamps[at]
    stamps[at + 1 :] += step - 1.0
    return len(time_stamps.begun_anew(stamps, "t")[1]) == 1


def test_when_a_clock_has_begun_anew() -> None:
    assert restarted(200, 0.0)
    assert restarted(200, 11.0)
    assert not restarted(200, 11.5)  # not at the start: a clock that was set back
    assert restarted(12, 0.0)  # 11 steps back
    assert not restarted(11, 0.0)  # 10 steps: less than a pause
    assert not restarted(399, 0.0)  # the last row: one damaged stamp
    assert restarted(398, 0.0)
    assert restarted(200, 0.0, step=11.0)
    assert not restarted(200, 0.0, step=12.0)  # the clock goes on as before it
    five = np.concatenate([np.arange(100.0)] * 5)
    assert len(time_stamps.begun_anew(five, "t")[1]) == 1
    many = np.concatenate([np.arange(80.0)] * 5)  # 4 of 400 rows are 1 %
    assert len(time_stamps.begun_anew(many, "t")[1]) == 1
    assert not time_stamps.begun_anew(np.concatenate([np.arange(78.0)] * 5), "t")[1]
    joined, (note,) = time_stamps.begun_anew(np.concatenate([np.arange(150.0)] * 7), "t")
    assert np.all(np.diff(joined)[149::150] == pytest.approx(11.0))
    assert (
        note
        == "t begins anew in data row 151, 301, 451, 601, 751, ...: a new stretch each time, 11 s after the last"
    )


@pytest.mark.parametrize(("step", "fine"), [(1.1e-12, True), (0.9e-12, False)])
def test_the_shortest_step(step: float, fine: bool) -> None:
    if fine:
        assert clock_of(step * np.arange(20)).period == pytest.approx(step)
    else:
        with pytest.raises(TimingError, match="below the shortest of 1e-12 s"):
            clock_of(step * np.arange(20))


def test_backwards_more_than_once_is_counted() -> None:
    stamps = np.arange(50.0)
    stamps[[20, 30]] -= 5.0
    with pytest.raises(
        TimingError, match=r"runs backwards at data row 21: 15 s after 19 s \(2 times in all\)"
    ):
        clock_of(stamps)


def test_a_shorter_number_is_taken_among_periods_that_stamps_cannot_tell() -> None:
    true = np.arange(100) * 0.0100004
    assert clock_of(np.round(true, 3)).period == 0.01
    assert clock_of(true).period == pytest.approx(0.0100004, rel=1e-9)
