"""Of a long log stretches are kept that are even in time, and some whose rows are rare, whatever they measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.logs.dataset import Dataset
from erclutch.logs.stretch_choice import STRETCH, StretchChoice, cut
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.examples import examples
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.slow


def log_of(
    rows: int,
    field: np.ndarray | None = None,
    effort: np.ndarray | None = None,
    slip: np.ndarray | None = None,
) -> Dataset:
    time = np.arange(rows, dtype=np.float64) * 1e-3
    return Dataset(
        "single",
        (
            Element(
                np.ones(rows) if field is None else field,
                3.0 + np.sin(time) if slip is None else slip,
            ),
        ),
        np.zeros(rows) if effort is None else effort,
        Clock(time, (Span(0, rows, 1e-3),)),
        Units("N", "V", "m/s"),
    )


def kept_places(data: Dataset, most: int, *, said: int | None = None, seed: int = 0) -> np.ndarray:
    choice = StretchChoice(data.rows if said is None else said, most, seed)
    for stretch in cut(0, 0, data):
        choice.show(stretch)
    return np.array([stretch.first for stretch in choice.kept])


@given(stretches=st.integers(1, 60), share=st.floats(0.05, 1.5), tail=st.integers(0, STRETCH - 1))
@settings(max_examples=examples(40), deadline=None)
def test_kept_rows_stay_below_the_limit_and_all_are_kept_where_they_fit(
    stretches: int, share: float, tail: int
) -> None:
    data = log_of(stretches * STRETCH + tail)
    most = max(int(share * data.rows), 4 * STRETCH)
    places = kept_places(data, most)
    kept = sum(min(STRETCH, data.rows - place) for place in places.tolist())
    if most >= data.rows:
        assert kept == data.rows
    else:
        assert 0.5 * most - STRETCH <= kept <= most + STRETCH


def test_places_are_even_in_time_but_do_not_follow_a_step() -> None:
    data = log_of(200 * STRETCH)
    places = kept_places(data, 50 * STRETCH) // STRETCH
    assert np.max(np.diff(places, prepend=0, append=200)) <= 10  # slots of five stretches
    assert len(set(np.diff(places).tolist())) > 3
    assert places.tolist() == (kept_places(data, 50 * STRETCH) // STRETCH).tolist()
    assert places.tolist() != (kept_places(data, 50 * STRETCH, seed=1) // STRETCH).tolist()


@pytest.mark.parametrize("at", slow_behind(1, [13, 71, 188]))
def test_a_stretch_with_rare_rows_is_kept(at: int) -> None:
    """A field that is nowhere else, for a tenth of a second."""
    field = np.ones(200 * STRETCH)
    field[at * STRETCH + 100 : at * STRETCH + 200] = 5.0
    for seed in range(5):
        assert at in kept_places(log_of(field.size, field), 80 * STRETCH, seed=seed) // STRETCH


def test_the_measured_effort_has_no_say() -> None:
    data = log_of(200 * STRETCH)
    effort = np.zeros(data.rows)
    effort[71 * STRETCH : 71 * STRETCH + 5000] = 1e6
    assert (
        kept_places(replace(data, effort=effort), 44 * STRETCH).tolist()
        == kept_places(data, 44 * STRETCH).tolist()
    )


def test_where_everything_is_rare_few_stretches_are_kept_for_it() -> None:
    """A field that never comes back makes each stretch rare; the share of those in time stays what it is."""
    field = np.repeat(1.2 ** np.arange(200.0), STRETCH)
    places = kept_places(log_of(field.size, field), 80 * STRETCH) // STRETCH
    assert 70 <= places.size <= 80
    parts = np.histogram(places, bins=4, range=(0, 200))[0]
    assert np.all((parts >= 16) & (parts <= 21))


def test_a_log_that_is_longer_than_was_said_is_thinned_out() -> None:
    data = log_of(200 * STRETCH)
    for said in (1, data.rows // 10, data.rows // 2):
        places = kept_places(data, 20 * STRETCH, said=said) // STRETCH
        assert 8 <= places.size <= 23
        assert np.max(np.diff(places, prepend=0, append=200)) < 60


def beginnings(choice: StretchChoice) -> list[int]:
    """The first rows of kept stretches of which the rows before are not kept."""
    ends = {stretch.stop for stretch in choice.kept}
    return [stretch.first + stretch.lead for stretch in choice.kept if stretch.first not in ends]


def test_a_stretch_that_is_due_at_rest_comes_with_the_motion_before_it() -> None:
    rows = 200 * STRETCH
    slip = np.sin(0.01 * np.arange(rows))
    for at in range(10, 200, 10):  # each tenth and ninth stretch is a rest
        slip[(at - 2) * STRETCH - 50 : at * STRETCH] = 0.0
    choice = StretchChoice(rows, 60 * STRETCH)
    for stretch in cut(0, 0, log_of(rows, slip=slip)):
        choice.show(stretch)
    kept = {stretch.first // STRETCH for stretch in choice.kept}
    resting = {place for place in kept if place % 10 in (8, 9)}
    assert 6 <= len(resting) <= 18  # a fifth of the rows
    assert all(place - 1 in kept for place in resting)
    assert len(kept) <= 60


def test_stretches_begin_in_motion_or_behind_a_gap() -> None:
    """At rest a fluid holds what the rows before did to it, and these are not kept."""
    rows = 200 * STRETCH
    slip = 1e-3 * np.sin(0.01 * np.arange(rows))  # small in SI units, and still motion
    slip[30 * STRETCH : 100 * STRETCH + 50] = 0.0
    choice = StretchChoice(rows, 50 * STRETCH)
    for stretch in cut(0, 0, log_of(rows, slip=slip)):
        choice.show(stretch)
    first_rows = np.array(beginnings(choice))
    assert np.all(slip[first_rows] != 0.0)
    assert np.any(first_rows < 30 * STRETCH)
    assert np.any(first_rows > 100 * STRETCH)
    still = log_of(rows, slip=np.zeros(rows))
    gap = replace(
        still,
        clock=replace(
            still.clock, spans=(Span(0, 7 * STRETCH + 9, 1e-3), Span(7 * STRETCH + 9, rows, 1e-3))
        ),
    )
    choice = StretchChoice(rows, rows - 1)
    for stretch in cut(0, 0, gap):
        choice.show(stretch)
    assert beginnings(choice) == [0, 7 * STRETCH + 9]
