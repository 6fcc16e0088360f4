#!/usr/bin/env python
"""Is the law that `fit` recommends near the noise of devices that are unlike each other?

SYNTHETIC devices of known truth, 20 s at 500 Hz each: dampers, friction without a field, a valve, a brake. Three laws
are fitted with the memory that the first 70 % of the rows choose; the rest judges the recommended one.

    python studies/made_up_devices.py [--only "ball screw"]

Printed for each device: the recommended model, its error over the standard deviation of the noise, its numbers.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.signal import lfilter

from erclutch.fit.comparison import Settings, compare
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.signals.recording import POSITION, TEMPERATURE

PERIOD, BEFORE, ROWS = 2e-3, 1000, 11_000  # s, rows before the log begins, with these
TIME: Array = PERIOD * np.arange(float(ROWS))
MODELS = ("bingham", "casson", "herschel-bulkley")


def waves(
    rng: np.random.Generator, size: float, lowest: float, highest: float
) -> tuple[Array, Array]:
    """A travel of six sines between these frequencies in Hz, and its rate."""
    travel = np.zeros(ROWS)
    for hertz in np.exp(rng.uniform(np.log(lowest), np.log(highest), 6)).tolist():
        travel += rng.uniform(0.4, 1.0) * np.sin(
            2.0 * np.pi * hertz * TIME + rng.uniform(0.0, 6.28)
        )
    travel *= size / 6**0.5
    return travel, np.gradient(travel, PERIOD)


def switched(
    rng: np.random.Generator, levels: tuple[float, ...], constant: float
) -> tuple[Array, Array]:
    """A command that switches between levels every half second, and the field that lags behind it."""
    command = np.repeat(rng.choice(levels, ROWS // 250), 250)
    keep = np.exp(-PERIOD / constant)
    field: Array = np.asarray(lfilter([1.0 - keep], [1.0, -keep], command))
    return command, field


def yielding(slip: Array, travel: float) -> Array:
    """A Dahl state."""
    states, at = np.empty(ROWS), 0.0
    for k, w in enumerate(slip.tolist()):
        gone = 1.0 - np.exp(-abs(w) * PERIOD / travel)
        at = states[k] = (1.0 - gone) * at + gone * np.sign(w)
    return states


def bristles(
    slip: Array,
    sliding: float,
    static: float,
    speed: float,
    stiffness: float,
    damping: float,
    forward: float = 0.0,
) -> Array:
    """LuGre's friction, in steps of a twentieth of the period; forward its levels are higher by a share, else lower."""
    bent, effort = 0.0, np.empty(ROWS)
    for k, w in enumerate(slip.tolist()):
        level = sliding + (static - sliding) * np.exp(-((w / speed) ** 2))
        level *= 1.0 + forward * np.sign(w)
        rate = 0.0
        for _ in range(20):
            rate = w - stiffness * abs(w) / level * bent
            bent += rate * PERIOD / 20
        effort[k] = stiffness * bent + damping * rate
    return effort


def knees(slip: Array, gains: tuple[float, float, float, float], at: tuple[float, float]) -> Array:
    """Rebound and compression of an oil damper, each steep up to its knee and flat beyond."""
    size = np.abs(slip)
    rebound = gains[0] * np.minimum(size, at[0]) + gains[1] * np.maximum(size - at[0], 0.0)
    compression = gains[2] * np.minimum(size, at[1]) + gains[3] * np.maximum(size - at[1], 0.0)
    return np.where(slip > 0.0, rebound, -compression)


def logged(
    field: Array, slip: Array, effort: Array, noise: float, extras: dict[str, Array] | None = None
) -> tuple[Dataset, float]:
    """The log, and its noise."""
    kept = slice(BEFORE, ROWS)
    time = TIME[: ROWS - BEFORE]
    measured = effort[kept] + noise * np.random.default_rng(1).standard_normal(time.size)
    clock = Clock(time, (Span(0, time.size, PERIOD),))
    further = {name: values[kept] for name, values in (extras or {}).items()}
    element = Element(field[kept], slip[kept])
    return Dataset(
        "single", (element,), measured, clock, Units("N", "A", "m/s"), extras=further
    ), noise


def damper_of_dahl() -> tuple[Dataset, float]:
    """A magnetorheological damper whose field works behind its memory, beside a spring."""
    rng = np.random.default_rng(1)
    travel, slip = waves(rng, 0.02, 0.2, 4.0)
    command, field = switched(rng, (0.0, 0.25, 0.5, 0.75, 1.0), 0.01)
    effort = (
        300.0 * travel
        + (200.0 + 300.0 * field) * slip
        + (40.0 + 600.0 * field) * yielding(slip, 0.0015)
    )
    return logged(command, slip, effort, 8.0)


