from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.arithmetic import dual
from erclutch.arithmetic.dual import Dual, partial_of, pick, seed, value_of
from tests.support.examples import examples

number = st.floats(-3.0, 3.0).filter(lambda x: abs(x) > 1e-2)
positive = st.floats(0.05, 3.0)

UNARY: dict[np.ufunc, st.SearchStrategy[float]] = {
    np.negative: number,
    np.square: number,
    np.exp: number,
    np.expm1: number,
    np.tanh: number,
    np.sin: number,
    np.cos: number,
    np.arctan: number,
    np.absolute: number,
    np.sqrt: positive,
    np.log: positive,
    np.log1p: positive,
}
BINARY: dict[np.ufunc, st.SearchStrategy[float]] = {
    np.add: number,
    np.subtract: number,
    np.multiply: number,
    np.true_divide: number,
    np.power: positive,
}


def difference(f: Callable[[float], Any], at: float) -> Any:
    step = 1e-5
    return (f(at + step) - f(at - step)) / (2 * step)


def test_every_rule_is_tested() -> None:
    assert set(dual._RULES) == {*UNARY, *BINARY}


@pytest.mark.parametrize("ufunc", UNARY, ids=lambda u: u.__name__)
@given(data=st.data())
def test_unary(ufunc: np.ufunc, data: st.DataObject) -> None:
    x = data.draw(UNARY[ufunc])
    out = ufunc(Dual(x, {3: 2.0}))
    assert out.value == ufunc(x)
    assert set(out.partials) == {3}
    assert out.partials[3] == pytest.approx(2.0 * difference(ufunc, x), rel=1e-7, abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("ufunc", BINARY, ids=lambda u: u.__name__)
@given(data=st.data())
def test_binary(ufunc: np.ufunc, data: st.DataObject) -> None:
    x, y = data.draw(BINARY[ufunc]), data.draw(BINARY[ufunc])
    left, right = difference(lambda v: ufunc(v, y), x), difference(lambda v: ufunc(x, v), y)
    both = ufunc(Dual(x, {0: 1.0, 1: 0.5}), Dual(y, {0: 1.0, 2: 3.0}))
    assert both.value == ufunc(x, y)
    assert both.partials == pytest.approx(
        {0: left + right, 1: 0.5 * left, 2: 3.0 * right},
        rel=1e-6,
        abs=1e-6 * (1 + abs(left) + abs(right)),
    )
    first, second = ufunc(Dual(x, {0: 1.0}), y), ufunc(x, Dual(y, {0: 1.0}))
    assert (first.value, second.value) == (ufunc(x, y), ufunc(x, y))
    assert first.partials[0] == pytest.approx(left, rel=1e-6, abs=1e-7)
    assert second.partials[0] == pytest.approx(right, rel=1e-6, abs=1e-7)


@given(x=positive, y=positive)
def test_operators_go_both_ways(x: float, y: float) -> None:
    a = Dual(x, {0: 1.0})
    for got, value, slope in (
        (a + y, x + y, 1.0),
        (y + a, x + y, 1.0),
        (a - y, x - y, 1.0),
        (y - a, y - x, -1.0),
        (a * y, x * y, y),
        (y * a, x * y, y),
        (a / y, x / y, 1 / y),
        (y / a, y / x, -y / x**2),
        (a**y, x**y, y * x ** (y - 1)),
        (y**a, y**x, y**x * np.log(y)),
        (-a, -x, -1.0),
        (np.array([y]) * a, x * y, y),  # an array on the left hands over too
    ):
        assert isinstance(got, Dual)
        assert value_of(got) == pytest.approx(value)
        assert partial_of(got, 0) == pytest.approx(slope)


def test_broadcasting() -> None:
    x, y = np.arange(1.0, 4.0), np.arange(1.0, 3.0)[:, None]
    a, b, c = seed([2.0, 3.0, 5.0])
    out = a * x + b * y + x * y * c
    assert value_of(out).shape == (2, 3)
    np.testing.assert_array_equal(value_of(out), 2 * x + 3 * y + 5 * x * y)
    for index, expected in enumerate((x, y, x * y)):
        np.testing.assert_array_equal(
            np.broadcast_to(partial_of(out, index), (2, 3)), np.broadcast_to(expected, (2, 3))
        )
    rows = Dual(x, {0: np.ones(3)}) * 2.0
    np.testing.assert_array_equal(partial_of(rows, 0), [2.0, 2.0, 2.0])


@settings(max_examples=examples(30))
@given(q=st.lists(st.floats(0.2, 2.0), min_size=3, max_size=3))
def test_chain_of_rules(q: list[float]) -> None:
    x = np.linspace(-2, 2, 7)

    def f(a: Any, b: Any, c: Any) -> Any:
        return (
            np.tanh(a * x / b) * (1.0 + c * np.expm1(-b * np.abs(x))) / np.sqrt(np.square(a) + c**b)
        )

    out = f(*seed(q))
    np.testing.assert_allclose(value_of(out), f(*q), rtol=1e-13)
    for i in range(3):
        expected = difference(
            lambda v, i=i: f(*(v if j == i else p for j, p in enumerate(q))), q[i]
        )
        np.testing.assert_allclose(partial_of(out, i), expected, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(
    "ufunc",
    [
        np.sinh,
        np.arcsin,
        np.sign,
        np.maximum,
        np.floor,
        np.cbrt,
        np.hypot,
        np.greater,
        np.equal,
        np.matmul,
        np.mod,
    ],
)
def test_without_a_rule_nothing_is_guessed(ufunc: np.ufunc) -> None:
    a = Dual(np.array([0.5, 0.7]), {0: np.array([1.0, 1.0])})
    with pytest.raises(TypeError):
        ufunc(*[a] * ufunc.nin)


def test_other_ways_in_are_refused() -> None:
    a = Dual(np.array([0.5, 0.7]), {0: np.array([1.0, 1.0])})
    with pytest.raises(TypeError):
        np.add.reduce(a)  # pyright: ignore[reportArgumentType, reportCallIssue]
    with pytest.raises(TypeError):
        np.add(a, 1.0, where=np.array([True, False]))  # pyright: ignore[reportArgumentType, reportCallIssue]
    with pytest.raises(TypeError):
        np.multiply.outer(a, np.ones(2))  # pyright: ignore[reportArgumentType, reportCallIssue]
    into = np.zeros(2)
    with pytest.raises(TypeError):
        into += a
    for compare in (lambda: a > 0, lambda: abs(a), lambda: float(a)):  # pyright: ignore
        with pytest.raises(TypeError):
            compare()


def test_pick_takes_rows_of_values_and_partials() -> None:
    x = np.arange(6.0)
    a = Dual(x, {0: x * x, 1: 1.0})
    got = pick(a, slice(1, None, 2))
    np.testing.assert_array_equal(got.value, [1.0, 3.0, 5.0])
    np.testing.assert_array_equal(got.partials[0], [1.0, 9.0, 25.0])
    assert got.partials[1] == 1.0
    np.testing.assert_array_equal(pick(x, np.array([5, 0])), [5.0, 0.0])
    assert pick(2.0, slice(1)) == 2.0
    assert partial_of(x, 0) == 0.0
    assert partial_of(a, 7) == 0.0
