"""The exported C checks the arithmetic that a compiler made of it: when it is compiled, and at each reset.

Options of a compiler may change the order of sums, fuse a product with a sum, or divide by multiplying. The numbers
are then others, and nothing says so. So the file refuses the options that a macro tells of, and takes back those that
a pragma can take back. Compilers without such macros and pragmas are found out at run time: the reset, and each
function without a state, does a few operations whose results show each of these changes.
"""

from __future__ import annotations

import numpy as np

from erclutch.arithmetic.precision import Precision

#: Ahead of the code. GCC has had its macros since version 10, and no macro tells of a fused product and sum.
COMPILE_TIME = """#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "-ffast-math, and each part of it, changes the numbers of this file"
#endif
#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ != 0)
#error "-ffinite-math-only lets a compiler take for granted what this file tests"
#endif
#if defined(__FLT_EVAL_METHOD__) && (__FLT_EVAL_METHOD__ != 0) && (__FLT_EVAL_METHOD__ != 16)
#error "this processor computes with more digits than it stores: use SSE on x86 (-msse2 -mfpmath=sse)"
#endif
#if defined(__clang__)
#if __clang_major__ >= 12
#pragma float_control(precise, on)
#endif
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && (defined(__FP_FAST_FMA) || defined(__FP_FAST_FMAF))
#pragma GCC optimize("fp-contract=off")
#endif
"""


def exact_function(n: str, p: Precision) -> str:
    """C of NAME_exact: 1 where each operation is rounded to nearest by itself, in the order of the brackets, else 0.

    Args:
        n: prefix of the names, with its underscore.
        p: precision of the file.
    """
    number = p.dtype.type
    # Half of it is lost beside 1 in either direction, so a sum with 1 stays 1.
    tiny = 2.0 ** -(p.fraction + 3)
    # (1 + step) (1 - step) = 1 - step^2 rounds to 1, but for a product that is fused with the sum behind it. In
    # float64 the step is less than float32 can add to 1: so constants that became float32 show, too.
    step = 2.0 ** -(p.fraction // 2 + 3)
    # The first odd number whose reciprocal, rounded, is not what it is divided by.
    odd = 3.0
    while number(1.0) / number(odd) * number(odd) == number(1.0):
        odd += 2.0
    probes = (1.0, tiny, 1.0 + step, 1.0 - step, odd)
    numbers = ", ".join(p.constant(value) for value in probes)
    odd_text = p.constant(odd)
    as_bits = np.asarray(step, p.dtype).view(p.bits)
    bits = int(as_bits)
    step_bits = f"0x{bits:x}{p.bits_suffix}"
    return f"""/* 1 where the compiler kept the arithmetic of this file, else 0: each operation is rounded to nearest by
   itself, in the order of the brackets. The numbers are read as if they could change: no compiler can know the results
   ahead, so these operations are done as all others are. */
#if defined(__FRAMAC__)
#define {n.upper()}READ const
#else
#define {n.upper()}READ const volatile
#endif
static uint32_t {n}exact(void)
{{
    static {n.upper()}READ {n}real numbers[5] = {{{numbers}}};
    const {n}real one = numbers[0];
    const {n}real tiny = numbers[1];
    const {n}real more = numbers[2];
    const {n}real less = numbers[3];
    const {n}real odd = numbers[4];
    const {n}real again = numbers[4];
    const {p.c_bits} sums = {n}bits_of((one + tiny) - one) | {n}bits_of((one - tiny) - one);
    const {p.c_bits} products = {n}bits_of((more * less) - one) | ({n}bits_of(more - one) ^ {step_bits});
    const {p.c_bits} quotients = ({n}bits_of(odd / {odd_text}) | {n}bits_of(odd / again)) ^ {n}bits_of(one);
    return ((sums | products | quotients) == 0u) ? (uint32_t)1u : (uint32_t)0u;
}}
"""
