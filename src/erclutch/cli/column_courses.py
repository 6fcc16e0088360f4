"""How columns run over time, in few numbers: for a picture of each beside its name, and for a plot that one zooms."""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.signals.array import Array
from erclutch.signals.recording import Recording


def sketch(values: Array, points: int = 60) -> list[list[float]]:
    """Smallest and largest value of each of some stretches of equal length; stretches without a value are left out."""
    parts = np.array_split(values[np.isfinite(values)], min(points, values.size))
    return [[float(f"{part.min():.4g}"), float(f"{part.max():.4g}")] for part in parts if part.size]


def courses_of(recording: Recording, stretches: int) -> dict[str, Any]:
    """Time and each signal of a recording in stretches of rows: where they begin, smallest and largest value."""
    cuts = np.unique(np.linspace(0, recording.rows, min(stretches, recording.rows) + 1).astype(np.intp))[:-1]
    every = {**recording.signals, **recording.extras}

    def ends(values: Array) -> dict[str, list[float]]:
        pairs = {"low": np.minimum.reduceat(values, cuts), "high": np.maximum.reduceat(values, cuts)}
        return {name: [float(f"{value:.5g}") for value in each] for name, each in pairs.items()}

    return {
        "time": [float(f"{value:.8g}") for value in recording.time[cuts]],
        "until": float(recording.time[-1]),
        "signals": {name: {"unit": recording.units.get(name, ""), **ends(values)} for name, values in every.items()},
    }
