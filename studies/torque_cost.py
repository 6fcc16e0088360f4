"""Time of a live step with torque control in stages: core, model, inverse and observer, in CPU ns on this machine.

    python studies/torque_cost.py

A compiled loop feeds one core with a drive that turns and a wanted torque that swings: 0.02 N m, which both models
reach, and 0.08 N m, which they do not reach at each instant. The first fifth does not count.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from erclutch.cli import terminal
from erclutch.wings.live.c_core import Core, step_function
from erclutch.wings.live.layout import COMMAND, FRAME, SAMPLE, word_places
from erclutch.wings.live.live_model import live_model
from erclutch.wings.live.offered_programs import rig_settings
from erclutch.wings.live.settings import LoopProgram, Mode, Waveform
from erclutch.wings.paper.torque_control import KNOWS
from erclutch.wings.rig.twin.parameters import default_rig
from erclutch.wings.rig.twin_model import twin_models

STEPS = 200_000


def feeder() -> Callable[..., None]:
    """The compiled loop around the core's step."""
    step = step_function()
    seq, stamp, theta, torque = word_places(SAMPLE, "seq", "time_ns", "theta", "torque")

    @numba.njit(error_model="numpy")
    def feed(
        core: Any, words: Any, numbers: Any, command: Any, frame: Any, first: int, steps: int, reach: float
    ) -> None:
        for k in range(first, first + steps):
            words[seq], words[stamp] = k + 1, (k + 1) * 1000000
            numbers[theta], numbers[torque] = 0.15 * k, reach * np.sin(0.03 * k)
            step(core.ctypes, words.ctypes, 1, k, 0, 0, command.ctypes, frame.ctypes)

    return feed


def main() -> None:
    """Print the table."""
    rig, feed = default_rig(), feeder()
    rows: list[list[str]] = []
    for name in ("bingham/forward", "fnn-16"):
        model = live_model(twin_models(rig, (name,), terminal.console())[0], "coaxial")
        for (knows, settings), reach in itertools.product(KNOWS.items(), (0.02, 0.08)):
            program = LoopProgram("torque", Mode.TORQUE, Waveform.SINE, reach, 5.0, motor_torque=0.2)
            core = Core(rig_settings(rig, [program], **settings), model.library)
            words = np.zeros(SAMPLE.itemsize // 8, np.uint64)
            out = np.zeros(COMMAND.itemsize // 8), np.zeros(FRAME.itemsize // 8)
            feed(core.memory, words, words.view(np.float64), *out, 0, STEPS // 5, reach)
            begin = time.process_time_ns()
            feed(core.memory, words, words.view(np.float64), *out, STEPS // 5, STEPS, reach)
            rows.append([name, knows, f"{reach:g}", f"{(time.process_time_ns() - begin) / STEPS:.0f}"])
    terminal.tell(terminal.table("A live step", ["model", "controller", "torque [N m]", "CPU time [ns]"], rows, left=2))


if __name__ == "__main__":
    main()
