#!/usr/bin/env python
"""Is the torque of a brake told whose iron or particles keep the field, in wide loops that saturate?

SYNTHETIC brakes: the field in the gap is that of 3,000 relays (Preisach), whose centres and widths are drawn; no stage
of ours has relays. Currents rise and fall in ramps or steps between random turns, every fourth brake also has currents
below zero, every third turns to and fro. The search for memory sees the first 70 % of each log, the rest judges once.

    python studies/iron.py [--devices 20] [--first 20]

Printed: RMSE on the last 30 %, of the standard deviation, of Bingham's law with a lag and of what the training rows
chose beside it.
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
PERIOD = 0.01
TRAINED = 0.7
RELAYS = 3000


def of_relays(current: Array, rng: np.random.Generator) -> Array:
    """The magnetisation behind a current, both of order one; the relays begin demagnetised."""
    draw = rng.uniform
    half_width, spread, bend, reversible = (
        draw(0.1, 0.35),
        draw(0.2, 0.5),
        draw(0.25, 0.5),
        draw(0.1, 0.4),
    )
    centre = rng.normal(0.0, bend, RELAYS)
    half = np.abs(half_width * (1.0 + spread * rng.standard_normal(RELAYS)))
    state = np.where(centre > 0.0, -1.0, 1.0)
    magnetised = np.empty(current.size)
    for k, now in enumerate(current.tolist()):
        state[now >= centre + half] = 1.0
        state[now <= centre - half] = -1.0
        magnetised[k] = (1.0 - reversible) * state.mean() + reversible * np.tanh(0.5 * now / bend)
    return magnetised


def brake(seed: int) -> Dataset:
    """A log of one brake, all of whose numbers are drawn."""
    rng = np.random.default_rng(seed)
    draw = rng.uniform
    turns = [0.0]
    for _ in range(int(draw(12, 30))):
        turns += [
            draw(0.4, 1.0),
            -draw(0.0, 1.0) if seed % 4 == 3 else rng.choice([0.0, draw(0.0, 0.6)]),
        ]
    current = np.interp(np.linspace(0.0, len(turns) - 1.0, ROWS), np.arange(len(turns)), turns)
    if seed % 2:
        current = np.repeat(turns, -(-ROWS // len(turns)))[:ROWS]
    strength = np.abs(of_relays(current, rng)) ** draw(0.9, 1.6)
    time = PERIOD * np.arange(float(ROWS))
    slip = draw(10.0, 80.0) * (0.6 + 0.4 * np.sin(draw(0.1, 1.0) * time))
    if seed % 3 == 0:
        slip = slip * np.sign(np.sin(draw(0.3, 1.0) * time) + 1e-9)
    torque = draw(2.0, 20.0)
    effort = torque * ((strength + draw(0.01, 0.05)) * np.tanh(slip) + draw(0.0005, 0.003) * slip)
    effort += draw(0.003, 0.015) * torque * rng.standard_normal(ROWS)
    clock = Clock(time, (Span(0, ROWS, PERIOD),))
    return Dataset(
        "single",
        (Element(draw(0.5, 3.0) * current, slip),),
        effort,
        clock,
        Units("N*m", "A", "rad/s"),
    )


def judged(log: Dataset) -> tuple[float, float, str]:
    """Error on the last rows, of the spread, without a memory and with what the training rows chose; its name."""
    train = log.take(np.arange(ROWS) < TRAINED * ROWS)
    law = law_from_name("bingham", "single")
    rungs = grown(
        train, Structure("single", "bingham", law, "lag", friction=not train.one_way, offset=True)
    )
    errors: list[float] = []
    for rung in (rungs[0], rungs[-1]):
        model = fit_structure(
            train, rung.structure, starts=[list(rung.numbers.values())], intervals=False
        ).model
        error = log.effort - model.predict(log)
        errors.append(rms(error[train.rows :]) / float(np.std(log.effort)))
    without, chosen = errors
    last = rungs[-1].structure
    return without, chosen, f"{last.specification}+{last.dynamics}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=20)
    parser.add_argument("--first", type=int, default=20, help="seed of the first device")
    asked = parser.parse_args()
    table: list[tuple[float, float]] = []
    for seed in range(asked.first, asked.first + asked.devices):
        without, chosen, name = judged(brake(seed))
        table.append((without, chosen))
        print(f"{seed:<4} without {without:6.2%}, chosen {chosen:6.2%}: {name}", flush=True)
    without, chosen = np.array(table).T
    print(
        f"\nmean {without.mean():.1%} without, {chosen.mean():.1%} chosen (largest {chosen.max():.1%})"
    )


if __name__ == "__main__":
    main()
