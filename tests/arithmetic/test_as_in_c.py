"""Arrays with the functions of the C, and what a record makes of operations: values against NumPy's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from erclutch.arithmetic import as_in_c
from erclutch.arithmetic.as_in_c import ArrayAsInC, array_as_in_c, power
from erclutch.arithmetic.elementary import elementary
from erclutch.arithmetic.precision import FLOAT64
from erclutch.arithmetic.record import Record, recorded
from erclutch.errors import ExportError

X = np.random.default_rng(0).uniform(0.01, 3.0, 50)


@pytest.mark.parametrize("size", [1, 8, 9, 8191, 8192, 8193, 20_000])
@pytest.mark.parametrize("name", ["exp", "expm1", "tanh"])
def test_arrays_of_any_size_have_the_bits_of_the_function(size: int, name: str) -> None:
    x = np.random.default_rng(size).normal(size=size)
    x[size // 2] = np.nan
    function = elementary(FLOAT64)[name]
    found = getattr(np, name)(array_as_in_c(x))
    assert isinstance(found, ArrayAsInC)
    fine = ~np.isnan(x)
    np.testing.assert_array_equal(found[fine], function(x[fine]))
    assert np.isnan(found[size // 2])
    np.testing.assert_allclose(found[fine], getattr(np, name)(x[fine]), rtol=1e-15)
    square = np.resize(x, (2, size))
    np.testing.assert_array_equal(getattr(np, name)(array_as_in_c(square))[1], found)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0, -1.0, 0.5, 1.7, -2.0, 3.0])
def test_powers_of_an_array_and_of_a_record(exponent: float) -> None:
    found = power(array_as_in_c(X), exponent)
    np.testing.assert_allclose(np.asarray(found), X**exponent, rtol=1e-14)
    assert found.shape == X.shape
    if exponent in (1.0, 2.0, -1.0):
        np.testing.assert_array_equal(
            np.asarray(found), {1.0: X, 2.0: X * X, -1.0: 1.0 / X}[exponent]
        )
    record = recorded(lambda x: np.power(x, exponent), ["x"])
    operations = [n.operation for n in record.needed() if n.operation not in ("input", "constant")]
    assert operations == {0.0: [], 1.0: [], 2.0: ["multiply"], -1.0: ["divide"]}.get(
        exponent, ["power"]
    )
    if exponent == 0.0:
        assert record.outputs[0].value == 1.0


def test_all_else_is_numpys() -> None:
    x = array_as_in_c(X)
    for made in (
        x + 1.0,
        np.sqrt(x),
        np.maximum(x, 1.0),
        np.add(x, x, out=array_as_in_c(np.empty(50))),
    ):
        assert isinstance(made, ArrayAsInC)
    assert not isinstance(x > 1.0, ArrayAsInC)
    assert isinstance(np.add.reduce(x), float)
    assert np.add.reduce(x) == X.sum()
    np.testing.assert_array_equal(np.add.accumulate(x), np.cumsum(X))
    out = array_as_in_c(np.empty(50))
    np.exp(x, out=out)
    np.testing.assert_allclose(np.asarray(out), np.exp(X), rtol=1e-15)
    assert as_in_c.array_as_in_c([1, 2]).dtype == np.float64


def test_a_record_keeps_the_simplest_node_of_the_same_value() -> None:
    record = Record()
    x: Any = record.input("x")
    y: Any = record.input("y")
    assert (x * 1.0).node is x.node
    assert (1.0 * x).node is x.node
    assert (x * -1.0).node.operation == "negate"
    assert (-1.0 * x).node.arguments == (x.node,)
    assert np.square(x).node is (x * x).node
    assert (x + y).node is (x + y).node
    assert record.inputs() == ["x", "y"]
    for wrong, said in (
        (lambda: np.power(x, y), "a power whose exponent is no constant"),
        (lambda: np.log(x), "no C for NumPy's log"),
        (lambda: x < y, "a comparison has no C here"),
        (lambda: np.add.reduce(x), "no C for NumPy's add"),
    ):
        with pytest.raises(ExportError, match=said):
            wrong()


def test_truths_that_are_known_leave_the_record() -> None:
    record = Record()
    x: Any = record.input("x")
    truth = record.less(x, 1.0)
    assert record.both(True, truth) is truth
    assert record.both(truth, True) is truth
    assert record.both(truth, False) is False
    assert record.either(False, truth) is truth
    assert record.either(truth, True) is True
    assert record.choose(True, x, 2.0) is x
    assert record.choose(False, x, 2.0) == 2.0
    for made, name in ((record.both(truth, truth), "both"), (record.either(truth, truth), "either"),
                       (record.opposite(truth), "opposite")):  # fmt: skip
        assert (made.node.operation, made.node.kind) == (name, "truth")
    assert record.choose(truth, x, 2.0).node.operation == "choose"


def test_what_is_called_is_recorded_once_and_comes_flat() -> None:
    record = Record()
    x: Any = record.input("x")
    twice = [record.call("f", lambda a: a * a + 1.0, a=value) for value in (x, x + 2.0)]
    assert record.call("same", lambda a: a, a=x) is x
    record.give(twice[0] * twice[1])
    unused = x * 7.0
    assert unused.node not in record.needed()
    assert list(record.calls) == ["f"]
    flat = record.flat()
    operations = [n.operation for n in flat.needed()]
    assert "call" not in operations
    assert (operations.count("multiply"), operations.count("add")) == (3, 3)
