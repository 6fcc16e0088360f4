"""Linear least squares with some coefficients bounded by zero are the inner problem of variable projection."""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array, Mask

#: Columns of length one whose triangle has an inverse with no larger entry can be told apart: a triangular solution is
#: then as good as one by singular values.
_TOLD_APART = 1e6


def solve_bounded(triangle: Array, vector: Array, nonnegative: Mask) -> tuple[Array, Mask]:
    """Minimise |vector - triangle c| with c >= 0 where asked, by active sets (Lawson and Hanson 1974).

    Args:
        triangle: shape (p, p), from a QR decomposition of the columns.
        vector: shape (p,).
        nonnegative: which coefficients are bounded, shape (p,).

    Returns:
        Coefficients (p,), and the mask of those held at zero.
    """
    # As `numpy.linalg.norm`, in a third of the time.
    scale = np.sqrt(np.add.reduce(triangle * triangle, axis=0))
    scale[scale == 0] = 1.0
    a = triangle / scale
    held = np.zeros(scale.size, np.bool_)
    c = _solve(a, vector, ~held)
    # Drop what is negative, until nothing is; then let back in what the gradient asks for. Finite: each pass with a
    # lower residual has another active set.
    most = 3 * scale.size + 3 if scale.size else 0
    for _ in range(most):
        negative = ~held & nonnegative & (c < 0)
        if negative.any():
            held |= negative
            c = _solve(a, vector, ~held)
            continue
        if not held.any():
            break
        gradient = a.T @ (vector - a @ c)
        wanting = np.where(held, gradient, -np.inf)
        enter = int(np.argmax(wanting))
        size = np.linalg.norm(vector) + np.finfo(float).tiny
        if wanting[enter] <= 1e-12 * size:
            break
        held[enter] = False

        # Toward the solution of the enlarged set, as far as to a coefficient that reaches zero.
        target = _solve(a, vector, ~held)
        while (negative := ~held & nonnegative & (target < 0)).any():
            share = np.min(c[negative] / (c[negative] - target[negative]))
            c = c + share * (target - c)
            held |= ~held & nonnegative & (c <= 1e-15)
            c[held] = 0.0
            target = _solve(a, vector, ~held)
        c = target
    return c / scale, held


def _solve(a: Array, vector: Array, free: Mask) -> Array:
    """The free coefficients that fit best, the others zero; the shortest ones where columns say the same."""
    # Without NumPy's ways around, which take 20 times as long.
    from scipy.linalg.lapack import (
        dgeqrf,
        dtrtri,
        dtrtrs,
    )

    c: Array = np.zeros(free.size)
    count = int(np.count_nonzero(free))
    if not count:
        return c
    r, right = a, vector
    if count < a.shape[0]:  # some are held, or nothing excites them: what is left is no triangle
        beside = np.column_stack([a[:, free], vector])
        packed = dgeqrf(beside)[0]  # R above the diagonal
        r, right = packed[:count, :count], packed[:count, count]
    inverse, singular = dtrtri(r)
    if singular == 0 and float(np.abs(inverse).max()) < _TOLD_APART:
        c[free] = dtrtrs(r, right)[0]
    else:
        c[free] = np.linalg.lstsq(a[:, free], vector, rcond=1e-14)[0]
    return c
