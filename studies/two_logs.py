#!/usr/bin/env python
"""Of two logs of two motions: should each be left out in turn, or blocks of both in time, to choose a model?

SYNTHETIC devices of known truth: of every two one is logged in sines at one field (`studies/two_motions.py`), the other
in motion and field that change at random (`studies/quiet_block.py`), a log each of four sizes and paces. Laws, a law
with a network and a network alone are fitted to two logs. Parts of these rows choose a model by each rule, and all
logs that nothing has seen judge it.

    python studies/two_logs.py [--devices 12] [--first 902] [--rules blocks logs further both]
    python studies/two_logs.py --utfsm FOLDER

With a folder, pairs of sines of the UTFSM damper at one current, a real recording. Rules: blocks in time, as before
decision 0004 was amended; whole logs, as now; whole logs that count the same, whose ties go to the least error
(further); whole logs and blocks (both).

Printed for each rule: the error of the chosen model on the logs unseen over the least error of all.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest import mock

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.signal import lfilter

from erclutch.fit.candidate import Fitted, kinds
from erclutch.fit.choice import validation
from erclutch.fit.choice.parts_left_out import LeftOut
from erclutch.fit.choice.validation import chosen
from erclutch.fit.fit_settings import Settings
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.logs.held_out import time_folds
from erclutch.signals.array import Array, Mask, rms
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from studies.bands import UTFSM
from studies.quiet_block import PERIOD, remembered, waves
from studies.two_motions import device as with_sines

#: Which two logs are fitted; all others judge.
PAIRS = {True: ((1, 3), (0, 4), (2, 5)), False: ((0, 1), (1, 2), (0, 3))}
#: Of the real recording: sines and currents as the names of its files write them, and what is fitted.
SINES = ("2mm5Hz", "5mm3Hz", "10mm1Hz", "25mm0x1Hz", "25mm0x25Hz", "25mm0x5Hz")
CURRENTS = ("0x25", "0x5", "1")
REAL_PAIRS = ((0, 3), (1, 4), (2, 5))
AT_ONE_FIELD = (
    "bingham/constant",
    "bingham/constant+dahl/field",
    "herschel-bulkley/constant+lugre/field",
    "bingham/constant+dahl-2/field+viscous",
    "bingham/constant+lugre/field+inertia+viscous",
    "bingham+fnn-16+dahl/field",
    "fnn-16+dahl/field",
)
AT_MANY_FIELDS = (
    "casson",
    "bingham+dahl/field",
    "casson+dahl/field",
    "casson/tanh+lugre/field+viscous",
    "bingham+dahl-2/field+viscous",
    "casson+fnn-16+dahl/field",
    "fnn-16+dahl/field",
)
ROWS = 4000


def at_random(seed: int) -> Dataset:
    """Four logs of one device: random motion of a size and pace of its own, and random field."""
    rng = np.random.default_rng(seed)
    draw = rng.uniform
    strain, shorter = draw(0.05, 0.4), draw(0.01, 0.08)
    floor, rise, exponent = draw(20.0, 150.0), draw(300.0, 800.0), draw(0.8, 1.8)
    second = draw(0.0, 0.35) * (draw() < 0.8)
    viscosity, thinning, inertia = draw(0.5, 3.0), draw(0.6, 1.0), draw(0.0, 0.1)
    noise, alike, drift = draw(3.0, 25.0), draw(0.0, 0.95), draw(0.0, 0.1) * (draw() < 0.5)
    logs: list[Dataset] = []
    for number in range(4):
        time: Array = PERIOD * np.arange(float(ROWS))
        size, pace = draw(15.0, 90.0), np.exp(draw(np.log(0.4), np.log(2.5)))
        slip = 0.5 * size * waves(rng, time, 0.4 * pace, 2.0 * pace, 5)
        field = 0.5 + 0.5 * np.tanh(0.6 * waves(rng, time, 0.05, 1.5, 8))
        level = (floor + rise * field**exponent) * (1.0 + drift * rng.standard_normal())
        effort = (1.0 - second) * remembered(slip, strain, level)
        effort += second * remembered(slip, shorter, level) * np.tanh(np.abs(slip) / 30.0)
        effort += viscosity * np.sign(slip) * np.abs(slip) ** thinning + inertia * np.gradient(
            slip, PERIOD
        )
        error: Array = np.asarray(lfilter([1.0], [1.0, -alike], rng.standard_normal(ROWS)))
        effort += noise * error * np.sqrt(1.0 - alike * alike)
        clock = Clock(time, (Span(0, ROWS, PERIOD),))
        log = Dataset("single", (Element(field, slip),), effort, clock, Units("N", "A", "mm/s"))
        logs.append(replace(log, sources=(f"m{number}",)))
    return joined(logs)


def parts_of(train: Dataset, rule: str) -> LeftOut:
    """What a rule leaves out in turn."""
    blocks = time_folds(train, 4)
    logs: list[Mask] = []
    for start, stop in train.source_rows:
        if stop > start:
            place = np.arange(train.rows)
            logs.append((place >= start) & (place < stop))
    masks = {"blocks": blocks, "both": [*logs, *blocks]}.get(rule, logs)
    return LeftOut(rule, masks, further=rule == "further")


def made_up(seed: int) -> tuple[Dataset, bool]:
    """The logs of a device, and whether they are sines at one field."""
    sines = seed % 2 == 0
    return (with_sines(seed, noise=0.03) if sines else at_random(seed)), sines


def real(folder: Path, current: str) -> tuple[Dataset, bool]:
    """The six sines of the UTFSM damper at one current."""
    return build_dataset([read(folder / f"{sine}{current}A.txt", UTFSM) for sine in SINES]), True


def judged(
    every: Dataset, sines: bool, pairs: tuple[tuple[int, int], ...], rules: list[str]
) -> Iterator[dict[str, float]]:
    """For each pair of logs the error of the model that each rule chooses, over the least."""
    settings = Settings(AT_ONE_FIELD if sines else AT_MANY_FIELDS, lag="none")
    for pair in pairs:
        held = np.ones(every.rows, np.bool_)
        filled = [rows for rows in every.source_rows if rows[1] > rows[0]]
        for number, (start, stop) in enumerate(filled):
            held[start:stop] = number not in pair
        train = every.take(~held)
        fitted: list[Fitted] = []
        with one_thread():
            for _, kind in kinds():
                fitted += [
                    Fitted(each, each.fit(train, fitted, 1))
                    for each in kind.candidates(settings, train)
                ]
            errors = {
                f.outcome.model.name: rms((every.effort - f.outcome.model.predict(every))[held])
                for f in fitted
            }
            sound = [f.outcome.model.name for f in fitted if f.outcome.sound]
            found: dict[str, float] = {}
            for rule in rules:
                with mock.patch.object(
                    validation, "parts_of_training", lambda train, rule=rule: parts_of(train, rule)
                ):
                    choice = chosen(train, fitted, sound, seed=0)
                assert choice is not None
                found[rule] = errors[choice.recommended] / min(errors.values())
        yield found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--devices", type=int, default=12)
    parser.add_argument("--first", type=int, default=902, help="seed of the first device")
    parser.add_argument("--utfsm", type=Path, help="folder with the logs of the UTFSM damper")
    parser.add_argument("--rules", nargs="+", default=["blocks", "logs", "further", "both"])
    parser.add_argument("--each", action="store_true", help="a line for each pair of logs too")
    asked = parser.parse_args()
    rows: list[dict[str, float]] = []
    devices: list[Callable[[], tuple[Dataset, bool]]] = []
    if asked.utfsm is None:
        devices += [
            partial(made_up, seed) for seed in range(asked.first, asked.first + asked.devices)
        ]
    else:
        devices += [partial(real, asked.utfsm, current) for current in CURRENTS]
    for number, make in enumerate(devices):
        every, sines = make()
        pairs = PAIRS[sines] if asked.utfsm is None else REAL_PAIRS
        for found in judged(every, sines, pairs, asked.rules):
            rows.append(found)
            if asked.each:
                print(number, *(f"{rule} {ratio:.3f}" for rule, ratio in found.items()), flush=True)
    for rule in asked.rules:
        own = np.array([row[rule] for row in rows])
        print(
            f"{rule:<8} geometric mean {np.exp(np.mean(np.log(own))):.3f}, largest {own.max():.2f}, over 1.1 in "
            f"{np.mean(own > 1.1):.0%}, over 1.3 in {np.mean(own > 1.3):.0%} of {own.size}",
            flush=True,
        )


if __name__ == "__main__":
    main()
