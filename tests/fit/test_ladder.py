"""The ladder of memory takes a stage where the rows tell it, and none for noise that swings on over many windows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.choice.ladder import grown, may_show, tells_without_field
from erclutch.fit.choice.rungs import Rung, by_chance
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.slow_params import slow_behind

PERIOD, ROWS, TRAVEL = 2e-3, 1500, 0.02  # s, -, rad
#: Of a noise that swings at the pace of the motion: a period of 260 rows, which decays over 50.
SWING = (2.0 * 0.98 * np.cos(2.0 * np.pi / 260.0), -(0.98**2))
BASE = Structure("single", "bingham", law_from_name("bingham", "single"), "none", True, True)


def log(seed: int, *, swings: bool) -> Dataset:
    """Five fields, and a yield effort that is a Dahl state (SYNTHETIC, truth known)."""
    rng = np.random.default_rng(seed)
    time: Array = PERIOD * np.arange(float(ROWS))
    field = np.repeat(rng.choice((0.0, 0.3, 0.5, 0.8, 1.0), ROWS // 60), 60)
    phases = rng.uniform(0.0, 2.0 * np.pi, 2)
    slip = 3.0 * np.sin(4.4 * time + phases[0]) + 2.0 * np.sin(11.9 * time + phases[1])
    yielding = 0.8 * field**1.5
    state, states = float(yielding[0] * np.sign(slip[0])), np.empty(ROWS)
    for k, (effort, w) in enumerate(zip(yielding.tolist(), slip.tolist(), strict=True)):
        gone = 1.0 - np.exp(-abs(w) * PERIOD / TRAVEL)
        state = states[k] = (1.0 - gone) * state + gone * effort * np.sign(w)
    noise = rng.standard_normal(1000 + ROWS)
    if swings:
        for k in range(2, noise.size):
            noise[k] += SWING[0] * noise[k - 1] + SWING[1] * noise[k - 2]
    noise = noise[1000:] / np.std(noise)
    clock = Clock(time, (Span(0, ROWS, PERIOD),))
    measured = states + 0.05 * slip + 0.02 * noise
    return Dataset("single", (Element(field, slip),), measured, clock, Units("N*m", "A", "rad/s"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "swings"), slow_behind(2, [(0, False), (7008, True), (7011, True)])
)
def test_a_memory_is_told_from_noise_at_the_pace_of_the_motion(seed: int, swings: bool) -> None:
    data = log(seed, swings=swings)
    rung = grown(data, BASE, among=("dahl/field", "lugre/field", "effort-lag"))[-1]
    assert rung.structure.dynamics == "dahl/field"


@pytest.mark.slow
@pytest.mark.parametrize(("late", "stages"), [(0.0, "dahl/field"), (0.03, "lag+dahl/field")])
def test_a_lag_stays_only_where_the_rows_tell_it_beside_the_memory(
    late: float, stages: str
) -> None:
    """Without the memory a lag takes some of its effort for its own."""
    data = log(0, swings=False)
    (element,) = data.elements
    ahead = round(late / PERIOD)  # the command changes so many rows before the effort does
    command = np.concatenate([element.field[ahead:], np.full(ahead, element.field[-1])])
    led = replace(data, elements=(Element(command, element.slip),))
    rung = grown(led, replace(BASE, dynamics="lag"), among=("dahl/field",))[-1]
    assert rung.structure.dynamics == stages


def test_what_numbers_take_off_by_chance_is_by_the_rows_that_are_independent() -> None:
    richer = replace(BASE, dynamics="dahl/field")
    more = Rung(richer, 1.0, {}, 0.0).numbers_of_fit - Rung(BASE, 1.0, {}, 0.0).numbers_of_fit
    assert more == 2
    for independent, share in (
        (np.inf, 0.0),
        (1500.0, 0.0007),
        (25.0, 0.041),
        (4.0, 0.293),
        (1.0, 1.0),
    ):
        assert by_chance(
            Rung(BASE, 1.0, {}, np.inf), Rung(richer, 0.9, {}, independent)
        ) == pytest.approx(share, abs=1e-3)
    assert by_chance(Rung(richer, 1.0, {}, 4.0), Rung(BASE, 0.9, {}, 4.0)) == 0.0


@pytest.mark.slow
def test_a_memory_that_holds_without_a_field_too_has_the_field_behind_it() -> None:
    """With the field ahead of it the share without a field is none, and lags or iron stand in for what is missing."""
    data = log(0, swings=False)
    (element,) = data.elements
    state, states = float(np.sign(element.slip[0])), np.empty(ROWS)
    for k, w in enumerate(element.slip.tolist()):
        gone = 1.0 - np.exp(-abs(w) * PERIOD / 0.2)
        state = states[k] = (1.0 - gone) * state + gone * np.sign(w)
    noise = 0.02 * np.random.default_rng(1).standard_normal(ROWS)
    effort = (0.2 + 0.8 * element.field**1.5) * states + 0.05 * element.slip + noise
    rung = grown(
        replace(data, effort=effort), BASE, among=("dahl/field", "effort-lag", "remanence")
    )[-1]
    assert rung.structure.dynamics == "dahl"
    assert rung.error < 0.03


def test_a_memory_without_rows_at_no_field_keeps_the_field_ahead() -> None:
    data = log(0, swings=False)
    (element,) = data.elements
    assert tells_without_field(data)
    assert not tells_without_field(
        replace(data, elements=(Element(element.field + 0.1, element.slip),))
    )


@pytest.mark.slow
def test_a_yield_effort_that_saturates_is_told_by_one_log() -> None:
    """Without it false stages stand in for the bend."""
    data = log(0, swings=False)
    (element,) = data.elements
    field = np.repeat(np.random.default_rng(3).uniform(0.0, 1.0, ROWS // 30), 30)
    noise = 0.02 * np.random.default_rng(1).standard_normal(ROWS)
    effort = (
        np.tanh((field / 0.5) ** 2.5) * np.tanh(element.slip / 0.1) + 0.05 * element.slip + noise
    )
    bent = replace(data, effort=effort, elements=(Element(field, element.slip),))
    rung = grown(bent, BASE, among=("dahl/field", "remanence", "sides"))[-1]
    assert rung.structure.specification == "bingham/saturating"
    assert rung.structure.dynamics == "none"
    assert rung.numbers["n"] == pytest.approx(2.5, abs=0.3)


def test_a_stage_shows_only_beside_the_best_of_the_laws_own_starts() -> None:
    """Of a law whose numbers are not known yet the first start may be far off, and any stage better at another one."""
    data = log(0, swings=False)
    unknown = Rung(BASE, 1.0, {}, np.inf)
    assert not may_show(data, unknown, replace(BASE, dynamics="self-heating"))


@pytest.mark.slow
@pytest.mark.parametrize(("forward", "stages"), [(0.0, "lugre/field"), (0.08, "lugre/field/sides")])
def test_bristles_under_a_hump_get_their_own_stage_and_no_other(
    forward: float, stages: str
) -> None:
    """A joint in presliding: LuGre's published equations in fine steps, SYNTHETIC, with static and sliding level.

    Forward these may be higher than backward; what differs between the ways and knows no bristles erred by 1.4 times.
    """
    sliding, static, fades, stiffness, damping = 10.0, 16.0, 0.004, 1e5, 150.0
    time: Array = PERIOD * np.arange(4000.0)
    slip = 0.01 * np.sin(4.4 * time) + 0.008 * np.sin(11.9 * time + 1.0)
    bent, friction = sliding / stiffness, np.empty(time.size)
    for k, w in enumerate(slip.tolist()):
        level = sliding + (static - sliding) * np.exp(-((w / fades) ** 2))
        level *= 1.0 + forward * np.sign(w)
        rate = 0.0
        for _ in range(20):
            rate = w - stiffness * abs(w) / level * bent
            bent += rate * PERIOD / 20
        friction[k] = stiffness * bent + damping * rate
    noise = 0.2 * np.random.default_rng(1).standard_normal(time.size)
    clock = Clock(time, (Span(0, time.size, PERIOD),))
    element = Element(np.zeros(time.size), slip)
    effort = friction + 60.0 * slip + noise
    joint = Dataset("single", (element,), effort, clock, Units("N", "A", "m/s"))
    law = law_from_name("bingham/constant", "single")
    base = Structure("single", "bingham/constant", law, "none", False, True)
    rung = grown(joint, base)[-1]
    assert rung.structure.dynamics == stages
    assert rung.error == pytest.approx(0.2, rel=0.05)
    if forward:
        assert rung.numbers["a_l"] == pytest.approx(forward, rel=0.05)
    assert rung.numbers["h_l"] == pytest.approx(static / sliding, rel=0.05)
    assert rung.numbers["w_l"] * np.sqrt(np.mean(slip**2)) == pytest.approx(fades, rel=0.05)
