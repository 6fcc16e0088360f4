"""The twin's internal step: `python studies/twin_step.py [--seconds 8] [--seed 0]`. TWIN.

How much the torque changes when the step is halved, over the same commands, and how well the energy balance closes.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from erclutch.wings.rig.twin import kernel as k
from erclutch.wings.rig.twin.excitation import FieldSettings, field_sequence, torque_sequence
from erclutch.wings.rig.twin.parameters import default_rig
from erclutch.wings.rig.twin.part_parameters import parts_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.twin_energy import stored

SPEEDS = [k.OMEGA, k.OMEGA_R, k.OMEGA_L]


def run(seconds: float, seed: int, step: float) -> tuple[np.ndarray, float]:
    """The torque meter each ms, and what is missing from the energy balance over the motor's work."""
    parts, rng = parts_of(default_rig()), np.random.default_rng(seed)
    rows, steps = round(seconds * 1000), round(1e-3 / step)
    fields, motor = field_sequence(rows, rng, FieldSettings()), torque_sequence(rows, rng)
    x, torque = np.zeros(k.SIZE), np.empty(rows)
    x[k.OMEGA] = 40.0
    before = x[SPEEDS]
    start = stored(x, parts, before)
    for i in range(rows):
        first, second = max(fields[i], 0.0), max(-fields[i], 0.0)
        k.advance(x, parts, first, second, motor[i], False, step, steps - 1)
        before = x[SPEEDS]
        k.advance(x, parts, first, second, motor[i], False, step, 1)
        torque[i] = x[k.METER_B]
    missing = x[k.WORK] + x[k.FIELD_WORK] - x[k.DISSIPATED] - (stored(x, parts, before) - start)
    return torque, float(missing / x[k.WORK])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Convergence of the digital TWIN.")
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    print(f"TWIN, {asked.seconds:g} s, seed {asked.seed}")
    print(f"{'step [us]':>10}{'torque on halving':>20}{'energy missing':>17}")
    for step in (100e-6, 50e-6, 25e-6):
        (whole, missing), (half, _) = (run(asked.seconds, asked.seed, s) for s in (step, step / 2))
        change = float(np.sqrt(np.mean((whole - half) ** 2) / np.mean(half**2)))
        print(f"{1e6 * step:10.0f}{change:20.2%}{missing:17.1e}")


if __name__ == "__main__":
    main()
