"""Another sampling rate: what lies below the filter's edge is kept, what lies above is gone, nothing moves in time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from erclutch.errors import SettingError, ShortLogError
from erclutch.fit.checks.data_check import check
from erclutch.fit.past_samples import past_rows
from erclutch.logs import read, recording_from_arrays
from erclutch.logs.clock import resample
from erclutch.logs.clock.resample import PASSED, resampled
from erclutch.logs.dataset import build_dataset
from erclutch.logs.held_out import hold_out
from erclutch.logs.keywords import HERTZ, number_of
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording
from tests.support.examples import examples

UNITS = {"field": "A", "slip": "m/s", "effort": "N"}


def smooth(t: Array, slower: float) -> Array:
    """A drift and a sine below the filter's edge."""
    return 3.0 + 0.5 * t + np.sin(2 * np.pi * 0.9 * PASSED * slower / 2 * t)


def log_at(
    rate: float, slower: float, seconds: float = 2.0, alias: float = 0.0, name: str = "log"
) -> Recording:
    t = np.arange(int(seconds * rate)) / rate
    effort = smooth(t, slower) + (np.sin(2 * np.pi * alias * t) if alias else 0.0)
    signals = {"field": np.full(t.size, 0.3), "slip": smooth(t, slower), "effort": effort}
    return recording_from_arrays(signals, UNITS, rate=rate, name=name)


@pytest.mark.parametrize(
    ("old", "new"),
    [(3004.8, 1000.0), (1000.0, 100.0), (1000.0, 900.0), (500.0, 1000.0), (1000.0, 999.5)],
)
def test_what_is_slow_is_kept_and_nothing_moves(old: float, new: float) -> None:
    slower = min(old, new)
    log = log_at(old, slower, 4.0)
    got = resampled(log, new)
    np.testing.assert_allclose(got.signals["slip"], smooth(got.time, slower), atol=2e-3)
    np.testing.assert_allclose(np.diff(got.time), 1 / new, rtol=1e-6)
    assert (got.period, got.uniform) == (1 / new, True)
    # Edges that the filter would reach beyond are gone, and no more than they.
    assert got.time[0] - log.time[0] == pytest.approx(16 / slower, abs=1.1 / new)
    assert log.time[-1] - got.time[-1] == pytest.approx(16 / slower, abs=1.1 / new)


@pytest.mark.parametrize("alias", [52.0, 70.0, 103.0, 350.0])
def test_aliases_are_stopped(alias: float) -> None:
    got = resampled(log_at(1000.0, 100.0, 4.0, alias), 100.0)
    np.testing.assert_allclose(got.signals["effort"], smooth(got.time, 100.0), atol=1e-3)


def test_a_constant_stays_what_it_is_and_the_note_says_what_was_done() -> None:
    got = resampled(log_at(1000.0, 100.0), 100.0)
    assert set(got.signals["field"]) == {0.3}
    assert (
        "brought from 1000 Hz to 100 Hz by a zero-phase filter that passes 34 Hz and stops 50 Hz"
        in got.notes[-1]
    )
    assert "160 ms left out at each end" in got.notes[-1]


def test_columns_that_nothing_takes_come_along() -> None:
    log = log_at(1000.0, 5.0)
    got = resampled(replace(log, spare={"effort again": log.signals["effort"]}), 400.0)
    np.testing.assert_array_equal(got.spare["effort again"], got.signals["effort"])


def test_each_stretch_by_itself() -> None:
    t = np.concatenate(
        [np.arange(1000) / 1000, 5 + np.arange(1000) / 1000, 9 + np.arange(20) / 1000]
    )
    level = np.repeat([1.0, 7.0, 3.0], [1000, 1000, 20])
    got = resampled(
        recording_from_arrays({"field": level, "slip": np.sin(t), "effort": level}, UNITS, time=t),
        500.0,
    )
    assert len(got.segments) == 2
    for (a, b), value in zip(got.segments, (1.0, 7.0), strict=True):
        assert set(got.signals["effort"][a:b]) == {value}
        np.testing.assert_allclose(got.signals["slip"][a:b], np.sin(got.time[a:b]), atol=1e-5)
    assert "1 stretch too short for the filter left out" in got.notes[-1]


@pytest.mark.slow
def test_unequal_steps_become_equal() -> None:
    rng = np.random.default_rng(0)
    t = np.cumsum(rng.uniform(0.8e-3, 1.2e-3, 3000))
    log = recording_from_arrays(
        {"field": np.cos(t), "slip": np.sin(t), "effort": np.sin(t)}, UNITS, time=t
    )
    assert not log.uniform
    got = resampled(log, 250.0)
    np.testing.assert_allclose(got.signals["slip"], np.sin(got.time), atol=1e-2)
    assert "unequal steps were joined by straight lines" in got.notes[-1]


def test_the_same_rate_and_a_short_log() -> None:
    log = log_at(1000.0, 1000.0)
    assert resampled(log, 1000.0) is log
    with pytest.raises(SettingError, match="no gapless stretch is longer than the 320 rows"):
        resampled(log_at(1000.0, 100.0, 0.2), 100.0)
    with pytest.raises(SettingError, match=r"0\.01 Hz for a log at 1000 Hz"):
        resampled(log, 0.01)


