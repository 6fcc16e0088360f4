"""An operand takes an array's place in a law: its operators call NumPy's ufuncs, which a subclass answers."""

from __future__ import annotations

from typing import Any

import numpy

# NumPy's stubs know ufuncs of arrays only; here they are met by a subclass's __array_ufunc__.
np: Any = numpy


class Operand:
    """Arithmetic by ufuncs. A subclass defines ``__array_ufunc__``, and laws written for arrays run on it unchanged."""

    __slots__ = ()

    def __add__(self, other: Any) -> Any:
        return np.add(self, other)

    def __radd__(self, other: Any) -> Any:
        return np.add(other, self)

    def __sub__(self, other: Any) -> Any:
        return np.subtract(self, other)

    def __rsub__(self, other: Any) -> Any:
        return np.subtract(other, self)

    def __mul__(self, other: Any) -> Any:
        return np.multiply(self, other)

    def __rmul__(self, other: Any) -> Any:
        return np.multiply(other, self)

    def __truediv__(self, other: Any) -> Any:
        return np.true_divide(self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return np.true_divide(other, self)

    def __pow__(self, other: Any) -> Any:
        return np.power(self, other)

    def __rpow__(self, other: Any) -> Any:
        return np.power(other, self)

    def __neg__(self) -> Any:
        return np.negative(self)
