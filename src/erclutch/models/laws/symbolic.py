"""A law's own function, run on SymPy's symbols, gives the law's equation. SymPy is imported only where it is needed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any, cast

import numpy as np
import sympy

from erclutch.arithmetic.operand import Operand
from erclutch.models.laws.law import Law
from erclutch.models.laws.smooth import OFF_ZERO, TINY
from erclutch.models.stages.stage import SlipStage

_UNARY: dict[np.ufunc, Callable[[Any], Any]] = {
    np.negative: lambda x: -x,
    np.square: lambda x: x**2,
    np.exp: sympy.exp,
    np.expm1: lambda x: sympy.exp(x) - 1,
    np.tanh: sympy.tanh,
    np.sqrt: sympy.sqrt,
    np.log: sympy.log,
    np.absolute: sympy.Abs,
}
_BINARY: dict[np.ufunc, Callable[[Any, Any], Any]] = {
    np.add: lambda x, y: x + y,
    np.subtract: lambda x, y: x - y,
    np.multiply: lambda x, y: x * y,
    np.true_divide: lambda x, y: x / y,
    np.power: lambda x, y: x**y,
}
_FUNCTIONS: dict[np.ufunc, Callable[..., Any]] = {**_UNARY, **_BINARY}


_STRENGTH = cast(Any, sympy).Function("y")(sympy.Symbol("E"))


class Symbolic(Operand):
    """A SymPy expression that NumPy's ufuncs act on."""

    __slots__ = ("expression",)

    def __init__(self, expression: Any) -> None:
        self.expression = expression

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        rule = _FUNCTIONS.get(ufunc)
        if rule is None or method != "__call__" or kwargs:
            return NotImplemented
        return Symbolic(rule(*(_expression(x) for x in inputs)))


def _expression(x: Any) -> Any:
    if isinstance(x, Symbolic):
        return x.expression
    return _rational(x)


@cache
def _rational(x: float) -> Any:
    """A number of a law's function as a fraction; the regularisation at zero is no part of the published equation."""
    if x in (TINY, OFF_ZERO):
        return sympy.Integer(0)
    return sympy.nsimplify(x, rational=True)


def _terms(law: Law) -> list[tuple[Any, Any]]:
    """Each gain with its column."""
    field: Any = Symbolic(sympy.Symbol("E", positive=True))
    slip = Symbolic(sympy.Symbol("w", positive=True))
    shape: list[Symbolic] = []
    for number in law.shape:
        positive = True if number.lower >= 0 else None  # None: SymPy does not know
        symbol = sympy.Symbol(number.name, real=True, positive=positive)
        shape.append(Symbolic(symbol))
    if law.stimulus is not None:
        of_stimulus = [
            Symbolic(sympy.Symbol(number.name, positive=True)) for number in law.stimulus_shape
        ]
        field = law.stimulus(field, *of_stimulus)
    terms: list[tuple[Any, Any]] = []
    columns = law.columns(field, slip, *shape)
    for gain, column in zip(law.gains, columns, strict=True):
        terms.append((sympy.Symbol(gain.name), _tidy(_expression(column))))
    return terms


def equation(law: Law) -> Any:
    """Effort of one element for w > 0 as a SymPy expression in E, w and the law's parameters.

    Made by running the law's own function on symbols. The regularisation at zero is left out, so that the equation
    reads as published; the transition slip stays. All laws are odd in w.
    """
    total: Any = sympy.Integer(0)
    for gain, column in _terms(law):
        total += gain * column
    return total


@lru_cache(maxsize=512)
def _tidy(expression: Any) -> Any:
    """Powers of powers and of products as single powers, with their exponents as sums."""

    def is_power(part: Any) -> bool:
        return bool(part.is_Pow)

    def with_expanded_exponent(part: Any) -> Any:
        return part.base ** sympy.expand(part.exp)

    flat = sympy.expand_power_base(sympy.powdenest(expression, force=True), deep=True)
    single = sympy.powsimp(flat, deep=True, force=True)
    return single.replace(is_power, with_expanded_exponent)


def _short(expression: Any) -> Any:
    """Fractions that nobody reads to four digits."""

    def is_awkward(part: Any) -> bool:
        return bool(part.is_Rational and part.q > 1000)

    def to_four_digits(part: Any) -> Any:
        return part.n(4)

    return expression.replace(is_awkward, to_four_digits)


def short_equation(law: Law) -> Any:
    """The equation with awkward fractions to four digits."""
    return _short(equation(law))


def short_terms(law: Law) -> list[tuple[Any, Any]]:
    """Gains and columns of the equation, in the law's own order, awkward fractions to four digits."""
    return [(gain, _short(column)) for gain, column in _terms(law)]


def memory_terms(stage: SlipStage) -> list[tuple[Any, Any]]:
    """Gains and columns that a stage on the slip adds to a law; y is the strength of the field."""
    outputs = [Symbolic(sympy.Symbol(name)) for name in stage.outputs]
    columns = stage.columns(outputs, Symbolic(_STRENGTH))
    pairs = zip(stage.gains, columns, strict=True)
    return [(sympy.Symbol(gain.name), _expression(column)) for gain, column in pairs]


def equation_text(law: Law) -> str:
    """The equation as one line of text, powers as ``^``."""
    return str(short_equation(law)).replace("**", "^")


#: Names whose LaTeX is not what SymPy makes of them.
_WRITTEN = {"T_sy": "T_{sy}", "T_on": r"T_\mathrm{on}", "E_on": r"E_\mathrm{on}"}


def symbol_latex(name: str) -> str:
    """A parameter's name as LaTeX."""
    return _WRITTEN.get(name) or str(sympy.latex(sympy.Symbol(name)))


def equation_latex(law: Law) -> str:
    """The equation as LaTeX, gain times column in the law's own order."""

    def gathered(exponent: Any) -> Any:
        """An exponential with its exponent as a product."""
        return sympy.exp(sympy.factor(exponent))

    written: list[str] = []
    for gain, column in _terms(law):
        shown = _short(column.replace(sympy.exp, gathered))
        names = {symbol: symbol_latex(symbol.name) for symbol in shown.free_symbols}
        factor = str(sympy.latex(shown, symbol_names=names))
        if shown.is_Add:
            factor = rf"\left({factor}\right)"
        written.append(f"{symbol_latex(gain.name)} {factor}")
    return " + ".join(written)
