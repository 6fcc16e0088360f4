"""A recording plays back as a rig: its sensors again, row after row. Commands change nothing. RECORDING."""

from __future__ import annotations

import math

import numpy as np

from erclutch.errors import MappingError, SettingError
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording
from erclutch.signals.units import UNKNOWN
from erclutch.wings.rig.interface import Measurement, RigCommand
from erclutch.wings.rig.rig_server import RigEnd

#: Rows of a loop that a replay keeps in memory, hours at 1 kHz.
_MOST_ROWS = 10_000_000


class Playback:
    """Angles and torque of a log, at its sampling rate; one step a row, `RigEnd` after the last.

    Args:
        angles: theta and alpha in rad and torque in N m (nan where not measured), shape (n, 3).
        period: sampling period in s.
    """

    def __init__(self, angles: Array, period: float) -> None:
        self._angles = angles
        self.period = period
        self._row = -1

    def sense(self) -> Measurement:
        """The sensors of the current row; alpha stands in rad where a table's position would be (lead 2 pi)."""
        row = max(self._row, 0)
        theta, alpha, torque = (float(v) for v in self._angles[row])
        return Measurement(row * self.period, theta, alpha, alpha, torque)

    def command(self, command: RigCommand) -> None:
        """Nothing: what happened has happened."""

    def step(self) -> None:
        """On to the next row."""
        if self._row + 1 >= len(self._angles):
            raise RigEnd
        self._row += 1

    def close(self) -> None:
        """Nothing to close."""


def at_period(
    log: Recording,
    values: Array,
    period: float,
    *,
    held: bool,
    seconds: float = math.inf,
) -> Array:
    """Rows of a recording as a loop of another period meets them, shape (m, 3).

    Args:
        log: whose rows they are.
        values: one row a row of the log, shape (n, 3); angles that do not wrap.
        period: of the loop in s.
        held: the last row holds (commands); else they are drawn out in lines between rows (positions).
        seconds: of the log from its start that are wanted.

    Raises:
        SettingError: so many rows that memory would not hold them.
    """
    lasts = min((len(values) - 1) * log.period, seconds)
    if lasts / period > _MOST_ROWS:
        most = f"{_MOST_ROWS * period:.0f}"
        problem = (
            f"a replay of {lasts:.0f} s has more than {_MOST_ROWS:,} rows at {1 / period:.0f} Hz"
        )
        raise SettingError(
            problem, where=log.name, remedy=f"Give --seconds {most} or fewer, or a shorter log"
        )
    if abs(log.period / period - 1.0) < 1e-4:
        return values[: int(lasts / period + 0.5) + 1]
    at = np.arange(int(lasts / period) + 1) * (period / log.period)
    if held:
        return values[np.minimum((at + 1e-9).astype(np.int64), len(values) - 1)]
    places = np.arange(len(values))
    columns: list[Array] = [np.interp(at, places, column) for column in values.T]
    return np.column_stack(columns)


def angles_of(log: Recording, wraps: tuple[float, float] = (0.0, 0.0)) -> Array:
    """What the sensors of a recording read: theta, alpha, torque, shape (n, 3). Speeds are summed to angles.

    A single device has its position (or summed slip) in theta, zero in alpha and its effort in torque.

    Args:
        log: the recording.
        wraps: range in rad of an encoder of theta and of alpha that starts again at zero; 0 for none.

    Raises:
        MappingError: neither angles nor speeds.
    """
    signals = log.signals

    def angle(position: str, speed: str) -> Array | None:
        if speed not in signals:
            return signals.get(position)
        # A position without a unit may be in cm: beside a slip in m/s it would be differentiated to 100 times that.
        own = log.units.get(position, UNKNOWN)
        if position in signals and own != UNKNOWN and f"{own}/s" == log.units.get(speed):
            return signals[position]
        return np.cumsum(signals[speed]) * log.period

    theta = angle("theta", "theta_dot")
    alpha = angle("alpha", "alpha_dot")
    if theta is None:
        theta = angle("position", "slip")
        alpha = np.zeros(log.rows)
    if theta is None or alpha is None:
        raise MappingError(
            "a replay needs theta and alpha, or a position or slip",
            where=log.name,
            remedy="Say which columns they are, with --device, --theta, --alpha, --slip or a mapping file",
        )
    theta_wrap, alpha_wrap = wraps
    if theta_wrap > 0.0:
        theta = np.unwrap(theta, period=theta_wrap)
    if alpha_wrap > 0.0:
        alpha = np.unwrap(alpha, period=alpha_wrap)
    not_measured = np.full(log.rows, math.nan)
    torque = signals.get("T", signals.get("effort", not_measured))
    return np.column_stack([theta, alpha, torque])


def fields_of(log: Recording) -> Array:
    """The commands of a recording: E1, E2, motor torque, shape (n, 3); what was not logged is zero.

    A single device has the negative part of its field in the place of E2.
    """
    signals = log.signals
    zero = np.zeros(log.rows)
    first = zero
    second = zero
    signed = signals.get("E", signals.get("field"))
    if "E1" in signals:
        first = signals["E1"]
        second = signals.get("E2", zero)
    elif signed is not None:
        first = np.maximum(signed, 0.0)
        second = np.maximum(-signed, 0.0)
    return np.column_stack([first, second, signals.get("motor_torque", zero)])
