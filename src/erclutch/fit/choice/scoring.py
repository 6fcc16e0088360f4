"""A score says how good a model is on rows that it has not seen, with a band for figures of so few independent rows.

Bands are 95 % intervals of a circular block bootstrap: residuals of neighbouring rows are alike, so blocks of rows are
drawn, and the same blocks for two models that are compared. A length with the least error of the variance is too short
for bands that hold, and the variance of few blocks is itself uncertain (Sun, Phillips and Jin 2008,
doi 10.1111/j.0012-9682.2008.00822.x). So blocks are twice as long, and bands as much wider as Student's t.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.solver.intervals import bandwidth_of, correlated_rows
from erclutch.signals.array import Array, largest_of_windows, largest_size, rms

_RESAMPLES = 1000
_LARGEST_RATIO = 1e300  # of mean squares: quantiles take no infinity
_LONGER = 2  # times the length with the least error of the variance
_MOST_BLOCKS = 1000


@dataclass(frozen=True)
class BandedFigure:
    """A figure with its 95 % band."""

    value: float
    low: float
    high: float

    def to_list(self) -> list[float]:
        """Value, low, high."""
        return [self.value, self.low, self.high]


@dataclass(frozen=True)
class Score:
    """Figures of a model on some rows.

    Attributes:
        rows: number of rows.
        mse: mean squared error, in the effort's unit squared.
        rmse: its root.
        share: rmse over the standard deviation of the measured effort on these rows.
        r2: 1 - mse over the variance.
        largest: largest absolute error.
        bias: mean error (measured minus predicted); no band.
    """

    rows: int
    mse: BandedFigure
    rmse: BandedFigure
    share: BandedFigure
    r2: BandedFigure
    largest: BandedFigure
    bias: float

    def to_dict(self) -> dict[str, Any]:
        """As JSON values."""
        return {
            "rows": self.rows,
            "bias": self.bias,
            "mse": self.mse.to_list(),
            "rmse": self.rmse.to_list(),
            "share": self.share.to_list(),
            "r2": self.r2.to_list(),
            "largest": self.largest.to_list(),
        }


def block_rows(residuals: Sequence[Array]) -> int:
    """Length of a bootstrap block in rows, by the longest correlation of the squared residuals of any model."""
    rows = residuals[0].size
    shortest = max(1, -(-rows // _MOST_BLOCKS))  # rounded up
    longest = max(1, rows // 4)
    longer = _LONGER * correlated_over(residuals)
    return int(np.clip(longer, shortest, longest))


def correlated_over(residuals: Sequence[Array]) -> int:
    """Rows over which the squared residuals of any model are correlated."""
    bandwidths: list[int] = []
    for residual in residuals:
        square = residual * residual
        centred = square - np.mean(square)
        bandwidths.append(bandwidth_of(centred[:, None]))
    return max(bandwidths)


def block_starts(rows: int, block: int, seed: int) -> NDArray[np.int64]:
    """First rows of the blocks of each resample, shape (resamples, blocks).

    Blocks wrap around the end, so that every row is drawn equally often (Politis and Romano 1992).
    """
    rng = np.random.default_rng(seed)
    blocks = max(1, round(rows / block))
    return rng.integers(0, rows, size=(_RESAMPLES, blocks))


def score(
    measured: Array,
    predicted: Array,
    *,
    block: int | None = None,
    seed: int = 0,
) -> Score:
    """Figures with bands.

    Args:
        measured: effort, shape (n,).
        predicted: effort of the model, shape (n,).
        block: rows of a bootstrap block; None takes it from these residuals.
        seed: of the resampling.
    """
    error = measured - predicted
    rows = error.size
    if not np.all(np.isfinite(error)):
        return _not_finite(rows)
    length = block or block_rows([error])
    starts = block_starts(rows, length, seed)
    # Around the mean: sums of squares of a far-off effort would cancel.
    effort: Array = measured - np.mean(measured)
    square = error * error
    effort_square = effort * effort

    # Mean square of the error and variance of the effort: over all rows, and in each resample.
    mse = float(np.mean(square))
    spread = float(np.mean(effort_square)) or np.finfo(float).tiny
    mses = _resampled(square, length, starts)
    means = _resampled(effort, length, starts)
    mean_squares = _resampled(effort_square, length, starts)
    spreads = np.maximum(mean_squares - means * means, np.finfo(float).tiny)
    maxima = _block_maxima(np.abs(error), length)
    largest = maxima[starts].max(axis=1)
    largest_error = largest_size(error)
    return _banded(
        rows,
        mse,
        spread,
        mses,
        spreads,
        blocks=starts.shape[1],
        largest=BandedFigure(largest_error, *_middle(largest)),
        bias=float(error.mean()),
    )


def _not_finite(rows: int) -> Score:
    """The score of a model with an error that is not finite."""
    worst = BandedFigure(np.inf, np.inf, np.inf)
    worst_r2 = BandedFigure(-np.inf, -np.inf, -np.inf)
    return Score(
        rows=rows,
        mse=worst,
        rmse=worst,
        share=worst,
        r2=worst_r2,
        largest=worst,
        bias=np.inf,
    )


def _banded(
    rows: int,
    mse: float,
    spread: float,
    mses: Array,
    spreads: Array,
    *,
    blocks: int,
    largest: BandedFigure,
    bias: float,
) -> Score:
    """A score of the mean square of the error and the variance of the effort, each with its resamples (resamples,)."""
    ratio = min(mse / spread, _LARGEST_RATIO)
    with np.errstate(over="ignore"):  # an effort that stands still in a resample
        ratios = np.minimum(mses / spreads, _LARGEST_RATIO)
    return Score(
        rows=rows,
        mse=_figure(mse, mses, blocks, least=0.0),
        rmse=_figure(mse**0.5, np.sqrt(mses), blocks, least=0.0),
        share=_figure(ratio**0.5, np.sqrt(ratios), blocks, least=0.0),
        r2=_figure(1.0 - ratio, 1.0 - ratios, blocks, most=1.0),
        largest=largest,
        bias=bias,
    )


@dataclass(frozen=True)
class BinSums:
    """Sums over bins, which are short stretches of rows, for more rows than memory holds; each of shape (bins,).

    Attributes:
        rows: number of rows.
        error, square: sum of the errors (measured minus predicted), and of their squares.
        largest: largest absolute error.
        effort, effort_square: sum of the measured effort less a constant near its mean, and of its squares.
    """

    rows: Array
    error: Array
    square: Array
    largest: Array
    effort: Array
    effort_square: Array


def score_of_bins(sums: BinSums, *, seed: int = 0) -> Score:
    """Figures with bands as `score` gives them, from sums over bins in the order of the rows; blocks hold whole bins.

    Args:
        sums: of at least one bin.
        seed: of the resampling.
    """
    rows = float(sums.rows.sum())
    if not np.all(np.isfinite(sums.square)):
        return _not_finite(int(rows))
    length = block_rows([np.sqrt(sums.square / sums.rows)])  # bins of a block
    starts = block_starts(sums.rows.size, length, seed)
    tiny = np.finfo(float).tiny

    # Over all rows.
    mse = float(sums.square.sum()) / rows
    mean = float(sums.effort.sum()) / rows
    mean_square = float(sums.effort_square.sum()) / rows
    spread = max(mean_square - mean * mean, float(tiny))
    # In each resample.
    rows_of_bin = _resampled(sums.rows, length, starts)
    mses = _resampled(sums.square, length, starts) / rows_of_bin
    means = _resampled(sums.effort, length, starts) / rows_of_bin
    mean_squares = _resampled(sums.effort_square, length, starts) / rows_of_bin
    spreads = np.maximum(mean_squares - means * means, tiny)
    largest = _block_maxima(sums.largest, length)[starts].max(axis=1)
    return _banded(
        int(rows),
        mse,
        spread,
        mses,
        spreads,
        blocks=starts.shape[1],
        largest=BandedFigure(float(sums.largest.max()), *_middle(largest)),
        bias=float(sums.error.sum()) / rows,
    )


def excess(
    error: Array,
    best: Array,
    *,
    block: int | None = None,
    seed: int = 0,
) -> BandedFigure:
    """How much larger a model's RMSE is than the best one's, as a share, on the same blocks of rows for both.

    Args:
        error: residuals of the model, shape (n,).
        best: residuals of the best one on the same rows, shape (n,).
        block: rows of a bootstrap block; None takes it from the two.
        seed: of the resampling.
    """
    best_is_perfect = error.any() and not best.any()
    if best_is_perfect or not np.all(np.isfinite(error)):
        return BandedFigure(np.inf, np.inf, np.inf)
    block = block or block_rows([error, best])
    starts = block_starts(error.size, block, seed)
    mine = np.sqrt(_resampled(error * error, block, starts))
    theirs = np.sqrt(_resampled(best * best, block, starts))
    size = np.sqrt(np.sum(error**2))
    size_of_best = np.sqrt(np.sum(best**2))
    value = float(_over(size, size_of_best))
    return _figure(value, _over(mine, theirs), starts.shape[1], least=-1.0)


def difference(
    error: Array,
    other: Array,
    *,
    block: int,
    seed: int = 0,
) -> BandedFigure:
    """How much larger a model's RMSE is than another's, in the effort's unit, on the same blocks of rows for both.

    Args:
        error: residuals of the model, shape (n,).
        other: residuals of the other one on the same rows, shape (n,).
        block: rows of a bootstrap block.
        seed: of the resampling.
    """
    starts = block_starts(error.size, block, seed)
    mine = np.sqrt(_resampled(error * error, block, starts))
    theirs = np.sqrt(_resampled(other * other, block, starts))
    value = rms(error) - rms(other)
    return _figure(value, mine - theirs, starts.shape[1])


def _over(mine: Array | np.float64, theirs: Array | np.float64) -> Array:
    """How much larger, as a share: zero where both are zero, infinite where only the other one is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        more = np.divide(mine, theirs) - 1.0
        return np.where(np.equal(mine, theirs), 0.0, more)


