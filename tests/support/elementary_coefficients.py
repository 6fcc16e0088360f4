"""Coefficients of the exported C's own exp, expm1, log and tanh, and how they were found.

Polynomials are Chebyshev fits of 60 digits; tanh for float32 is an odd rational by Lawson's weighted least squares.
Needs mpmath, which comes with SymPy. `studies/elementary.py` prints them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np

from erclutch.arithmetic.elementary import elementary
from erclutch.arithmetic.precision import FLOAT32

mp.mp.dps = 60
#: Half a step of the reduction by ln 2, and a little more for its rounding.
HALF = mp.log(2) / 2 * (1 + mp.mpf(2) ** -12)
#: (m - 1) / (m + 1) for a mantissa m between sqrt(1/2) and sqrt(2), squared.
LARGEST = ((mp.sqrt(2) - 1) / (mp.sqrt(2) + 1)) ** 2
#: From here on float32's tanh is held.
FLAT = mp.mpf("7.789")
#: Units of the last place by which the coefficients leave the rounded ones: found by trying neighbours at random, as
#: rounding decides which of them are the best (`largest_tanh_error`).
NUDGES = (0, 0, 0, 0, -2, 1, 0, -1)


def expm1_tail(r: Any) -> Any:
    """(exp(r) - 1 - r) / r^2."""
    return mp.mpf("0.5") if r == 0 else (mp.expm1(r) - r) / r**2


def log_tail(z: Any) -> Any:
    """(2 atanh(s) - 2 s) / s^3 for s^2 = z."""
    if z < mp.mpf("1e-20"):
        return mp.mpf(2) / 3
    s = mp.sqrt(z)
    return (2 * mp.atanh(s) - 2 * s) / s**3


def polynomial(f: Callable[[Any], Any], low: Any, high: Any, terms: int) -> list[float]:
    """Coefficients, lowest power first."""
    return [float(c) for c in reversed(mp.chebyfit(f, [low, high], terms))]


def allowed(x: float) -> float:
    """Share of the error that the rational may have at x: less where rounding has more."""
    return 1.0 - 0.4 * min(1.0, max(0.0, (x - 0.3) / 2.0))


def rational_tanh(
    above: int = 3, below: int = 4, rounds: int = 12, nodes: int = 50
) -> tuple[list[float], list[float]]:
    """P, Q with tanh(x) ~ x P(x^2) / Q(x^2) up to FLAT, the highest coefficient of Q one, as float32 with NUDGES."""
    x = [FLAT / 2 * (1 - mp.cos(mp.pi * (2 * i + 1) / (2 * nodes))) for i in range(nodes - 1)] + [
        FLAT
    ]
    f = [mp.tanh(t) / t for t in x]
    u = [(t / FLAT) ** 2 for t in x]
    share = [allowed(float(t)) for t in x]
    weight, q = [mp.mpf(1)] * nodes, [mp.mpf(1)] * nodes
    best: tuple[Any, list[Any]] | None = None
    for _ in range(rounds):
        rows, right = mp.matrix(nodes, above + 1 + below), mp.matrix(nodes, 1)
        for i in range(nodes):
            s = mp.sqrt(weight[i]) / (q[i] * f[i] * share[i])
            for j in range(above + 1):
                rows[i, j] = s * u[i] ** j
            for j in range(below):
                rows[i, above + 1 + j] = -s * f[i] * u[i] ** (j + 1)
            right[i] = s * f[i]
        c = list(mp.lu_solve(rows.T * rows, rows.T * right))
        p = [sum(c[j] * u[i] ** j for j in range(above + 1)) for i in range(nodes)]
        q = [
            1 + sum(c[above + 1 + j] * u[i] ** (j + 1) for j in range(below)) for i in range(nodes)
        ]
        error = [abs(p[i] / q[i] / f[i] - 1) / share[i] for i in range(nodes)]
        worst = max(error)
        if best is None or worst < best[0]:
            best = worst, c
        weight = [w * (e / worst + mp.mpf("1e-3")) for w, e in zip(weight, error, strict=True)]
        mean = sum(weight) / nodes
        weight = [w / mean for w in weight]
    assert best is not None
    c, top = best[1], best[1][-1] / FLAT ** (2 * below)
    numerator = [c[j] / FLAT ** (2 * j) / top for j in range(above + 1)]
    denominator = [1 / top, *(c[above + j] / FLAT ** (2 * j) / top for j in range(1, below))]
    nudged = np.array([float(v) for v in numerator + denominator], np.float32).view(np.int32)
    nudged += np.array(NUDGES, np.int32)
    held = [float(v) for v in nudged.view(np.float32)]
    return held[: above + 1], [*held[above + 1 :], 1.0]


def largest_tanh_error(stride: int = 1) -> float:
    """Of `elementary`'s tanh on every positive float32 from 2^-12 to 10, in units of the last place (15 s)."""
    tanh, worst = elementary(FLOAT32)["tanh"], 0.0
    first, last = (int(np.float32(v).view(np.uint32)) for v in (2.0**-12, 10.0))
    for start in range(first, last, 2**22):
        x = np.arange(start, min(start + 2**22, last), stride, dtype=np.uint32).view(np.float32)
        exact = np.tanh(x.astype(np.float64))
        unit = np.spacing(np.minimum(exact, 1.0 - 2.0**-25).astype(np.float32), dtype=np.float32)
        unit = np.where(exact > 0.5, 2.0**-24, unit)
        worst = max(worst, float(np.max(np.abs(tanh(x) - exact) / unit)))
    return worst


def parts(value: Any, bits: int) -> tuple[float, float]:
    """A number as a first part of so many bits, exact in products with small integers, and the rest."""
    scale = mp.mpf(2) ** (bits - 1 - int(mp.floor(mp.log(value, 2))))
    first = mp.nint(value * scale) / scale
    return float(first), float(value - first)


def found() -> dict[str, list[float]]:
    """All coefficients by name."""
    p, q = rational_tanh()
    return {
        "exp32": polynomial(expm1_tail, -HALF, HALF, 6),
        "exp64": polynomial(expm1_tail, -HALF, HALF, 11),
        "log32": polynomial(log_tail, mp.mpf(0), LARGEST, 4),
        "log64": polynomial(log_tail, mp.mpf(0), LARGEST, 9),
        "tanh32_p": p,
        "tanh32_q": q,
        "ln2_32": list(parts(mp.log(2), 15)),
        "ln2_64": list(parts(mp.log(2), 40)),
    }