def test_a_rate_that_would_fill_the_memory_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    log = log_at(100.0, 100.0, 4.0)
    assert log.rows == 400
    assert resampled(log, 1000.0).rows < 4000
    monkeypatch.setattr(resample, "_MOST_ROWS", 3999)
    with pytest.raises(
        SettingError, match=r"1000 Hz makes 4,000 rows of 400\. Give 1e\+03 Hz or less"
    ):
        resampled(log, 1000.0)


def test_logs_of_different_rates_are_refused_or_brought_to_one() -> None:
    one, other = log_at(1000.0, 500.0, name="one"), log_at(500.0, 500.0, name="other")
    apart = build_dataset([one, other])
    assert apart.rates == pytest.approx((500.0, 1000.0))
    with pytest.raises(SettingError) as caught:
        past_rows(("2ms",), apart)
    assert str(caught.value) == (
        "the logs were sampled at 500 to 1000 Hz, so past samples are other instants in each. "
        "Bring all logs to one rate, for example --resample 500."
    )
    assert past_rows((), apart) == ()
    joined = build_dataset([resampled(log, 500.0) for log in (one, other)])
    assert joined.rates == pytest.approx((500.0, 500.0))
    assert past_rows(("2ms",), joined) == (1,)
    near = build_dataset([one, log_at(1003.0, 500.0, name="near")])  # clocks of two recorders
    assert near.rates[0] == near.rates[1]


def test_a_check_says_what_the_rates_are() -> None:
    rng = np.random.default_rng(0)
    logs = []
    for rate in (1000.0, 500.0):
        signals = {name: rng.uniform(-1, 1, 400) for name in UNITS}
        logs.append(recording_from_arrays(signals, UNITS, rate=rate))
    data = build_dataset(logs)
    (note,) = [f for f in check(data, hold_out(data, 0.3)) if f.subject == "rate"]
    assert "sampled at 500 to 1000 Hz" in note.message
    data = build_dataset([resampled(log, 250.0) for log in logs])
    (note,) = [f for f in check(data, hold_out(data, 0.3)) if f.subject == "rate"]
    assert "logs were brought from 1000 Hz to 250 Hz" in note.message
    assert "(and 1 other ways)" in note.message


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("1000", 1000.0),
        ("1kHz", 1000.0),
        ("0.5 kHz", 500.0),
        ("3004.8 Hz", 3004.8),
        ("1e3", 1000.0),
    ],
)
def test_rates(text: str, rate: float) -> None:
    assert number_of("resample", text, HERTZ) == pytest.approx(rate)


@pytest.mark.parametrize("text", ["", "0", "-5", "fast", "1 ms", "nan", "inf Hz", "1e99", "3 rpm"])
def test_what_is_no_rate(text: str) -> None:
    with pytest.raises(SettingError, match="no sampling rate"):
        number_of("resample", text, HERTZ)


@pytest.mark.slow
@settings(deadline=None)
@given(st.text(max_size=15))
def test_any_text_is_a_rate_or_one_line(text: str) -> None:
    try:
        rate = number_of("resample", text, HERTZ)
    except SettingError:
        return
    assert 1e-3 <= rate <= 1e7


@pytest.mark.slow
@settings(max_examples=examples(25), deadline=None)
@example(562, 0.0625)
@example(656, 0.0625)
@given(st.integers(200, 3000), st.floats(0.05, 3.0))
def test_any_ratio_keeps_a_line_and_its_time(rows: int, ratio: float) -> None:
    t = np.arange(rows) / 1000
    log = recording_from_arrays({"field": t, "slip": 2 * t - 1, "effort": -t}, UNITS, rate=1000.0)
    try:
        got = resampled(log, 1000.0 * ratio)
    except (
        SettingError,
        ShortLogError,
    ):  # fewer than ten rows, nine steps, are left between the ends of the filter
        assert rows < 32 * max(1 / ratio, 1) + 9 / ratio + 2
        return
    np.testing.assert_allclose(got.signals["slip"], 2 * got.time - 1, atol=1e-3)
    assert got.time[0] >= t[0]
    assert got.time[-1] <= t[-1] + 1e-9


@pytest.mark.slow
def test_an_angle_that_starts_again_is_drawn_out_before_the_filter(tmp_path: Path) -> None:
    t = np.arange(4000) / 1000
    angle = 2.0 * np.sin(2.0 * t) + 9.0 * t  # rad
    columns = {"t [s]": t, "I [A]": np.ones(t.size), "q [rad]": angle % (2 * np.pi), "M [N*m]": t}
    rows = np.column_stack(list(columns.values()))
    path = tmp_path / "log.csv"
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="")
    log = read(path, field="I [A]", position="q [rad]", effort="M [N*m]", resample=200.0)
    slip = build_dataset(log).elements[0].slip
    np.testing.assert_allclose(slip[9:-9], (4.0 * np.cos(2.0 * log.time) + 9.0)[9:-9], atol=0.01)
    assert any("starts again after a full turn, 6 times" in note for note in log.notes)
