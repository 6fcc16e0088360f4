"""How surely a network reaches its best known optimum, on the TWIN: `python studies/seeds.py [--seeds 20]`.

Best known, of all fits of the size in the run, polished ones included: the lowest training error, the lowest test
error, and the test error of the fit with the lowest training error. The lowest test error is chosen on the test rows,
so it falls with every fit that is added; the last one is what a user with unlimited time would have.

A long run is one start without spare neurons and exchanges: steps on the finest grid until the error falls no more,
then up to 30 on all rows. Polished fits are compared with the best of these runs too.
"""

from __future__ import annotations

import argparse
from functools import partial
from time import process_time

import numpy as np
from threadpoolctl import threadpool_limits

from erclutch.fit.networks.backprop import tables_of
from erclutch.fit.networks.fit_fnn import Round, Schedule, train
from erclutch.fit.networks.fit_network import fit_network
from erclutch.logs.blocks import OneBlock
from erclutch.logs.dataset import Dataset
from erclutch.models.networks import network_from_name
from erclutch.models.networks.network_model import forward_fnn
from erclutch.paper.sweeps import UnitRows
from erclutch.paper.tables import twin_runs

NAMES = ("fnn-6", "fnn-16")


def fits(runs: dict[str, Dataset], name: str, seeds: int, polish: bool) -> np.ndarray:
    """Training error, test error and CPU seconds of each seed, shape (seeds, 3)."""
    train, test = runs.values()
    found: list[tuple[float, float, float]] = []
    for seed in range(seeds):
        began = process_time()
        outcome = fit_network(train, network_from_name(name), seed=seed, polish=polish)
        seconds = process_time() - began
        error = float(np.mean((test.effort - outcome.model.predict(test)) ** 2))
        found.append((outcome.train_cost / train.rows, error, seconds))
    return np.array(found)


def long_runs(runs: dict[str, Dataset], name: str, seeds: int) -> np.ndarray:
    """`fits` of long runs."""
    structure = network_from_name(name)
    unit = UnitRows(structure, *runs.values())
    schedule = Schedule(1, (Round(2, 1500, 1),), polish=30)
    found: list[tuple[float, float, float]] = []
    for seed in range(seeds):
        began = process_time()
        best = train(OneBlock((unit.x, unit.y, unit.spaced)), structure.hidden, seed, schedule, slips=unit.slips)
        seconds = process_time() - began
        tables = tables_of(best.theta, (unit.x.shape[0], *structure.hidden, 1))
        train_error, test_error = unit.errors(partial(forward_fnn, tables, exactly=False))
        found.append((train_error, test_error, seconds))
    return np.array(found)


def line(label: str, found: np.ndarray, best: np.ndarray) -> str:
    """One line: CPU seconds, the training error, and shares of seeds near the best errors."""
    train, test = found[:, 0], found[:, 1]
    near = train <= 1.02 * best[0], train <= 1.002 * best[0], test <= 1.02 * best[1], test <= 1.02 * best[2]
    return (
        f"{label:18}{np.median(found[:, 2]):8.2f}{found[:, 2].max():8.2f}{train.min():12.3e}"
        f"{np.median(train / best[0]):10.4f}" + "".join(f"{np.mean(share):14.0%}" for share in near)
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Networks from many seeds, on the digital TWIN.")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=290.0)
    parser.add_argument("--polished", type=int, default=20, help="seeds that are polished on all rows")
    parser.add_argument("--long", type=int, default=20, help="long runs to compare these with")
    asked = parser.parse_args()
    runs = twin_runs(("training", "test"), seconds=asked.seconds)
    print(
        f"TWIN, {next(iter(runs.values())).rows:,} training rows; shares of seeds within 2 or 0.2 % of the best known"
    )
    heads = "".join(f"{name:>14}" for name in ("train 2 %", "train 0.2 %", "lowest test", "best's test"))
    print(f"{'fit':18}{'CPU s':>8}{'most':>8}{'best MSE':>12}{'median':>10}{heads}", flush=True)
    with threadpool_limits(1):
        for name in NAMES:
            quick = fits(runs, name, asked.seeds, False)
            fine = fits(runs, name, asked.polished, True)
            every = np.vstack([quick, fine])
            best = np.array([*every[:, :2].min(axis=0), every[every[:, 0].argmin(), 1]])
            print(line(name, quick, best), flush=True)
            print(line(f"{name} polished", fine, best), flush=True)
            if asked.long:
                slow = long_runs(runs, name, asked.long)
                print(line(f"{name} long runs", slow, best))
                share = np.mean(fine[:, 0] <= 1.002 * slow[:, 0].min())
                print(f"{'':18}{name} polished within 0.2 % of the best long run's training error: {share:.0%}")


if __name__ == "__main__":
    main()
