"""Inputs and effort of a network are scaled to where its neurons work."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.networks.fit_network import scaling_of


@pytest.mark.parametrize(("kind", "ends"), [("fnn", (-1.0, 1.0)), ("rbfn", (0.0, 1.0))])
def test_inputs_fill_their_range_and_effort_goes_round_its_mean(
    kind: str, ends: tuple[float, float]
) -> None:
    rng = np.random.default_rng(0)
    x = np.vstack([rng.uniform(3.0, 9.0, 50), rng.uniform(-2.0, 5.0, 50), np.full(50, 4.0)])
    y = rng.uniform(-1.0, 7.0, 50)
    scaling = scaling_of(x, y, kind)  # type: ignore[arg-type]
    made = scaling.inputs(x)
    np.testing.assert_allclose(made[:2].min(axis=1), ends[0], atol=1e-12)
    np.testing.assert_allclose(made[:2].max(axis=1), ends[1], atol=1e-12)
    assert np.all(np.isfinite(made))
    assert np.all((made[2] >= ends[0]) & (made[2] <= ends[1]))
    effort = (y - scaling.effort_offset) / scaling.effort_scale
    assert scaling.effort_offset == pytest.approx(y.mean())
    assert np.abs(effort).max() == pytest.approx(1.0)
    assert scaling_of(x, np.full(50, 2.0), kind).effort_scale == 1.0  # type: ignore[arg-type]