def _figure(
    value: float,
    resampled: Array,
    blocks: int,
    *,
    least: float = -np.inf,
    most: float = np.inf,
) -> BandedFigure:
    """A band as much wider than the resamples as t of so many blocks is than the normal quantile, within limits."""
    from scipy.special import ndtri, stdtrit

    freedom = max(blocks - 1, 1)
    student_over_normal = float(stdtrit(freedom, 0.975) / ndtri(0.975))
    wider = student_over_normal * (blocks / freedom) ** 0.5
    low, high = _middle(resampled)
    return BandedFigure(
        value,
        low=_widened(value, low, wider, least),
        high=_widened(value, high, wider, most),
    )


def _widened(
    value: float,
    end: float,
    wider: float,
    limit: float,
) -> float:
    """An end so many times as far from the value; where it would reach the limit, by the logarithm of its distance."""
    if not np.isfinite(end):
        return end
    moved = value + wider * (end - value)
    if np.sign(moved - limit) == np.sign(value - limit):
        return moved
    nearer = (end - limit) / (value - limit)
    return limit + (value - limit) * nearer**wider


def _middle(resampled: Array) -> tuple[float, float]:
    """Ends of the middle 95 %; infinite where they lie among resamples that are."""
    ends = np.quantile(np.minimum(resampled, _LARGEST_RATIO), (0.025, 0.975))
    low, high = np.where(ends < 0.5 * _LARGEST_RATIO, ends, np.inf).tolist()
    return low, high


