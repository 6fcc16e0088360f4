"""Models predict with the functions of the exported C, so that both give the same bits.

NumPy's own exp, tanh and powers differ by a unit in the last place from one processor to the next, and a model whose
terms cancel makes millions of it. With `ArrayAsInC`s a law written for NumPy uses `elementary` instead; fits
do not, as they need the last bit of nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import elementary
from erclutch.arithmetic.precision import FLOAT64
from erclutch.signals.array import Array

_BLOCK = 8192  # numbers at a time: what an operation leaves stays in the cache
_DOUBLE = np.dtype(np.float64)
_FEW = 8  # so many Python floats are faster than one array


def _own(name: str) -> Callable[..., Array]:
    """An elementary function on arrays of any size; the C never sees what is not a number, and here it stays one."""
    function = elementary(FLOAT64)[name]

    def apply(x: Any, *more: Any) -> Array:
        shape = np.shape(x)
        if np.size(x) <= _FEW:
            values: list[float] = []
            for number in np.ravel(x).tolist():
                is_lost = number != number  # NaN alone is not itself
                values.append(number if is_lost else function(number, *more))
            return np.array(values, np.float64).reshape(shape)
        flat = np.ascontiguousarray(x, np.float64).reshape(-1)
        out = np.empty(flat.size)
        for start in range(0, flat.size, _BLOCK):
            block = slice(start, start + _BLOCK)
            out[block] = function(flat[block], *more)
        lost = np.isnan(flat)
        if np.any(lost):
            out[lost] = np.nan
        return out.reshape(shape)

    return apply


exp = _own("exp")
tanh = _own("tanh")
_expm1 = _own("expm1")
_power = _own("power")


def power(x: Any, n: Any) -> Any:
    """x^n for x > 0; the exponents 0, 1, 2 and -1 by multiplication and division, as they are exported."""
    exponent = float(n)
    if exponent == 0.0:
        return np.ones(np.shape(x))
    if exponent == 1.0:
        return x * 1.0
    if exponent == 2.0:
        return x * x
    if exponent == -1.0:
        return 1.0 / x
    return _power(x, exponent)


_FUNCTIONS: dict[np.ufunc, Callable[..., Any]] = {
    np.exp: exp,
    np.expm1: _expm1,
    np.tanh: tanh,
    np.power: power,
}


class ArrayAsInC(np.ndarray[Any, np.dtype[np.float64]]):
    """An array of doubles on which exp, expm1, tanh and powers are those of the exported C; all else is NumPy's."""

    def __array_ufunc__(
        self,
        ufunc: np.ufunc,
        method: str,
        *inputs: Any,
        **kwargs: Any,
    ) -> Any:
        plain = [_plain(x) for x in inputs]
        if not kwargs and method == "__call__":
            function = _FUNCTIONS.get(ufunc, ufunc)
            outcome: Any = function(*plain)
        else:
            if "out" in kwargs:
                kwargs["out"] = tuple(_plain(x) for x in kwargs["out"])
            outcome = getattr(ufunc, method)(*plain, **kwargs)

        # What comes next in a law goes on with the functions of the C; a mask or a single number is NumPy's own.
        of_doubles = getattr(outcome, "dtype", np.bool_) == _DOUBLE
        if of_doubles and np.ndim(outcome):
            return outcome.view(ArrayAsInC)
        return outcome


def _plain(x: Any) -> Any:
    """NumPy's own array of an `ArrayAsInC`, or the thing itself."""
    return x.view(np.ndarray) if isinstance(x, ArrayAsInC) else x


def array_as_in_c(x: Any) -> ArrayAsInC:
    """The same numbers as an `ArrayAsInC`."""
    return np.asarray(x, np.float64).view(ArrayAsInC)
