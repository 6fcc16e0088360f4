"""Error of each speed filter against the true speed, on the digital TWIN: `python studies/velocity.py [--seconds 60]`.

The motor's speed comes from a 13-bit encoder, the output's from a linear encoder of 1 um on the table; both at 1 kHz.
"""

from __future__ import annotations

import argparse

import numpy as np

from erclutch.signals.clock import Clock, Span
from erclutch.signals.speed import CAUSAL, Derivative, differentiate
from erclutch.wings.rig.twin.scenarios import prepare

CHOICES = (
    Derivative("difference"),
    *(Derivative("lowpass", cutoff) for cutoff in (60.0, 100.0, 150.0, 250.0)),
    *(Derivative("kalman", cutoff) for cutoff in (30.0, 60.0, 100.0, 150.0, 250.0)),
    Derivative("central"),
    *(Derivative("savgol", window=window) for window in (5, 9, 15)),
)


def errors(seconds: float, seed: int) -> list[tuple[str, bool, float, float]]:
    """Filter, whether it is causal, and the RMS errors of the motor's and of the output's speed in rad/s."""
    columns = prepare("training", seconds=seconds, seed=seed).columns()
    time = columns["time"][1]
    clock = Clock(time, (Span(0, time.size, 1e-3),))
    rows: list[tuple[str, bool, float, float]] = []
    for choice in CHOICES:
        found = []
        for angle, truth in (("theta", "true_theta_dot"), ("alpha", "true_alpha_dot")):
            speed = differentiate(columns[angle][1], clock, choice)
            found.append(float(np.sqrt(np.mean((speed - columns[truth][1])[100:-100] ** 2))))
        setting = {"savgol": f"{choice.window} rows", "central": "", "difference": ""}
        label = f"{choice.name} {setting.get(choice.name, f'{choice.cutoff:g} Hz')}".strip()
        rows.append((label, choice.name in CAUSAL, found[0], found[1]))
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Speed filters against the true speed, on the digital TWIN.")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    print(f"TWIN, training scenario, {asked.seconds:g} s, seed {asked.seed}: RMS error of the speed in rad/s")
    print(f"{'filter':16}{'causal':>8}{'motor':>8}{'output':>8}{'both':>8}")
    for label, causal, motor, output in errors(asked.seconds, asked.seed):
        print(f"{label:16}{'yes' if causal else 'no':>8}{motor:8.3f}{output:8.3f}{np.hypot(motor, output):8.3f}")


if __name__ == "__main__":
    main()
