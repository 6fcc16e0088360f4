"""The elementary functions are printed in C from their records, and numbers are printed as bits."""

from __future__ import annotations

from erclutch.arithmetic.precision import Precision
from erclutch.arithmetic.record import traced
from erclutch.export.c.c_printer import function


def bits(n: str, p: Precision) -> str:
    """Numbers as bits and back."""
    exponent = f"0x{((1 << (p.width - 1 - p.fraction)) - 1) << p.fraction:x}{p.bits_suffix}"
    return f"""/* A number and its bits. The two members have the same size, so the order of bytes does not matter. */
typedef union {{ {n}real real; {p.c_bits} bits; }} {n}pun;

static {p.c_bits} {n}bits_of({n}real x)
{{
    {n}pun pun;
    pun.real = x;
    return pun.bits;
}}

/* Neither infinite nor NaN, told by the bits: no compiler option can take it away. */
static uint32_t {n}finite({n}real x)
{{
    return (({n}bits_of(x) & {exponent}) != {exponent}) ? (uint32_t)1u : (uint32_t)0u;
}}
"""


def real_of_bits(n: str, p: Precision) -> str:
    """The number with these bits."""
    return f"""static {n}real {n}real_of_bits({p.c_bits} u)
{{
    {n}pun pun;
    pun.bits = u;
    return pun.real;
}}
"""


#: The functions in their order in the file.
_ABOUT = {
    "absolute": "|x|",
    "exp": "e^x = 2^k (1 + r + r^2 P(r)) for x = k ln 2 + r",
    "exp_hold": "The argument of exp within what it can do",
    "exp_held": "e^x = 2^k (1 + r + r^2 P(r)) for x = k ln 2 + r, x held",
    "expm1": "e^x - 1, precise near zero",
    "tanh": "Hyperbolic tangent",
    "tanh_hold": "The argument of tanh within where it is not yet 1",
    "tanh_held": "Hyperbolic tangent of a held argument",
    "power": "x^n = e^(n log x) for x > 0; log x and its product with n as sums of two numbers",
    "nearest": "The nearest whole number",
}
_WITH_BITS = {"exp", "exp_held", "expm1", "power"}


def functions(n: str, used: set[str], p: Precision) -> list[str]:
    """The functions that are used, with what they need."""
    parts = [bits(n, p)]
    if used & _WITH_BITS or (p.width == 64 and used & {"tanh", "tanh_held"}):
        parts.append(real_of_bits(n, p))
    for name, about in _ABOUT.items():
        if name in used:
            record = traced(name, p)
            parts.append(function(n, p, name, record, about))
    return parts
