"""A sensor's zero or gain may differ from log to log: both are estimated for each log and tested against one for all.

The estimates are made on the residuals of one model and stay apart from it: the model keeps its one offset, and scores
are of the data as logged. The zero of a log is estimated beside a gain of the log, so that a law that errs at the field
of one log, as far with the slip one way as the other, does not look like a zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.fit.data_check import Finding
from erclutch.fit.scoring import independent_rows
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array

#: Chance of such a difference between equal logs below which it is called one.
_CHANCE = 1e-3
#: Smallest difference worth a word: of a zero, as a share of the effort's standard deviation; of a gain, as a share.
_ZERO, _GAIN = 0.01, 0.03
#: Share of rows with the slip one way, and the other, without which a zero is not told from a yield effort.
_EACH_WAY = 0.1
#: Share of the range of all fields that each log must cover for gains to be compared.
_SAME_FIELDS = 0.8
_LISTED = 6


@dataclass(frozen=True)
class PerLog:
    """One number of each log, and how surely it differs between logs.

    Attributes:
        values: of each log.
        errors: standard error of each, from the log's independent rows.
        chance: of numbers this far apart if all logs had one (Welch's F test on independent rows).
        ratio: the F ratio.
    """

    values: Array
    errors: Array
    chance: float
    ratio: float


def log_differences(data: Dataset, predicted: Array) -> tuple[Finding, ...]:
    """What differs between logs: zeros, and gains where all logs have the same fields.

    Args:
        data: rows of several logs.
        predicted: effort of one model on all of them, shape (n,).
    """
    logs = [k for k, place in enumerate(data.source_rows) if _both_ways(data, *place)]
    if len(logs) < 2 or not np.all(np.isfinite(predicted)):
        return ()
    residual = data.effort - predicted
    rows = [slice(*data.source_rows[k]) for k in logs]
    names = [data.sources[k] for k in logs]
    residuals, efforts = [residual[r] for r in rows], [predicted[r] for r in rows]
    ones = [np.ones(e.size) for e in efforts]
    found: list[Finding | None] = [_zeros(names, per_log(residuals, ones, efforts), data)]
    if _same_fields(data, rows):
        found.append(_gains(names, per_log(residuals, efforts, ones)))
    return tuple(finding for finding in found if finding is not None)


def per_log(residuals: Sequence[Array], columns: Sequence[Array], beside: Sequence[Array]) -> PerLog:
    """The factor of a column in each log's residuals, tested against one factor for all logs.

    Args:
        residuals: of each log, (n_k,).
        columns: what the factor multiplies, of each log, (n_k,).
        beside: a column with a factor of its own in each log, whether factors differ or not, (n_k,).
    """
    residuals = [_without(r, d) for r, d in zip(residuals, beside, strict=True)]
    columns = [_without(c, d) for c, d in zip(columns, beside, strict=True)]
    along = np.array([float(c @ r) for c, r in zip(columns, residuals, strict=True)])
    squares = np.array([float(c @ c) for c in columns]) + np.finfo(float).tiny
    values = along / squares
    left = [r - v * c for r, v, c in zip(residuals, values, columns, strict=True)]
    costs = np.array([float(e @ e) for e in left]) + np.finfo(float).tiny
    independent = np.array([max(independent_rows(e), 4.0) for e in left])
    errors = np.sqrt(costs / squares / np.maximum(independent - 2.0, 1.0))
    ratio, chance = welch(values, errors, independent)
    return PerLog(values, errors, chance, ratio)


def welch(values: Array, errors: Array, rows: Array) -> tuple[float, float]:
    """F ratio of numbers of unequal error, and the chance of it if all were one (Welch 1951, doi 10.2307/2332579).

    Args:
        values: the numbers, shape (k,).
        errors: the standard error of each.
        rows: the independent rows behind each.
    """
    from scipy.special import fdtrc

    weights, k = errors**-2.0, values.size
    mean = float(weights @ values / weights.sum())
    between = float(weights @ (values - mean) ** 2) / (k - 1)
    lost = float(np.sum((1.0 - weights / weights.sum()) ** 2 / (rows - 1.0)))
    ratio = between / (1.0 + 2.0 * (k - 2) / (k * k - 1) * lost)
    return ratio, float(fdtrc(k - 1, (k * k - 1) / (3.0 * lost), ratio))


def _without(values: Array, other: Array) -> Array:
    """What another column does not explain of a column."""
    square = float(other @ other)
    return values - other * (float(other @ values) / square) if square > 0 else values


def _both_ways(data: Dataset, start: int, stop: int) -> bool:
    slip = data.elements[0].slip[start:stop]
    return slip.size > 2 and min(float(np.mean(slip > 0)), float(np.mean(slip < 0))) >= _EACH_WAY


def _same_fields(data: Dataset, rows: Sequence[slice]) -> bool:
    return all(np.ptp(e.field[r]) >= _SAME_FIELDS * np.ptp(e.field) for e in data.elements for r in rows)


def _zeros(names: Sequence[str], found: PerLog, data: Dataset) -> Finding | None:
    unit = data.units.effort if data.units.effort not in ("", "?") else ""
    worth = _ZERO * float(np.std(data.effort))
    listed = _listed(names, found, worth, lambda v, e: f"{v:+.3g} +- {1.96 * e:.2g} {unit}".rstrip())
    if not listed:
        return None
    message = (
        f"the zero of the effort differs between logs: {listed}, counted from the models' one offset "
        f"({_sureness(found)}). The models keep one offset, and scores are of the data as logged"
    )
    remedy = "Zero the sensor before each run, or subtract these values from the logs"
    return Finding("warning", "zero", message, remedy)


def _gains(names: Sequence[str], found: PerLog) -> Finding | None:
    listed = _listed(names, found, _GAIN, lambda v, e: f"{100 * v:+.1f} +- {196 * e:.2g} %")
    if not listed:
        return None
    message = f"the effort at the same field and slip differs between logs: {listed} ({_sureness(found)})"
    return Finding("warning", "gain", message, "Look for a gain of the sensor that was changed, or for a warmer fluid")


def _listed(names: Sequence[str], found: PerLog, worth: float, text: Callable[[float, float], str]) -> str:
    """The logs that surely differ from the usual one, the farthest first; "" where there is none, or by too little."""
    usual = float(np.median(found.values))
    away = np.abs(found.values - usual)
    odd = [k for k in np.argsort(-away, kind="stable").tolist() if away[k] > max(worth, 3.0 * float(found.errors[k]))]
    if found.chance > _CHANCE or not odd:
        return ""
    shown = [f"{names[k]} {text(float(found.values[k]), float(found.errors[k]))}" for k in odd[:_LISTED]]
    more = f" and {len(odd) - _LISTED} more" if len(odd) > _LISTED else ""
    median = int(np.argmin(away))
    rest = f"; the usual log {names[median]} {text(float(found.values[median]), float(found.errors[median]))}"
    return ", ".join(shown) + more + (rest if len(odd) < len(names) else "")


def _sureness(found: PerLog) -> str:
    return f"F = {found.ratio:.3g}, chance {found.chance:.0e}" if found.chance > 1e-12 else f"F = {found.ratio:.3g}"
