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

ROWS = 7000  # of a run, at 1 kHz
SETTLING = 2000  # rows that do not count
P_GAINS = np.geomspace(0.5, 60.0, 8)
D_GAINS = np.geomspace(5e-3, 0.5, 6)
COMPUTED = {"observer": "none", "track_bandwidth": 30.0, "track_integral": 30.0}


def tracked(
    rig: RigParameters, frequency: float, seed: int, library: Path | None, **settings: Any
) -> Any:
    """Frames of a run without its beginning."""
    stroke = 0.02 / (5.0 if frequency > 1.0 else 1.0)  # m
    height = stroke * 2.0 * math.pi / rig.value("screw.lead")  # rad
    program = LoopProgram(
        "tracking", Mode.TRACK, Waveform.SINE, height, frequency, motor_torque=0.1
    )
    run = AcceleratedRun(
        rig_settings(rig, [program], **settings), library, rig, seed=seed, speed=40.0
    )
    frames, *_ = run.frames(ROWS)
    return frames[SETTLING:]


def figures(frames: Any) -> list[float]:
    """RMS of the error in rad, and of the field as a measure of the supply's effort."""
    error = frames["alpha"] - frames["reference"]
    field = frames["field1"] + frames["field2"]
    return [float(np.sqrt(np.mean(np.square(signal)))) for signal in (error, field)]


def output_numbers(frames: Any) -> dict[str, float]:
    """Inertia and dry friction of the output by least squares: a model's torque, and the output's motion over 5 ms."""
    window = 5  # rows, of 1 ms
    starts = np.arange(0, len(frames) - window, window)
    speed = frames["alpha_dot"]
    acceleration = (speed[starts + window] - speed[starts]) / (window * 1e-3)
    torque = np.array([np.mean(frames["estimate"][start : start + window]) for start in starts])
    direction = np.sign(speed[starts])
    moving = np.abs(speed[starts]) > 2.0
    motion = np.column_stack([acceleration, direction])[moving]
    (inertia, friction), *_ = np.linalg.lstsq(motion, torque[moving], rcond=None)
    return {
        "output_inertia": max(0.0, float(inertia)),
        "output_friction": max(0.0, float(friction)),
    }


def main() -> None:
    """Print a row for each frequency and way to track."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    rig = default_rig()
    of_ways: dict[
        tuple[float, str], list[list[float]]
    ] = {}  # figures of each seed, by frequency and way to track
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(asked.first, asked.first + asked.seeds):
            models, _ = tc.fitted_models(rig, seed, Path(folder))
            for frequency in (0.4, 2.0):
                gains = itertools.product(P_GAINS, D_GAINS)
                runs = (tracked(rig, frequency, seed + 100, None, k_p=p, k_d=d) for p, d in gains)
                of_ways.setdefault((frequency, "best PD"), []).append(min(map(figures, runs)))
                for name, model in models.items():
                    output = output_numbers(tracked(rig, 2.0, seed, model.library))
                    run = tracked(rig, frequency, seed + 100, model.library, **COMPUTED, **output)
                    of_ways.setdefault((frequency, name), []).append(figures(run))
                    print(f"{seed}, {frequency} Hz, {name}: {output}", flush=True)
    print(
        "TWIN | frequency [Hz] | way | error, mean [mrad] | worst [mrad] | field, rms | times below PD"
    )
    for (frequency, name), of_seeds in of_ways.items():
        errors, fields = np.array(of_seeds).T
        errors_of_pd, _ = np.array(of_ways[frequency, "best PD"]).T
        ratio = np.mean(errors_of_pd) / errors.mean()
        mean, worst = 1e3 * errors.mean(), 1e3 * errors.max()  # mrad
        print(
            f"{frequency} | {name} | {mean:.2f} | {worst:.2f} | {fields.mean():.3f} | {ratio:.1f}"
        )


if __name__ == "__main__":
    main()
