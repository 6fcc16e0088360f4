"""Sets of parameters of the digital TWIN against the paper's tables: `python studies/table3_sets.py [RIG.toml ...]`.

Seeds that no calibration saw; without a file the default set. Laws, and networks that no calibration is told of:
levels and ratios to Bingham beside the paper's, with the smallest and largest of the seeds; on which seeds table II
has the paper's order; the rank of FNN-16 at zero field and with the output held, over all starts on each seed; its
bias at zero field. Last, laws that were trained with the output held: how near any training could bring them.
"""

from __future__ import annotations

import argparse
from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.networks.fit_network import fit_network
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset
from erclutch.models.model import Model
from erclutch.models.networks import is_network, network_from_name
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.paper.tables import BASE, law_fit, printed, rows_of
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig, load_rig
from erclutch.wings.rig.twin.scenarios import prepare

LAWS = tuple(name for name in APPROACHES if not is_network(name))
FNN = "fnn-16"  # from several starts
NETWORKS = tuple(name for name in APPROACHES if is_network(name) and name != FNN)
RUNS = ("training", "test", "zero-field", "zero-motion")
FIRST_SEED = 101


def network(train: Dataset, name: str, start: int) -> Model:
    """A network from one start."""
    return fit_network(train, network_from_name(name, train.device), seed=start).model


def errors_of(model: Model, runs: dict[str, Dataset]) -> list[float]:
    """Mean squared error on each run."""
    return [float(np.mean((data.effort - model.predict(data)) ** 2)) for data in runs.values()]


def judged(
    rig: RigParameters, seconds: float, seeds: range, starts: int
) -> dict[str, NDArray[np.float64]]:
    """Errors by model, shape (seeds, runs); those of FNN-16 (seeds, starts, runs); its bias (seeds, starts)."""
    found: dict[str, list[object]] = {name: [] for name in (*LAWS, *NETWORKS, FNN, "bias")}
    for seed in seeds:
        length = {"training": seconds}
        runs = {
            name: rows_of(prepare(name, rig=rig, seed=seed + 1000 * k, seconds=length.get(name)))
            for k, name in enumerate(RUNS)
        }
        train, idle = runs["training"], runs["zero-field"]
        for name in LAWS:
            found[name].append(errors_of(law_fit(train, name).model, runs))
        for name in NETWORKS:
            found[name].append(errors_of(network(train, name, 0), runs))
        started = [network(train, FNN, start) for start in range(starts)]
        found[FNN].append([errors_of(model, runs) for model in started])
        missed = [float(np.mean(idle.effort - model.predict(idle))) for model in started]
        found["bias"].append([each / float(np.mean(idle.effort)) for each in missed])
    return {name: np.array(values, np.float64) for name, values in found.items()}


def band(values: NDArray[np.float64], form: str) -> str:
    """Median, smallest and largest."""
    return f"{np.median(values):{form}} ({values.min():{form}} - {values.max():{form}})"


def print_figures(found: dict[str, NDArray[np.float64]]) -> None:
    """Levels of Bingham and ratios of the others, beside the paper's."""
    print("| figure | TWIN, median of the seeds (smallest - largest) | paper | TWIN over paper |")
    print("| --- | --- | --- | --- |")
    for k, run in enumerate(RUNS):
        base, theirs = found[BASE][:, k], printed(BASE)[run] or np.nan
        print(
            f"| {run}, level of Bingham | {band(base, '.2e')} | {theirs:.2e} | {np.median(base) / theirs:.2f} |"
        )
        for name in (*LAWS[1:], *NETWORKS, FNN):
            known = printed(name)[run]
            if known is None:
                continue
            errors = found[name][..., k]
            ratio = (np.median(errors, axis=1) if errors.ndim > 1 else errors) / base
            title = APPROACHES[name].title
            apart = np.median(ratio) / (known / theirs)
            print(
                f"| {run}, {title} over Bingham | {band(ratio, '.2f')} | {known / theirs:.2f} | {apart:.2f} |"
            )


def print_order(found: dict[str, NDArray[np.float64]]) -> None:
    """On how many seeds the errors of table II have the paper's order, and which neighbours change places."""
    for k, run in enumerate(RUNS[:2]):
        theirs = sorted(APPROACHES, key=lambda name: -(printed(name)[run] or np.nan))
        fits = [
            found[name][:, 0, k] if name == FNN else found[name][:, k] for name in theirs
        ]  # FNN-16: its first start
        gains = -np.diff(
            np.log(np.stack(fits, axis=1)), axis=1
        )  # (seeds, neighbours), above 0 in the paper's order
        ordered = np.all(gains > 0.0, axis=1)
        print(
            f"table II, {run}: the paper's order of {len(theirs)} models on {ordered.sum()} of {ordered.size} seeds"
        )
        for (worse, better), gain in zip(pairwise(theirs), gains.T, strict=True):
            if swapped := int(np.sum(gain < 0.0)):
                names = f"{APPROACHES[better].title} behind {APPROACHES[worse].title}"
                print(f"  {names} on {swapped} seeds, by at most {np.expm1(-gain.min()):.1%}")


def print_network(found: dict[str, NDArray[np.float64]]) -> None:
    """Rank of FNN-16 among the six of table III, and its bias at zero field."""
    others = np.stack(
        [found[name] for name, known in APPROACHES.items() if known.zero_field and name != FNN]
    )
    for run in ("zero-field", "zero-motion"):
        k = RUNS.index(run)
        ranks = 1 + (others[:, :, None, k] < found[FNN][None, :, :, k]).sum(axis=0)
        counted = Counter(int(rank) for rank in ranks.ravel())
        words = ", ".join(f"{counted[rank]} times {rank}" for rank in sorted(counted))
        print(f"FNN-16 at {run}: rank of six in {ranks.size} fits: {words}; paper: 1")
    bias = found["bias"].ravel()
    print(f"bias of FNN-16 at zero field, share of the mean torque measured: {band(bias, '.0%')}")


def print_trained_held(rig: RigParameters) -> None:
    """Laws trained with the output held, scored on another run of that kind."""
    train = rows_of(prepare("zero-motion", rig=rig, seed=4101, seconds=60.0))
    other = {"zero-motion": rows_of(prepare("zero-motion", rig=rig, seed=4102, seconds=60.0))}
    errors = {name: errors_of(law_fit(train, name).model, other)[0] for name in LAWS}
    words = ", ".join(
        f"{APPROACHES[name].title} {error / errors[BASE]:.2f}" for name, error in errors.items()
    )
    print(f"trained with the output held: Bingham {errors[BASE]:.2e}; over Bingham: {words}")


def main() -> None:
    """Print the figures of each set."""
    parser = argparse.ArgumentParser(
        description="Sets of the digital TWIN against the paper's tables."
    )
    parser.add_argument("rigs", nargs="*", type=Path, metavar="RIG.toml")
    parser.add_argument("--seconds", type=float, default=290.0, help="of the training runs")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--starts", type=int, default=1, help="of FNN-16 on each seed")
    asked = parser.parse_args()
    with one_thread():
        for rig in [load_rig(path) for path in asked.rigs] or [default_rig()]:
            seeds = range(FIRST_SEED, FIRST_SEED + asked.seeds)
            print(
                f"\nTWIN, {rig.name}; {asked.seconds:g} s of training, seeds {seeds[0]} to {seeds[-1]}\n"
            )
            found = judged(rig, asked.seconds, seeds, asked.starts)
            print_figures(found)
            print()
            print_order(found)
            print_network(found)
            print_trained_held(rig)


if __name__ == "__main__":
    main()
