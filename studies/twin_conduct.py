"""How a set of parameters of the digital TWIN behaves: `python studies/twin_conduct.py [RIG.toml ...]`. TWIN.

What no error of a model shows, over five seeds that no calibration saw: how long the table stands at an end stop in
training, how fast the housings turn at zero field, what the meter shows there, how much 20 minutes of tracking warm the
clutches, and what is missing from the balance of energy.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from twin_step import run

from erclutch.wings.rig.twin.parameters import RigParameters, default_rig, load_rig
from erclutch.wings.rig.twin.scenarios import prepare

SEEDS = range(101, 106)
STEP = 50e-6  # s, the twin's own


def at_stop(rig: RigParameters, seed: int) -> float:
    """Share of the training run in which the table is beyond its stroke."""
    _, table = prepare("training", rig=rig, seed=seed, seconds=290.0).columns()["table"]
    return float(np.mean(np.abs(table) > rig.value("screw.half_stroke")))


def idling(rig: RigParameters, seed: int) -> tuple[float, float]:
    """Fastest housing at zero field, rad/s, and the mean torque that the meter shows, N m."""
    columns = prepare("zero-field", rig=rig, seed=2000 + seed).columns()
    return float(np.abs(columns["true_theta_dot"][1]).max()), float(np.mean(columns["T"][1]))


def warmer(rig: RigParameters) -> float:
    """What 20 minutes of tracking add to the clutches' temperature, K."""
    *_, last = prepare("temperature", rig=rig).chunks()
    return float(last[-1, -1])


def main() -> None:
    """Print a line for each set."""
    parser = argparse.ArgumentParser(
        description="How a set of parameters of the digital TWIN behaves."
    )
    parser.add_argument(
        "rigs", nargs="*", type=Path, metavar="RIG.toml", help="sets beside the default one"
    )
    asked = parser.parse_args()
    print(f"TWIN, seeds {SEEDS[0]} to {SEEDS[-1]}; a median and the largest of the seeds\n")
    heads = "at an end stop in training | fastest at zero field [rad/s] | torque there [mN m] | warmer [K]"
    print(f"| set | {heads} | energy missing |")
    print("| --- | --- | --- | --- | --- | --- |")
    for rig in [default_rig(), *map(load_rig, asked.rigs)]:
        stops = 100.0 * np.array([at_stop(rig, seed) for seed in SEEDS])
        speeds, torques = np.array([idling(rig, seed) for seed in SEEDS]).T
        _, missing = run(8.0, 0, STEP, rig)
        cells = f"{np.median(stops):.2f} %, {stops.max():.2f} % | {np.median(speeds):.0f}, {speeds.max():.0f}"
        torque = f"{1e3 * np.median(torques):.1f}, {1e3 * torques.max():.1f}"
        print(
            f"| {rig.name} | {cells} | {torque} | {warmer(rig):.2f} | {missing:.1e} |", flush=True
        )
    print("| paper | - | 210 | - | 0.4 | - |")


if __name__ == "__main__":
    main()