def oil_damper() -> tuple[Dataset, float]:
    """Rebound unlike compression, a knee each, a gas spring that stiffens, friction of the seal."""
    travel, slip = waves(np.random.default_rng(2), 0.015, 0.2, 5.0)
    effort = knees(slip, (4000.0, 1200.0, 2500.0, 500.0), (0.08, 0.05))
    effort += 120.0 + 900.0 * travel / (1.0 - travel / 0.12) + 25.0 * yielding(slip, 0.0003)
    return logged(np.zeros(ROWS), slip, effort, 6.0, {POSITION: travel})


def lugre_rig() -> tuple[Dataset, float]:
    """Friction with stiction, less in one way."""
    _, slip = waves(np.random.default_rng(3), 0.004, 0.1, 2.0)
    effort = bristles(slip, 10.0, 16.0, 0.004, 1e5, 150.0)
    effort = np.where(slip > 0.0, 1.0, 0.85) * effort + 60.0 * slip
    return logged(np.zeros(ROWS), slip, effort, 0.2)


def rig_with_two_levels() -> tuple[Dataset, float]:
    """The same with levels of its own for each way: the friction goes on as the slip turns, where that above jumps."""
    _, slip = waves(np.random.default_rng(3), 0.004, 0.1, 2.0)
    effort = bristles(slip, 10.0, 16.0, 0.004, 1e5, 150.0, forward=0.08) + 60.0 * slip
    return logged(np.zeros(ROWS), slip, effort, 0.2)


def robot_joint() -> tuple[Dataset, float]:
    """Friction that differs between the ways, and a grease that warms and thins."""
    _, slip = waves(np.random.default_rng(4), 1.2, 0.1, 0.8)
    warmth = 298.0 + 15.0 * (1.0 - np.exp(-TIME / 8.0))
    effort = np.where(slip > 0.0, 4.0, 3.4) * np.tanh(slip / 0.02)
    effort += 3.0 * np.sign(slip) * np.abs(slip) ** 0.6 * np.exp(-0.02 * (warmth - 298.0))
    return logged(np.zeros(ROWS), slip, effort, 0.08, {TEMPERATURE: warmth})


def ball_screw() -> tuple[Dataset, float]:
    """Stribeck's friction and a ripple over the lead."""
    travel, slip = waves(np.random.default_rng(5), 0.08, 0.05, 0.5)
    effort = (0.3 + 0.15 * np.exp(-((slip / 0.008) ** 2))) * np.tanh(slip / 0.0008) + 1.5 * slip
    effort += 0.03 * np.sin(2.0 * np.pi * travel / 0.01 + 0.4)
    return logged(np.zeros(ROWS), slip, effort, 0.006, {POSITION: travel})


def valve_damper() -> tuple[Dataset, float]:
    """Rebound unlike compression, both set by the current of a valve."""
    rng = np.random.default_rng(6)
    _, slip = waves(rng, 0.02, 0.2, 4.0)
    command, field = switched(rng, (0.0, 0.4, 0.8, 1.2, 1.6), 0.012)
    size = np.abs(slip)
    rebound = (300.0 + 900.0 * (np.maximum(field, 0.0) / 1.6) ** 1.2) * np.tanh(
        size / 0.06
    ) + 500.0 * size
    effort = np.where(slip > 0.0, rebound, -0.55 * rebound) + 90.0 + 20.0 * np.tanh(slip / 0.002)
    return logged(command, slip, effort, 8.0)


def brake_that_saturates() -> tuple[Dataset, float]:
    """A brake whose iron saturates."""
    rng = np.random.default_rng(7)
    _, slip = waves(rng, 4.0, 0.1, 2.0)
    command, field = switched(rng, (0.0, 0.3, 0.6, 1.0), 0.03)
    level = 0.1 + 3.0 * np.tanh((np.maximum(field, 0.0) / 0.7) ** 1.6)
    effort = level * yielding(slip, 0.05) * (1.0 + 0.15 * np.exp(-np.abs(slip) / 3.0)) + 0.02 * slip
    return logged(command, slip, effort, 0.03)


DEVICES: tuple[Callable[[], tuple[Dataset, float]], ...] = (
    damper_of_dahl,
    oil_damper,
    lugre_rig,
    rig_with_two_levels,
    robot_joint,
    ball_screw,
    valve_damper,
    brake_that_saturates,
)


def judged(only: str) -> Iterator[str]:
    """A line for each device."""
    for make in DEVICES:
        name = make.__name__.replace("_", " ")
        if only not in name:
            continue
        data, noise = make()
        result = compare(data, Settings(models=MODELS))
        chosen = result.entry(result.recommended)
        over = chosen.test.rmse.value / noise
        yield f"{name:<21} {over:5.2f} times the noise, {chosen.outcome.parameters:2} numbers: {chosen.name}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", default="", help="a part of a device's name")
    for line in judged(parser.parse_args().only):
        print(line, flush=True)


if __name__ == "__main__":
    main()