def _resampled(values: Array, block: int, starts: NDArray[np.int64]) -> Array:
    """Mean of the values (n,) in each resample, shape (resamples,); the sum of a block is a difference of two sums."""
    wrapped = np.concatenate([values, values[: block - 1]])
    total = np.concatenate([[0.0], np.cumsum(wrapped)])
    sums = total[starts + block] - total[starts]  # (resamples, blocks)
    return np.mean(sums, axis=1) / block


def _block_maxima(values: Array, block: int) -> Array:
    """Largest value of each block that starts at a row; the rows behind the last are the first."""
    return largest_of_windows(np.concatenate([values, values[: block - 1]]), block)


def independent_rows(residual: Array) -> float:
    """How many independent rows carry the information of these correlated ones."""
    return residual.size / correlated_rows(residual)


def information_criteria(
    cost: float,
    rows: int,
    independent: float,
    parameters: int,
) -> dict[str, float]:
    """AIC and BIC of Gaussian residuals, as printed everywhere and for the number of independent rows.

    Args:
        cost: sum of squared residuals.
        rows: number of rows n.
        independent: number of independent rows, the same for all models that are compared.
        parameters: number of fitted parameters.

    Returns:
        aic, bic: with n rows; they prefer too many parameters wherever residuals are correlated. aic_independent,
        bic_independent: with the number of independent rows.
    """
    mse = max(cost / rows, np.finfo(float).tiny)
    log_mse = float(np.log(mse))
    log_rows = float(np.log(rows))
    log_independent = float(np.log(max(independent, 2.0)))
    return {
        "aic": rows * log_mse + 2 * parameters,
        "bic": rows * log_mse + parameters * log_rows,
        "aic_independent": independent * log_mse + 2 * parameters,
        "bic_independent": independent * log_mse + parameters * log_independent,
    }


#: Share of rows at rest from which figures over those in motion are given too.
MANY_AT_REST = 0.1

#: A simpler model is worth this much more error; docs/decisions/0004-recommendation.md.
TOLERATED = 0.05
