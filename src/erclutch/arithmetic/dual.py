"""Dual numbers differentiate plain NumPy functions, so a law is defined once and has exact derivatives.

A `Dual` carries a value and its partial derivatives with respect to a few named seeds. NumPy hands its ufuncs to
`Dual.__array_ufunc__`, so a law that is written for arrays runs on duals unchanged. Only the partials that are not zero
are kept, which makes a law with five parameters cost about as much as the same derivatives written by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.operand import Operand
from erclutch.signals.array import Array

Value = Array | float


class Dual(Operand):
    """A value with partial derivatives.

    Args:
        value: number or array.
        partials: seed index -> derivative of the value with respect to that seed, broadcastable to the value.
    """

    __slots__ = ("partials", "value")

    def __init__(self, value: Value, partials: dict[int, Value]) -> None:
        self.value = value
        self.partials = partials

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        rule = _RULES.get(ufunc)
        if rule is None or method != "__call__" or kwargs:
            return NotImplemented
        values = tuple(x.value if isinstance(x, Dual) else x for x in inputs)
        value, slopes = rule(*values)
        partials: dict[int, Value] = {}
        for x, slope in zip(inputs, slopes, strict=True):
            if isinstance(x, Dual) and x.partials:
                factor = slope()
                for seed, partial in x.partials.items():
                    term = partial if factor is _ONE else factor * partial
                    partials[seed] = partials[seed] + term if seed in partials else term
        return Dual(value, partials)


# A rule gives the value and, for each input, a function for the slope: slopes of constant inputs are never computed.
Slope = Callable[[], Any]
Outcome = tuple[Any, tuple[Slope, ...]]
Unary = Callable[[Any], Outcome]
Binary = Callable[[Any, Any], Outcome]
_ONE = 1.0  # the slope of a sum: its partials go on as they are


def _power(x: Any, y: Any) -> tuple[Any, tuple[Slope, Slope]]:
    value = np.power(x, y)
    return value, (lambda: y * np.power(x, y - 1.0), lambda: value * np.log(x))


def _exp(x: Any) -> tuple[Any, tuple[Slope]]:
    value = np.exp(x)
    return value, (lambda: value,)


def _expm1(x: Any) -> tuple[Any, tuple[Slope]]:
    value = np.expm1(x)
    return value, (lambda: value + 1.0,)


def _tanh(x: Any) -> tuple[Any, tuple[Slope]]:
    value = np.tanh(x)
    return value, (lambda: 1.0 - value * value,)


def _sqrt(x: Any) -> tuple[Any, tuple[Slope]]:
    value = np.sqrt(x)
    return value, (lambda: 0.5 / value,)


_UNARY: dict[np.ufunc, Unary] = {
    np.negative: lambda x: (-x, (lambda: -1.0,)),
    np.square: lambda x: (x * x, (lambda: 2.0 * x,)),
    np.exp: _exp,
    np.expm1: _expm1,
    np.tanh: _tanh,
    np.sqrt: _sqrt,
    np.log: lambda x: (np.log(x), (lambda: 1.0 / x,)),
    np.log1p: lambda x: (np.log1p(x), (lambda: 1.0 / (1.0 + x),)),
    np.sin: lambda x: (np.sin(x), (lambda: np.cos(x),)),
    np.cos: lambda x: (np.cos(x), (lambda: -np.sin(x),)),
    np.arctan: lambda x: (np.arctan(x), (lambda: 1.0 / (1.0 + x * x),)),
    np.absolute: lambda x: (np.abs(x), (lambda: np.sign(x),)),
}
_BINARY: dict[np.ufunc, Binary] = {
    np.add: lambda x, y: (x + y, (lambda: _ONE, lambda: _ONE)),
    np.subtract: lambda x, y: (x - y, (lambda: _ONE, lambda: -1.0)),
    np.multiply: lambda x, y: (x * y, (lambda: y, lambda: x)),
    np.true_divide: lambda x, y: (x / y, (lambda: 1.0 / y, lambda: -x / (y * y))),
    np.power: _power,
}
_RULES: dict[np.ufunc, Callable[..., Outcome]] = {**_UNARY, **_BINARY}


def seed(values: Any) -> list[Dual]:
    """Make each number in ``values`` a seed: the i-th dual has derivative one with respect to seed i."""
    return [Dual(float(value), {index: 1.0}) for index, value in enumerate(values)]


def value_of(x: Any) -> Any:
    """The value of a dual, or the thing itself."""
    return x.value if isinstance(x, Dual) else x


def partial_of(x: Any, index: int) -> Any:
    """The derivative of ``x`` with respect to seed ``index``; 0.0 where it does not depend on it."""
    return x.partials.get(index, 0.0) if isinstance(x, Dual) else 0.0


def pick(x: Any, rows: slice | NDArray[np.int64]) -> Any:
    """Some rows of an array or of a dual of arrays."""

    def picked(values: Any) -> Any:
        return values[rows] if np.ndim(values) else values  # a number is the same in all rows

    if not isinstance(x, Dual):
        return picked(x)
    partials = {index: picked(partial) for index, partial in x.partials.items()}
    return Dual(picked(x.value), partials)


def chosen(condition: Any, yes: Any, no: Any) -> Any:
    """``yes`` where a mask is true and ``no`` elsewhere, of numbers, arrays and duals of them."""
    choose: Any = np.where
    value: Any = choose(condition, value_of(yes), value_of(no))
    seeds = {seed for x in (yes, no) if isinstance(x, Dual) for seed in x.partials}
    partials: dict[int, Value] = {}
    for seed in sorted(seeds):
        partials[seed] = choose(condition, partial_of(yes, seed), partial_of(no, seed))
    return Dual(value, partials) if partials else value
