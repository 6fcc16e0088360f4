"""Self-heating: known answers, its numbers found from nothing, and the ladder on brakes that warm by another law."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.choice import ladder
from erclutch.fit.choice import rungs as rungs_of
from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.stages import stage_named
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.slow_params import slow_behind

PERIOD = 0.05
ROWS = 6000
LAW = law_from_name("bingham", "single")
#: Currents in A and speeds in rad/s of a brake that slips all the time.
CURRENTS = np.random.default_rng(3).choice([0.0, 0.5, 1.0, 1.5, 2.0], 30)
SPEEDS = np.random.default_rng(4).uniform(5.0, 30.0, 8)


def clock_of(rows: int) -> Clock:
    return Clock(np.arange(float(rows)) * PERIOD, (Span(0, rows, PERIOD),))


def stepped(levels: Array, rows: int = ROWS) -> Array:
    return np.repeat(levels, -(-rows // levels.size))[:rows]


def brake(fade: float, tau_s: float, thinning: float = 0.0) -> Dataset:
    """A brake whose heat comes of the torque that it gives, faded as that is: the stage knows the power of a cold one.

    Args:
        fade: of the yield torque at the mean power of the log, as a share.
        tau_s: time constant of warming.
        thinning: of the viscosity at that heat, as a share.
    """
    current = stepped(CURRENTS)
    slip = stepped(SPEEDS)
    cold = 6.0 * (current / 2.0) ** 1.2
    mean_power = float(np.mean(cold * slip))
    heat = 0.0
    effort = np.empty(ROWS)
    for k in range(ROWS):
        effort[k] = 0.3 + cold[k] * (1.0 - fade * heat) + 0.02 * (1.0 - thinning * heat) * slip[k]
        heat += PERIOD / tau_s * (effort[k] * slip[k] / mean_power - heat)
    effort += 0.03 * np.random.default_rng(5).standard_normal(ROWS)
    return Dataset(
        "single", (Element(current, slip),), effort, clock_of(ROWS), Units("N*m", "A", "rad/s")
    )


def structure(stages: str = "none") -> Structure:
    return Structure("single", "bingham", LAW, stages, offset=True)


def halves(log: Dataset) -> tuple[Dataset, slice]:
    """The first 70 % of a log, and the rest of its rows."""
    cut = round(0.7 * log.rows)
    return log.take(np.arange(log.rows) < cut), slice(cut, None)


def test_a_power_that_lasts_warms_as_newton_says() -> None:
    stage = stage_named("self-heating")
    slip = np.full(400, 0.5)
    (fade,) = stage.respond(
        SlipAndStrength(slip, 0.8 + 0.0 * slip), clock_of(400), [4.0], slice(None)
    )
    time = clock_of(400).time
    assert fade == pytest.approx(0.4 * (1.0 - np.exp(-time / 4.0)), abs=3e-3)
    (back,) = stage.respond(
        SlipAndStrength(-slip, 0.8 + 0.0 * slip), clock_of(400), [4.0], slice(None)
    )
    assert back == pytest.approx(-fade)


def test_a_heat_that_no_log_had_takes_the_effort_no_further() -> None:
    stage = stage_named("self-heating/viscous")
    slip = np.full(4000, 30.0)
    of_yield, of_viscous = stage.respond(
        SlipAndStrength(slip, 1.0 + 0.0 * slip), clock_of(4000), [4.0], slice(None)
    )
    assert of_yield[-1] == 2.0
    assert of_viscous[-1] == 60.0


@pytest.mark.slow
def test_known_numbers_are_found_in_units() -> None:
    log = brake(0.0, 20.0)
    reference = rms(log.elements[0].slip)
    power = SlipAndStrength(log.elements[0].slip / reference, (log.elements[0].field / 2.0) ** 1.2)
    (fade,) = stage_named("self-heating").respond(power, log.clock, [20.0], slice(None))
    faded = Dataset(
        "single",
        log.elements,
        log.effort - 1.5 * power.strength * fade,
        log.clock,
        Units("N*m", "A", "rad/s"),
    )
    outcome = fit_structure(faded, structure("self-heating"))
    found = {estimate.name: estimate for estimate in outcome.estimates}
    assert found["tau_h"].unit == "s"
    for name, value in {"tau_h": 20.0, "T_h": -1.5, "T_y": 6.0, "n": 1.2}.items():
        assert found[name].low < value < found[name].high, name
    assert found["tau_h"].high - found["tau_h"].low < 0.2 * 20.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fade", "tau_s"), slow_behind(1, [(0.08, 30.0), (0.15, 100.0), (0.2, 15.0)])
)
def test_the_rest_of_a_log_is_told_where_the_device_warms(fade: float, tau_s: float) -> None:
    log = brake(fade, tau_s)
    train, rest = halves(log)
    rungs = grown(train, structure(), among=("dahl/field", "self-heating", "self-heating/viscous"))
    assert "self-heating" in rungs[-1].structure.dynamics
    errors = []
    for rung in (rungs[0], rungs[-1]):
        outcome = fit_structure(
            train, rung.structure, starts=[list(rung.numbers.values())], intervals=False
        )
        errors.append(rms((log.effort - outcome.model.predict(log))[rest]))
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.slow
def test_a_viscosity_that_falls_gets_its_own_gain() -> None:
    log = brake(0.05, 40.0, thinning=0.5)
    rungs = grown(log, structure(), among=("self-heating", "self-heating/viscous"))
    assert rungs[-1].structure.dynamics == "self-heating/viscous"


@pytest.mark.slow
def test_a_device_that_stays_cold_is_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[str] = []
    searched = rungs_of.rung_of

    def counted(folds, of_structure, known):  # type: ignore[no-untyped-def]
        tried.append(of_structure.dynamics)
        return searched(folds, of_structure, known)

    monkeypatch.setattr(ladder, "rung_of", counted)
    rungs = grown(brake(0.0, 20.0), structure(), among=("self-heating", "stiffness"))
    assert [rung.structure.dynamics for rung in rungs] == ["none"]
    assert set(tried) == {
        "none"
    }  # the law alone, with either yield effort: no search was made for a stage


@pytest.mark.slow
def test_a_log_that_is_cut_for_the_search_is_whole_where_the_device_warms(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(rungs_of, "_MOST_ROWS", 1200)
    rungs = grown(brake(0.15, 150.0), structure(), among=("self-heating",))
    assert rungs[-1].structure.dynamics == "self-heating"
    assert 100.0 < rungs[-1].numbers["tau_h"] < 200.0  # some hours where each stretch begins cold
