"""An eddy-current brake gets its own law, and rows of a fluid are not taken for its drag."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.checks.field_drag import field_drags
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset

_LARGEST, _CRITICAL, _RUB, _TURN, _NOISE = 12.0, 80.0, 0.15, 0.5, 0.05  # N m, rad/s, N m, ...


def log(
    highest: float, *, saturates: float = np.inf, fluid: bool = False, rows: int = 10_000
) -> Dataset:
    """MADE-UP rows of a brake up to a speed, whose iron may saturate from a current on; or of a fluid's."""
    rng = np.random.default_rng(5)
    time = np.arange(rows) / 500.0
    current = np.repeat(rng.choice([0.0, 0.5, 1.0, 1.5, 2.0], rows // 250), 250)
    slip = highest * (0.6 * np.sin(2 * np.pi * 0.11 * time) + 0.4 * np.sin(2 * np.pi * 0.37 * time))
    strength = (current / 2.0) ** 2
    if np.isfinite(saturates):
        strength = np.tanh(current / saturates) ** 2
    ratio = slip / _CRITICAL
    drag = np.tanh(slip / _TURN) if fluid else 2.0 * ratio / (1.0 + ratio**2)
    torque = _LARGEST * strength * drag + _RUB * np.tanh(slip / _TURN) + 0.002 * slip
    torque += _NOISE * rng.standard_normal(rows)
    recording = recording_from_arrays(
        {"field": current, "slip": slip, "effort": torque},
        {"field": "A", "slip": "rad/s", "effort": "N*m"},
        time=time,
    )
    return build_dataset(recording)


@pytest.mark.parametrize("highest", [0.5 * _CRITICAL, 1.5 * _CRITICAL, 4.0 * _CRITICAL])
def test_a_drag_is_seen_below_and_beyond_the_critical_slip(highest: float) -> None:
    assert field_drags(log(highest))


def test_a_yield_stress_is_no_drag() -> None:
    assert not field_drags(log(40.0, fluid=True))


@pytest.mark.slow
def test_of_all_laws_that_of_a_drag_is_fitted_to_a_drag_alone() -> None:
    of_brake, of_fluid = [
        [each.specification for each in structures_for(log(120.0, fluid=fluid), Settings())]
        for fluid in (False, True)
    ]
    assert "eddy-current" in of_brake
    assert "eddy-current" not in of_fluid
    named = structures_for(log(120.0, fluid=True), Settings(models=("eddy-current",), lag="none"))
    assert [each.specification for each in named] == ["eddy-current"]


@pytest.mark.slow
@pytest.mark.parametrize("saturates", [np.inf, 2.2])
@pytest.mark.parametrize("highest", [0.5 * _CRITICAL, 1.5 * _CRITICAL])
def test_the_brake_gets_its_law(highest: float, saturates: float) -> None:
    """Beside laws of fluids with a viscosity that the field changes; iron that saturates hid the law before."""
    models = ("bingham", "herschel-bulkley", "hem", "eddy-current")
    # The end, whatever is usual: the limit below is of its noise.
    result = compare(log(highest, saturates=saturates), Settings(models=models, test=0.3))
    chosen = result.entry(result.recommended)
    assert chosen.name.startswith("eddy-current")
    assert chosen.test.rmse.value <= 1.05 * _NOISE
    reference = chosen.outcome.model.reference
    assert chosen.outcome.model.shape["w_c"] * reference.slip == pytest.approx(_CRITICAL, rel=0.02)
