"""Stribeck's hump of the friction: its numbers are found from nothing, and data ask for it only where there is one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.arithmetic.dual import partial_of, seed
from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.clock.timing import of_points
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.stages import needs_time, slip_stages, stage_named
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

ROWS = 2400
PERIOD = 4e-3
AMONG = ("dahl/field", "viscous", "sides", "knees", "stribeck", "stribeck-1")
#: Coulomb and static level in N m, Stribeck's speed in rad/s, viscosity in N m s/rad, speed over which the sign turns.
COULOMB, STATIC, SPEED, VISCOSITY, TURN = 1.0, 1.6, 0.08, 0.4, 0.006
NOISE = 0.03


def friction(slip: Array, static: float = STATIC, exponent: int = 2) -> Array:
    """The friction as it is published, with a sign that turns over a small slip."""
    left = np.exp(-(np.abs(slip / SPEED) ** exponent))
    return np.tanh(slip / TURN) * (COULOMB + (static - COULOMB) * left)


def rows_of(slip: Array, field: Array, effort: Array, random: int = 5) -> Dataset:
    effort = effort + NOISE * np.random.default_rng(random).standard_normal(slip.size)
    clock = Clock(PERIOD * np.arange(float(slip.size)), (Span(0, slip.size, PERIOD),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N*m", "A", "rad/s"))


def joint(static: float = STATIC, exponent: int = 2, one_way: bool = False) -> Dataset:
    """A joint without a field, that runs both ways at up to 1.2 rad/s."""
    t = PERIOD * np.arange(float(ROWS))
    slip = 0.7 * np.sin(1.7 * t) + 0.5 * np.sin(4.1 * t)
    if one_way:
        slip = np.abs(slip)
    effort = friction(slip, static, exponent) + VISCOSITY * slip
    return rows_of(slip, np.zeros(ROWS), effort)


def points(static: float, random: int) -> Dataset:
    """Forty points of speed and friction."""
    one_way: Array = np.geomspace(0.02, 1.0, 20)
    slip = np.concatenate([-one_way[::-1], one_way])
    data = rows_of(
        slip, np.zeros(slip.size), friction(slip, static) + VISCOSITY * slip, random=random
    )
    return replace(data, notes=of_points(data.rows, 1.0).notes)


def structure(stages: str, law: str = "bingham/constant") -> Structure:
    of_field = not law.endswith("/constant")
    made = law_from_name(law, "single")
    return Structure("single", law, made, stages, friction=of_field, offset=True)


def test_the_hump_is_whole_at_rest_and_gone_where_all_slides() -> None:
    (stage,) = slip_stages("stribeck")
    slip = np.array([-5.0, -0.5, 0.0, 0.5, 5.0])
    (left,) = stage.settled(SlipAndStrength(slip, np.ones(5)), {"w_st": 0.5})
    assert left[2] == 1.0
    assert left[1] == left[3] == pytest.approx(np.exp(-1.0))
    assert left[0] == left[4] < 1e-40


@pytest.mark.parametrize(
    ("name", "exponent"), [("stribeck", 2.0), ("stribeck-1", 1.0), ("stribeck-3", 3.0)]
)
def test_the_free_exponent_says_what_a_fixed_one_says(name: str, exponent: float) -> None:
    moved = SlipAndStrength(np.linspace(-2.0, 2.0, 81), np.ones(81))
    (fixed,) = slip_stages(name)[0].settled(moved, {"w_st": 0.4})
    (free,) = slip_stages("stribeck/free")[0].settled(moved, {"w_st": 0.4, "p_st": exponent})
    np.testing.assert_allclose(fixed, free, atol=1e-9)


def test_its_columns_turn_with_the_friction_of_the_law() -> None:
    slip = np.linspace(-1.0, 1.0, 41)
    made = structure("stribeck", "bingham")
    clock = Clock(PERIOD * np.arange(41.0), (Span(0, 41, PERIOD),))
    field = np.full(41, 2.0)
    columns = made.columns(
        (Element(field, slip),), clock, Reference(2.0, 1.0, PERIOD), [0.1, 1.5, 0.3]
    )
    names = [gain.name for gain in made.gains()]
    way = columns[names.index("T_f")]
    hump = columns[names.index("T_st")]
    np.testing.assert_array_equal(way, np.tanh(slip / 0.1))
    np.testing.assert_allclose(hump, way * np.exp(-((slip / 0.3) ** 2)))
    np.testing.assert_allclose(columns[names.index("T_sty")], hump)


def test_its_derivatives_in_the_turning_slip_are_those_of_differences() -> None:
    slip = np.linspace(-1.0, 1.0, 41)
    made = structure("stribeck/free")
    clock = Clock(PERIOD * np.arange(41.0), (Span(0, 41, PERIOD),))
    reference = Reference(1.0, 1.0, PERIOD)
    element = Element(np.zeros(41), slip)
    q = [0.1, 0.3, 1.3]  # turning slip, Stribeck's speed, exponent
    place = [gain.name for gain in made.gains()].index("T_st")
    exact = made.columns((element,), clock, reference, seed(q))[place]
    for k, value in enumerate(q):
        step = 1e-6 * value
        up, down = (
            made.columns((element,), clock, reference, [*q[:k], value + way * step, *q[k + 1 :]])
            for way in (1, -1)
        )
        slope = (up[place] - down[place]) / (2.0 * step)
        np.testing.assert_allclose(partial_of(exact, k), slope, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("one_way", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_known_numbers_are_found_in_the_units_of_the_log(one_way: bool) -> None:
    outcome = fit_structure(joint(one_way=one_way), structure("stribeck"))
    found = {estimate.name: estimate for estimate in outcome.estimates}
    assert found["T_st"].unit == "N*m"
    assert found["w_st"].unit == "rad/s"
    truth = {"T_y": COULOMB, "T_st": STATIC - COULOMB, "w_st": SPEED, "eta": VISCOSITY, "w_s": TURN}
    for name, value in truth.items():
        assert found[name].low < value < found[name].high, name
        assert found[name].value == pytest.approx(value, rel=0.1), name
    assert outcome.train_cost**0.5 < 1.03 * NOISE * ROWS**0.5


@pytest.mark.slow
def test_a_field_scales_its_own_share_of_the_hump() -> None:
    t = PERIOD * np.arange(float(ROWS))
    slip = 0.7 * np.sin(1.7 * t) + 0.5 * np.sin(4.1 * t)
    field = np.repeat([0.0, 0.5, 1.0, 1.5, 2.0, 1.0, 0.0, 2.0], ROWS // 8)
    effort = (0.2 + 2.0 * (field / 2.0) ** 1.3) * friction(slip) + VISCOSITY * slip
    outcome = fit_structure(rows_of(slip, field, effort), structure("stribeck", "bingham"))
    assert outcome.sound
    found = {estimate.name: estimate for estimate in outcome.estimates}
    step = STATIC - COULOMB
    truth = {"T_f": 0.2, "T_y": 2.0, "T_st": 0.2 * step, "T_sty": 2.0 * step, "w_st": SPEED}
    for name, value in truth.items():
        assert found[name].low < value < found[name].high, name


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [2, 1])
def test_a_log_with_a_hump_asks_for_it_and_for_its_exponent(exponent: int) -> None:
    rungs = grown(joint(exponent=exponent), structure("none"), among=AMONG)
    assert rungs[-1].structure.dynamics == ("stribeck" if exponent == 2 else "stribeck-1")
    assert rungs[-1].error < 1.03 * NOISE


@pytest.mark.slow
def test_a_log_without_a_hump_asks_for_none() -> None:
    rungs = grown(joint(static=COULOMB), structure("none"), among=AMONG)
    assert rungs[-1].structure.dynamics == "none"


@pytest.mark.slow
@pytest.mark.parametrize("random", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
def test_a_sheet_of_points_asks_for_a_hump_only_where_there_is_one(random: int) -> None:
    asked = grown(points(STATIC, random), structure("none"), among=("viscous", "stribeck"))
    assert asked[-1].structure.dynamics == "stribeck"
    alike = grown(points(COULOMB, random), structure("none"), among=("viscous", "stribeck"))
    assert "stribeck" not in alike[-1].structure.dynamics


def test_points_of_a_table_may_ask_for_it_for_it_needs_no_time() -> None:
    assert not needs_time(stage_named("stribeck"))


@pytest.mark.slow
def test_rates_over_decades_make_no_hump_of_a_plain_yield_stress() -> None:
    """The lowest rates lie below the least slip over which a sign turns, and a narrow hump took up what was missing."""
    field = np.repeat(np.linspace(0.0, 2.0, 5), 25)
    rate = np.tile(np.geomspace(0.1, 300.0, 25), 5)
    noise = np.random.default_rng(2).normal(0.0, 0.01, rate.size)
    stress = (5.0 + 200.0 * field**1.6 + 0.8 * rate) * (1.0 + noise)
    data = replace(rows_of(rate, field, stress), notes=of_points(rate.size, 1.0).notes)
    rungs = grown(data, structure("none", "bingham"), among=["stribeck", "stribeck-1"])
    assert len(rungs) == 1
