"""Terms of a law that its memory says better, and twins without a field, are left out: the law stays eligible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.candidate import Fitted
from erclutch.fit.comparison import compare
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.law_alone import LawCandidate
from erclutch.fit.kinds.law_with_network import LawWithNetworkCandidate
from erclutch.fit.laws.fit_law import fit_structure, refit_near
from erclutch.fit.laws.terms_told import with_terms_told
from erclutch.fit.laws.twin_gains import twin_gains
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.networks import network_from_name
from erclutch.models.residual_model import ResidualStructure
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD, ROWS = 2e-3, 3000  # s


def joint(travel: float) -> Dataset:
    """Friction of a joint without a field, whose viscous effort thins (SYNTHETIC, truth known)."""
    rng = np.random.default_rng(3)
    time: Array = PERIOD * np.arange(float(ROWS))
    slip = 2.0 * np.sin(4.4 * time) + 1.5 * np.sin(11.9 * time + 1.0)
    state, states = 1.0, np.empty(ROWS)
    for k, w in enumerate(slip.tolist()):
        gone = 1.0 - np.exp(-abs(w) * PERIOD / travel)
        state = states[k] = (1.0 - gone) * state + gone * np.sign(w)
    effort = (
        1.5 * states + 0.8 * np.sign(slip) * np.abs(slip) ** 0.5 + 0.02 * rng.standard_normal(ROWS)
    )
    clock = Clock(time, (Span(0, ROWS, PERIOD),))
    return Dataset(
        "single", (Element(np.zeros(ROWS), slip),), effort, clock, Units("N*m", "A", "rad/s")
    )


def structure(stages: str, law: str = "bingham/constant", device: str = "single") -> Structure:
    single = device == "single"
    return Structure(
        "single" if single else "coaxial", law, law_from_name(law, device), stages, False, True
    )


@pytest.mark.parametrize(
    ("stages", "twins"),
    [
        ("viscous", {"T_vy"}),
        ("dahl-2", {"T_z1", "T_z2"}),
        ("lugre", {"T_ly", "T_ldy"}),
        ("lugre/field+sides", {"T_ay"}),
    ],
)
def test_without_a_field_two_gains_of_a_stage_are_one(stages: str, twins: set[str]) -> None:
    assert twin_gains(structure(stages)) == twins
    assert not twin_gains(structure(stages, "bingham"))
    of_pair = {f"{name}_{element}" for name in twins for element in (1, 2)}
    assert twin_gains(structure(stages, device="coaxial")) == of_pair


@pytest.mark.slow
def test_a_power_of_the_slip_is_sound_without_a_field() -> None:
    outcome = fit_structure(joint(0.02), structure("dahl/field+viscous"))
    assert outcome.model.gains["T_vy"] == 0.0
    assert outcome.model.gains["T_v"] > 0.0
    assert outcome.without == ("T_vy",)
    assert "T_vy" not in outcome.unidentified
    assert outcome.rank + len(outcome.idle) == outcome.unknowns


@pytest.mark.slow
def test_a_term_that_the_memory_says_better_is_left_out_and_the_law_is_sound() -> None:
    data = joint(0.02)
    outcome = LawCandidate(structure("dahl/field+viscous")).fit(data, [], 1)
    assert outcome.sound
    assert (outcome.train_cost / ROWS) ** 0.5 == pytest.approx(0.02, rel=0.1)
    again = refit_near(data, outcome.model, without=outcome.without)
    for name in outcome.without:
        assert again.model.gains[name] == 0.0


@pytest.mark.slow
def test_a_term_that_is_left_out_stays_out_beside_a_network() -> None:
    data = joint(0.02)
    alone = LawCandidate(structure("dahl/field+viscous"))
    law = alone.fit(data, [], 1)
    network = network_from_name(
        "fnn-2", "single", dynamics=law.model.structure.dynamics, field=False
    )
    both = LawWithNetworkCandidate(ResidualStructure(law.model.structure, network), seed=0)
    outcome = both.fit(data, [Fitted(alone, law)], 1)
    assert law.without
    assert outcome.without == law.without
    assert not set(outcome.at_bounds) & set(law.without)
    later = both.refit(data, np.arange(ROWS) < ROWS // 2, outcome, ())
    final = both.fit_again(data, outcome)
    for name in law.without:
        assert later.model.law.gains[name] == 0.0
        assert final.model.law.gains[name] == 0.0
    # For use the law is the law of all rows, with its intervals.
    assert final.model.law.to_dict() == alone.fit_again(data, law).model.to_dict()
    assert not any(np.isnan(estimate.low) for estimate in final.estimates)


@pytest.mark.slow
def test_the_law_of_a_joint_without_a_field_is_recommended_with_all_that_it_needs() -> None:
    result = compare(joint(0.02), Settings(models=("bingham", "casson")))
    chosen = result.entry(result.recommended)
    assert chosen.test.rmse.value < 1.2 * 0.02


@pytest.mark.slow
def test_a_term_of_a_stage_is_left_out_of_both_elements_of_a_pair() -> None:
    # Slips turn at once, so friction that differs between the ways is a constant effort in either clutch.
    rng = np.random.default_rng(4)
    time: Array = PERIOD * np.arange(float(ROWS))
    first = np.sign(np.sin(7.0 * time)) * (1.5 + 0.5 * np.sin(3.1 * time))
    second = np.sign(np.sin(4.3 * time)) * (1.5 + 0.5 * np.cos(5.7 * time))
    fields = np.clip(np.sin(2.3 * time), 0.0, 1.0), np.clip(-np.sin(2.3 * time), 0.0, 1.0)
    effort = 0.1 * first + fields[0] ** 2 * np.sign(first)
    effort += 0.1 * second + fields[1] ** 2 * np.sign(second)
    effort += 0.03 * np.abs(first) + 0.2 + 0.01 * rng.standard_normal(ROWS)
    elements = Element(fields[0], first), Element(fields[1], second)
    clock = Clock(time, (Span(0, ROWS, PERIOD),))
    data = Dataset("coaxial", elements, effort, clock, Units("N*m", "", "rad/s"))

    # A solver that stopped early leaves all terms in doubt.
    law = replace(fit_structure(data, structure("sides", "bingham", "coaxial")), stop="iterations")
    outcome = with_terms_told(data, law)
    assert any("left out" in note for note in outcome.notes)
    assert outcome.without == ("T_a_1", "T_a_2")
    assert outcome.model.gains["T_a_1"] == outcome.model.gains["T_a_2"] == 0.0
    assert outcome.model.gains["T_0"] == pytest.approx(0.2, abs=0.01)
