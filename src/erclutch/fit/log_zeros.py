"""A sensor's zero or gain may differ from log to log: both are estimated for each log and tested against one for all.

The estimates are made on the residuals of one model and stay apart from it: the model keeps its one offset, and scores
are of the data as logged. The zero of a log is estimated beside a gain of the log, so that a law that errs at the field
of one log, as far with the slip one way as the other, does not look like a zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.fit.checks.finding import Finding
from erclutch.fit.choice.scoring import independent_rows
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.signals.units import amount

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
    names: list[str] = []
    rows: list[slice] = []  # of each log that moves both ways
    for name, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        slip = data.elements[0].slip[start:stop]
        if slip.size <= 2:
            continue
        forward = float(np.mean(slip > 0))  # share of the rows
        backward = float(np.mean(slip < 0))
        if min(forward, backward) >= _EACH_WAY:
            names.append(name)
            rows.append(slice(start, stop))
    if len(names) < 2 or not np.all(np.isfinite(predicted)):
        return ()
    residual = data.effort - predicted
    residuals = [residual[of_log] for of_log in rows]
    efforts = [predicted[of_log] for of_log in rows]
    ones = [np.ones(effort.size) for effort in efforts]

    findings: list[Finding] = []
    zeros = per_log(residuals, ones, efforts)
    unit = data.units.effort
    worth = _ZERO * float(np.std(data.effort))
    listed = _listed(
        names, zeros, worth, lambda zero, error: amount(f"{zero:+.3g} +- {1.96 * error:.2g}", unit)
    )
    if listed:
        message = (
            f"the zero of the effort differs between logs: {listed}, counted from the models' one offset "
            f"({_sureness(zeros)}). The models keep one offset, and scores are of the data as logged"
        )
        remedy = "Zero the sensor before each run, or subtract these values from the logs"
        findings.append(Finding("warning", "zero", message, remedy))

    same_fields = True
    for element in data.elements:
        whole = np.ptp(element.field)
        same_fields &= all(np.ptp(element.field[of_log]) >= _SAME_FIELDS * whole for of_log in rows)
    if same_fields:
        gains = per_log(residuals, efforts, ones)
        listed = _listed(
            names, gains, _GAIN, lambda gain, error: f"{100 * gain:+.1f} +- {196 * error:.2g} %"
        )
        if listed:
            message = f"the effort at the same field and slip differs between logs: {listed} ({_sureness(gains)})"
            remedy = "Look for a gain of the sensor that was changed, or for a warmer fluid"
            findings.append(Finding("warning", "gain", message, remedy))
    return tuple(findings)


def per_log(
    residuals: Sequence[Array],
    columns: Sequence[Array],
    beside: Sequence[Array],
) -> PerLog:
    """The factor of a column in each log's residuals, tested against one factor for all logs.

    Args:
        residuals: of each log, (n_k,).
        columns: what the factor multiplies, of each log, (n_k,).
        beside: a column with a factor of its own in each log, whether factors differ or not, (n_k,).
    """
    tiny = np.finfo(float).tiny
    factors: list[float] = []
    squares: list[float] = []  # of the column, summed
    costs: list[float] = []  # of what is left
    counts: list[float] = []  # independent rows
    for residual, column, other in zip(residuals, columns, beside, strict=True):
        residual = _without(residual, other)
        column = _without(column, other)
        square = float(column @ column) + tiny
        factor = float(column @ residual) / square
        left = residual - factor * column
        factors.append(factor)
        squares.append(square)
        costs.append(float(left @ left) + tiny)
        counts.append(max(independent_rows(left), 4.0))
    values = np.array(factors)
    independent = np.array(counts)
    freedom = np.maximum(independent - 2.0, 1.0)
    errors = np.sqrt(np.array(costs) / np.array(squares) / freedom)
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

    weights = errors**-2.0
    k = values.size
    mean = float(weights @ values / weights.sum())
    between = float(weights @ (values - mean) ** 2) / (k - 1)
    others = 1.0 - weights / weights.sum()
    lost = float(np.sum(others**2 / (rows - 1.0)))
    correction = 2.0 * (k - 2) / (k * k - 1) * lost  # Welch's
    ratio = between / (1.0 + correction)
    freedom = (k * k - 1) / (3.0 * lost)
    return ratio, float(fdtrc(k - 1, freedom, ratio))


def _without(values: Array, other: Array) -> Array:
    """What another column does not explain of a column."""
    square = float(other @ other)
    if not square > 0:
        return values
    share = float(other @ values) / square
    return values - other * share


def _listed(
    names: Sequence[str],
    numbers: PerLog,
    worth: float,
    text: Callable[[float, float], str],
) -> str:
    """The logs that surely differ from the usual one, the farthest first; "" where there is none, or by too little."""
    usual = float(np.median(numbers.values))
    away = np.abs(numbers.values - usual)
    limits = np.maximum(worth, 3.0 * numbers.errors)
    farthest_first = np.argsort(-away, kind="stable").tolist()
    odd = [log for log in farthest_first if away[log] > limits[log]]
    if numbers.chance > _CHANCE or not odd:
        return ""

    def said(log: int) -> str:
        return f"{names[log]} {text(float(numbers.values[log]), float(numbers.errors[log]))}"

    listed = ", ".join(said(log) for log in odd[:_LISTED])
    if len(odd) > _LISTED:
        listed += f" and {len(odd) - _LISTED} more"
    if len(odd) < len(names):
        nearest = int(np.argmin(away))
        listed += f"; the usual log {said(nearest)}"
    return listed


def _sureness(numbers: PerLog) -> str:
    ratio = f"F = {numbers.ratio:.3g}"
    if numbers.chance > 1e-12:
        return f"{ratio}, chance {numbers.chance:.0e}"
    return ratio
