"""Parity compares estimated with measured effort on held-out rows and says how residuals are distributed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array

_CELLS, _BARS = 64, 61


@dataclass(frozen=True)
class Parity:
    """Rows held out over measured (first axis) and estimated effort (second axis).

    Attributes:
        edges: of both axes, shape (n + 1,).
        counts: shape (n, n).
        beyond: rows whose estimate lies outside the edges.
    """

    edges: Array
    counts: NDArray[np.int64]
    beyond: int


@dataclass(frozen=True)
class Distribution:
    """Residuals of one model.

    Attributes:
        model: its name.
        edges: of the bars, shape (n + 1,), the same for all models of a picture.
        density: share of rows per unit of effort in each bar, shape (n,).
        beyond: share of rows outside the edges.
        bias: mean.
        quantiles: of the absolute residual, at 0.5, 0.95, 0.99 and 1.
        spread: standard deviation.
    """

    model: str
    edges: Array
    density: Array
    beyond: float
    bias: float
    quantiles: tuple[float, ...]
    spread: float


def parity(rows: RunRows, model: str) -> Parity:
    """Counts of the rows held out in square cells."""
    measured = rows.data.effort[rows.test]
    estimated = rows.predicted[model][rows.test]
    low = float(measured.min())
    high = float(measured.max())
    slack = 0.06 * (high - low)
    edges = np.linspace(low - slack, high + slack, _CELLS + 1)
    inside = (estimated >= edges[0]) & (estimated < edges[-1])
    scale = _CELLS / (edges[-1] - edges[0])
    along = (measured[inside] - edges[0]) * scale
    column = along.astype(np.intp)
    up = (estimated[inside] - edges[0]) * scale
    row = up.astype(np.intp)
    cell = column * _CELLS + row  # one number a cell
    counts = np.bincount(cell, minlength=_CELLS * _CELLS).reshape(_CELLS, _CELLS)
    return Parity(edges, counts, int(np.count_nonzero(~inside)))


def distributions(rows: RunRows, models: Sequence[str]) -> tuple[Distribution, ...]:
    """Residuals of some models on the same bars: out to the widest 99.5 % of the first model."""
    residuals = [rows.residual(model)[rows.test] for model in models]
    sizes = np.abs(residuals[0])
    reach = float(np.quantile(sizes, 0.995)) or 1.0
    edges = np.linspace(-1.25 * reach, 1.25 * reach, _BARS + 1)
    width = edges[1] - edges[0]
    of_models: list[Distribution] = []
    for model, residual in zip(models, residuals, strict=True):
        counts, _ = np.histogram(residual, edges)
        quantiles = np.quantile(np.abs(residual), (0.5, 0.95, 0.99, 1.0))
        distribution = Distribution(
            model=model,
            edges=edges,
            density=counts / (residual.size * width),
            beyond=1.0 - float(counts.sum()) / residual.size,
            bias=float(residual.mean()),
            quantiles=tuple(quantiles.tolist()),
            spread=float(residual.std()),
        )
        of_models.append(distribution)
    return tuple(of_models)
