#!/usr/bin/env python
"""May a network lose a little to the law in a quiet block of a log, where it wins in the others?

SYNTHETIC devices whose effort no law of ours has in full (a second memory, a wave over the field, a drift; all numbers
drawn) are logged once each: motion in stretches of their own size and pace, some at rest, and for every other device
larger or smaller as the log goes on. A law, the law with a network, and a network alone are fitted to the first 70 %;
four blocks of these rows choose one: as now, and as before decision 0004 was amended, when a freer model was not
recommended if it lost any block.

    python studies/quiet_block.py [--devices 40] [--first 2000]

Printed: the error of the chosen model on the last 30 % over the least error of the three, by both rules.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from unittest import mock

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.candidate import Fitted, kinds
from erclutch.fit.choice.parts_left_out import LeftOut
from erclutch.fit.choice.validation import chosen
from erclutch.fit.fit_settings import Settings
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array, rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD, ROWS = 5e-3, 6000
MODELS = ("casson+dahl/field", "casson+fnn-16+dahl/field", "fnn-16+dahl/field")


def remembered(slip: Array, strain: float, level: Array) -> Array:
    """A yield effort that the fluid reaches over a strain; a field that changes at rest changes nothing."""
    states, at = np.empty(slip.size), 0.0
    for k, (step, top) in enumerate(
        zip((slip * PERIOD / strain).tolist(), level.tolist(), strict=True)
    ):
        at = (at + step * top) / (1.0 + abs(step))
        states[k] = at
    return states


def waves(
    rng: np.random.Generator, time: Array, lowest: float, highest: float, count: int
) -> Array:
    """A sum of sines of frequencies between these, in Hz."""
    hertz = np.exp(rng.uniform(np.log(lowest), np.log(highest), count))
    total = np.zeros(time.size)
    for each in hertz.tolist():
        size = rng.standard_normal()
        total += size * np.sin(2.0 * np.pi * each * time + rng.uniform(0.0, 6.28))
    return total


def motion(rng: np.random.Generator, trend: Callable[[], float]) -> Array:
    """Slip in stretches, some at rest; each begins and ends at rest."""
    draw = rng.uniform
    slip, start = np.zeros(ROWS), 0
    rest, typical, wide = draw(0.0, 0.4), draw(30.0, 80.0), draw(0.2, 1.0)
    growth = trend()
    while start < ROWS:
        count = min(int(draw(300, 1500)), ROWS - start)
        size = 0.0
        if draw() >= rest:
            size = typical * np.exp(wide * rng.standard_normal() + growth * (start / ROWS - 0.5))
        place: Array = np.arange(float(count))
        ramp = np.minimum(1.0, np.minimum(place, place[::-1]) / 60.0)
        slip[start : start + count] = 0.5 * size * ramp * waves(rng, PERIOD * place, 0.3, 5.0, 5)
        start += count
    return slip


def device(seed: int) -> Dataset:
    """One log of a device."""
    rng = np.random.default_rng(seed)
    draw = rng.uniform
    slip = motion(rng, lambda: (seed % 2) * draw(-2.0, 2.0))
    time: Array = PERIOD * np.arange(float(ROWS))
    field = 0.5 + 0.5 * np.tanh(0.6 * waves(rng, time, 0.05, 1.5, 8))
    strain, shorter = draw(0.05, 0.4), draw(0.01, 0.08)
    floor, rise, exponent = draw(20.0, 150.0), draw(300.0, 800.0), draw(0.8, 1.8)
    second = draw(0.0, 0.35) * (draw() < 0.8)  # the share of the second memory
    wave, length = draw(0.0, 0.25) * (draw() < 0.7), draw(0.2, 0.8)
    drift = draw(0.0, 0.12) * (draw() < 0.5)
    viscosity, thinning = draw(0.5, 3.0), draw(0.6, 1.0)
    noise = draw(3.0, 25.0)
    warmth = drift * np.sin(
        2.0 * np.pi * np.arange(float(ROWS)) / ROWS * draw(0.4, 1.5) + draw(0.0, 6.28)
    )
    level = (
        (floor + rise * field**exponent)
        * (1.0 + warmth)
        * (1.0 + wave * np.sin(2.0 * np.pi * field / length))
    )
    effort = (1.0 - second) * remembered(slip, strain, level)
    effort += second * remembered(slip, shorter, level) * np.tanh(np.abs(slip) / 30.0)
    effort += viscosity * np.sign(slip) * np.abs(slip) ** thinning
    drawn, alike, error = rng.standard_normal(ROWS), draw(0.0, 0.95), np.zeros(ROWS)
    for k in range(1, ROWS):
        error[k] = alike * error[k - 1] + drawn[k]
    effort += noise * error * np.sqrt(1.0 - alike * alike)
    clock = Clock(time, (Span(0, ROWS, PERIOD),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N", "A", "mm/s"))


def judged(data: Dataset) -> tuple[float, float]:
    """Error of the chosen model over the least, before the amendment and now."""
    held = np.arange(data.rows) >= 0.7 * data.rows
    train = data.take(~held)
    settings = Settings(MODELS, lag="none")
    fitted: list[Fitted] = []
    with one_thread():
        for _, kind in kinds():
            fitted += [
                Fitted(each, each.fit(train, fitted, 1))
                for each in kind.candidates(settings, train)
            ]
        errors = {
            f.outcome.model.name: rms((data.effort - f.outcome.model.predict(data))[held])
            for f in fitted
        }
        now = chosen(train, fitted, list(errors), seed=0)
        with mock.patch.object(LeftOut, "may_lose", 0.0):
            before = chosen(train, fitted, list(errors), seed=0)
    assert now is not None
    assert before is not None
    least = min(errors.values())
    return errors[before.recommended] / least, errors[now.recommended] / least


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=40)
    parser.add_argument("--first", type=int, default=2000, help="seed of the first device")
    asked = parser.parse_args()
    ratios = np.array(
        [judged(device(seed)) for seed in range(asked.first, asked.first + asked.devices)]
    )
    for rule, own in zip(("before", "now"), ratios.T, strict=True):
        far = f"over 1.1 in {np.mean(own > 1.1):.0%}, over 1.3 in {np.mean(own > 1.3):.0%}"
        print(
            f"{rule:<6} mean {own.mean():.3f}, largest {own.max():.2f}, {far} of {own.size} devices",
            flush=True,
        )


if __name__ == "__main__":
    main()
