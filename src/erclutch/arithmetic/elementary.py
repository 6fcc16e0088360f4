"""exp, expm1, tanh, powers and magnitude use additions, multiplications, divisions and shifts alone: no libm.

Each is a branch-free function of one definition: run on arrays or floats it is what models predict with (`exact`), run
on a trace it is the exported C. Bounds in units of the last place (ulp), with the command that measures them, are in
docs/export.md. The coefficients are those that studies/elementary.py finds.

exp:   x = k ln 2 + r, exp(x) = 2^k (1 + r + r^2 P(r)); k by adding and subtracting 1.5 2^fraction, 2^k from its bits.
power: x^n = exp(n log x) with log x and its product with n as unevaluated sums of two numbers, because an error of one
       ulp in n log x = 80 would be one of 80 in the result (Dekker's products; log by the odd series in
       (m - 1) / (m + 1), the quotient too as a sum of two).
tanh:  float64 -e / (2 + e) with e = expm1(-2 |x|); float32 a rational function, odd in x, which is cheaper.
"""

from __future__ import annotations

import struct
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial, reduce
from typing import Any, cast

import numpy as np

from erclutch.arithmetic.dual import Dual, chosen, value_of
from erclutch.arithmetic.operand import Operand
from erclutch.arithmetic.precision import FLOAT32, FLOAT64, Precision

# fmt: off
_H = float.fromhex
COEFFICIENTS: Mapping[str, tuple[float, ...]] = {
    "exp32": tuple(map(_H, ("0x1.0000000b93b9ep-1", "0x1.5555555a7a10cp-3", "0x1.5554e8f634947p-5",
                            "0x1.1110e0eb1c49ap-7", "0x1.6d433a9ed61abp-10", "0x1.a12505592a271p-13"))),
    "exp64": tuple(map(_H, ("0x1.0000000000000p-1", "0x1.5555555555557p-3", "0x1.5555555555556p-5",
                            "0x1.11111111100d7p-7", "0x1.6c16c16c162d1p-10", "0x1.a01a01abea9bap-13",
                            "0x1.a01a01a6da084p-16", "0x1.71de02294b1fbp-19", "0x1.27e4db5fae4a0p-22",
                            "0x1.af4dfabdcee56p-26", "0x1.1f730d24fd4ebp-29"))),
    "log32": tuple(map(_H, ("0x1.5555554bb2b2cp-1", "0x1.9999eb5d84f14p-2", "0x1.245c438323e9ap-2",
                            "0x1.ddced7078dd3ap-3"))),
    "log64": tuple(map(_H, ("0x1.5555555555555p-1", "0x1.9999999999998p-2", "0x1.2492492492959p-2",
                            "0x1.c71c71c64c8ccp-3", "0x1.745d17d35328cp-3", "0x1.3b137b347f3c2p-3",
                            "0x1.111d273ca8a70p-3", "0x1.debedbffa1d9ep-4", "0x1.e6afc55fa9490p-4"))),
    "tanh32_p": tuple(map(_H, ("0x1.e5da5c0000000p+21", "0x1.f6e7ea0000000p+18", "0x1.70d3c00000000p+13",
                               "0x1.710dc60000000p+5"))),
    "tanh32_q": tuple(map(_H, ("0x1.e5da5e0000000p+21", "0x1.c1a09e0000000p+20", "0x1.732abe0000000p+16",
                               "0x1.df14b00000000p+9", "0x1.0000000000000p+0"))),
    "ln2_32": (_H("0x1.62e4000000000p-1"), _H("0x1.7f7d1cf79abcap-20")),
    "ln2_64": (_H("0x1.62e42fefa4000p-1"), _H("-0x1.8432a1b0e2634p-43")),
}
# fmt: on
#: One over ln 2.
_PER_LN2 = 1.4426950408889634
#: From here on tanh is as good as 1: within the bound of the docs in float32, to the nearest number in float64.
_TANH_IS_ONE = {32: 7.789, 64: 20.0}


