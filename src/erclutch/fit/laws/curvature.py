"""The curvature that Gauss and Newton leave out is learned from the gradients of successive steps.

Where residuals stay large, as those of a law beside a real device do, a step of Gauss and Newton can be too long by a
fixed factor, and the solver goes back and forth across the valley. The secant matrix S of Dennis, Gay and Welsch (1981,
doi 10.1145/355958.355965) holds what is missing: R'R + S is the curvature that the gradients have shown.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem
from erclutch.signals.array import Array


def with_curvature(problem: Problem) -> Problem:
    """A problem for one run of the solver, whose local models have the curvature learned on the way."""
    learned = _Secant(problem.lower.size)

    def linearise(u: Array) -> Linearisation:
        return learned.corrected(u, problem.linearise(u))

    return replace(problem, linearise=linearise)


class _Secant:
    def __init__(self, size: int) -> None:
        self.matrix = np.zeros((size, size))
        self.last: tuple[Array, Array] | None = None

    def corrected(self, u: Array, model: Linearisation) -> Linearisation:
        """The local model with R'R + S in place of R'R, where that is a valley."""
        square = model.triangle.T @ model.triangle
        gradient = -model.triangle.T @ model.vector
        if self.last is not None:
            step = u - self.last[0]
            turn = gradient - self.last[1]
            self._learn(step, turn, square)
        self.last = u, gradient
        try:
            triangle = np.linalg.cholesky(square + self.matrix).T
        except np.linalg.LinAlgError:
            return model
        vector = -np.linalg.solve(triangle.T, gradient)
        return replace(model, triangle=triangle, vector=vector)

    def _learn(self, step: Array, turned: Array, square: Array) -> None:
        """The symmetric matrix nearest to S with which R'R + S turns the gradient as seen."""
        along = float(step @ turned)
        if not along > 0.0:
            return
        missing = turned - square @ step
        known = float(step @ self.matrix @ step)
        size = min(1.0, abs(float(step @ missing) / known)) if known else 1.0
        self.matrix *= size
        off = missing - self.matrix @ step
        outer = np.outer(off, turned)
        twice = float(step @ off) * np.outer(turned, turned)  # in both of the products above
        self.matrix += (outer + outer.T) / along - twice / along**2
