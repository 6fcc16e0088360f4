"""Where an inverse searches, and whether effort follows the field one way there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from erclutch.export.monotone import apart, middles, monotone_share, sides
from erclutch.models.model import margins


def model(
    field: tuple[float, float],
    *,
    device: str = "single",
    signed: bool = False,
    steady: Any = None,
    effort: float = 2.0,
) -> Any:
    trained = SimpleNamespace(field=field, slip=(-1.0, 1.0), effort=(-effort, 0.5 * effort))
    structure = SimpleNamespace(device=device)
    return SimpleNamespace(
        trained_on=trained,
        structure=structure,
        signed=signed,
        steady=steady,
        extras={"D": (2.0, 5.0)},
    )


@pytest.mark.parametrize(
    ("field", "how", "expected"),
    [
        ((0.0, 3.0), {}, (0.0, 3.0, 0.0)),
        ((1.0, 3.0), {}, (1.0, 3.0, 1.0)),
        ((-4.0, 3.0), {}, (0.0, 4.0, 0.0)),
        ((-4.0, -3.0), {}, (0.0, 4.0, 0.0)),
        ((-2.0, 3.0), {"signed": True}, (0.0, 3.0, -2.0)),
        ((0.0, 3.0), {"signed": True}, (0.0, 3.0, 0.0)),
        ((-2.0, 0.0), {"signed": True}, (-2.0, 0.0, -2.0)),
        ((0.5, 3.0), {"device": "coaxial"}, (0.0, 3.0, -3.0)),
        ((0.0, 0.0), {}, (0.0, 1.0, 0.0)),
        ((2.0, 2.0), {}, (2.0, margins((2.0, 2.0))[1], 2.0)),
    ],
)
def test_where_an_inverse_searches(
    field: tuple[float, float], how: Any, expected: tuple[float, ...]
) -> None:
    assert sides(model(field, **how)) == expected


def test_a_signed_field_is_that_of_either_element() -> None:
    signed = np.array([-2.0, 0.0, 3.0])
    one, two = apart(model((0.0, 3.0), device="coaxial"), signed)
    assert (one.tolist(), two.tolist()) == ([0.0, 0.0, 3.0], [2.0, 0.0, 0.0])
    assert apart(model((0.0, 3.0)), signed)[0] is signed
    assert middles(model((0.0, 1.0))) == [3.5]


@pytest.mark.parametrize(
    ("steady", "share"),
    [
        (lambda f, w, x: f[0] * w[0] * x[0], 1.0),
        (lambda f, w, x: (f[0] - 1.5) ** 2 + 0.0 * w[0], 0.0),
        (lambda f, w, x: np.where(w[0] > 0.5, (f[0] - 1.5) ** 2, f[0]), 8 / 11),
        (lambda f, w, x: f[0] + np.where(f[0] > 1.5, 0.0, 1.9e-9), 1.0),
        (lambda f, w, x: 0.0 * f[0] + np.where((f[0] > 1.4) & (f[0] < 1.6), 1.9e-9, 0.0), 1.0),
        (lambda f, w, x: 0.0 * f[0] + np.where((f[0] > 1.4) & (f[0] < 1.6), 2.1e-9, 0.0), 0.0),
    ],
)
def test_the_share_of_lines_that_never_turn(steady: Any, share: float) -> None:
    assert monotone_share(model((0.0, 3.0), steady=steady)) == pytest.approx(share)


def test_both_sides_of_zero_field_and_all_pairs_of_speeds_count() -> None:
    seen = []

    def steady(fields: Any, slips: Any, extras: Any) -> Any:
        seen.append((fields, slips, extras))
        return np.where(fields[1] > 0, (fields[1] - 1.0) ** 2, fields[0])

    assert monotone_share(model((0.0, 3.0), device="coaxial", steady=steady)) == 0.5
    assert [fields[0].size for fields, _, _ in seen] == [33 * 121] * 2
    fields, slips, extras = seen[0]
    np.testing.assert_allclose(np.unique(fields[0]), np.linspace(0.0, 3.0, 33))
    assert len({*zip(slips[0].tolist(), slips[1].tolist(), strict=True)}) == 121
    assert set(extras[0].tolist()) == {3.5}
