"""Confidence intervals of parameters allow for residuals that are correlated in time.

The sandwich of R^-1 around the long-run covariance of the scores (Newey and West 1987, doi 10.2307/1913610), Bartlett
kernel, bandwidth after Andrews (1991, doi 10.2307/2938229), critical values for that bandwidth after Kiefer and
Vogelsang (2005, doi 10.1017/S0266466605050565). That covariance is too small where the residual resonates at the pace
of the motion: few scores then stand for all. So a variance is no less than by the spectrum of the residual at the
frequencies of what tells the parameter. Without an order in time (flow curves) the classical covariance and Student's
t.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from erclutch.fit.solver.variable_projection import triangle_of
from erclutch.signals.array import Array, Mask

_ORDERS = 6  # of the autoregression that whitens a score, at most
_NEAR_ROOT = 0.97  # sum of its coefficients, at most: beyond, a score wanders


@dataclass(frozen=True)
class Uncertainty:
    """Standard errors of the columns of a Jacobian.

    Attributes:
        errors: standard error a parameter, shape (p,); infinite where the data do not identify it.
        covariance: shape (p, p); rows of unidentified parameters are infinite.
        quantile: half width of the 95 % interval in standard errors, a parameter, shape (p,).
        rank: numerical rank of the Jacobian, columns scaled to one.
        condition: ratio of its largest and smallest singular value.
        bandwidth: of the long-run covariance, in rows, after whitening; 1 where rows have no order.
        widened: by how much the spectrum of the residual has widened each standard error, shape (p,); 1: not at all.
    """

    errors: Array
    covariance: Array
    quantile: Array
    rank: int
    condition: float
    bandwidth: int
    widened: Array


def unknown(jacobian: Array, rows: int | None = None) -> Uncertainty:
    """Rank and condition alone; standard errors are nan. ``rows``: of the Jacobian that a triangle stands for."""
    n = rows or int(jacobian.shape[0])
    p = int(jacobian.shape[1])
    norms = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(norms > 0, norms, 1.0)
    s: Any = np.linalg.svd(triangle_of(scaled), compute_uv=False)
    solid = _solid(s, max(n, p))
    rank = int(np.count_nonzero(solid))
    return Uncertainty(
        errors=np.full(p, np.nan),
        covariance=np.full((p, p), np.nan),
        quantile=np.full(p, 1.96),
        rank=rank,
        condition=_condition(s, rank, p),
        bandwidth=1,
        widened=np.ones(p),
    )


def uncertainty(jacobian: Array, residual: Array, *, ordered: bool) -> Uncertainty:
    """Standard errors of parameters from the Jacobian and the residual at the optimum.

    Args:
        jacobian: derivatives of the prediction by the parameters, shape (n, p).
        residual: measured minus predicted, shape (n,).
        ordered: whether rows follow in time, so that neighbours may be correlated.
    """
    n, p = jacobian.shape
    norms = np.linalg.norm(jacobian, axis=0)
    usable = np.where(norms > 0, norms, 1.0)
    q, r = np.linalg.qr(jacobian / usable)
    left, s, right = np.linalg.svd(r)
    solid = _solid(s, max(n, p))
    rank = int(np.count_nonzero(solid))

    # Pseudo-inverse over the identified directions; a parameter with a part outside of them is not identified.
    inverted = np.where(solid, 1.0 / np.where(solid, s, 1.0), 0.0)
    inverse = (right.T[:, : s.size] * inverted) @ left.T
    nowhere = np.vstack([right[: s.size][~solid], right[s.size :]])
    shares_lost = np.linalg.norm(nowhere, axis=0)
    lost = (shares_lost > 1e-6) | (norms == 0)

    freedom = np.full(p, max(n - p, 1.0))  # degrees, of each parameter
    share = np.zeros(p)  # of what tells a parameter, within one bandwidth
    widened = np.ones(p)
    if ordered and n > 4 * p + 40:
        # What each row adds to the error of each parameter, scaled to one: sums of scores would cancel each other.
        influence = q @ inverse.T
        added = influence * residual[:, None]
        scale = np.linalg.norm(added, axis=0)
        scale[scale == 0] = 1.0
        middle, bandwidth = long_run(added / scale)
        # Neighbours of a swinging residual cancel, but not in the scores of a parameter whose effect swings too. Each
        # parameter has its own independent rows: those that tell one badly take no freedom from the others.
        alike = np.maximum(np.diag(middle), correlated_rows(residual))  # rows as one, shape (p,)
        independent = np.maximum(n / alike, 2.0 * p)
        freedom = np.maximum(independent - p, 1.0)
        scale *= np.sqrt(independent / freedom)
        by_scores = np.sqrt(np.diag(middle)) * scale  # standard errors

        # The same if the residual is an autoregression: its spectrum, weighted by the power of the influence at each
        # frequency. Few coefficients resolve its peaks, where sums of scores would need many turns of a slow resonance.
        weights, unexplained = _autoregressions(residual[:, None])
        drive = float(unexplained[0]) * float(np.mean(residual**2))  # variance that is new in a row
        points = 1 << (2 * n - 1).bit_length()  # so many that the ends of the log do not meet
        gain = np.fft.rfft(np.concatenate([[1.0], -weights[:, 0]]), points)
        spectrum = drive / np.maximum(np.abs(gain) ** 2, np.finfo(float).tiny)
        spectrum[1:-1] *= 2.0  # frequencies below zero
        variances: list[float] = []
        for column in influence.T:
            power = np.abs(np.fft.rfft(column, points)) ** 2
            variances.append(float(power @ spectrum) / points)
        by_spectrum = np.sqrt(np.array(variances))
        widened = np.maximum(by_spectrum / np.where(by_scores > 0, by_scores, 1.0), 1.0)
        scale *= widened
        covariance = middle * np.outer(scale, scale)
        # The bandwidth is such a share of the rows where all rows tell a parameter alike. What few rows tell, as the
        # slip over which friction turns, has as few scores to estimate a variance by.
        square = influence**2
        told = square / np.maximum(square.sum(axis=0), np.finfo(float).tiny)
        share = np.diag(_bartlett(told, bandwidth))
    else:
        covariance = inverse @ inverse.T * float(residual @ residual) / max(n - p, 1.0)
        bandwidth = 1
    covariance /= np.outer(usable, usable)
    covariance[lost, :] = np.inf
    covariance[:, lost] = np.inf
    squares = np.maximum(np.diag(covariance), 0.0)
    return Uncertainty(
        errors=np.sqrt(squares),
        covariance=covariance,
        quantile=fixed_bandwidth_quantile(freedom, share),
        rank=rank,
        condition=_condition(s, rank, p),
        bandwidth=bandwidth,
        widened=widened,
    )


def _solid(singular: Array, size: int) -> Mask:
    """Which directions stand out of rounding, by singular values (p,), the largest first, of a matrix of that size."""
    if not singular.size or not singular[0] > 0:
        return np.zeros(singular.size, np.bool_)
    rounding = singular[0] * size * np.finfo(float).eps
    return singular > rounding


def _condition(singular: Array, rank: int, columns: int) -> float:
    """Ratio of the largest and the smallest singular value; infinite where a direction is lost in rounding."""
    if not columns:
        return 1.0
    if rank < columns:
        return np.inf
    return float(singular[0] / singular[-1])


def bandwidth_of(scores: Array) -> int:
    """Rows over which the columns of an array (n, p) are correlated: Andrews' plug-in for the Bartlett kernel."""
    before = scores[:-1]
    after = scores[1:]
    power = np.sum(before * before, axis=0)
    keep = power > 0
    if not keep.any():
        return 1
    # Andrews (1991), equations 6.2 and 6.4: an autoregression of order one in each column.
    products = np.sum(before * after, axis=0)
    coefficients = products / np.where(power > 0, power, 1.0)
    rho = np.clip(coefficients[keep], -0.97, 0.9999)
    innovation = after[:, keep] - rho * before[:, keep]
    weight = np.var(innovation, axis=0) ** 2
    whole = float(np.sum(weight / (1 - rho) ** 4))
    if not whole > 0.0:  # a perfect fit: what is left is rounding
        return 1
    poles = (1 - rho) ** 6 * (1 + rho) ** 2
    curved = 4 * rho**2 * weight / poles
    alpha = np.sum(curved) / whole
    rows = scores.shape[0]
    best = np.ceil(1.1447 * (alpha * rows) ** (1 / 3))
    return int(np.clip(best, 1, max(rows // 5, 1)))


def long_run(scores: Array) -> tuple[Array, int]:
    """Long-run covariance of the columns of an array (n, p), summed over its rows, and the bandwidth that it took.

    An autoregression of its own whitens each column first, which takes away most of the kernel's bias (Andrews and
    Monahan 1992, doi 10.2307/2951574). Its order is chosen by Schwarz's criterion (den Haan and Levin 1997,
    doi 10.1016/S0169-7161(97)15014-0): a score that swings with its input needs two at least.
    """
    weights, _ = _autoregressions(scores)  # (order, p)
    whole = weights.sum(axis=0)
    shrunk = _NEAR_ROOT / np.where(whole > 0, whole, 1.0)
    weights *= np.where(whole > _NEAR_ROOT, shrunk, 1.0)
    order = weights.shape[0]
    n = scores.shape[0]
    explained: Any = 0  # by the rows before
    for back, weight in enumerate(weights, 1):
        explained = explained + weight * scores[order - back : n - back]
    white = scores[order:] - explained
    # An autoregression does not see bursts.
    bandwidth = max(bandwidth_of(white), round(n ** (1 / 3)))
    recolour = 1.0 / (1.0 - weights.sum(axis=0))
    covariance = _bartlett(white, bandwidth) * np.outer(recolour, recolour)
    return covariance, bandwidth


def _autoregressions(scores: Array) -> tuple[Array, Array]:
    """Coefficients of the best autoregression of each column of (n, p), shape (orders, p), by Levinson's recursion.

    Beside them the share of the power that each leaves unexplained, shape (p,).
    """
    n, p = scores.shape
    covariances: list[Array] = []  # of each shift, times n
    for shift in range(_ORDERS + 1):
        products = np.einsum("tj,tj->j", scores[: n - shift], scores[shift:])
        covariances.append(products)
    power = np.where(covariances[0] > 0, covariances[0], 1.0)
    correlation = np.array(covariances) / power  # (orders + 1, p)

    weights = np.zeros((_ORDERS, p))
    best = np.zeros((_ORDERS, p))
    left = np.ones(p)  # share of the power that the autoregression does not explain
    unexplained = np.ones(p)  # the same of the best one
    least = np.zeros(p)  # Schwarz's criterion of the best one; that of order zero is zero
    for k in range(_ORDERS):
        of_shorter = weights[:k] * correlation[k:0:-1]
        explained = np.sum(of_shorter, axis=0)
        reflection = (correlation[k + 1] - explained) / left
        weights[:k] -= reflection * weights[:k][::-1]
        weights[k] = reflection
        left = np.maximum(left * (1.0 - reflection**2), 1e-12)
        criterion = n * np.log(left) + (k + 1) * np.log(n)
        better = criterion < least
        least = np.where(better, criterion, least)
        best = np.where(better, weights, best)
        unexplained = np.where(better, left, unexplained)
    return best, unexplained


def _bartlett(scores: Array, bandwidth: int) -> Array:
    """Sum over lags |j| < bandwidth of (1 - |j| / bandwidth) autocovariances, by sums over windows."""
    columns = scores.shape[1]
    ahead = np.zeros((bandwidth, columns))
    behind = np.zeros((bandwidth - 1, columns))
    padded = np.concatenate([ahead, scores, behind])
    total = np.cumsum(padded, axis=0)
    windows = total[bandwidth:] - total[:-bandwidth]
    return windows.T @ windows / bandwidth


def fixed_bandwidth_quantile(freedom: Array, share: Array) -> Array:
    """Kiefer and Vogelsang's polynomial for a bandwidth that is such a share of the rows, wider as Student's t is."""
    from scipy.special import stdtrit

    fixed = 1.9600 + 2.9694 * share + 0.4160 * share**2 - 0.5324 * share**3
    return stdtrit(freedom, 0.975) * fixed / 1.9600


def correlated_rows(residual: Array) -> float:
    """How many rows carry the information of one independent row: 1 for white residuals."""
    centred = residual - residual.mean()
    variance = float(centred @ centred)
    if variance == 0.0 or residual.size < 50:
        return 1.0
    covariance, _ = long_run(centred[:, None])
    return float(max(covariance[0, 0] / variance, 1.0))


def as_json(value: float) -> Any:
    """A number for JSON, which has no infinity: None stands for "not identified"."""
    return value if np.isfinite(value) else None
