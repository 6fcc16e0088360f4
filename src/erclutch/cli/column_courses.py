"""How columns run over time, in few numbers: for a picture of each beside its name, and for a plot that one zooms."""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.signals.array import Array
from erclutch.signals.recording import Recording


def sketch(values: Array, points: int = 60) -> list[list[float]]:
    """Smallest and largest value of each of some stretches of equal length; stretches without a value are left out."""
    finite = values[np.isfinite(values)]
    ends: list[list[float]] = []
    for stretch in np.array_split(finite, min(points, values.size)):
        if stretch.size:
            lowest = float(f"{stretch.min():.4g}")
            highest = float(f"{stretch.max():.4g}")
            ends.append([lowest, highest])
    return ends


def courses_of(recording: Recording, stretches: int) -> dict[str, Any]:
    """Time and each signal of a recording in stretches of rows: where they begin, smallest and largest value."""
    count = min(stretches, recording.rows)
    edges = np.linspace(0, recording.rows, count + 1).astype(np.intp)
    firsts = np.unique(edges)[:-1]  # first row of each stretch

    signals: dict[str, dict[str, Any]] = {}
    for name, values in {**recording.signals, **recording.extras}.items():
        lowest = np.minimum.reduceat(values, firsts)
        highest = np.maximum.reduceat(values, firsts)
        signals[name] = {
            "unit": recording.units.get(name, ""),
            "low": [float(f"{value:.5g}") for value in lowest],
            "high": [float(f"{value:.5g}") for value in highest],
        }
    return {
        "time": [float(f"{value:.8g}") for value in recording.time[firsts]],
        "until": float(recording.time[-1]),
        "signals": signals,
    }
