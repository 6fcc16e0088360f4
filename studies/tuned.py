"""What `erclutch tune` foretells of a step, beside what the TWIN does: `python studies/tuned.py`.

A model is fitted to 20 s of the TWIN, and `erclutch tune` finds gains for a bandwidth. Printed: overshoot and rise of
the linear loop and of the accelerated TWIN, the gain margin, and how the output moves with gains about that margin.
"""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.cli import app
from erclutch.runs.run_folder import read_run
from erclutch.signals.array import Array
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.commands.tune import torque_path, tuned_loops
from erclutch.wings.live.live_model import live_model
from erclutch.wings.live.offered_programs import rig_settings
from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
from erclutch.wings.rig.twin.parameters import default_rig

BANDWIDTH, TORQUE_BANDWIDTH = 10.0, 20.0  # Hz
STEP, SMALL_STEP = 0.5, 0.05  # rad
SHARES = (0.8, 1.2, 1.4)  # of the gain that the margin allows


def quietly(*words: str) -> None:
    """A command whose words nobody reads."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        app(list(words), exit_on_error=False)


def rise(step: Array) -> int:
    """Rows from 10 to 90 % of a step; rows are 1 ms."""
    return int(np.argmax(step > 0.9) - np.argmax(step > 0.1))


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        quietly("simulate", "training", "--seconds", "20", "--out", "log.csv")
        fit = (
            "--models",
            "bingham",
            "--lag",
            "rise-fall",
            "--derivative",
            "kalman",
            "--out",
            "run",
        )
        quietly("fit", "log.csv", "--device", "coaxial", *fit)
        quietly("tune", "run", "--bandwidth", f"{BANDWIDTH:g}", "--out", "tuning")
        gains = tomllib.loads(Path("tuning", "control.toml").read_text(encoding="utf-8"))
        rig = default_rig()
        model = read_run(Path("run")).model()
        motion = tuned_loops(torque_path(model)[0], rig, BANDWIDTH, TORQUE_BANDWIDTH)[1]
        library = live_model(next(Path("run", "models").glob("*.json")), "coaxial").library

        def twin(height: float, gain: float = 1.0) -> Any:
            step = LoopProgram(
                "step", Mode.TRACK, Waveform.SQUARE, height, 0.25, motor_torque=0.2, relative=True
            )
            changed = {
                **gains,
                "output_inertia": gain * gains["output_inertia"],
                "observer": "none",
            }
            settings = rig_settings(rig, [step], **changed)
            return AcceleratedRun(settings, library, rig, seed=3, speed=150.0).frames(4000)[0]

        frames = twin(STEP)
        turned = frames["alpha"][2000:3000] - frames["alpha"][1999]
        seen = -turned / (2.0 * STEP)
        told = motion.loop.step()
        inertia = gains["output_inertia"]
        print(
            f"TWIN, {model.name} fitted to 20 s, {BANDWIDTH:g} Hz; inertia that its torque moves {inertia:.2g} kg m2"
        )
        for name, step in (("foretold", told), ("TWIN", seen)):
            print(f"{name:<10} overshoot {step.max() - 1.0:.0%}, rise {rise(step)} ms")
        print(f"gain margin {motion.margins.gain:.1f}")
        for share in SHARES:
            speed = np.asarray(twin(SMALL_STEP, share * motion.margins.gain)["alpha_dot"][3000:])
            spectrum = np.abs(np.fft.rfft(speed - speed.mean()))
            loudest = np.fft.rfftfreq(speed.size, 1e-3)[int(np.argmax(spectrum))]
            print(
                f"{share:g} times it: speed {speed.std():.2f} rad/s rms, most of it at {loudest:.0f} Hz"
            )


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    main()
