"""How surely a network reaches its best known optimum, on the TWIN: `python studies/seeds.py [--seeds 20]`.

Best known, of all fits of the size in the run, polished ones included: the lowest training error, the lowest test
error, and the test error of the fit with the lowest training error. The lowest test error is chosen on the test rows,
so it falls with every fit that is added; the last one is what a user with unlimited time would have.

A long run is one start without spare neurons and exchanges: steps on the finest grid until the error falls no more,
then up to 30 on all rows. Polished fits are compared with the best of these runs too.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from time import process_time

import numpy as np

from erclutch.fit.networks.backprop import tables_of
from erclutch.fit.networks.fit_fnn import Round, Schedule, train
from erclutch.fit.networks.fit_network import fit_network
from erclutch.models.networks import network_from_name
from erclutch.models.networks.forward import forward_fnn
from erclutch.runs.cluster import in_order, task_pool
from erclutch.wings.paper.sweeps import RunsRecipe, UnitRows, made
from erclutch.wings.paper.tables import twin_runs

NAMES = ("fnn-6", "fnn-16")


Task = tuple[RunsRecipe, str, int]  # the runs, the network, the seed


def fit(polish: bool, task: Task) -> list[float]:
    """Training error, test error and CPU seconds of a fit."""
    runs, name, seed = task
    train_rows, test = made(runs)
    began = process_time()
    outcome = fit_network(train_rows, network_from_name(name), seed=seed, polish=polish)
    seconds = process_time() - began
    error = float(np.mean((test.effort - outcome.model.predict(test)) ** 2))
    return [outcome.train_cost / train_rows.rows, error, seconds]


def long_run(task: Task) -> list[float]:
    """The same of a long run."""
    runs, name, seed = task
    structure = network_from_name(name)
    unit = UnitRows(structure, *made(runs))
    schedule = Schedule(1, (Round(2, 1500, 1),), polish=30)
    began = process_time()
    best = train((unit.x, unit.y, unit.spaced), structure.hidden, seed, schedule, slips=unit.slips)
    seconds = process_time() - began
    tables = tables_of(best.theta, (unit.x.shape[0], *structure.hidden, 1))
    return [*unit.errors(partial(forward_fnn, tables, exactly=False)), seconds]


def line(label: str, fits: np.ndarray, best: np.ndarray) -> str:
    """One line: CPU seconds, the training error, and shares of seeds near the best errors."""
    train, test, seconds = fits.T
    best_train, best_test, test_of_best = best
    near = (
        train <= 1.02 * best_train,
        train <= 1.002 * best_train,
        test <= 1.02 * best_test,
        test <= 1.02 * test_of_best,
    )
    shares = "".join(f"{np.mean(seeds):14.0%}" for seeds in near)
    return (
        f"{label:18}{np.median(seconds):8.2f}{seconds.max():8.2f}{train.min():12.3e}"
        f"{np.median(train / best_train):10.4f}{shares}"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Networks from many seeds, on the digital TWIN.")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=290.0)
    parser.add_argument(
        "--polished", type=int, default=20, help="seeds that are polished on all rows"
    )
    parser.add_argument("--long", type=int, default=20, help="long runs to compare these with")
    parser.add_argument("--cluster", default="processes", help="see erclutch fit-many")
    parser.add_argument(
        "--workers", type=int, default=1, help="CPU seconds are exact where each has a core"
    )
    asked = parser.parse_args()
    runs = RunsRecipe(twin_runs, (("names", ("training", "test")), ("seconds", asked.seconds)))
    print(
        f"TWIN, {made(runs)[0].rows:,} training rows; shares of seeds within 2 or 0.2 % of the best known"
    )
    heads = "".join(
        f"{name:>14}" for name in ("train 2 %", "train 0.2 %", "lowest test", "best's test")
    )
    print(f"{'fit':18}{'CPU s':>8}{'most':>8}{'best MSE':>12}{'median':>10}{heads}", flush=True)
    with task_pool(asked.cluster, asked.workers) as pool:

        def all_of(function: Callable[[Task], list[float]], name: str, seeds: int) -> np.ndarray:
            return np.array(
                list(in_order(pool, function, [(runs, name, seed) for seed in range(seeds)]))
            )

        for name in NAMES:
            quick = all_of(partial(fit, False), name, asked.seeds)
            fine = all_of(partial(fit, True), name, asked.polished)
            every = np.vstack([quick, fine])
            best = np.array([*every[:, :2].min(axis=0), every[every[:, 0].argmin(), 1]])
            print(line(name, quick, best), flush=True)
            print(line(f"{name} polished", fine, best), flush=True)
            if asked.long:
                slow = all_of(long_run, name, asked.long)
                print(line(f"{name} long runs", slow, best))
                share = np.mean(fine[:, 0] <= 1.002 * slow[:, 0].min())
                print(
                    f"{'':18}{name} polished within 0.2 % of the best long run's training error: {share:.0%}"
                )


if __name__ == "__main__":
    main()
