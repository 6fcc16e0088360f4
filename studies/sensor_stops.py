"""What a healthy device loses where a torque sensor that cannot be brings zero field. TWIN.

    python studies/sensor_stops.py [--seeds 1] [--model bingham]

Runs each program that `erclutch live` offers for pair and brake, with each observer and several torques of the motor,
without `--meter-needed`, with it and with `--no-meter-needed`. Printed are the sessions that stop, and the periods in
which the torque sensor is in doubt, by reason. No sensor is wrong, so each of these is a false alarm.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from erclutch.signals.device import DeviceName
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.rig.twin.parameters import default_rig

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.healthy_sessions import sessions
from tests.support.sensor_faults import ROWS, model_of

MOTORS = (0.05, 0.1, 0.3, 0.95)  # N m
REASONS = ("out-of-range", "glitch", "stuck", "disagrees")
NEEDED = {"": None, "--meter-needed": True, "--no-meter-needed": False}


def main() -> int:
    """Print the table; 1 if a healthy session stops by default."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--model", default="bingham")
    asked = parser.parse_args()
    rig, stopped = default_rig(), 0
    devices: tuple[DeviceName, ...] = ("coaxial", "single")
    fitted = {device: model_of(rig, asked.model, device) for device in devices}
    print(f"TWIN, {asked.model}, {asked.seeds} seeds, sessions of {ROWS} rows of 1 ms")
    print(
        f"| option | sessions | that stop | {' | '.join(REASONS)} |\n|{' --- |' * (3 + len(REASONS))}"
    )
    for option, needed in NEEDED.items():
        counts, runs = Counter[str](), 0
        loops = itertools.product(
            devices, ("off", "none", "sensor", "motion"), MOTORS, range(asked.seeds)
        )
        for device, observer, motor, seed in loops:
            model, single = fitted[device], device == "single"
            for settings, _ in sessions(
                device, model, motor=motor, observer=observer, meter_needed=needed
            ):
                run = AcceleratedRun(
                    settings, model.library, rig, seed=seed, single=single, locked=single
                )
                events = run.frames(ROWS)[0]["events"]
                doubted = events[(events & EVENT_BITS["torque-doubted"]) != 0]
                counts.update(
                    {name: int(np.count_nonzero(doubted & EVENT_BITS[name])) for name in REASONS}
                )
                counts["stops"] += bool(np.any(events & EVENT_BITS["trip"]))
                runs += 1
        reasons = " | ".join(str(counts[name]) for name in REASONS)
        print(f"| {option} | {runs} | {counts['stops']} | {reasons} |", flush=True)
        stopped += counts["stops"] if needed is None else 0
    return 1 if stopped else 0


if __name__ == "__main__":
    raise SystemExit(main())
