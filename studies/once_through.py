#!/usr/bin/env python
"""A log goes once through its fields and speeds: do stretches all over it choose a model beside blocks in time?

SYNTHETIC devices of the eight kinds of `next_log.py` are logged once each: a speed that rises from rest, or a motion
that grows, while the field rises from none to its largest, falls, goes up in steps, or sways a little. A next log of
the device goes the other way, with another motion. Nine models are fitted to the training rows of the first log; parts
of these, left out in turn, choose one. The rows held out and the next log judge it: by blocks in time alone (before
decision 0004 was amended on 2026-12-01) and now.

    python studies/once_through.py [--devices 32] [--first 0]

Printed: the error of the chosen model over the least of all, on the rows held out and on the next log, by both rules.
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
from erclutch.fit.checks.usual_hold_out import usual_hold_out
from erclutch.fit.choice import parts_left_out
from erclutch.fit.choice.validation import chosen
from erclutch.fit.fit_settings import Settings
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import hold_out
from erclutch.signals.array import Array, rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from studies.next_log import TRUTHS, Truth

PERIOD, ROWS = 5e-3, 4000
STEPS = 10  # of the simulation in a period
MODELS = (
    "bingham",
    "casson",
    "herschel-bulkley",
    "bingham+dahl/field",
    "bingham/tanh+dahl/field",
    "bingham+fnn-16",
    "bingham+fnn-16+dahl/field",
    "fnn-16",
    "rbfn-10",
)


def device(seed: int) -> tuple[Dataset, Dataset]:
    """A log and the next log of a device, its numbers drawn."""
    rng = np.random.default_rng(seed)

    def draw(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    truth = TRUTHS[seed % len(TRUTHS)](draw)
    noise = draw(0.005, 0.03)  # of the effort's spread
    # The four ways of the field go with all eight kinds of device in 32 seeds.
    way = (seed // len(TRUTHS)) % 4
    turns = draw(0.0, 1.0) < 0.5
    first = logged(truth, draw, way, turns=turns, back=False)
    second = logged(truth, draw, way, turns=turns, back=True)
    spread = noise * float(np.std(first.effort))
    first.effort[:] += spread * rng.standard_normal(first.rows)
    second.effort[:] += spread * rng.standard_normal(second.rows)
    return first, second


def logged(
    truth: Truth, draw: Callable[[float, float], float], way: int, *, turns: bool, back: bool
) -> Dataset:
    """A log that goes once through its speeds and fields, or back.

    Args:
        truth: of the device.
        draw: a number between two.
        way: of the field: it sways a little, rises, falls, or goes up in steps.
        turns: whether the device goes to and fro; else it turns one way.
        back: whether all goes from its end to its beginning.
    """
    time = PERIOD / STEPS * np.arange(float(ROWS * STEPS))
    share = time / time[-1]
    if back:
        share = 1.0 - share
    field = (
        0.6 + 0.1 * np.sin(0.7 * time),
        share,
        1.0 - share,
        np.floor(5.0 * share).clip(0.0, 4.0) / 4.0,
    )[way]
    top = draw(40.0, 100.0)  # mm/s
    wobble = np.sin(2.0 * np.pi * draw(0.3, 0.7) * time + draw(0.0, 6.28))
    rising = 0.05 + 0.95 * share
    slip = top * rising * (wobble if turns else 1.0 + 0.1 * wobble)
    place = np.cumsum(slip) * PERIOD / STEPS
    # A truth takes one field a call, and states of its own: the effort of each level is taken where the field is there.
    levels = np.round(40.0 * field) / 40.0
    effort = np.empty(share.size)
    for level in np.unique(levels):
        own = levels == level
        effort[own] = truth(float(level), slip, place, PERIOD / STEPS)[own]
    clock = Clock(time[::STEPS], (Span(0, ROWS, PERIOD),))
    element = Element(levels[::STEPS], slip[::STEPS])
    return Dataset("single", (element,), effort[::STEPS].copy(), clock, Units("N", "A", "mm/s"))


def judged(seed: int) -> tuple[Array, str]:
    """Error of the chosen model over the least, shape (held out or next log, before or now); and what was left out."""
    data, following = device(seed)
    test, _ = usual_hold_out(data)
    held = hold_out(data, test)
    train = data.take(~held)
    settings = Settings(MODELS, lag="none")
    fitted: list[Fitted] = []
    with one_thread():
        for _, kind in kinds():
            candidates = kind.candidates(settings, train)
            fitted += [Fitted(each, each.fit(train, fitted, 1)) for each in candidates]
        sound = [each.outcome.name for each in fitted if each.outcome.sound]
        now = chosen(train, fitted, sound, seed=0)
        with mock.patch.object(parts_left_out, "stretches_left_out", return_value=[]):
            before = chosen(train, fitted, sound, seed=0)
    assert now is not None
    assert before is not None
    ratios: list[list[float]] = []
    for log, rows in ((data, held), (following, np.ones(following.rows, np.bool_))):
        errors: dict[str, float] = {}
        for each in fitted:
            errors[each.outcome.name] = rms((log.effort - each.outcome.model.predict(log))[rows])
        least = min(errors.values())
        ratios.append([errors[each.recommended] / least for each in (before, now)])
    return np.array(ratios), now.words


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=32)
    parser.add_argument("--first", type=int, default=0, help="seed of the first device")
    asked = parser.parse_args()
    all_ratios: list[Array] = []
    for seed in range(asked.first, asked.first + asked.devices):
        ratios, words = judged(seed)
        name = TRUTHS[seed % len(TRUTHS)].__name__
        (held_before, held_now), (next_before, next_now) = ratios
        print(
            f"{seed:>5} {name:<18} {words:<52} held out {held_before:.2f} -> {held_now:.2f}, "
            f"next log {next_before:.2f} -> {next_now:.2f}",
            flush=True,
        )
        all_ratios.append(ratios)
    of_all = np.array(all_ratios)  # shape (devices, 2, 2)
    for place, rows in enumerate(("held out", "next log")):
        for number, rule in enumerate(("blocks in time", "now")):
            own = of_all[:, place, number]
            mean = np.exp(np.log(own).mean())
            far = f"over 1.1 in {np.mean(own > 1.1):.0%}, over 1.3 in {np.mean(own > 1.3):.0%}"
            print(
                f"{rows}, {rule:<14} geometric mean {mean:.3f}, largest {own.max():.2f}, {far}",
                flush=True,
            )


if __name__ == "__main__":
    main()
