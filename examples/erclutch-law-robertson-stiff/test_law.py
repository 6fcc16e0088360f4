"""The law against its published form, and where it meets Bingham's."""

from __future__ import annotations

import numpy as np

from erclutch.models.laws import law_from_name

W = np.array([-2.0, -0.5, 0.5, 2.0])
STIFF = 1e-9  # a sign that turns at once


def test_the_published_form() -> None:
    law = law_from_name("robertson-stiff/square")
    A, B, C = 0.7, 0.4, 1.3
    grown, _ = law.columns(np.ones(4), W, STIFF, C, B)
    np.testing.assert_allclose(A * C**B * grown, A * (np.abs(W) + C) ** B * np.sign(W), rtol=1e-9)


def test_exponent_one_is_bingham_at_one_field() -> None:
    grown, viscous = law_from_name("rs/square").columns(np.ones(4), W, STIFF, 2.0, 1.0)
    yields, _ = law_from_name("bingham/square").columns(np.ones(4), W, STIFF)
    np.testing.assert_allclose(grown, yields + viscous / 2.0, rtol=1e-9)
