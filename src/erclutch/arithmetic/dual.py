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
from erclutch.signals.clock import Clock

Value = Array | float


class Dual(Operand):
    """A value with partial derivatives.

    The operators call the rules themselves: on the way through NumPy's ufuncs an operation takes twice its time.

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
        return rule(*inputs)

    def __add__(self, other: Any) -> Any:
        return _sum(self, other)

    def __radd__(self, other: Any) -> Any:
        return _sum(other, self)

    def __sub__(self, other: Any) -> Any:
        return _difference(self, other)

    def __rsub__(self, other: Any) -> Any:
        return _difference(other, self)

    def __mul__(self, other: Any) -> Any:
        return _product(self, other)

    def __rmul__(self, other: Any) -> Any:
        return _product(other, self)

    def __truediv__(self, other: Any) -> Any:
        return _quotient(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _quotient(other, self)

    def __pow__(self, other: Any) -> Any:
        return _power(self, other)

    def __rpow__(self, other: Any) -> Any:
        return _power(other, self)


# A rule takes duals, numbers and arrays, of which one at least is a dual. Slopes of constant inputs are never computed.
Partials = dict[int, Value]


def _scaled(factor: Any, partials: Partials) -> Partials:
    """The partials of a function of one input: its slope times those of the input."""
    return {seed: factor * partial for seed, partial in partials.items()}


def _joined(first: Partials, second: Partials) -> Partials:
    """The partials of a function of two inputs, from what each brings."""
    joined = first.copy()
    for seed, partial in second.items():
        joined[seed] = joined[seed] + partial if seed in joined else partial
    return joined


def _sum(x: Any, y: Any) -> Dual:
    if not isinstance(y, Dual):
        return Dual(x.value + y, x.partials)
    if not isinstance(x, Dual):
        return Dual(x + y.value, y.partials)
    return Dual(x.value + y.value, _joined(x.partials, y.partials))


def _difference(x: Any, y: Any) -> Dual:
    if not isinstance(y, Dual):
        return Dual(x.value - y, x.partials)
    if not isinstance(x, Dual):
        return Dual(x - y.value, _scaled(-1.0, y.partials))
    partials = x.partials.copy()
    for seed, partial in y.partials.items():
        partials[seed] = partials[seed] - partial if seed in partials else -1.0 * partial
    return Dual(x.value - y.value, partials)


def _product(x: Any, y: Any) -> Dual:
    if not isinstance(y, Dual):
        return Dual(x.value * y, _scaled(y, x.partials))
    if not isinstance(x, Dual):
        return Dual(x * y.value, _scaled(x, y.partials))
    by_x = _scaled(y.value, x.partials)
    by_y = _scaled(x.value, y.partials)
    return Dual(x.value * y.value, _joined(by_x, by_y))


def _quotient(x: Any, y: Any) -> Dual:
    above: Partials = {}
    below: Partials = {}
    dividend = value_of(x)
    divisor = value_of(y)
    if isinstance(x, Dual) and x.partials:
        above = _scaled(1.0 / divisor, x.partials)
    if isinstance(y, Dual) and y.partials:
        below = _scaled(-dividend / (divisor * divisor), y.partials)
    return Dual(dividend / divisor, _joined(above, below))


def _power(x: Any, y: Any) -> Dual:
    base = value_of(x)
    exponent = value_of(y)
    value = np.power(base, exponent)
    by_base: Partials = {}
    by_exponent: Partials = {}
    if isinstance(x, Dual) and x.partials:
        by_base = _scaled(exponent * np.power(base, exponent - 1.0), x.partials)
    if isinstance(y, Dual) and y.partials:
        by_exponent = _scaled(value * np.log(base), y.partials)
    return Dual(value, _joined(by_base, by_exponent))


#: A rule of one input, and of two.
Unary = Callable[[Dual], Dual]
Binary = Callable[[Any, Any], Dual]


def _by_argument(function: Callable[[Any], Any], slope: Callable[[Any], Any]) -> Unary:
    """The rule of a function of one input whose slope is known from the input."""

    def rule(x: Dual) -> Dual:
        partials = _scaled(slope(x.value), x.partials) if x.partials else {}
        return Dual(function(x.value), partials)

    return rule


def _by_value(function: Callable[[Any], Any], slope: Callable[[Any], Any]) -> Unary:
    """The rule of a function of one input whose slope is known from the function's own value."""

    def rule(x: Dual) -> Dual:
        value = function(x.value)
        partials = _scaled(slope(value), x.partials) if x.partials else {}
        return Dual(value, partials)

    return rule


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
    np.add: _sum,
    np.subtract: _difference,
    np.multiply: _product,
    np.true_divide: _quotient,
    np.power: _power,
}
_RULES: dict[np.ufunc, Callable[..., Dual]] = {**_UNARY, **_BINARY}


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
        if not getattr(values, "ndim", 0):
            return values  # a number is the same in all rows
        if isinstance(rows, slice):
            return values[rows]
        return values.take(rows, axis=0)  # twice as fast as an index

    if not isinstance(x, Dual):
        return picked(x)
    partials = {index: picked(partial) for index, partial in x.partials.items()}
    return Dual(picked(x.value), partials)


def rows_before(x: Any, clock: Clock, rows: int) -> Any:
    """An array, or a dual of arrays, so many rows earlier; at the start of a span its first value."""

    def earlier(values: Any) -> Any:
        if not getattr(values, "ndim", 0):
            return values
        out = values.copy()
        for span in clock.spans:
            part = values[span.start : span.stop]
            k = min(rows, part.size)
            out[span.start : span.start + k] = part[0]
            out[span.start + k : span.stop] = part[: part.size - k]
        return out

    if not isinstance(x, Dual):
        return earlier(x)
    partials = {index: earlier(partial) for index, partial in x.partials.items()}
    return Dual(earlier(x.value), partials)


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
