"""The twin's internal step: `python studies/twin_step.py [--seconds 8] [--seed 0] [--rig-file RIG.toml]`. TWIN.

How much the torque changes when the step is halved, over the same commands, and how well the energy balance closes.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from erclutch.wings.rig.twin import kernel as k
from erclutch.wings.rig.twin.excitation import FieldSettings, field_sequence, torque_sequence
from erclutch.wings.rig.twin.parameters import RigParameters, load_rig
from erclutch.wings.rig.twin.part_parameters import parts_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.twin_energy import stored

SPEEDS = [k.OMEGA, k.OMEGA_R, k.OMEGA_L]


def run(seconds: float, seed: int, step: float, rig: RigParameters) -> tuple[np.ndarray, float]:
    """The torque meter each ms, and what is missing from the energy balance over the motor's work."""
    parts = parts_of(rig)
    rng = np.random.default_rng(seed)
    rows = round(seconds * 1000)
    steps = round(1e-3 / step)  # a row
    fields = field_sequence(rows, rng, FieldSettings())
    motor = torque_sequence(rows, rng)
    torque = np.empty(rows)
    state = np.zeros(k.SIZE)
    state[k.OMEGA] = 40.0
    before = state[SPEEDS]  # half a step ago: the energy is that of the middle
    at_start = stored(state, parts, before)
    for row in range(rows):
        first, second = max(fields[row], 0.0), max(-fields[row], 0.0)
        k.advance(state, parts, first, second, motor[row], False, step, steps - 1)
        before = state[SPEEDS]
        k.advance(state, parts, first, second, motor[row], False, step, 1)
        torque[row] = state[k.METER_B]
    put_in = state[k.WORK] + state[k.FIELD_WORK]
    missing = put_in - state[k.DISSIPATED] - (stored(state, parts, before) - at_start)
    return torque, float(missing / state[k.WORK])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Convergence of the digital TWIN.")
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rig-file", type=Path)
    asked = parser.parse_args()
    rig = load_rig(asked.rig_file)
    print(f"TWIN, {rig.name}, {asked.seconds:g} s, seed {asked.seed}")
    print(f"{'step [us]':>10}{'torque on halving':>20}{'energy missing':>17}")
    for step in (100e-6, 50e-6, 25e-6):
        whole, missing = run(asked.seconds, asked.seed, step, rig)
        half, _ = run(asked.seconds, asked.seed, step / 2, rig)
        change = float(np.sqrt(np.mean((whole - half) ** 2) / np.mean(half**2)))
        print(f"{1e6 * step:10.0f}{change:20.2%}{missing:17.1e}")


if __name__ == "__main__":
    main()
