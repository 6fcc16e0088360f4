"""Linear least squares with some coefficients bounded by zero are the inner problem of variable projection."""

from __future__ import annotations

import numpy as np

from erclutch.signals.array import Array, Mask


def solve_bounded(triangle: Array, vector: Array, nonnegative: Mask) -> tuple[Array, Mask]:
    """Minimise |vector - triangle c| with c >= 0 where asked, by active sets (Lawson and Hanson 1974).

    Args:
        triangle: shape (p, p), from a QR decomposition of the columns.
        vector: shape (p,).
        nonnegative: which coefficients are bounded, shape (p,).

    Returns:
        Coefficients (p,), and the mask of those held at zero.
    """
    scale = np.sqrt(np.add.reduce(triangle * triangle, axis=0))  # as `numpy.linalg.norm`, in a third of the time
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
        c, held = _enter(a, vector, c, held, nonnegative)
    return c / scale, held


def _enter(
    a: Array,
    vector: Array,
    c: Array,
    held: Mask,
    nonnegative: Mask,
) -> tuple[Array, Mask]:
    """Step toward the solution of the enlarged set, stopping where a coefficient reaches zero."""
    while True:
        target = _solve(a, vector, ~held)
        negative = ~held & nonnegative & (target < 0)
        if not negative.any():
            return target, held
        share = np.min(c[negative] / (c[negative] - target[negative]))
        c = c + share * (target - c)
        held = held | (~held & nonnegative & (c <= 1e-15))
        c[held] = 0.0


def _solve(a: Array, vector: Array, free: Mask) -> Array:
    c: Array = np.zeros(free.size)
    if free.size and free.all():  # mostly
        c[:] = np.linalg.lstsq(a, vector, rcond=1e-14)[0]
    elif free.any():
        c[free] = np.linalg.lstsq(a[:, free], vector, rcond=1e-14)[0]
    return c
