"""Terms of a law that its memory says better, and twins without a field, are left out: the law stays eligible."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.comparison import compare
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.law_alone import LawCandidate
from erclutch.fit.laws.fit_law import fit_structure, refit_near
from erclutch.fit.laws.twin_gains import twin_gains
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
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
def test_the_law_of_a_joint_without_a_field_is_recommended_with_all_that_it_needs() -> None:
    result = compare(joint(0.02), Settings(models=("bingham", "casson")))
    chosen = result.entry(result.recommended)
    assert chosen.test.rmse.value < 1.2 * 0.02