@dataclass(frozen=True)
class Format:
    """A precision with the numbers that the functions need in it.

    Attributes:
        precision: of all arithmetic.
        magic: added and taken off again, it rounds to a whole number.
        splitter: Veltkamp's, parts a number into two of half the digits.
        largest: arguments of exp are held within plus and minus this, so that its result stays a normal number.
        exp, log, ln2: coefficients.
    """

    precision: Precision
    magic: float
    splitter: float
    largest: float
    exp: tuple[float, ...]
    log: tuple[float, ...]
    ln2: tuple[float, ...]


@cache
def format_of(precision: Precision) -> Format:
    """The numbers for a precision."""
    half_of_digits = (precision.fraction + 2) // 2
    return Format(
        precision=precision,
        magic=1.5 * 2.0**precision.fraction,
        splitter=2.0**half_of_digits + 1.0,
        largest=87.0 if precision is FLOAT32 else 708.0,
        exp=COEFFICIENTS[f"exp{precision.width}"],
        log=COEFFICIENTS[f"log{precision.width}"],
        ln2=COEFFICIENTS[f"ln2_{precision.width}"],
    )


# --- operations that are no operators --------------------------------------------------------------------------------
# Each is answered for three kinds of numbers: an operand that records, a Python float, an array;
# a choice for duals too.


class RecordingOperand(Operand, ABC):
    """An operand that writes down, besides ufuncs, a choice and what is done to the bits of a number."""

    __slots__ = ()

    @abstractmethod
    def record(self, operation: str, *arguments: Any, bits: bool = False) -> Any:
        """The operand for an operation on some operands and numbers; ``bits``: it is bits that come out."""


def _recorder_among(*operands: Any) -> RecordingOperand | None:
    """The first operand that records; None where all are numbers."""
    for x in operands:
        if isinstance(x, RecordingOperand):
            return x
    return None


def less_select(a: Any, b: Any, yes: Any, no: Any) -> Any:
    """``a < b ? yes : no``."""
    if isinstance(a, float) and isinstance(b, float):
        return yes if a < b else no
    recorder = _recorder_among(a, b, yes, no)
    if recorder is not None:
        return recorder.record("less_select", a, b, yes, no)
    if any(isinstance(x, Dual) for x in (a, b, yes, no)):
        return chosen(value_of(a) < value_of(b), yes, no)
    # A plain number takes the type of the other one, as in C.
    choose: Any = np.where
    selected = choose(a < b, yes, no)
    typed = next((x.dtype for x in (yes, no) if hasattr(x, "dtype")), selected.dtype)
    return selected.astype(typed, copy=False)


def table_entry(table: Sequence[Any], *places: Any) -> Any:
    """Entry of a nested table of truths, whole numbers up to 255 or real numbers at the whole parts of its places."""
    recorder = _recorder_among(*places)
    if recorder is not None:
        return recorder.record("table", table, *places)
    if all(isinstance(x, float) for x in places):
        return reduce(lambda entries, x: entries[int(x)], places, table)
    whole = [np.asarray(place).astype(np.intp) for place in places]
    return np.array(table)[tuple(whole)]


def is_less(a: Any, b: Any) -> Any:
    """Whether a < b: a truth of operands that record, else of NumPy."""
    recorder = _recorder_among(a, b)
    return a < b if recorder is None else recorder.record("less", a, b)


def one_where(truth: Any) -> Any:
    """1 where a truth holds, else 0."""
    if isinstance(truth, RecordingOperand):
        return truth.record("choose", truth, 1.0, 0.0)
    return 1.0 * truth


def whole_number_near(x: Any) -> Any:
    """The whole number nearest to x, for |x| below half of 2^23."""
    if isinstance(x, RecordingOperand):
        return x.record("nearest", x)
    return nearest(format_of(FLOAT64), x)


def _bits_of(x: Any, precision: Precision) -> Any:
    """The bits of a number."""
    if isinstance(x, float):
        return _WORD.unpack(_DOUBLE.pack(x))[0]
    if isinstance(x, RecordingOperand):
        return x.record("bits_of", x, bits=True)
    return np.asarray(x, precision.dtype).view(precision.bits)


