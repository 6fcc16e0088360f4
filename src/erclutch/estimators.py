"""scikit-learn estimators wrap each model with ``fit``, ``predict`` and ``score``, for pipelines and grids.

`LawRegressor` takes columns in the order of its device: field and slip for a single one; E1, E2, theta_dot, alpha_dot
for the coaxial pair; further columns are left alone. Of a DataFrame with these names, with or without units
(``slip [m/s]``), it takes the columns by name, in any order. `FnnRegressor` and `RbfnRegressor` take every column as an
input. A law needs field and slip as they were logged: scaling may be part of a pipeline with a network, not with a law.
Rows of a log follow in time, so split them in blocks (`sklearn.model_selection.TimeSeriesSplit`), never shuffled.

Needs scikit-learn: ``pip install "erclutch[sklearn]"``.
"""

# scikit-learn carries no types.
# pyright: basic

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from erclutch.signals.array import Array

try:
    from sklearn.base import BaseEstimator, RegressorMixin
    from sklearn.utils.validation import check_is_fitted, validate_data
except ImportError as missing:
    raise ImportError(
        'erclutch.estimators needs scikit-learn: pip install "erclutch[sklearn]"'
    ) from missing

from erclutch.errors import SettingError
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks.fit_fnn import Training
from erclutch.fit.networks.fit_network import learn, scaling_of
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.networks import NetworkStructure, network_from_name
from erclutch.models.networks.forward import forward_fnn, forward_rbfn
from erclutch.models.stages import stages_of
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Units, elements_of

_COLUMNS = {"single": ("field", "slip"), "coaxial": ("E1", "E2", "theta_dot", "alpha_dot")}
# Distances from a mean of 0 and from a deviation of 1 that no raw columns have, all of them at once.
_CENTRED = 1e-6
_SCALED = 1e-3


@dataclass(eq=False, repr=False)
class LawRegressor(RegressorMixin, BaseEstimator):
    """A law of `erclutch laws` as an estimator.

    Args:
        law: specification, for example ``bingham``, ``hem/square`` or ``rbfm-10/forward``.
        device: "single" or "coaxial": which columns there are.
        dynamics: "none", or stages joined by ``+``, for example "lag" or "lag+dahl/field"; rows then follow in time,
            ``period`` apart, and each array starts with the fluid at rest.
        friction: a friction effort at zero field.
        offset: a constant effort.
        period: sampling period in s.

    Attributes:
        outcome_: the fit with its parameters and intervals.
        model_: the `TorqueModel`.
    """

    law: str = "bingham"
    device: str = "single"
    dynamics: str = "none"
    friction: bool = False
    offset: bool = False
    period: float = 1e-3

    def fit(self, X: Any, y: Any) -> LawRegressor:
        """Fit the law's parameters by least squares.

        Args:
            X: columns of the device, shape (n, columns).
            y: effort, shape (n,).

        Raises:
            ValueError: columns are missing, or values are not finite.
            SettingError: an unknown law, device or dynamics; a DataFrame with the names of some columns alone.

        Warns:
            UserWarning: all columns look standardised, or scaled to 0 .. 1.
        """
        if self.device not in _COLUMNS:
            raise SettingError(f"device {self.device!r}", remedy="Give single or coaxial")
        stages_of(self.dynamics)
        X = self._by_name(X)
        X, y = validate_data(
            self,
            X,
            y,
            dtype=np.float64,
            y_numeric=True,
            ensure_min_samples=2,
            ensure_min_features=len(_COLUMNS[self.device]),
        )
        self._warn_of_scaling(X)
        device = cast(DeviceName, self.device)
        law = law_from_name(self.law, device)
        structure = Structure(device, self.law, law, self.dynamics, self.friction, self.offset)
        data = self._rows(X, np.asarray(y, np.float64))
        self.outcome_ = fit_structure(data, structure)
        self.model_ = self.outcome_.model
        return self

    def predict(self, X: Any) -> Array:
        """Effort, shape (n,); warns as `fit` does."""
        check_is_fitted(self)
        X = validate_data(self, self._by_name(X), dtype=np.float64, reset=False)
        self._warn_of_scaling(X)
        return self.model_.predict(self._rows(X, np.zeros(X.shape[0])))

    def _by_name(self, X: Any) -> Any:
        """The device's columns of a DataFrame that names them; anything else as it is."""
        labels = {
            str(label).partition("[")[0].strip(): label for label in getattr(X, "columns", ())
        }
        wanted = _COLUMNS[self.device]
        missing = [name for name in wanted if name not in labels]
        if len(missing) == len(wanted):
            return X
        if missing:
            there = [name for name in wanted if name in labels]
            raise SettingError(
                f"no column {', '.join(missing)} beside {', '.join(there)}",
                remedy=f"Name all columns: {', '.join(wanted)}",
            )
        return X[[labels[name] for name in wanted]]

    def _warn_of_scaling(self, X: Array) -> None:
        """Warn of columns that a scaler has moved: a law knows zero field and rest by their zeros."""
        own = X[:, : len(_COLUMNS[self.device])]

        def all_near(values: Array, wanted: float, slack: float) -> bool:
            return bool(np.all(np.abs(values - wanted) < slack))

        standard = all_near(own.mean(0), 0.0, _CENTRED) and all_near(own.std(0), 1.0, _SCALED)
        ranged = all_near(own.min(0), 0.0, _CENTRED) and all_near(own.max(0), 1.0, _CENTRED)
        if standard or ranged:
            how = "standardised (mean 0, deviation 1)" if standard else "scaled to 0 .. 1"
            warnings.warn(
                f"the columns {', '.join(_COLUMNS[self.device])} look {how}: a law needs field and slip as they were "
                "logged; leave the scaler out",
                stacklevel=3,
            )

    def _rows(self, X: Array, y: Array) -> Dataset:
        """Columns and effort as a data set without gaps, in units as logged."""
        device = cast(DeviceName, self.device)
        signals = {name: X[:, i] for i, name in enumerate(_COLUMNS[device])}
        rows = X.shape[0]
        clock = Clock(np.arange(rows) * self.period, (Span(0, rows, self.period),))
        return Dataset(device, elements_of(device, signals), y, clock, Units("?", "?", "?"))

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.regressor_tags.poor_score = True  # a law of two columns cannot learn just anything
        return tags


