#!/usr/bin/env python
"""Does a brake that warms while it slips keep its model, where nobody logged a temperature?

SYNTHETIC brakes slip all the time under steps of current and speed; every third one turns to and fro. Yield torque and
viscosity fall with a temperature that the dissipated power raises, so the truth is not the stage `self-heating`, which
knows the power of a cold device. The search for memory sees the first 70 % of each log, the rest judges once.

    python studies/self_heating.py [--devices 20] [--first 40] [--cold] [--drift]

With --cold nothing warms; with --drift the zero of the torque walks besides. Printed: RMSE on the last 30 %, of the
standard deviation, without the stage and with what the training rows chose; how often the stage was chosen.
"""

from __future__ import annotations

import argparse
import os

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

ROWS = 12_000
TRAINED = 0.7
STAGES = ("self-heating", "self-heating/viscous")


def brake(seed: int, *, cold: bool = False, drift: bool = False) -> Dataset:
    """A log of one brake, all of whose numbers are drawn."""
    rng = np.random.default_rng(seed)
    draw = rng.uniform
    period = float(rng.choice([0.01, 0.02, 0.05]))
    time = np.arange(float(ROWS)) * period
    current = _held(rng.choice([0.0, 0.25, 0.5, 0.75, 1.0], int(draw(20, 50))) * draw(1.0, 3.0))
    slip = _held(draw(0.2, 1.0, int(draw(4, 20)))) * draw(10.0, 100.0)
    if seed % 3 == 0:
        slip = slip * np.sign(np.sin(2.0 * np.pi * time / draw(5.0, 0.25 * time[-1])) + 1e-9)
    yield_torque, exponent = draw(2.0, 20.0), draw(0.9, 1.7)
    friction = draw(0.01, 0.05) * yield_torque
    viscosity = draw(0.02, 0.25) * yield_torque / np.abs(slip).max()
    lag_s, warming_s = draw(0.5, 3.0) * period, draw(0.05, 0.6) * time[-1]
    fade, thinning = draw(0.04, 0.2), draw(0.0, 0.6)
    if cold:
        fade = thinning = 0.0

    field = np.empty(ROWS)
    behind = 0.0
    for k, wanted in enumerate((current / current.max()).tolist()):
        behind += (1.0 - np.exp(-period / lag_s)) * (wanted - behind)
        field[k] = behind
    direction = np.tanh(slip / (0.02 * np.abs(slip).max()))
    cold_yield = yield_torque * field**exponent
    mean_power = float(np.mean((cold_yield + friction) * np.abs(slip)))
    effort = np.empty(ROWS)
    heat = 0.0  # 1 once the mean power of a cold brake has lasted
    for k in range(ROWS):
        effort[k] = (cold_yield[k] * max(0.05, 1.0 - fade * heat) + friction) * direction[k]
        effort[k] += viscosity * np.exp(-thinning * heat) * slip[k]
        heat += (effort[k] * slip[k] / mean_power - heat) * period / warming_s
    if drift:
        effort += 0.03 * yield_torque * np.cumsum(rng.standard_normal(ROWS)) / np.sqrt(ROWS)
    effort += draw(0.003, 0.02) * yield_torque * rng.standard_normal(ROWS)
    clock = Clock(time, (Span(0, ROWS, period),))
    return Dataset("single", (Element(current, slip),), effort, clock, Units("N*m", "A", "rad/s"))


def _held(levels: Array) -> Array:
    """Levels of equal length over all rows."""
    return np.repeat(levels, -(-ROWS // levels.size))[:ROWS]


def judged(log: Dataset) -> tuple[float, float, str]:
    """Error on the last rows without the stage and with what the training rows chose, of the spread; its stages."""
    train = log.take(np.arange(ROWS) < TRAINED * ROWS)
    last = slice(train.rows, None)
    law = law_from_name("bingham", "single")
    base = Structure("single", "bingham", law, "lag", friction=not train.one_way, offset=True)
    rungs = grown(train, base, among=STAGES)
    errors: list[float] = []
    for rung in (rungs[0], rungs[-1]):
        model = fit_structure(
            train, rung.structure, starts=[list(rung.numbers.values())], intervals=False
        ).model
        error = log.effort - model.predict(log)
        errors.append(rms(error[last]) / float(np.std(log.effort)))
    without, chosen = errors
    return without, chosen, rungs[-1].structure.dynamics


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=20)
    parser.add_argument("--first", type=int, default=40, help="seed of the first device")
    parser.add_argument("--cold", action="store_true", help="nothing warms")
    parser.add_argument("--drift", action="store_true", help="the zero of the torque walks")
    asked = parser.parse_args()
    table: list[tuple[float, float, bool]] = []
    for seed in range(asked.first, asked.first + asked.devices):
        without, with_chosen, stages = judged(brake(seed, cold=asked.cold, drift=asked.drift))
        table.append((without, with_chosen, "self-heating" in stages))
        print(f"{seed:<4} without {without:6.2%}, chosen {with_chosen:6.2%}: {stages}", flush=True)
    without, with_chosen, taken = np.array(table, np.float64).T
    ratio = with_chosen / without
    print(
        f"\nmean {without.mean():.2%} without, {with_chosen.mean():.2%} chosen; ratio {ratio.mean():.2f} (largest "
        f"{ratio.max():.2f}); the stage was chosen for {taken.sum():.0f} of {taken.size}"
    )


if __name__ == "__main__":
    main()