def _real_of(u: Any, precision: Precision) -> Any:
    """The number with these bits."""
    if isinstance(u, int):
        return _DOUBLE.unpack(_WORD.pack(u))[0]
    if isinstance(u, RecordingOperand):
        return u.record("real_of_bits", u)
    return np.asarray(u, precision.bits).view(precision.dtype)


def _number(u: Any, precision: Precision) -> Any:
    """The bits' value as an integer, as a real number."""
    if isinstance(u, RecordingOperand):
        return u.record("real_from_bits", u)
    if isinstance(u, int):
        return float(u)
    return np.asarray(u).astype(precision.dtype)


_DOUBLE = struct.Struct("<d")
_WORD = struct.Struct("<Q")
_ALL_BITS = 0xFFFF_FFFF_FFFF_FFFF
_ON_BITS: dict[str, tuple[Callable[..., Any], str]] = {
    "bits_add": (np.add, "__add__"),
    "bits_subtract": (np.subtract, "__sub__"),
    "bits_and": (np.bitwise_and, "__and__"),
    "left_shift": (np.left_shift, "__lshift__"),
    "right_shift": (np.right_shift, "__rshift__"),
}


def _on_bits(operation: str, u: Any, other: Any, precision: Precision) -> Any:
    """An operation on bits; what overflows is lost, as in C."""
    on_arrays, on_integers = _ON_BITS[operation]
    if isinstance(u, int):
        return getattr(u, on_integers)(other) & _ALL_BITS
    if isinstance(u, RecordingOperand):
        return u.record(operation, u, other, bits=True)
    # Arrays of unsigned integers wrap without a warning.
    return on_arrays(u, other if np.ndim(other) else precision.bits.type(other))


# --- the functions ---------------------------------------------------------------------------------------------------


def _polynomial(x: Any, coefficients: Sequence[float]) -> Any:
    """Horner's rule, lowest power first."""
    total: Any = coefficients[-1] * x
    for c in coefficients[-2:0:-1]:
        total += c  # in place where it is an array
        total *= x
    return total + coefficients[0]


def absolute(x: Any) -> Any:
    """|x|."""
    return less_select(x, 0.0, -x, x)


def sign_of(x: Any) -> Any:
    """1, -1 or 0, of a number, an array or an operand."""
    if isinstance(x, np.ndarray):
        return np.sign(cast(Any, x))
    return less_select(x, 0.0, -1.0, less_select(0.0, x, 1.0, 0.0))


def nearest(f: Format, x: Any) -> Any:
    """The whole number nearest to x, for |x| below half of 2^fraction."""
    return (x + f.magic) - f.magic


def _hold(x: Any, low: float, high: float) -> Any:
    """X within [low, high]; high where x is not a number."""
    if isinstance(x, np.ndarray):
        return np.maximum(np.fmin(cast(Any, x), high), low)  # the same, faster
    held = less_select(x, high, x, high)
    return less_select(low, held, held, low)


def _reduced(f: Format, x: Any, rest: Any = None) -> tuple[Any, Any]:
    """2^k, and exp(r) - 1 for x + rest = k ln 2 + r."""
    shifted = x * _PER_LN2 + f.magic
    k = shifted - f.magic
    high, low = f.ln2
    r = (x - k * high) - k * low
    if rest is not None:
        r = r + rest
    e = r + (r * r) * _polynomial(r, f.exp)
    # The last bits of the shifted number are k: moved to where a number has its exponent, they make 2^k.
    p = f.precision
    exponent = _on_bits("bits_add", _bits_of(shifted, p), p.bias, p)
    scale = _real_of(_on_bits("left_shift", exponent, p.fraction, p), p)
    return scale, e


def exp_hold(f: Format, x: Any) -> Any:
    """The argument within what exp can do."""
    return _hold(x, -f.largest, f.largest)


def exp_held(f: Format, x: Any) -> Any:
    """e^x of a held argument."""
    scale, e = _reduced(f, x)
    return scale + scale * e


def exp(f: Format, x: Any) -> Any:
    """e^x, held at its ends at the smallest and largest normal numbers."""
    return exp_held(f, exp_hold(f, x))


def expm1(f: Format, x: Any) -> Any:
    """e^x - 1, precise near zero."""
    scale, e = _reduced(f, exp_hold(f, x))
    return scale * e + (scale - 1.0)


