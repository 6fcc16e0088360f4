"""Target: a log of the user's own pair. The twin gets the log's commands and is compared sample by sample.

The log is cut into short stretches; each starts from the measured angles and speeds, so that neither drift nor a guard
at the stroke's end makes the two part ways, and its first rows, while inner states settle, are left out. Compared are
the torque and both speeds (over 5 ms, so that encoder steps do not drown them), each over its own spread in the log.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import CheckError, MappingError
from erclutch.rig.parameters import RigParameters
from erclutch.rig.parts import parts_of
from erclutch.rig.replay import follow
from erclutch.rig.twin import PERIOD, substeps
from erclutch.signals import Recording

Array = NDArray[np.float64]

_SETTLING, _STRETCH, _MOST = 150, 650, 60  # rows, rows, stretches
_APART = 5  # rows of a speed's difference quotient


@dataclass(frozen=True)
class Trace:
    """The target.

    Attributes:
        recording: a coaxial log with E1 and E2 (or E), theta, alpha, T and motor_torque, sampled at 1 kHz.
    """

    recording: Recording

    def __post_init__(self) -> None:
        missing = [name for name in ("theta", "alpha", "T", "motor_torque") if name not in self.recording.signals]
        if missing:
            raise MappingError(
                f"a log to calibrate to needs theta, alpha, T and motor_torque; {', '.join(missing)} is missing",
                remedy='Name its column, such as --motor-torque "M [N*m]"',
                where=self.recording.name,
            )
        if abs(self.recording.period - PERIOD) > 1e-6:
            raise CheckError(
                f"sampled at {1 / self.recording.period:g} Hz, and the twin runs at {1 / PERIOD:g} Hz",
                remedy="Resample the log",
                where=self.recording.name,
            )
        if not self._starts():
            raise CheckError(
                f"no stretch without a gap is {(_STRETCH + 2 * _APART) * PERIOD:g} s long",
                remedy="Give a longer log",
                where=self.recording.name,
            )

    @property
    def name(self) -> str:
        """For people."""
        return self.recording.name

    @property
    def ordered(self) -> bool:
        """Residuals are samples in time."""
        return True

    def _starts(self) -> list[int]:
        whole = [
            start
            for first, stop in self.recording.segments
            for start in range(first + _APART, stop - _STRETCH - _APART, _STRETCH)
        ]
        if len(whole) <= _MOST:
            return whole
        return [whole[round(i * (len(whole) - 1) / (_MOST - 1))] for i in range(_MOST)]

    def residuals(self, rig: RigParameters) -> Array:
        """Torque and speeds of the twin less those of the log, each over its spread in the log."""
        signals = self.recording.signals
        fields = signals["E1"] - signals["E2"] if "E1" in signals else signals["E"]
        parts, steps = parts_of(rig), substeps(rig)
        out: list[Array] = []
        for start in self._starts():
            rows = slice(start, start + _STRETCH)
            speeds = [
                float(signals[s][start + _APART] - signals[s][start - _APART]) / (2 * _APART * PERIOD)
                for s in ("theta", "alpha")
            ]
            log = follow(
                parts, fields[rows], signals["motor_torque"][rows], signals["theta"][start], signals["alpha"][start],
                speeds[0], speeds[1], float(signals["T"][start]), PERIOD / steps, steps,
            )  # fmt: skip
            pairs = ((log[:, 2], signals["T"][rows], self._spread("T")),
                     (_rate(log[:, 0]), _rate(signals["theta"][rows]), self._spread("theta")),
                     (_rate(log[:, 1]), _rate(signals["alpha"][rows]), self._spread("alpha")))  # fmt: skip
            out += [(ours - theirs)[_SETTLING:] / spread for ours, theirs, spread in pairs]
        return np.concatenate(out)

    def _spread(self, signal: str) -> float:
        values = self.recording.signals[signal]
        return float(np.std(values if signal == "T" else _rate(values))) or 1.0


def _rate(angle: Array) -> Array:
    """Speed over a few rows, in rad/s; the first rows repeat the first speed."""
    speed = (angle[_APART:] - angle[:-_APART]) / (_APART * PERIOD)
    return np.concatenate([np.full(_APART, speed[0]), speed])
