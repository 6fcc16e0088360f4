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
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.part_parameters import parts_of
from erclutch.wings.rig.twin.twin import PERIOD, substeps
from erclutch.wings.rig.twin.twin_replay import follow

_SETTLING, _STRETCH, _MOST = 150, 650, 60  # rows, rows, stretches
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
        missing = [name for name in ("theta", "alpha", "T", "motor_torque") if name not in log.signals]
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
            problem = f"no stretch without a gap is {(_STRETCH + 2 * _APART) * PERIOD:g} s long"
            raise CheckError(problem, remedy="Give a longer log", where=log.name)

    @property
    def name(self) -> str:
        """For people."""
        return self.recording.name

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
        compared = {"T": signals["T"], "theta": _rate(signals["theta"]), "alpha": _rate(signals["alpha"])}
        angles = np.column_stack([signals["theta"], signals["alpha"]])
        out: list[Array] = []
        for start in self._starts():
            rows = slice(start, start + _STRETCH)
            speeds = (angles[start + _APART] - angles[start - _APART]) / (2 * _APART * PERIOD)
            first = np.array([*angles[start], *speeds, signals["T"][start]], np.float64)
            log = follow(parts, fields[rows], signals["motor_torque"][rows], first, PERIOD / steps, steps)
            ours = {"T": log[:, 2], "theta": _rate(log[:, 0]), "alpha": _rate(log[:, 1])}
            for name, values in compared.items():
                theirs = signals["T"][rows] if name == "T" else _rate(signals[name][rows])
                out.append((ours[name] - theirs)[_SETTLING:] / (float(np.std(values)) or 1.0))
        return np.concatenate(out)


def _rate(angle: Array) -> Array:
    """Speed over a few rows, in rad/s; the first rows repeat the first speed."""
    speed = (angle[_APART:] - angle[:-_APART]) / (_APART * PERIOD)
    return np.concatenate([np.full(_APART, speed[0]), speed])