def tanh_hold(f: Format, x: Any) -> Any:
    """The argument within where tanh is not yet 1."""
    edge = _TANH_IS_ONE[f.precision.width]
    return _hold(x, -edge, edge)


def tanh_held(f: Format, x: Any) -> Any:
    """Hyperbolic tangent of a held argument."""
    if f.precision is FLOAT32:
        square = x * x
        above = x * _polynomial(square, COEFFICIENTS["tanh32_p"])
        return above / _polynomial(square, COEFFICIENTS["tanh32_q"])
    size: Any = np.abs(cast(Any, x)) if isinstance(x, np.ndarray) else absolute(x)
    scale, rest = _reduced(f, -2.0 * size)
    e = scale * rest + (scale - 1.0)  # expm1(-2 |x|)
    t = -e / (2.0 + e)
    return less_select(x, 0.0, -t, t)


def tanh(f: Format, x: Any) -> Any:
    """Hyperbolic tangent."""
    return tanh_held(f, tanh_hold(f, x))


def _split(f: Format, x: Any) -> tuple[Any, Any]:
    """X as a sum of two numbers of half the digits (Veltkamp)."""
    wide = f.splitter * x
    high = wide - (wide - x)
    return high, x - high


def _lost(f: Format, a: Any, b: Any, product: Any) -> Any:
    """A b - product, what rounding lost (Dekker)."""
    a_high, a_low = _split(f, a)
    b_high, b_low = _split(f, b)
    return ((a_high * b_high - product) + (a_high * b_low + a_low * b_high)) + a_low * b_low


def power(f: Format, x: Any, n: Any) -> Any:
    """x^n for x > 0; at x = 0 as at the smallest normal number."""
    # Each step gives a number and what rounding took off it. The order of operations is that of the exported C.
    p = f.precision
    smallest = 2.0 ** (1 - p.bias)

    # x = 2^k m with m between sqrt(1/2) and sqrt(2)
    half_root = int(np.asarray(0.5**0.5, p.dtype).view(p.bits))
    one = p.bias << p.fraction
    bits = _bits_of(less_select(x, smallest, smallest, x), p)
    moved = _on_bits("bits_add", bits, one - half_root, p)
    exponent = _on_bits("right_shift", moved, p.fraction, p)
    exponent_in_place = _on_bits("left_shift", exponent, p.fraction, p)
    rest = _on_bits("bits_subtract", bits, exponent_in_place, p)
    k = _number(exponent, p) - float(p.bias)
    m = _real_of(_on_bits("bits_add", rest, one, p), p)

    # s = (m - 1) / (m + 1)
    above = m - 1.0
    below = m + 1.0
    s = above / below
    product = s * below
    left = (above - product) - _lost(f, s, below, product)
    s_rest = (left - s * (m - (below - 1.0))) / below  # the sum below was rounded too

    # log x = k ln 2 + 2 s + s^3 P(s^2)
    square = s * s
    high, low = f.ln2
    whole = k * high
    twice = 2.0 * s
    log = whole + twice
    lost_in_sum = twice - (log - whole)
    small = k * low + 2.0 * s_rest
    log_rest = lost_in_sum + (small + s * square * _polynomial(square, f.log))

    y = n * log
    y_rest = _lost(f, n, log, y) + n * log_rest
    scale, e = _reduced(f, _hold(y, -f.largest, f.largest), y_rest)
    return scale + scale * e


BY_NAME: Mapping[str, Callable[..., Any]] = {
    "exp": exp,
    "exp_hold": exp_hold,
    "exp_held": exp_held,
    "expm1": expm1,
    "tanh": tanh,
    "tanh_hold": tanh_hold,
    "tanh_held": tanh_held,
    "power": power,
    "nearest": nearest,
}


@cache
def elementary(precision: Precision) -> Mapping[str, Callable[..., Any]]:
    """The functions on arrays of a precision."""
    number_format = format_of(precision)
    functions: dict[str, Callable[..., Any]] = {}
    for name, function in BY_NAME.items():
        functions[name] = partial(function, number_format)
    functions["absolute"] = absolute
    return functions
