"""The loop's C core runs on the twin as fast as the machine can: hours of rig time in minutes, frame by frame as live.

Machine code calls machine code: the compiled twin and the compiled core take turns, Python only waits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.signals.array import Array
from erclutch.wings.live.c_core import Core, step_function
from erclutch.wings.live.layout import COMMAND, FRAME, SAMPLE, word_places
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.kernel import OMEGA, OMEGA_L, SIZE, WARMTH, advance
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.part_parameters import parts_of, single_clutch
from erclutch.wings.rig.twin.sampled_rows import sense
from erclutch.wings.rig.twin.twin import PERIOD, substeps

_WORDS = FRAME.itemsize // 8
#: Where a sample's and a command's members lie, in words of 8 bytes.
_SEQ, _TIME, _THETA, _ALPHA, _TORQUE = word_places(
    SAMPLE, "seq", "time_ns", "theta", "alpha", "torque"
)
_FIELD1, _FIELD2, _MOTOR = word_places(COMMAND, "field1", "field2", "motor_torque")


@cache
def _runner() -> Callable[..., None]:
    """The compiled loop around the core's step."""
    import numba

    step = step_function()

    # fmt: off
    @numba.njit(nogil=True, error_model="numpy")
    def run(
        core: Any, state: Any, parts: Any,  # what is changed: the core, the twin; and what the twin is made of
        locked: Any, hand: Any, rotary: Any, noise: Any,  # how the rig is held and read
        first: Any, dt: Any, steps: Any,  # number of the first row; the twin's steps a row, and the time of each
        words: Any, numbers: Any,  # a sample, as integers and as numbers
        command: Any, frames: Any, other: Any,  # what comes out
    ) -> None:
        row = np.zeros(7)
        turns = 2.0 * math.pi / parts.screw.lead  # rad of the shaft a metre of the table
        for k in range(noise.size):
            sense(state, parts, noise[k], row)
            by_table = row[4] * turns
            by_shaft = row[5]
            if hand.size:
                state[OMEGA_L] = hand[min(first + k, hand.size - 1)]
            words[_SEQ] = first + k + 1
            words[_TIME] = (first + k + 1) * 1000000
            numbers[_THETA] = row[3]
            numbers[_ALPHA] = by_shaft if rotary else by_table
            numbers[_TORQUE] = row[6]
            other[k] = by_table if rotary else by_shaft
            step(core.ctypes, words.ctypes, 1, first + k, 0, 0, command.ctypes, frames[k].ctypes)
            advance(state, parts, command[_FIELD1], command[_FIELD2], command[_MOTOR], locked, dt, steps)
    # fmt: on

    return run


class AcceleratedRun:
    """A session without clocks and packets: the twin, the core, and nothing between.

    Args:
        settings: of the loop; its first program runs.
        model: shared library of a compiled model; None estimates nothing.
        rig: parameters of the twin.
        seed: of the torque meter's noise.
        speed: initial speed of the motor in rad/s.
        locked: the output shaft is held.
        hand: speeds in rad/s, one a row, at which a hand moves the output whatever its torque; the last one stays.
        single: CH1 alone is left.
        rotary: alpha is read by the rotary encoder instead of the linear one.

    Attributes:
        core: to give orders to between stretches.
    """

    def __init__(
        self,
        settings: LoopSettings,
        model: Path | None,
        rig: RigParameters,
        *,
        seed: int = 0,
        speed: float = 0.0,
        locked: bool = False,
        hand: Array | None = None,
        single: bool = False,
        rotary: bool = False,
    ) -> None:
        self.core = Core(settings, model)
        self._run = _runner()
        self._parts = parts_of(rig)
        if single:
            self._parts = single_clutch(self._parts)
        self._steps = substeps(rig)
        self._state = np.zeros(SIZE)
        self._state[OMEGA] = speed
        self._rotary = rotary
        self._locked = locked or hand is not None
        self._hand = np.zeros(0)
        if hand is not None:
            self._hand = np.ascontiguousarray(hand, np.float64)
        self._random = np.random.default_rng(seed)
        self._sample = np.zeros(SAMPLE.itemsize // 8, np.uint64)
        self._command = np.zeros(COMMAND.itemsize // 8)
        self._rows = 0

    @property
    def warming(self) -> float:
        """How much warmer the clutches are than at the start, in K: only a twin knows."""
        return float(self._state[WARMTH])

    def frames(self, rows: int) -> tuple[Any, Array]:
        """Run on.

        Args:
            rows: how many steps.

        Returns:
            Frames, dtype `FRAME`, shape (rows,), with times as if each step had been on time; and the other encoder's
            alpha in rad, shape (rows,).
        """
        words = np.zeros((rows, _WORDS))
        other = np.empty(rows)
        noise = self._random.standard_normal(rows)
        # fmt: off
        self._run(
            self.core.memory, self._state, self._parts,
            self._locked, self._hand, self._rotary, noise,
            self._rows, PERIOD / self._steps, self._steps,
            self._sample, self._sample.view(np.float64),
            self._command, words, other,
        )
        # fmt: on
        frames = words.view(FRAME).reshape(rows)
        frames["seq"] = np.arange(self._rows, self._rows + rows)
        frames["time_ns"] = frames["seq"] * np.uint64(round(PERIOD * 1e9))
        frames["lateness_ns"] = 0
        frames["step_ns"] = 0
        self._rows += rows
        return frames, other

    def stretches(self, rows: int, each: int) -> Iterator[Any]:
        """Frames of a long run, ``each`` at a time."""
        while rows > 0:
            yield self.frames(min(each, rows))[0]
            rows -= each
