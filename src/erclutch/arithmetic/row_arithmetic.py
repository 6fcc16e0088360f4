"""How one operation of a record is computed on rows: the numbers of a precision, with the bits of the C."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.elementary import elementary, table_entry
from erclutch.arithmetic.precision import Precision
from erclutch.arithmetic.record import Node

AnyArray = NDArray[Any]


class Arithmetic(Protocol):
    """How one operation is computed. The last axis of every value is that of the rows, or has length one.

    Attributes:
        on_numbers: operations that single numbers of NumPy give with the bits of arrays, in a fifth of their time.
    """

    @property
    def on_numbers(self) -> Mapping[str, Callable[..., Any]]:
        """See `Arithmetic`."""
        ...

    def apply(self, node: Node, arguments: Sequence[Any]) -> Any:
        """The value of a node on some rows."""
        ...

    def function_of(self, node: Node) -> Callable[..., Any]:
        """What `apply` does for this node, as a function of its arguments: for a node that runs row by row."""
        ...

    def zero(self, node: Node) -> Any:
        """A number of the state before the first row."""
        ...


@dataclass(frozen=True)
class Numbers:
    """Numbers of a precision, with the bits of the C.

    Attributes:
        precision: of every operation.
        network: the forward pass of a network, from inputs (inputs, n) to effort (n,).
    """

    precision: Precision
    network: Callable[[AnyArray], AnyArray] | None = None

    def apply(self, node: Node, arguments: Sequence[Any]) -> Any:
        """The value of a node on some rows."""
        function = self._functions.get(node.operation)
        if function is not None:
            return function(*arguments)
        if node.operation == "constant":
            return np.asarray(node.value, np.float64).astype(self.precision.dtype).reshape(1)
        if node.operation == "table":
            entry = table_entry(node.value, *arguments)
            if node.kind == "real":
                return entry.astype(self.precision.dtype)
            return entry
        assert node.operation == "network"
        assert self.network is not None
        inputs = np.array(np.broadcast_arrays(*arguments))
        return self.network(inputs)

    def function_of(self, node: Node) -> Callable[..., Any]:
        """What `apply` does for this node."""
        known = self._functions.get(node.operation)
        return known or (lambda *arguments: self.apply(node, arguments))

    @property
    def on_numbers(self) -> Mapping[str, Callable[..., Any]]:
        """Operators and choices."""
        return _ON_NUMBERS

    @cached_property
    def _functions(self) -> Mapping[str, Callable[..., Any]]:
        return {**elementary(self.precision), **_NUMPY}

    def zero(self, node: Node) -> Any:
        """A number of the state before the first row."""
        if node.kind == "truth":
            return np.zeros(1, np.bool_)
        return np.zeros(1, self.precision.dtype)


_np: Any = np
_NUMPY: Mapping[str, Callable[..., Any]] = {
    "add": _np.add,
    "subtract": _np.subtract,
    "multiply": _np.multiply,
    "divide": _np.true_divide,
    "negate": _np.negative,
    "less": _np.less,
    "finite": _np.isfinite,
    "both": _np.logical_and,
    "either": _np.logical_or,
    "opposite": _np.logical_not,
    "choose": _np.where,
}


def _absolute(x: Any) -> Any:
    return -x if x < 0.0 else x


def _chosen(condition: Any, yes: Any, no: Any) -> Any:
    return yes if condition else no


_python: Any = operator
_ON_NUMBERS: Mapping[str, Callable[..., Any]] = {
    "add": _python.add,
    "subtract": _python.sub,
    "multiply": _python.mul,
    "divide": _python.truediv,
    "negate": _python.neg,
    "absolute": _absolute,
    "less": _python.lt,
    "finite": math.isfinite,
    "both": _python.and_,
    "either": _python.or_,
    "opposite": _python.not_,
    "choose": _chosen,
}
