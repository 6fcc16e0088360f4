"""The same log in other units gives the same physical parameters: normalisation is inside, bounds hold for any unit."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

pytestmark = pytest.mark.slow

VOLT, RAD_S, NEWTON_METRE = 1e-3, 1e3 / 60.0, 1e3  # a thousandth of the number, and so on


def synthetic(rows: int = 500) -> Dataset:
    rng = np.random.default_rng(11)
    field = 1800.0 * np.repeat(rng.random(rows // 10) * (rng.random(rows // 10) > 0.2), 10)
    slip = 40.0 * np.sin(np.linspace(0.0, 60.0, rows)) * rng.uniform(0.1, 1.0, rows)
    effort = 0.4 * (field / 1800) ** 1.7 * np.tanh(slip / 2.0) + 4e-3 * slip * (
        1 + 0.4 * np.expm1(field / 1800)
    )
    effort += 1e-3 * rng.standard_normal(rows)
    clock = Clock(np.arange(float(rows)) * 1e-3, (Span(0, rows, 1e-3),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N*m", "V", "rad/s"))


@pytest.mark.parametrize(
    ("specification", "dynamics"),
    [
        ("on-off", "none"),
        pytest.param("bingham", "lag", marks=pytest.mark.slow),
        ("bingham/critical", "none"),
        ("bingham/saturating", "none"),
        ("bingham/tanh", "none"),
        ("casson", "none"),
        ("herschel-bulkley", "none"),
        ("hem", "none"),
        ("rbfm-5", "none"),
    ],
)
def test_same_parameters_in_other_units(specification: str, dynamics: str) -> None:
    data = synthetic()
    (element,) = data.elements
    other = Dataset(
        "single",
        (Element(element.field * VOLT, element.slip * RAD_S),),
        data.effort * NEWTON_METRE,
        data.clock,
        Units("mN*m", "kV", "1/min"),
    )
    structure = Structure(
        "single",
        specification,
        law_from_name(specification),
        "lag" if dynamics == "lag" else "none",
        True,
        True,
    )
    one, two = fit_structure(data, structure), fit_structure(other, structure)
    assert two.model.predict(other) == pytest.approx(
        one.model.predict(data) * NEWTON_METRE, rel=1e-5, abs=1e-6
    )
    parameters = [*structure.shapes(1e-3), *structure.gains()]
    for parameter, a, b in zip(parameters, one.estimates, two.estimates, strict=True):
        d = parameter.dimension
        factor = NEWTON_METRE**d.effort * VOLT**d.field * RAD_S**d.slip
        assert b.at_bound == a.at_bound
        for end in ("value", "low", "high"):
            expected = getattr(a, end) * factor
            scale = 1e-4 * abs(a.high - a.low) * factor if np.isfinite(a.high - a.low) else 0.0
            assert getattr(b, end) == pytest.approx(expected, rel=1e-4, abs=scale, nan_ok=True), (
                parameter.name
            )
    assert two.paper_form.keys() == one.paper_form.keys()


def test_units_of_parameters_are_written_out() -> None:
    outcome = fit_structure(synthetic(), Structure("single", "hem", law_from_name("hem")))
    units = {e.name: e.unit for e in outcome.estimates}
    assert units == {
        "w_s": "rad/s",
        "kappa": "1",
        "beta": "1/V",
        "n": "1",
        "T_y": "N*m",
        "eta_0": "N*m/(rad/s)",
    }
