"""RBFM, HEM, Seo-Seo and CCJ: erclutch and peers, on the same columns of the same law."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rows import Split
from task import Fit, Task
from watch import Predict

from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Reference, Structure

Array = NDArray[np.float64]

LAWS = {
    "rbfm": "rbfm-10/forward",
    "hem": "hem/forward",
    "seo-seo": "seo-seo/forward",
    "cho-choi-jhon": "cho-choi-jhon/forward",
}


def structure_of(task: Task) -> Structure:
    """The group's law for the twin's device."""
    name = LAWS[task.group]
    return Structure("coaxial", name, law_from_name(name, "coaxial"))


def matrix(
    structure: Structure, split: Split, reference: Reference, q: Sequence[float] = ()
) -> Array:
    """Columns of the law, shape (n, gains)."""
    return np.column_stack(structure.columns(split.data.elements, split.data.clock, reference, q))


def erclutch(task: Task) -> Predict:
    """Erclutch's own fit, without intervals; with its scan of starts."""
    found = fit_structure(task.train.data, structure_of(task), intervals=False)
    task.notes.append(f"{found.stop}, {len(found.at_bounds)} parameters on a bound")
    if task.group == "rbfm":
        task.check = partial(_against_qr, task, lambda split: found.model.predict(split.data))
    return lambda split: found.model.predict(split.data)


# --- RBFM: bounded linear least squares -------------------------------------------------------------------------------


def _linear(task: Task, structure: Structure, reference: Reference, gains: Array) -> Predict:
    def predict(split: Split) -> Array:
        return matrix(structure, split, reference) @ gains

    task.check = partial(_against_qr, task, predict)
    return predict


def _against_qr(task: Task, predict: Predict) -> None:
    """Note how far a prediction is from a QR on all rows, columns scaled; gains that cross a bound are held on it."""
    structure, y = structure_of(task), task.train.data.effort
    columns = matrix(structure, task.train, reference_of(task.train.data))
    bounded, held = np.isfinite(_lower(structure)), np.zeros(columns.shape[1], np.bool_)
    while True:
        gains = np.zeros(held.size)
        free = columns[:, ~held]
        scale = np.linalg.norm(free, axis=0)
        q, r = np.linalg.qr(free / scale)
        gains[~held] = np.linalg.solve(r, q.T @ y) / scale
        crossing = bounded & (gains < 0)
        if not crossing.any():
            break
        held |= crossing
    exact = columns @ gains
    apart = float(np.linalg.norm(predict(task.train) - exact) / np.linalg.norm(exact))
    task.notes.append(f"{apart:.1e} from a full QR with {int(held.sum())} gains held")


def _lower(structure: Structure) -> Array:
    return np.array([0.0 if gain.nonnegative else -np.inf for gain in structure.gains()])


def scipy_lsq_linear(task: Task, method: Any) -> Predict:
    """scipy.optimize.lsq_linear on all rows."""
    from scipy.optimize import lsq_linear

    task.watch.start()
    structure, reference = structure_of(task), reference_of(task.train.data)
    columns = matrix(structure, task.train, reference)
    found = lsq_linear(columns, task.train.data.effort, (_lower(structure), np.inf), method=method)
    task.notes.append(f"status {found.status}")
    return _linear(task, structure, reference, found.x)


def scipy_slsqp(task: Task) -> Predict:
    """Scipy's SLSQP on the normal equations."""
    from scipy.optimize import Bounds, minimize

    task.watch.start()
    structure, reference = structure_of(task), reference_of(task.train.data)
    columns, y = matrix(structure, task.train, reference), task.train.data.effort
    square, right, power = (
        columns.T @ columns / y.size,
        columns.T @ y / y.size,
        float(y @ y) / y.size,
    )
    found = minimize(
        lambda c: float(c @ square @ c - 2.0 * c @ right) + power,
        np.zeros(right.size),
        jac=lambda c: 2.0 * (square @ c - right),
        method="SLSQP",
        bounds=Bounds(_lower(structure), np.full(right.size, np.inf)),
        options={"ftol": 1e-14, "maxiter": 10_000},
    )
    task.notes.append(f"status {found.status}, {found.nit} iterations")
    return _linear(task, structure, reference, found.x)


# --- HEM, Seo-Seo and CCJ: all parameters at once, from one start -----------------------------------------------------


class Whole:
    """A law with all its parameters in one vector, nonlinear ones first, as a general solver sees it."""

    def __init__(self, task: Task) -> None:
        self.task, self.structure = task, structure_of(task)
        self.reference = reference_of(task.train.data)
        self.shapes = self.structure.shapes(self.reference.period)
        gains = len(self.structure.gains())
        self.lower = np.concatenate([[s.lower for s in self.shapes], _lower(self.structure)])
        self.upper = np.concatenate([[s.upper for s in self.shapes], np.full(gains, np.inf)])
        middle = [
            np.sqrt(s.lower * s.upper) if s.scale == "log" else 0.5 * sum(s.scanned)
            for s in self.shapes
        ]
        self.start = np.concatenate([middle, np.ones(gains)])

    def effort(self, p: Array, split: Split) -> Array:
        """Effort of a split's rows for parameters p."""
        count = len(self.shapes)
        return matrix(self.structure, split, self.reference, list(p[:count])) @ p[count:]

    def predict(self, p: Array) -> Predict:
        """Prediction with a copy of these parameters."""
        return partial(self.effort, np.array(p))

    def residual(self, p: Array) -> Array:
        """Residual on the training rows, looked at where the cost falls."""
        r = self.effort(p, self.task.train) - self.task.train.data.effort
        if self.task.watch.better(float(r @ r)):
            self.task.watch.look(self.predict(p))
        return r


def scipy_least_squares(task: Task) -> Predict:
    """scipy.optimize.least_squares with bounds, numerical derivatives and its default tolerances."""
    from scipy.optimize import least_squares

    task.watch.start()
    law = Whole(task)
    found = least_squares(law.residual, law.start, bounds=(law.lower, law.upper), x_scale="jac")
    task.notes.append(f"status {found.status}, {found.nfev} evaluations")
    return law.predict(found.x)


def lmfit_leastsq(task: Task) -> Predict:
    """Lmfit with bounds and its default method."""
    import lmfit

    task.watch.start()
    law = Whole(task)
    table = lmfit.Parameters()
    for i, (value, low, high) in enumerate(zip(law.start, law.lower, law.upper, strict=True)):
        table.add(f"p{i}", value=value, min=low, max=high)

    def vector(p: Any) -> Array:
        return np.array([p[f"p{i}"].value for i in range(law.start.size)])

    found = lmfit.minimize(lambda p: law.residual(vector(p)), table)
    task.notes.append(f"{found.nfev} evaluations")
    return law.predict(vector(found.params))


FITS: dict[str, Fit] = {
    "erclutch": erclutch,
    "scipy lsq_linear trf": partial(scipy_lsq_linear, method="trf"),
    "scipy lsq_linear bvls": partial(scipy_lsq_linear, method="bvls"),
    "scipy SLSQP": scipy_slsqp,
    "scipy least_squares trf": scipy_least_squares,
    "lmfit leastsq": lmfit_leastsq,
}
