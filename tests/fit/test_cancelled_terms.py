"""Where the slip keeps its sign a constant effort and a yield effort may cancel: no model then gives millions."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.candidate import Fitted
from erclutch.fit.kinds.law_alone import LawCandidate
from erclutch.fit.kinds.network_alone import law_beyond
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.laws.terms_told import with_terms_told
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD, ROWS = 0.1, 470  # s


def pull() -> Dataset:
    """A spring that is drawn out one way: the effort grows with the travel, and the slip tells nothing (SYNTHETIC)."""
    rng = np.random.default_rng(5)
    time: Array = PERIOD * np.arange(float(ROWS))
    slip = 2.5e-4 * (1.0 + 0.05 * rng.standard_normal(ROWS)) * (1.0 - 0.2 * np.exp(-time))
    effort = 1000.0 * np.minimum(time / 45.0, 1.0)
    clock = Clock(time, (Span(0, ROWS, PERIOD),))
    return Dataset(
        "single", (Element(np.zeros(ROWS), slip),), effort, clock, Units("N", "A", "m/s")
    )


def structure(law: str) -> Structure:
    return Structure("single", law, law_from_name(law, "single"), "none", False, True)


LAWS = ("bingham/constant", "seo-seo/constant", "cho-choi-jhon/constant")


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_a_constant_effort_that_cancels_a_yield_effort_is_left_out(name: str) -> None:
    log = pull()
    plain = fit_structure(log, structure(name), intervals=False)
    # As it is, the fit makes use of the last bend of a sign that has turned already.
    assert abs(plain.model.gains["T_0"]) > 3.0 * log.effort.max()

    outcome = with_terms_told(log, plain)

    assert not outcome.model.structure.offset
    assert "left out: a constant effort" in outcome.notes[-1]
    # Such a log tells an effort of one sign at one slip: at half of it, at rest and in reverse none is beyond it.
    slips = np.array([1.25e-4, 0.0, -2.5e-4])
    there = outcome.model.steady([np.zeros(3)], [slips])
    assert np.abs(there).max() <= 1.2 * log.effort.max()
    assert there[1] == 0.0


@pytest.mark.slow
def test_the_law_that_a_network_falls_back_to_is_bounded() -> None:
    log = pull()
    candidate = LawCandidate(structure("bingham/constant"))
    fitted = Fitted(candidate, candidate.fit(log, (), 1))
    for laws in ([fitted.outcome], []):  # as asked for, and made for the network
        law = law_beyond(log, laws)
        assert max(map(abs, law.gains.values())) <= 3.0 * log.effort.max()
