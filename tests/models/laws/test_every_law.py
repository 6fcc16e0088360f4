"""What holds for every law: exact derivatives, oddness in slip, limits at zero, finiteness over all of its bounds."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from erclutch.arithmetic.dual import Dual, partial_of, seed, value_of
from erclutch.errors import SettingError
from erclutch.models.laws import Law, ladder, law_from_name, law_names, quick_laws
from erclutch.models.laws.smooth import OFF_ZERO
from erclutch.models.laws.yield_stress import CONSTANT, FALLING, YIELD_FORMS
from tests.support.examples import examples

Columns = Callable[[Law, Any, Any, Sequence[Any]], tuple[Any, ...]]
Point = Callable[[Law, Sequence[float]], list[float]]

MOST_SHAPES = 8
shares = st.lists(st.floats(0.0, 1.0), min_size=MOST_SHAPES, max_size=MOST_SHAPES)
free = settings(
    max_examples=examples(15),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)

# Zero among them, small, typical and beyond the reference.
FIELDS = np.array([0.0, 0.0, 0.01, 0.2, 0.41, 0.7, 1.0, 1.0, 1.3])
SLIPS = np.array([0.0, 0.7, -0.3, 0.0, 1e-3, -2.0, 0.5, -1e-3, 4.0])


def assert_slopes(
    of: Callable[[Any], tuple[Any, ...]], columns: tuple[Any, ...], index: int, at: float
) -> None:
    """Derivatives of columns by seed ``index`` against central differences of ``of`` around ``at``."""
    # Extended precision, where there is any: terms that nearly cancel leave its digits to the difference.
    step = np.longdouble(1e-6 * max(abs(at), 1e-2))
    for ahead, behind, column in zip(of(at + step), of(at - step), columns, strict=True):
        difference = (np.asarray(ahead) - np.asarray(behind)) / (2 * step)
        exact = np.broadcast_to(partial_of(column, index), difference.shape)
        size = 1 + np.abs(value_of(column)).max()
        # Rounding of the difference; and of the derivative, whose terms grow as 1 / rate where a rate goes to zero.
        rate = max(abs(at), OFF_ZERO)
        floor = (
            4.0 * size * (np.finfo(np.longdouble).eps / step + np.finfo(float).eps / rate) + 1e-9
        )
        np.testing.assert_array_less(
            np.abs(exact - difference), 2e-5 * np.abs(exact) + floor + 1e-30
        )


@pytest.mark.slow
@free
@given(shares=shares)
def test_derivatives_by_shape_parameters(
    law: Law, columns: Columns, point: Point, shares: list[float]
) -> None:
    q = point(law, shares)
    dual = columns(law, FIELDS, SLIPS, seed(q))
    for i in range(len(q)):
        assert_slopes(
            lambda v, i=i: columns(law, FIELDS, SLIPS, [*q[:i], v, *q[i + 1 :]]), dual, i, q[i]
        )


@pytest.mark.slow
@free
@given(shares=shares)
def test_derivative_by_field(law: Law, columns: Columns, point: Point, shares: list[float]) -> None:
    q = point(law, shares)
    for E in (0.0, 0.01, 0.2, 0.41, 0.7, 1.0, 1.3):
        dual = columns(law, Dual(E, {0: 1.0}), SLIPS, q)
        assert_slopes(lambda v: tuple(np.broadcast_arrays(*columns(law, v, SLIPS, q))), dual, 0, E)


@pytest.mark.slow
@free
@given(shares=shares)
def test_derivative_by_slip(law: Law, columns: Columns, point: Point, shares: list[float]) -> None:
    q = point(law, shares)
    for w in (-2.0, -1e-2, 1e-3, 0.3, 4.0):
        dual = columns(law, FIELDS, Dual(w, {0: 1.0}), q)
        assert_slopes(lambda v: tuple(np.broadcast_arrays(*columns(law, FIELDS, v, q))), dual, 0, w)


@free
@given(shares=shares, E=st.floats(0, 1.5), w=st.floats(-5, 5))
def test_odd_in_slip(
    law: Law, columns: Columns, point: Point, shares: list[float], E: float, w: float
) -> None:
    q = point(law, shares)
    field, slip = np.array([E, E, E]), np.array([w, -w, 0.0])
    for column in columns(law, field, slip, q):
        assert column[0] == -column[1]
        assert column[2] == 0.0


def test_gains_and_columns_are_as_many(law: Law, columns: Columns, point: Point) -> None:
    out = columns(law, FIELDS, SLIPS, point(law, [0.5] * MOST_SHAPES))
    assert len(out) == len(law.gains)
    assert all(np.shape(column) == FIELDS.shape for column in out)
    names = [p.name for p in (*law.stimulus_shape, *law.shape, *law.gains)]
    assert len(set(names)) == len(names)


def test_finite_with_finite_derivatives_on_every_corner_of_the_bounds(
    law: Law, columns: Columns, point: Point
) -> None:
    E = np.array([0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.5, 1.0, 2.0])[:, None]
    w = np.array([0.0, 1e-300, -1e-12, 1e-6, -1e-3, 1.0, -5.0, 30.0])[None, :]
    fields, slips = (np.ascontiguousarray(x).ravel() for x in np.broadcast_arrays(E, w))
    count = len(law.stimulus_shape) + len(law.shape)
    for corner in itertools.product((0.0, 1.0), repeat=count):
        q = point(law, corner)
        duals = [
            *seed(q),
            Dual(fields, {count: np.ones(fields.size)}),
            Dual(slips, {count + 1: np.ones(slips.size)}),
        ]
        for column in columns(law, duals[count], duals[count + 1], duals[:count]):
            assert np.isfinite(value_of(column)).all(), q
            for i in range(count + 2):
                assert np.isfinite(partial_of(column, i)).all(), (q, i)


@free
@given(shares=shares)
def test_nothing_happens_without_field_and_slip(
    law: Law, columns: Columns, point: Point, shares: list[float]
) -> None:
    for column in columns(law, np.zeros(1), np.zeros(1), point(law, shares)):
        assert column[0] == 0.0


@pytest.mark.slow
@free
@given(shares=shares)
def test_without_field_only_viscosity_is_left(
    law: Law, columns: Columns, point: Point, shares: list[float]
) -> None:
    shapes = (*law.stimulus_shape, *law.shape)
    values = dict(zip((s.name for s in shapes), point(law, shares), strict=True))
    values["w_s"] = 1e-3
    if "E_on" in values:
        values["E_on"] = max(
            values["E_on"], 0.5
        )  # a threshold of a few step widths is on without field already
    w = np.array([-3.0, -0.4, 0.02, 1.0, 3.0])
    got = columns(law, np.zeros(w.size), w, list(values.values()))
    name = law.name
    if name == "casson":
        np.testing.assert_allclose(got[0], values["r"] * w, rtol=1e-12)
        return
    np.testing.assert_allclose(got[0], 0.0, atol=1e-15)
    if name == "herschel-bulkley":
        viscous = np.sign(w) * np.abs(w) ** values["m"]
    elif name == "cho-choi-jhon":
        viscous = w * (1 + (values["t_2"] * np.abs(w)) ** -values["b"])
    else:
        viscous = w
    np.testing.assert_allclose(got[1], viscous, rtol=1e-8)
    for other in got[2:]:  # kernels of the RBFM beyond the first
        np.testing.assert_allclose(other, 0.0, atol=1e-15)


GROWING = {
    name: form for name, form in YIELD_FORMS.items() if form is not CONSTANT and form is not FALLING
}


@pytest.mark.parametrize("form", GROWING.values(), ids=GROWING)
@free
@given(share=st.floats(0.0, 1.0))
def test_yield_factor_is_zero_without_field_one_at_the_reference_and_grows(
    form: Any, share: float
) -> None:
    q = [s.lower * (s.upper / s.lower) ** share for s in form.shape]
    E = np.linspace(0.0, 1.0, 101)
    y = form.factor(E, *q)
    assert y[0] == 0.0
    assert y[-1] == pytest.approx(1.0, rel=1e-9)
    assert np.all(np.diff(y) > 0)


@free
@given(share=st.floats(0.0, 1.0))
def test_the_form_that_falls_is_finite_without_field_and_one_at_the_reference(share: float) -> None:
    (scale,) = FALLING.shape
    y = FALLING.factor(
        np.linspace(0.0, 2.0, 101), scale.lower * (scale.upper / scale.lower) ** share
    )
    assert np.isfinite(y).all()
    assert y[50] == pytest.approx(1.0, rel=1e-9)
    assert np.all(np.diff(y) < 0)


def test_the_ladder_and_its_names() -> None:
    assert [law_from_name(s).name for s in ("ss", "ccj", "hb", "rbfm", "RBFM-10 ")] == [
        "seo-seo",
        "cho-choi-jhon",
        "herschel-bulkley",
        "rbfm-5",
        "rbfm-10",
    ]
    for specification in ladder():
        name = specification.partition("/")[0]
        assert name in law_names() or name.startswith("rbfm-")
    # Laws that are fitted while a log grows are the simple ones of the ladder, in its order.
    quick = quick_laws()
    assert quick
    assert list(quick) == [name for name in ladder() if name in quick]
    # The device decides on the form where none is given.
    assert "n" in [s.name for s in law_from_name("bingham", "single").shape]
    assert [s.name for s in law_from_name("bingham", "coaxial").shape] == ["w_s"]


@pytest.mark.parametrize(
    ("specification", "problem"),
    [
        ("binghm", "Did you mean bingham"),
        ("bingham/cubic", "unknown yield stress 'cubic'"),
        ("on-off/square", "no choice of yield stress"),
        ("rbfm-1", "1 kernels"),
        ("rbfm-101", "101 kernels"),
        ("rbfm-x", "unknown law"),
        ("", "unknown law"),
    ],
)
def test_names_that_are_none(specification: str, problem: str) -> None:
    with pytest.raises(SettingError, match=problem):
        law_from_name(specification)
