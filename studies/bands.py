#!/usr/bin/env python
"""Does a prediction band of 95 % hold 95 % of the rows of logs that were not there when it was made?

Models are fitted and their bands calibrated on a few SYNTHETIC logs. Fresh logs of the same source (another seed of
command, motion and noise) then judge each band, without a torque sensor and with one.

    python studies/bands.py [--logs 100] [--fits 5] [--models bingham+lag casson+lag+dahl fnn-16+lag]
    python studies/bands.py --utfsm FOLDER [--models casson+dahl/field]
    python studies/bands.py --stretches FILE [--models all]

The second line judges bands for other motions on a recording: FOLDER holds the logs of the UTFSM damper. Each motion of
the training logs is left out in turn; then the test is held out, 0.5 A and all of 5 mm 3 Hz. What bands are made of is
chosen by the motions alone. The last line is of a band that is calibrated on the test itself, so no band of these cells
is narrower.

The third line holds out each of six stretches of one log in turn, each of 30 % of the rows: FILE is the NEES damper.
The model is the one that `erclutch fit` recommends for the rows left.

Exits with 1 where the share of rows inside, over all fresh logs, misses 95 % by more than 2 points.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.bands.prediction_bands import HeldBand, calibrated, judged
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.logs.held_out import hold_out
from erclutch.logs.synthetic import RATE, synthetic_log
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

TARGET = 0.95
TOLERANCE = 0.02
TRAINING_S = 20.0
FRESH_S = 5.0
#: How a log of UTFSM is read, its motions for training, and its logs for the test.
UTFSM = {
    "time": "c1 [s]",
    "columns": {"slip": "c3 [mm/s]", "effort": "c4 [N]"},
    "name_pattern": "{amplitude}mm{frequency}Hz{field}A",
}
MOTIONS = ("10mm1Hz", "25mm0x1Hz", "25mm0x25Hz", "25mm0x5Hz", "2mm5Hz")
TEST = ("*0x5A.txt", "5mm3Hz*")
#: How the log of NEES is read; where the stretches held out of it begin, and their length, as shares of its rows.
NEES = {"columns": {"field": "Y [V]", "slip": "V [cm/s]", "effort": "F [N]"}}
BEGIN = (0.0, 0.14, 0.28, 0.42, 0.56, 0.7)
LENGTH = 0.3


def made_up(seconds: float, seed: int) -> Dataset:
    """A SYNTHETIC log as rows."""
    columns = {name: values for name, (_, values) in synthetic_log(seconds, seed).items()}
    clock = Clock(columns["time"], (Span(0, columns["time"].size, 1.0 / RATE),))
    elements = (Element(columns["field"], columns["slip"]),)
    return Dataset("single", elements, columns["torque"], clock, Units("N*m", "V", "rad/s"))


def judge(models: tuple[str, ...], fits: int, logs: int) -> dict[str, list[HeldBand]]:
    """How the band of each model does on each fresh log."""
    bands: dict[str, list[HeldBand]] = {}  # by model
    for fit in range(fits):
        comparison = compare(
            made_up(TRAINING_S, fit), Settings(models=models, lag="none", seed=fit)
        )
        fresh = [made_up(FRESH_S, 1000 + k) for k in range(fit, logs, fits)]
        for entry in comparison.entries:
            model = entry.outcome.model
            if model.band is None or entry.band is None:
                continue
            for data in fresh:
                all_rows = np.ones(data.rows, np.bool_)
                figures = judged(
                    data, all_rows, model.predict(data), model.band, entry.band.plain, sensor=True
                )
                bands.setdefault(entry.name, []).append(figures)
    return bands


def of_motions(folder: Path, model: str) -> Iterator[tuple[str, HeldBand]]:
    """How the band of a model does on motions that were left out of the training logs, and on the test."""
    paths = sorted(folder.glob("*mm*.txt"))
    data = build_dataset([read(path, UTFSM) for path in paths])
    seen = build_dataset(
        [read(path, UTFSM) for path in paths if not any(path.match(name) for name in TEST)]
    )
    for motion in MOTIONS:
        entry = compare(seen, Settings((model,), "none", (f"{motion}*",))).entries[0]
        assert entry.band is not None
        yield f"{motion} left out", entry.band
    entry = compare(data, Settings((model,), "none", TEST)).entries[0]
    assert entry.band is not None
    yield "test", entry.band
    test = hold_out(data, TEST)
    best = calibrated(data, test, [data.effort - entry.predicted], [0])[0]
    assert best is not None
    yield (
        "test, calibrated on itself",
        judged(data, test, entry.predicted, best[0], entry.band.plain, sensor=True),
    )


def of_stretches(path: Path, models: tuple[str, ...]) -> Iterator[tuple[str, HeldBand]]:
    """How the band of the recommended model does on each stretch of a log."""
    data = build_dataset(read(path, NEES))
    for begin in BEGIN:
        start, stop = round(begin * data.rows), round((begin + LENGTH) * data.rows)
        held = np.zeros(data.rows, np.bool_)
        held[start:stop] = True
        known_part = replace(data.take(~held), sources=("known",))
        held_part = replace(data.take(held), sources=("held",))
        comparison = compare(joined([known_part, held_part]), Settings(models, test=("held",)))
        best = next(entry for entry in comparison.entries if entry.name == comparison.recommended)
        assert best.band is not None
        yield f"{begin:.0%} - {begin + LENGTH:.0%}", best.band


def print_bands(title: str, bands: Iterator[tuple[str, HeldBand]]) -> None:
    """A line for each part that was held out."""
    print(
        f"\n{title:<28} {'inside':>8} {'worst part':>28} {'over plain':>11} {'sensor':>8} {'over plain':>11}",
        flush=True,
    )
    for name, figures in bands:
        held, taught = figures.held, figures.with_sensor
        assert taught is not None
        worst = f"{held.where.removesuffix('.txt').removeprefix('the second ')} {held.worst:.1%}"
        print(
            f"{name:<28} {held.share:>8.1%} {worst:>28} {held.width / figures.plain:>11.2f}"
            f" {taught.share:>8.1%} {taught.width / figures.plain:>11.2f}",
            flush=True,
        )


def main() -> int:
    """Print a line a model; 1 where a band misses."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--logs", type=int, default=100, help="fresh logs")
    parser.add_argument("--fits", type=int, default=5, help="training logs")
    parser.add_argument(
        "--models", nargs="+", help="default: three; casson+dahl/field of UTFSM; all of NEES"
    )
    parser.add_argument(
        "--utfsm", type=Path, metavar="FOLDER", help="logs of the UTFSM damper: judge other motions"
    )
    parser.add_argument(
        "--stretches", type=Path, metavar="FILE", help="log of the NEES damper: judge its stretches"
    )
    asked = parser.parse_args()
    if asked.utfsm:
        for model in asked.models or ["casson+dahl/field"]:
            print_bands(model, of_motions(asked.utfsm, model))
        return 0
    if asked.stretches:
        print_bands("held out", of_stretches(asked.stretches, tuple(asked.models or ["all"])))
        return 0
    asked.models = asked.models or ["bingham+lag", "casson+lag+dahl", "fnn-16+lag"]
    print(
        f"{asked.logs} fresh logs of {FRESH_S:g} s, {asked.fits} fits on {TRAINING_S:g} s (SYNTHETIC)"
    )
    print(f"{'model':<20} {'sensor':<8} {'inside':>8} {'logs from .. to':>18} {'over plain':>11}")
    missed = False
    for name, figures in judge(tuple(asked.models), asked.fits, asked.logs).items():
        for sensor in ("without", "with"):
            held = [each.held if sensor == "without" else each.with_sensor for each in figures]
            shares = np.array([each.share for each in held if each is not None])
            widths = [
                each.width / f.plain
                for each, f in zip(held, figures, strict=True)
                if each is not None
            ]
            low, high = np.quantile(shares, (0.025, 0.975))
            missed |= abs(float(np.mean(shares)) - TARGET) > TOLERANCE
            print(
                f"{name:<20} {sensor:<8} {np.mean(shares):>8.1%} {f'{low:.1%} .. {high:.1%}':>18}"
                f" {np.mean(widths):>11.2f}"
            )
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
