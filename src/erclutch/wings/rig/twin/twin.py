"""The digital twin is a rig. TWIN: everything that comes from it is labelled so."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from erclutch.wings.rig.interface import Measurement, RigCommand
from erclutch.wings.rig.twin.jit import for_arguments_like
from erclutch.wings.rig.twin.kernel import OMEGA, SIZE, WARMTH, advance
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from erclutch.wings.rig.twin.part_parameters import parts_of, single_clutch
from erclutch.wings.rig.twin.sampled_rows import sense
from erclutch.wings.rig.twin.supply import interlocked

LABEL = "TWIN"
PERIOD = 1.0e-3


class Twin:
    """Two coaxial ER clutches on a ball screw, or one of them as a brake, stepped at 1 kHz.

    Args:
        rig: its parameters; None is the default rig.
        seed: of the torque meter's noise.
        locked: whether the output shaft is held.
        single: CH1 alone is left; with the output shaft held it is a brake.
        speed: initial speed of the motor in rad/s.

    Attributes:
        period: sampling period in s.
        events: how often a command was changed or refused, by kind: ``both fields``, ``beyond limit``, ``not finite``.
    """

    period = PERIOD

    def __init__(
        self,
        rig: RigParameters | None = None,
        *,
        seed: int = 0,
        locked: bool = False,
        single: bool = False,
        speed: float = 0.0,
    ) -> None:
        self.rig = rig or default_rig()
        self.events: Counter[str] = Counter()
        self._parts = single_clutch(parts_of(self.rig)) if single else parts_of(self.rig)
        self._steps = substeps(self.rig)
        self._random = np.random.default_rng(seed)
        self._locked = locked
        self._state = np.zeros(SIZE)
        self._state[OMEGA] = speed
        self._rows = 0
        self._command = RigCommand()
        self._command_limit = self.rig.value("supply.command_limit")
        self._torque_limit = self.rig.value("drive.torque_limit")
        self._row = np.zeros(7)
        self._sense = for_arguments_like(sense, self._state, self._parts, 0.0, self._row)
        self._advance = for_arguments_like(
            advance, self._state, self._parts, 0.0, 0.0, 0.0, locked, PERIOD, self._steps
        )
        self._measured = self._read()

    @property
    def warming(self) -> float:
        """How much warmer the clutches are than at the start, in K: only a twin knows."""
        return float(self._state[WARMTH])

    def sense(self) -> Measurement:
        """Read the sensors; the same until the next step."""
        return self._measured

    def command(self, command: RigCommand) -> None:
        """Set the commands for the next step.

        As the supply would: a field beyond its limit is clipped, of two fields the smaller gives way, and a command
        that is not finite counts as zero; each is counted in `events`.
        """
        limit = self._command_limit
        first, second = (self._clipped(field, 0.0, limit) for field in (command.E1, command.E2))
        first, second, gave_way = interlocked(first, second)
        if gave_way:
            self.events["both fields"] += 1
        bound = self._torque_limit
        self._command = RigCommand(
            first, second, self._clipped(command.motor_torque, -bound, bound)
        )

    def step(self) -> None:
        """Let one period pass."""
        now = self._command
        dt = PERIOD / self._steps
        self._advance(
            self._state,
            self._parts,
            now.E1,
            now.E2,
            now.motor_torque,
            self._locked,
            dt,
            self._steps,
        )
        self._rows += 1
        self._measured = self._read()

    def close(self) -> None:
        """Fields and torque to zero."""
        self._command = RigCommand()

    def __enter__(self) -> Twin:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _clipped(self, value: float, low: float, high: float) -> float:
        if not math.isfinite(value):
            self.events["not finite"] += 1
            return 0.0
        if not low <= value <= high:
            self.events["beyond limit"] += 1
        return min(max(value, low), high)

    def _read(self) -> Measurement:
        noise = float(self._random.standard_normal())
        self._sense(self._state, self._parts, noise, self._row)
        return Measurement(self._rows * PERIOD, *self._row[3:7].tolist())


def substeps(rig: RigParameters) -> int:
    """Internal steps in a sampling period."""
    return max(1, round(PERIOD / rig.value("integration.step")))
