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

    def __array_ufunc__(
        self,
        ufunc: np.ufunc,
        method: str,
        *inputs: Any,
        **kwargs: Any,
    ) -> Any:
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


def _by_argument(function: Callable[[Any], Any], slope: Callable[[Any], Any]) -> Unary:
    """The rule of a function of one input whose slope is known from the input."""
    return lambda x: (function(x), (lambda: slope(x),))


def _by_value(function: Callable[[Any], Any], slope: Callable[[Any], Any]) -> Unary:
    """The rule of a function of one input whose slope is known from the function's own value."""

    def rule(x: Any) -> Outcome:
        value = function(x)
        return value, (lambda: slope(value),)

    return rule


def _power(x: Any, y: Any) -> Outcome:
    value = np.power(x, y)

    def by_base() -> Any:
        return y * np.power(x, y - 1.0)

    def by_exponent() -> Any:
        return value * np.log(x)

    return value, (by_base, by_exponent)


_UNARY: dict[np.ufunc, Unary] = {
    np.negative: _by_argument(lambda x: -x, lambda x: -1.0),
    np.square: _by_argument(lambda x: x * x, lambda x: 2.0 * x),
    np.exp: _by_value(np.exp, lambda value: value),
    np.expm1: _by_value(np.expm1, lambda value: value + 1.0),
    np.tanh: _by_value(np.tanh, lambda value: 1.0 - value * value),
    np.sqrt: _by_value(np.sqrt, lambda value: 0.5 / value),
    np.log: _by_argument(np.log, lambda x: 1.0 / x),
    np.log1p: _by_argument(np.log1p, lambda x: 1.0 / (1.0 + x)),
    np.sin: _by_argument(np.sin, np.cos),
    np.cos: _by_argument(np.cos, lambda x: -np.sin(x)),
    np.arctan: _by_argument(np.arctan, lambda x: 1.0 / (1.0 + x * x)),
    np.absolute: _by_argument(np.abs, np.sign),
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
        if np.ndim(values) == 0:
            return values  # a number is the same in all rows
        return values[rows]

    if not isinstance(x, Dual):
        return picked(x)
    partials = {index: picked(partial) for index, partial in x.partials.items()}
    return Dual(picked(x.value), partials)


def chosen(condition: Any, yes: Any, no: Any) -> Any:
    """``yes`` where a mask is true and ``no`` elsewhere, of numbers, arrays and duals of them."""
    choose: Any = np.where
    value: Any = choose(condition, value_of(yes), value_of(no))
    seeds = set[int]()
    for x in (yes, no):
        if isinstance(x, Dual):
            seeds |= x.partials.keys()
    partials: dict[int, Value] = {}
    for seed in sorted(seeds):
        partials[seed] = choose(condition, partial_of(yes, seed), partial_of(no, seed))
    return Dual(value, partials) if partials else value
