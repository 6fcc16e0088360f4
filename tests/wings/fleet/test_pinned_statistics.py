"""Statistics of a fleet stay as they are kept beside this file; `tests/conftest.py` says how to pin anew."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from erclutch.signals.array import Array
from erclutch.wings.fleet.fleet_statistics import control_chart, outlier_scores, trend


def walk(rows: int, pole: float, seed: int, columns: int = 1) -> Array:
    found = np.random.default_rng(seed).normal(size=(rows, columns))
    for k in range(1, rows):
        found[k] += pole * found[k - 1]
    return found


def test_fleets(pinned: Callable[..., None]) -> None:
    y = walk(14, 0.3, 3)[:, 0] + 0.2 * np.arange(14.0)
    y[5] += 9.0
    given = [
        (y, y - 0.3, y + 0.4),
        (y[:4], y[:4], y[:4]),
        (np.ones(6), np.ones(6), np.ones(6)),
        (y, y - np.inf, y + 1),
    ]
    found: list[Any] = [outlier_scores(*g) for g in given]
    charts = [*(trend(np.arange(float(n)), y[:n]) for n in (3, 4, 5, 14)), trend(np.ones(14), y)]
    charts += [control_chart(y[:n], first) for n in (1, 2, 4, 5, 14) for first in (0, 2, 5, 20)]
    pinned([found, [None if c is None else vars(c) for c in charts]])
