#!/usr/bin/env python
"""Is the true law found in a bench sheet: points of field, slip and effort, none after another in time?

SYNTHETIC sheets of a damper, of known truth and noise, several seeds each. Two laws are fitted with the stages that the
training points choose; the recommended law is compared with the truth without noise on a finer sheet.

    python studies/sheets.py [--seeds 8] [--only "oil"]

Printed for each kind of sheet: the median and largest error over the spread of the truth, and what was recommended.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from dataclasses import dataclass, replace

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.comparison import Settings, compare
from erclutch.logs import recording_from_arrays
from erclutch.logs.clock.timing import of_points
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.signals.array import Array

MODELS = ("bingham", "casson")


@dataclass(frozen=True)
class Sheet:
    """A kind of sheet: its fields in A, speeds a way, compression over rebound, noise in N, whether it has knees."""

    name: str
    fields: tuple[float, ...]
    speeds: int
    softer: float
    noise: float
    knees: bool = False


SHEETS = (
    Sheet("30 points, ways alike", (0.0, 0.8, 1.6), 5, 1.0, 8.0),
    Sheet("30 points, ways differ", (0.0, 0.8, 1.6), 5, 0.55, 8.0),
    Sheet("48 points, ways alike", (0.0, 0.5, 1.0, 1.6), 6, 1.0, 8.0),
    Sheet("48 points, ways differ", (0.0, 0.5, 1.0, 1.6), 6, 0.8, 8.0),
    Sheet("80 points, ways differ", (0.0, 0.4, 0.8, 1.2, 1.6), 8, 0.55, 8.0),
    Sheet("30 points, one field", (0.8,), 15, 0.7, 8.0),
    Sheet("48 points, oil damper", (0.0,), 24, 1.0, 3.0, knees=True),
)


def truth(sheet: Sheet, field: Array, slip: Array) -> Array:
    """The force without noise."""
    if sheet.knees:
        force = 3000.0 * slip - 2400.0 * np.maximum(slip - 0.2, 0.0)
        return np.asarray(force - 2000.0 * np.minimum(slip + 0.12, 0.0))
    size = np.abs(slip)
    rebound = (300.0 + 900.0 * (field / 1.6) ** 1.2) * np.tanh(size / 0.03) + 500.0 * size
    return np.where(slip > 0.0, rebound, -sheet.softer * rebound) + 90.0


def points(sheet: Sheet, speeds: int, seed: int | None) -> Dataset:
    """The sheet with so many speeds each way; without noise where there is no seed."""
    one_way = np.linspace(0.05, 0.6, speeds)
    slip = np.tile(np.concatenate([-one_way[::-1], one_way]), len(sheet.fields))
    field = np.repeat(sheet.fields, 2 * speeds)
    force = truth(sheet, field, slip)
    if seed is not None:
        force = force + sheet.noise * np.random.default_rng(seed).standard_normal(slip.size)
    signals = {"field": field, "slip": slip, "effort": force}
    data = build_dataset(
        recording_from_arrays(signals, {"field": "A", "slip": "m/s", "effort": "N"}, rate=1.0)
    )
    return replace(data, notes=(*data.notes, *of_points(data.rows, 1.0).notes))


def judged(sheet: Sheet, seed: int) -> tuple[float, str]:
    """Error of the recommended law over the spread of the truth, and its name."""
    comparison = compare(points(sheet, sheet.speeds, seed), Settings(models=MODELS))
    chosen = comparison.entry(comparison.recommended)
    finer = points(sheet, 40, None)
    error = finer.effort - chosen.outcome.model.predict(finer)
    return float(np.sqrt(np.mean(error**2)) / finer.effort.std()), chosen.name


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--only", default="", help="a part of a sheet's name")
    asked = parser.parse_args()
    for sheet in SHEETS:
        if asked.only not in sheet.name:
            continue
        found = [judged(sheet, seed) for seed in range(asked.seeds)]
        errors = [error for error, _ in found]
        names = ", ".join(
            f"{count} {name}" for name, count in Counter(n for _, n in found).most_common()
        )
        print(
            f"{sheet.name:<23} {np.median(errors):6.2%}, at most {max(errors):6.2%}: {names}",
            flush=True,
        )


if __name__ == "__main__":
    main()
