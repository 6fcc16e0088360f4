#!/usr/bin/env python
"""Do 95 % intervals hold the true numbers after the rows have chosen the terms?

`studies/recovery.py` fits the law that made the log. Here `erclutch fit` is asked for Bingham's law, and the rows
decide which terms it has: a constant effort and friction stay only where they can be told, and a memory comes where the
search asks for it. SYNTHETIC logs of known truths, noise drawn anew for each:

    all told    five fields, slip of both signs, friction and a constant effort
    one way     slip of one sign: friction is a constant effort
    two fields  friction, yield effort and exponent are three numbers, of which two fields tell two; friction is none
    memory      a Dahl state that the field enters (`dahl/field`), which the search for memory has to find

    python studies/chosen_terms.py [--logs 200] [--first 0] [--cases "one way" memory] [--rows 1500] [--noise resonance]

The noise is white; "drift", an autoregression of 0.97; or "resonance", which swings at the pace of the motion (a period
of 260 rows, and a decay over 50).

Printed for each case: in how many logs the chosen terms were the true ones, the share of true numbers inside their
intervals over all logs and numbers that the chosen model has, and the number with the smallest share. Exits with 1
where a case misses 95 % by more than 3 points; fewer than 100 logs get no verdict.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.candidate import Fitted, kinds
from erclutch.fit.fit_settings import Settings
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

TARGET, TOLERANCE, ENOUGH = 0.95, 0.03, 100
PERIOD, NOISE = 2e-3, 0.02  # s, N m
TRUTH = {"T_y": 0.8, "eta": 0.05, "n": 1.5, "w_s": 0.3}
TRAVEL = 0.02  # rad
#: Coefficients of the autoregression that makes a noise.
NOISES = {
    "white": (),
    "drift": (0.97,),
    "resonance": (2.0 * 0.98 * float(np.cos(2.0 * np.pi / 260.0)), -(0.98**2)),
}
SETTLED = 1000  # rows of noise that are thrown away


@dataclass(frozen=True)
class Case:
    """A kind of log.

    Attributes:
        fields: levels of the field, the largest 1.
        forward: speed that is added to the motion, in rad/s.
        numbers: true numbers by the names of the fit.
        remembers: whether the yield effort is a Dahl state that the field enters.
    """

    fields: tuple[float, ...]
    forward: float
    numbers: Mapping[str, float]
    remembers: bool = False


CASES = {
    "all told": Case((0.0, 0.3, 0.5, 0.8, 1.0), 0.0, {**TRUTH, "T_f": 0.2, "T_0": 0.05}),
    "one way": Case(
        (0.0, 0.3, 0.5, 0.8, 1.0), 6.0, {"T_y": 0.8, "eta": 0.05, "n": 1.5, "T_0": 0.2}
    ),
    "two fields": Case((0.2, 1.0), 0.0, {**TRUTH, "T_0": 0.05}),
    "memory": Case(
        (0.0, 0.3, 0.5, 0.8, 1.0),
        0.0,
        {"T_z1": 0.8, "eta": 0.05, "n": 1.5, "r_1": TRAVEL},
        remembers=True,
    ),
}


def noise_of(kind: str, rows: int, rng: np.random.Generator) -> Array:
    """Noise of variance one, shape (rows,)."""
    weights = NOISES[kind]
    if not weights:
        return rng.standard_normal(rows)
    drawn = rng.standard_normal(SETTLED + rows)
    for k in range(len(weights), drawn.size):
        drawn[k] += sum(weight * drawn[k - back] for back, weight in enumerate(weights, 1))
    one, two = (*weights, 0.0)[:2]
    variance = (1.0 - two) / ((1.0 + two) * ((1.0 - two) ** 2 - one**2))
    return drawn[SETTLED:] / np.sqrt(variance)


def log_of(case: Case, rows: int, seed: int, noise: str = "white") -> Dataset:
    """A log of a case; field and motion are drawn anew too."""
    rng = np.random.default_rng(seed)
    t: Array = PERIOD * np.arange(float(rows))
    field = np.repeat(rng.choice(case.fields, rows // 60 + 1), 60)[:rows]
    phases = rng.uniform(0.0, 2.0 * np.pi, 2)
    slip = case.forward + 3.0 * np.sin(4.4 * t + phases[0]) + 2.0 * np.sin(11.9 * t + phases[1])
    yielding = case.numbers.get("T_y", 0.8) * field ** case.numbers["n"]
    if case.remembers:
        yielded = _dahl(yielding, slip)
    else:
        yielded = yielding * np.tanh(slip / case.numbers.get("w_s", 1e-3))
    effort = yielded + case.numbers["eta"] * slip + case.numbers.get("T_0", 0.0)
    effort += case.numbers.get("T_f", 0.0) * np.tanh(slip / TRUTH["w_s"])
    clock = Clock(t, (Span(0, rows, PERIOD),))
    noisy = effort + NOISE * noise_of(noise, rows, rng)
    return Dataset("single", (Element(field, slip),), noisy, clock, Units("N*m", "A", "rad/s"))


def _dahl(yielding: Array, slip: Array) -> Array:
    """A Dahl state, which tends to the yield effort in the way of the slip and has got there when the log begins."""
    state, states = yielding[0] * np.sign(slip[0]), np.empty(slip.size)
    for k, (effort, w) in enumerate(zip(yielding, slip, strict=True)):
        gone = 1.0 - np.exp(-abs(w) * PERIOD / TRAVEL)
        state = states[k] = (1.0 - gone) * state + gone * effort * np.sign(w)
    return states


def held_by(case: Case, data: Dataset) -> dict[str, bool]:
    """Of each true number that the chosen model has, whether its interval holds it."""
    settings = Settings(("bingham",), lag="auto" if case.remembers else "none")
    _, laws = kinds()[0]
    asked = [each for each in laws.candidates(settings, data) if each.name == "bingham"]
    fitted = [Fitted(each, each.fit(data, (), 1)) for each in asked]
    further = laws.grown(settings, data, fitted).candidates if case.remembers else []
    outcome = further[0].fit(data, (), 1) if further else fitted[0].outcome
    return {
        each.name: bool(each.low <= case.numbers[each.name] <= each.high)
        for each in outcome.estimates
        if each.name in case.numbers
    }


def main() -> int:
    """Print a line a case."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--logs", type=int, default=200)
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))
    parser.add_argument("--rows", type=int, default=1500)
    parser.add_argument("--first", type=int, default=0, help="seed of the first log")
    parser.add_argument("--noise", default="white", choices=list(NOISES))
    asked = parser.parse_args()
    missed = False
    for name in asked.cases:
        case = CASES[name]
        seeds = range(asked.first, asked.first + asked.logs)
        found = [held_by(case, log_of(case, asked.rows, seed, asked.noise)) for seed in seeds]
        right = sum(set(each) == set(case.numbers) for each in found)
        told, held = (
            Counter(key for each in found for key in each),
            Counter(k for each in found for k in each if each[k]),
        )
        share = sum(held.values()) / sum(told.values())
        least = min(told, key=lambda key: held[key] / told[key])
        print(
            f"{name:<11} true terms in {right} of {len(found)} logs; intervals hold {share:.1%}, "
            f"the least {least} {held[least] / told[least]:.1%}",
            flush=True,
        )
        missed |= len(found) >= ENOUGH and abs(share - TARGET) > TOLERANCE
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
