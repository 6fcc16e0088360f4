"""What fits of a small made-up flow curve report stays as it is kept beside this file (SYNTHETIC)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.wings.rheology.flow_curve import FlowCurve, ranked
from tests.support.pinning import Pinned, summed, told


@pytest.mark.slow
def test_flow_curves(pinned: Pinned) -> None:
    rate = np.geomspace(0.5, 300.0, 12)
    noise = np.exp(0.03 * np.random.default_rng(4).normal(size=12))
    curve = FlowCurve("1 kV/mm", rate, (120.0 + 5.0 * rate**0.6) * noise)
    laws = ("bingham", "casson", "herschel-bulkley")
    found = [
        [f.law, f.stop, f.log_rmse, f.rmse, f.aicc, summed(f.predicted)]
        for f in ranked(curve, laws)
    ]
    fewer = [FlowCurve("x", rate[:n], curve.stress[:n]) for n in (3, 4, 5)]
    odd = [*fewer, replace(curve, stress=-curve.stress)]
    pinned([found, [told(lambda c=c: [f.law for f in ranked(c, laws)]) for c in odd]], rel=1e-3)
