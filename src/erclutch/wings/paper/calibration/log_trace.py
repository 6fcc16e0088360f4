"""The target is a log of the user's own pair: the twin gets the log's commands and is compared sample by sample.

The log is cut into short stretches; each starts from the measured angles and speeds, so that neither drift nor a guard
at the stroke's end makes the two part ways, and its first rows, while inner states settle, are left out. Compared are
the torque and both speeds (over 5 ms, so that encoder steps do not drown them), each over its own spread in the log.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from erclutch.errors import CheckError, MappingError
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording
from erclutch.wings.paper.sweep_points import digest_of_rows
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.part_parameters import parts_of
from erclutch.wings.rig.twin.twin import PERIOD, substeps
from erclutch.wings.rig.twin.twin_replay import follow

_SETTLING = 150  # rows at the start of a stretch that are left out
_STRETCH = 650  # rows
_MOST = 60  # stretches
_APART = 5  # rows of a speed's difference quotient


@dataclass(frozen=True)
class LogTrace:
    """The target.

    Attributes:
        recording: a coaxial log with E1 and E2 (or E), theta, alpha, T and motor_torque, sampled at 1 kHz.
        ordered: residuals are samples in time.
    """

    recording: Recording
    ordered: ClassVar[bool] = True

    def __post_init__(self) -> None:
        log = self.recording
        missing = [
            name for name in ("theta", "alpha", "T", "motor_torque") if name not in log.signals
        ]
        if missing:
            raise MappingError(
                f"a log to calibrate to needs theta, alpha, T and motor_torque; {', '.join(missing)} is missing",
                remedy='Name its column, such as --motor-torque "M [N*m]"',
                where=log.name,
            )
        if abs(log.period - PERIOD) > 1e-6:
            problem = f"sampled at {1 / log.period:g} Hz, and the twin runs at {1 / PERIOD:g} Hz"
            raise CheckError(problem, remedy="Resample the log", where=log.name)
        if not self._starts():
            seconds = (_STRETCH + 2 * _APART) * PERIOD
            problem = f"no stretch without a gap is {seconds:g} s long"
            raise CheckError(problem, remedy="Give a longer log", where=log.name)

    @property
    def name(self) -> str:
        """For people."""
        return self.recording.name

    @property
    def digest(self) -> str:
        """Of the rows as they were read: a log may have been changed, or a sign turned."""
        names = sorted(self.recording.signals)
        return digest_of_rows(self.recording.signals[name] for name in names)

    def _starts(self) -> list[int]:
        """First rows of the stretches, none across a gap; of a long log some, evenly over it."""
        starts: list[int] = []
        for first, stop in self.recording.segments:
            starts += range(first + _APART, stop - _STRETCH - _APART, _STRETCH)
        if len(starts) <= _MOST:
            return starts
        last = len(starts) - 1
        return [starts[round(number * last / (_MOST - 1))] for number in range(_MOST)]

    def residuals(self, rig: RigParameters) -> Array:
        """Torque and speeds of the twin less those of the log, each over its spread in the log."""
        signals = self.recording.signals
        theta = signals["theta"]
        alpha = signals["alpha"]
        torque = signals["T"]
        motor_torque = signals["motor_torque"]
        field = signals["E1"] - signals["E2"] if "E1" in signals else signals["E"]
        # What a difference is divided by; 1 where a signal never changes.
        torque_spread = float(np.std(torque)) or 1.0
        theta_dot_spread = float(np.std(_rate(theta))) or 1.0
        alpha_dot_spread = float(np.std(_rate(alpha))) or 1.0

        parts = parts_of(rig)
        steps = substeps(rig)
        angles = np.column_stack([theta, alpha])
        residuals: list[Array] = []
        for start in self._starts():
            rows = slice(start, start + _STRETCH)
            turned = angles[start + _APART] - angles[start - _APART]
            speeds = turned / (2 * _APART * PERIOD)
            first = np.array([*angles[start], *speeds, torque[start]], np.float64)
            step = PERIOD / steps  # [s], of the twin
            twin = follow(parts, field[rows], motor_torque[rows], first, step, steps)

            # Columns of the twin: theta, alpha, torque.
            torque_apart = twin[:, 2] - torque[rows]
            theta_dot_apart = _rate(twin[:, 0]) - _rate(theta[rows])
            alpha_dot_apart = _rate(twin[:, 1]) - _rate(alpha[rows])
            residuals.append(torque_apart[_SETTLING:] / torque_spread)
            residuals.append(theta_dot_apart[_SETTLING:] / theta_dot_spread)
            residuals.append(alpha_dot_apart[_SETTLING:] / alpha_dot_spread)
        return np.concatenate(residuals)


def _rate(angle: Array) -> Array:
    """Speed over a few rows, in rad/s; the first rows repeat the first speed."""
    speed = (angle[_APART:] - angle[:-_APART]) / (_APART * PERIOD)
    return np.concatenate([np.full(_APART, speed[0]), speed])
