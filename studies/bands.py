#!/usr/bin/env python
"""Does a prediction band of 95 % hold 95 % of the rows of logs that were not there when it was made?

Models are fitted and their bands calibrated on a few SYNTHETIC logs. Fresh logs of the same source (another seed of
command, motion and noise) then judge each band, without a torque sensor and with one.

    python studies/bands.py [--logs 100] [--fits 5] [--models bingham+lag casson+lag+dahl fnn-16+lag]

Exits with 1 where the share of rows inside, over all fresh logs, misses 95 % by more than 2 points.
"""

from __future__ import annotations

import argparse
import os
import sys

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.comparison import Settings, compare
from erclutch.fit.prediction_bands import HeldBand, judged
from erclutch.logs.dataset import Dataset
from erclutch.logs.synthetic import RATE, synthetic_log
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

TARGET, TOLERANCE = 0.95, 0.02
TRAINING_S, FRESH_S = 20.0, 5.0


def made_up(seconds: float, seed: int) -> Dataset:
    """A SYNTHETIC log as rows."""
    columns = {name: values for name, (_, values) in synthetic_log(seconds, seed).items()}
    clock = Clock(columns["time"], (Span(0, columns["time"].size, 1.0 / RATE),))
    elements = (Element(columns["field"], columns["slip"]),)
    return Dataset("single", elements, columns["torque"], clock, Units("N*m", "V", "rad/s"))


def judge(models: tuple[str, ...], fits: int, logs: int) -> dict[str, list[HeldBand]]:
    """How the band of each model does on each fresh log."""
    found: dict[str, list[HeldBand]] = {}
    for fit in range(fits):
        comparison = compare(made_up(TRAINING_S, fit), Settings(models=models, lag="none", seed=fit))
        fresh = [made_up(FRESH_S, 1000 + k) for k in range(fit, logs, fits)]
        for entry in comparison.entries:
            model = entry.outcome.model
            if model.band is None or entry.band is None:
                continue
            every = [(data, np.ones(data.rows, np.bool_)) for data in fresh]
            figures = [
                judged(data, rows, model.predict(data), model.band, entry.band.plain, sensor=True)
                for data, rows in every
            ]
            found.setdefault(entry.name, []).extend(figures)
    return found


def main() -> int:
    """Print a line a model; 1 where a band misses."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--logs", type=int, default=100, help="fresh logs")
    parser.add_argument("--fits", type=int, default=5, help="training logs")
    parser.add_argument("--models", nargs="+", default=["bingham+lag", "casson+lag+dahl", "fnn-16+lag"])
    asked = parser.parse_args()
    print(f"{asked.logs} fresh logs of {FRESH_S:g} s, {asked.fits} fits on {TRAINING_S:g} s (SYNTHETIC)")
    print(f"{'model':<20} {'sensor':<8} {'inside':>8} {'logs from .. to':>18} {'over plain':>11}")
    missed = False
    for name, figures in judge(tuple(asked.models), asked.fits, asked.logs).items():
        for sensor in ("without", "with"):
            held = [each.held if sensor == "without" else each.with_sensor for each in figures]
            shares = np.array([each.share for each in held if each is not None])
            widths = [each.width / f.plain for each, f in zip(held, figures, strict=True) if each is not None]
            low, high = np.quantile(shares, (0.025, 0.975))
            missed |= abs(float(np.mean(shares)) - TARGET) > TOLERANCE
            print(
                f"{name:<20} {sensor:<8} {np.mean(shares):>8.1%} {f'{low:.1%} .. {high:.1%}':>18}"
                f" {np.mean(widths):>11.2f}"
            )
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