class _Network(RegressorMixin, BaseEstimator, ABC):
    """What the networks share: normalisation, training, prediction on any columns."""

    seed: int
    polish: bool
    n_jobs: int | None

    @abstractmethod
    def _structure(self) -> NetworkStructure: ...

    def fit(self, X: Any, y: Any) -> _Network:
        """Train the weights by least squares.

        Args:
            X: inputs, shape (n, inputs).
            y: effort, shape (n,).

        Raises:
            ValueError: values that are not finite.
            SettingError: a size that cannot be.
        """
        structure = self._structure()
        X, y = validate_data(self, X, y, dtype=np.float64, y_numeric=True, ensure_min_samples=2)
        x = np.ascontiguousarray(X.T)
        target = np.asarray(y, np.float64)
        self.scaling_ = scaling_of(x, target, structure.kind)
        training = Training(self.seed, self.polish, workers=self.n_jobs or 1)
        with one_thread():
            self.weights_, self.stop_, self.n_iter_ = learn(
                (x, target), self.scaling_, structure, training
            )
        return self

    def predict(self, X: Any) -> Array:
        """Effort, shape (n,)."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=np.float64, reset=False)
        forward = forward_fnn if "W_out" in self.weights_ else forward_rbfn
        unit = forward(self.weights_, self.scaling_.inputs(X.T))
        return unit * self.scaling_.effort_scale + self.scaling_.effort_offset


@dataclass(eq=False, repr=False)
class FnnRegressor(_Network):
    """A feedforward network (equation 19 of Huang and Ishikawa), trained by Levenberg-Marquardt.

    Args:
        hidden: neurons of each hidden layer.
        seed: of the starts.
        polish: whether the last steps run over all rows instead of centroids.
        n_jobs: starts side by side; changes no figure.

    Attributes:
        weights_: tables W1, b1, ..., W_out, b_out in normalised units.
        scaling_: the normalisation.
        n_iter_: steps of all starts.
    """

    hidden: tuple[int, ...] = (16,)
    seed: int = 0
    polish: bool = False
    n_jobs: int | None = None

    def _structure(self) -> NetworkStructure:
        return network_from_name("-".join(["fnn", *(str(n) for n in self.hidden)]))


@dataclass(eq=False, repr=False)
class RbfnRegressor(_Network):
    """A radial basis function network (equation 17 of Huang and Ishikawa).

    Args:
        neurons: number of centres.
        centres: forward (orthogonal forward selection), kmeans, refined, or spreads (refined, one spread a neuron).
        seed: of the candidates or first centres.
        polish: whether a refinement runs on the finest grid.
        n_jobs: for scikit-learn's sake.

    Attributes:
        weights_: tables centres, spreads, w, b in normalised units.
        scaling_: the normalisation.
        n_iter_: steps of a refinement; 0 without.
    """

    neurons: int = 20
    centres: str = "forward"
    seed: int = 0
    polish: bool = False
    n_jobs: int | None = None

    def _structure(self) -> NetworkStructure:
        return network_from_name(f"rbfn-{self.neurons}/{self.centres}")
