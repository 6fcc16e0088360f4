"""The NIST StRD problems, solved with the project's own solver, derivatives and standard errors.

27 nonlinear regressions with certified answers, each from two starts: ``.dat`` files of
https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml. Digits are -log10 of the largest relative difference from a
certified number, at most 11. `studies/nist.py` prints the table.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.dual import partial_of, seed, value_of
from erclutch.fit.solver.intervals import uncertainty
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem, minimise

Array = NDArray[np.float64]

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data" / "nist_strd"
#: What counts as solved, and the one problem whose standard errors are out of reach: its certified residuals, 1e-13 of
#: the data, lie below the rounding of a double.
DIGITS = 6.0
ROUNDING = "Lanczos1"
#: First trust radius, in scaled norms of the start. From the solver's own default, 100, BoxBOD's first start leaps onto
#: its flat far side.
REACH = 10.0
#: Turning the signs of its height and its width leaves this function as it is; the certified answer has both positive.
MIRRORED = "Eckerle4"


def _gauss(b: Sequence[Any], x: Array) -> Any:
    first = b[2] * np.exp(-((x - b[3]) ** 2) / b[4] ** 2)
    return b[0] * np.exp(-b[1] * x) + first + b[5] * np.exp(-((x - b[6]) ** 2) / b[7] ** 2)


def _lanczos(b: Sequence[Any], x: Array) -> Any:
    return b[0] * np.exp(-b[1] * x) + b[2] * np.exp(-b[3] * x) + b[4] * np.exp(-b[5] * x)


def _chwirut(b: Sequence[Any], x: Array) -> Any:
    return np.exp(-b[0] * x) / (b[1] + b[2] * x)


def _cubics(b: Sequence[Any], x: Array) -> Any:
    return (b[0] + b[1] * x + b[2] * x**2 + b[3] * x**3) / (
        1 + b[4] * x + b[5] * x**2 + b[6] * x**3
    )


def _enso(b: Sequence[Any], x: Array) -> Any:
    def wave(cosine: Any, sine: Any, period: Any) -> Any:
        angle = 2 * np.pi * x / period
        return cosine * np.cos(angle) + sine * np.sin(angle)

    return b[0] + wave(b[1], b[2], 12.0) + wave(b[4], b[5], b[3]) + wave(b[7], b[8], b[6])


#: ``model(b, x)``: the response; x is (n,), and (2, n) for Nelson, whose response is the logarithm of the data.
MODELS: dict[str, Callable[[Sequence[Any], Array], Any]] = {
    "Bennett5": lambda b, x: b[0] * (b[1] + x) ** (-1 / b[2]),
    "BoxBOD": lambda b, x: b[0] * (1 - np.exp(-b[1] * x)),
    "Chwirut1": _chwirut,
    "Chwirut2": _chwirut,
    "DanWood": lambda b, x: b[0] * x ** b[1],
    "ENSO": _enso,
    "Eckerle4": lambda b, x: b[0] / b[1] * np.exp(-0.5 * ((x - b[2]) / b[1]) ** 2),
    "Gauss1": _gauss,
    "Gauss2": _gauss,
    "Gauss3": _gauss,
    "Hahn1": _cubics,
    "Kirby2": lambda b, x: (b[0] + b[1] * x + b[2] * x**2) / (1 + b[3] * x + b[4] * x**2),
    "Lanczos1": _lanczos,
    "Lanczos2": _lanczos,
    "Lanczos3": _lanczos,
    "MGH09": lambda b, x: b[0] * (x**2 + x * b[1]) / (x**2 + x * b[2] + b[3]),
    "MGH10": lambda b, x: b[0] * np.exp(b[1] / (x + b[2])),
    "MGH17": lambda b, x: b[0] + b[1] * np.exp(-x * b[3]) + b[2] * np.exp(-x * b[4]),
    "Misra1a": lambda b, x: b[0] * (1 - np.exp(-b[1] * x)),
    "Misra1b": lambda b, x: b[0] * (1 - (1 + b[1] * x / 2) ** -2.0),
    "Misra1c": lambda b, x: b[0] * (1 - (1 + 2 * b[1] * x) ** -0.5),
    "Misra1d": lambda b, x: b[0] * b[1] * x / (1 + b[1] * x),
    "Nelson": lambda b, x: b[0] - b[1] * x[0] * np.exp(-b[2] * x[1]),
    "Rat42": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)),
    "Rat43": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)) ** (1 / b[3]),
    "Roszman1": lambda b, x: b[0] - b[1] * x - np.arctan(b[2] / (x - b[3])) / np.pi,
    "Thurber": _cubics,
}


@dataclass(frozen=True)
class Certified:
    """A problem with its certified answers.

    Attributes:
        x: predictor, shape (n,), or (2, n).
        y: response, shape (n,).
        starts: the two points to start from, each (p,).
        values, errors: certified parameters and their standard errors, shape (p,).
    """

    x: Array
    y: Array
    starts: tuple[Array, Array]
    values: Array
    errors: Array


@dataclass(frozen=True)
class Solved:
    """How one start went: digits of parameters and of standard errors, and the steps tried."""

    digits: float
    error_digits: float
    iterations: int


def read(name: str, folder: Path = FOLDER) -> Certified:
    """A problem out of its ``.dat`` file, which says itself on which lines its data are."""
    lines = (folder / f"{name}.dat").read_text(encoding="ascii").splitlines()
    found = (re.match(r"\s*Data\s+\(lines\s+(\d+)\s+to\s+(\d+)\)", line) for line in lines)
    first, last = next((int(m[1]), int(m[2])) for m in found if m)
    response, *predictors = _columns(lines[first - 1 : last])
    one, two, values, errors = _columns(
        [line.split("=")[1] for line in lines if re.match(r"\s*b\d+\s*=", line)]
    )
    if name == "Nelson":
        return Certified(np.stack(predictors), np.log(response), (one, two), values, errors)
    return Certified(predictors[0], response, (one, two), values, errors)


def _columns(lines: Sequence[str]) -> list[Array]:
    return [
        np.array(column, np.float64)
        for column in zip(*(line.split() for line in lines), strict=True)
    ]


def jacobian_of(name: str, problem: Certified, b: Array) -> tuple[Array, Array]:
    """Derivatives of the response by the parameters, shape (n, p), and the residual, shape (n,)."""
    with np.errstate(all="ignore"):
        response = MODELS[name](seed(b), problem.x)
        slopes = [np.broadcast_to(partial_of(response, i), problem.y.shape) for i in range(b.size)]
        return np.column_stack(slopes), problem.y - value_of(response)


def solve(name: str, problem: Certified, start: Array, reach: float = REACH) -> Solved:
    """Solve a problem from a start."""
    p = start.size

    def cost(b: Array) -> float:
        with np.errstate(all="ignore"):
            residual = problem.y - MODELS[name](list(b), problem.x)
            return float(residual @ residual)

    def linearise(b: Array) -> Linearisation:
        slopes, residual = jacobian_of(name, problem, b)
        triangle = np.asarray(np.linalg.qr(np.column_stack([slopes, residual]), mode="r"))
        return Linearisation(float(residual @ residual), triangle[:p, :p], triangle[:p, p])

    free = np.full(p, np.inf)
    found = minimise(
        Problem(cost, linearise, -free, free),
        start,
        tolerance=1e-14,
        max_iterations=5000,
        reach=reach,
    )
    spread = uncertainty(*jacobian_of(name, problem, found.point), ordered=False)
    values = np.abs(found.point) if name == MIRRORED else found.point
    return Solved(
        digits(values, problem.values), digits(spread.errors, problem.errors), found.iterations
    )


def digits(found: Array, certified: Array) -> float:
    """Correct digits of the worst of some numbers, 0 to 11."""
    share = float(np.max(np.abs(found - certified) / np.abs(certified)))
    return float(np.clip(-np.log10(max(share, 1e-11)), 0.0, 11.0)) if np.isfinite(share) else 0.0
