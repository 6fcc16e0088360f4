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
    function = elementary(FLOAT64)[name]

    def apply(x: Any, *more: Any) -> Array:
        # The C never sees what is not a number; here it stays one.
        if np.size(x) <= _FEW:
            values = [function(v, *more) if v == v else v for v in np.ravel(x).tolist()]
            return np.array(values, np.float64).reshape(np.shape(x))
        flat = np.ascontiguousarray(x, np.float64).reshape(-1)
        out = np.empty(flat.size)
        for at in range(0, flat.size, _BLOCK):
            out[at : at + _BLOCK] = function(flat[at : at + _BLOCK], *more)
        lost = np.isnan(flat)
        if np.any(lost):
            out[lost] = np.nan
        return out.reshape(np.shape(x))

    return apply


exp, tanh = _own("exp"), _own("tanh")
_expm1, _power = _own("expm1"), _own("power")


def power(x: Any, n: Any) -> Any:
    """x^n for x > 0; the exponents 0, 1, 2 and -1 by multiplication and division, as they are exported."""
    exponent = float(n)
    if exponent in (0.0, 1.0, 2.0):
        return np.ones(np.shape(x)) if exponent == 0.0 else (x * 1.0 if exponent == 1.0 else x * x)
    return 1.0 / x if exponent == -1.0 else _power(x, exponent)


_FUNCTIONS: dict[np.ufunc, Callable[..., Any]] = {np.exp: exp, np.expm1: _expm1, np.tanh: tanh, np.power: power}


class ArrayAsInC(np.ndarray[Any, np.dtype[np.float64]]):
    """An array of doubles on which exp, expm1, tanh and powers are those of the exported C; all else is NumPy's."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        plain = [x.view(np.ndarray) if isinstance(x, ArrayAsInC) else x for x in inputs]
        if not kwargs and method == "__call__":
            own = _FUNCTIONS.get(ufunc)
            made: Any = ufunc(*plain) if own is None else own(*plain)
            return made.view(ArrayAsInC) if np.ndim(made) and made.dtype == _DOUBLE else made
        if "out" in kwargs:
            kwargs["out"] = tuple(x.view(np.ndarray) if isinstance(x, ArrayAsInC) else x for x in kwargs["out"])
        found: Any = getattr(ufunc, method)(*plain, **kwargs)
        return found.view(ArrayAsInC) if getattr(found, "dtype", None) == np.float64 and np.ndim(found) else found


def array_as_in_c(x: Any) -> ArrayAsInC:
    """The same numbers as an `ArrayAsInC`."""
    return np.asarray(x, np.float64).view(ArrayAsInC)
