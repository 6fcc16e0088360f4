"""A log that moves more slowly or more quickly than every log of a fit is told in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.log_groups import rate_of
from erclutch.fit.pace import motion_held_out, other_motion, told, two_motions
from erclutch.logs.clock.timing import of_points
from erclutch.logs.dataset import Dataset, joined
from erclutch.signals.array import Array, rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units


def sine(hertz: float, size: float = 3.0, name: str = "log") -> Dataset:
    """Twenty seconds of a sine."""
    time: Array = 5e-3 * np.arange(4000.0)
    element = Element(np.full(time.size, 1.0), size * np.sin(2.0 * np.pi * hertz * time))
    clock = Clock(time, (Span(0, time.size, 5e-3),))
    units = Units("N*m", "V", "rad/s")
    rows = ((0, time.size),)
    return Dataset(
        "single", (element,), np.zeros(time.size), clock, units, sources=(name,), source_rows=rows
    )


LOGS = [sine(1.0, name="a"), sine(2.0, name="b")]
#: What is noted on rows that are points of a table.
OF_POINTS = of_points(10, 1.0).notes
KNOWN = joined(LOGS)


@pytest.mark.parametrize("hertz", [0.6, 0.9, 1.0, 1.5, 2.0, 2.2, 3.5])
def test_a_motion_like_those_of_the_fit_needs_no_word(hertz: float) -> None:
    assert other_motion(KNOWN, sine(hertz, size=0.5)) == []


def test_three_logs_say_how_much_a_pace_scatters() -> None:
    several = joined([*LOGS, sine(1.5, name="c")])
    assert other_motion(several, sine(2.2)) == []
    assert other_motion(KNOWN, sine(3.0)) == []
    assert len(other_motion(several, sine(3.0))) == 1


@pytest.mark.parametrize(
    ("hertz", "way", "limit"), [(0.2, "more slowly", "slowest"), (5.0, "more quickly", "quickest")]
)
def test_a_slower_and_a_quicker_motion_are_told(hertz: float, way: str, limit: str) -> None:
    (seen,) = other_motion(KNOWN, sine(hertz, name="new"))
    assert seen.startswith(
        f"new moves {way} than every training log: the slip changes as a sine of {hertz:.2g} Hz does"
    )
    assert f"in the {limit} training log as a sine of" in seen
    (sentence,) = told(KNOWN, sine(hertz))
    assert sentence.endswith("off there. Add a log of such a motion to the fit.")


def test_two_motions_are_said_to_tell_too_little_of_a_third() -> None:
    (finding,) = two_motions(KNOWN)
    assert "of a third motion the prediction band holds less than it says" in finding.message
    assert not two_motions(LOGS[0])
    assert not two_motions(joined([LOGS[0], LOGS[0]]))
    assert not two_motions(joined([*LOGS, sine(4.0, name="c")]))
    assert not two_motions(KNOWN.take(np.arange(KNOWN.rows) < LOGS[0].rows))
    assert not two_motions(replace(KNOWN, notes=OF_POINTS))


def test_of_several_logs_the_furthest_is_named() -> None:
    several = joined([sine(0.4, name="c"), sine(0.1, name="d"), sine(1.0, name="e")])
    (seen,) = other_motion(KNOWN, several)
    assert seen.startswith("2 of 3 logs, d the most, move more slowly than every training log")


def test_a_log_at_rest_has_no_pace() -> None:
    assert other_motion(KNOWN, sine(7.0, size=1e-3)) == []
    assert other_motion(sine(7.0, size=0.0), sine(1.0)) == []


def test_points_of_a_table_do_not_move() -> None:
    assert other_motion(KNOWN, replace(sine(7.0), notes=OF_POINTS)) == []


def test_a_fit_says_it_of_logs_that_it_holds_out_whole() -> None:
    data = joined([*LOGS, sine(5.0, name="c")])
    start, stop = data.source_rows[-1]
    test = np.zeros(data.rows, np.bool_)
    test[start + 1000 : stop] = True
    assert motion_held_out(data, test) == ()
    test[start:stop] = True
    (finding,) = motion_held_out(data, test)
    assert (finding.level, finding.subject) == ("note", "motion")
    assert finding.message.startswith("c moves more quickly")


def noisy(data: Dataset, share: float, seed: int = 0) -> Dataset:
    """The same with noise of the slip, a share of its root mean square."""
    (element,) = data.elements
    noise = share * rms(element.slip) * np.random.default_rng(seed).standard_normal(data.rows)
    return replace(data, elements=(Element(element.field, element.slip + noise),))


@pytest.mark.parametrize("share", [0.0, 0.05, 0.2])
@pytest.mark.parametrize("hertz", [0.1, 1.0, 5.0])
def test_noise_of_a_sensor_sets_no_rate(share: float, hertz: float) -> None:
    data = noisy(sine(hertz), share)
    turn = 2.0 * np.pi * hertz / np.sqrt(1.0 + share**2)
    assert rate_of(data.elements[0].slip, data.clock.time) == pytest.approx(
        turn * rms(data.elements[0].slip), rel=0.1
    )


def test_a_ramp_has_its_slope_as_rate_and_a_slip_that_stands_still_none() -> None:
    time: Array = 1e-3 * np.arange(5000.0)
    assert rate_of(3.0 * time, time) == pytest.approx(3.0, rel=0.1)
    assert rate_of(np.full(5000, 2.0), time) == 0.0
    assert rate_of(np.array([2.0]), time[:1]) == 0.0


def test_two_motions_are_two_and_their_paces_true_under_noise() -> None:
    """From row to row such noise changes more than either motion."""
    slow, quick = noisy(sine(0.1, name="slow"), 0.1, 1), noisy(sine(0.4, name="quick"), 0.1, 2)
    assert two_motions(joined([slow, quick]))
    (seen,) = other_motion(joined([slow, quick]), noisy(sine(2.0, name="new"), 0.1, 3))
    assert "as a sine of 2 Hz does, in the quickest training log as a sine of 0.4 Hz" in seen
