"""Position tracking on the TWIN: computed torque on models of its log, beside the best PD that a search finds.

    python studies/tracking.py [--seeds 5]

PD may choose its gains on the very run that it is judged on. Computed torque has one bandwidth and one integral for all
runs, chosen on another seed, and takes inertia and friction of the output out of a PD run. The first 2 s do not count.
"""

from __future__ import annotations

import argparse
import itertools
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.offered_programs import rig_settings
from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
from erclutch.wings.paper import torque_control as tc
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig

ROWS, SETTLING = 7000, 2000
P_GAINS, D_GAINS = np.geomspace(0.5, 60.0, 8), np.geomspace(5e-3, 0.5, 6)
COMPUTED = {"observer": "none", "track_bandwidth": 30.0, "track_integral": 30.0}


def tracked(rig: RigParameters, frequency: float, seed: int, library: Path | None, **settings: Any) -> Any:
    """Frames of a run without its beginning."""
    height = 0.02 * 2.0 * math.pi / rig.value("screw.lead") / (5.0 if frequency > 1.0 else 1.0)
    program = LoopProgram("tracking", Mode.TRACK, Waveform.SINE, height, frequency, motor_torque=0.1)
    run = AcceleratedRun(rig_settings(rig, [program], **settings), library, rig, seed=seed, speed=40.0)
    return run.frames(ROWS)[0][SETTLING:]


def figures(frames: Any) -> list[float]:
    """RMS of the error in rad, and of the field as a measure of the supply's effort."""
    off, field = frames["alpha"] - frames["reference"], frames["field1"] + frames["field2"]
    return [float(np.sqrt(np.mean(np.square(x)))) for x in (off, field)]


def output_numbers(frames: Any) -> dict[str, float]:
    """Inertia and dry friction of the output by least squares: a model's torque, and the output's motion over 5 ms."""
    window = 5
    at = np.arange(0, len(frames) - window, window)
    speed = frames["alpha_dot"]
    gained = (speed[at + window] - speed[at]) / (window * 1e-3)
    torque = np.array([np.mean(frames["estimate"][k : k + window]) for k in at])
    moving = np.abs(speed[at]) > 2.0
    known = np.column_stack([gained, np.sign(speed[at])])[moving]
    found = np.linalg.lstsq(known, torque[moving], rcond=None)[0]
    return {"output_inertia": max(0.0, float(found[0])), "output_friction": max(0.0, float(found[1]))}


def main() -> None:
    """Print a row for each frequency and way to track."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args()
    rig = default_rig()
    found: dict[tuple[float, str], list[Any]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(given.first, given.first + given.seeds):
            models, _ = tc.fitted_models(rig, seed, Path(folder))
            for frequency in (0.4, 2.0):
                gains = itertools.product(P_GAINS, D_GAINS)
                tried = (tracked(rig, frequency, seed + 100, None, k_p=p, k_d=d) for p, d in gains)
                found.setdefault((frequency, "best PD"), []).append(min(map(figures, tried)))
                for name, model in models.items():
                    output = output_numbers(tracked(rig, 2.0, seed, model.library))
                    one = tracked(rig, frequency, seed + 100, model.library, **COMPUTED, **output)
                    found.setdefault((frequency, name), []).append(figures(one))
                    print(f"{seed}, {frequency} Hz, {name}: {output}", flush=True)
    print("TWIN | frequency [Hz] | way | error, mean [mrad] | worst [mrad] | field, rms | times below PD")
    for (frequency, name), values in found.items():
        errors, fields = np.array(values).T
        ratio = np.mean(np.array(found[frequency, "best PD"])[:, 0]) / errors.mean()
        mean, worst = 1e3 * errors.mean(), 1e3 * errors.max()
        print(f"{frequency} | {name} | {mean:.2f} | {worst:.2f} | {fields.mean():.3f} | {ratio:.1f}")


if __name__ == "__main__":
    main()
