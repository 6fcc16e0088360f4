"""A controller senses, commands and steps a rig at 1 kHz. Twin, replay and hardware all look like this."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Measurement:
    """What the sensors read at one time.

    Attributes:
        time: in s since the start.
        theta: motor angle in rad, quantised by its encoder.
        alpha_raw: table position in m, quantised by the linear encoder.
        alpha_rotary: angle of the clutches' output shaft in rad, by the rotary encoder.
        torque: torque meter in N m.
    """

    time: float
    theta: float
    alpha_raw: float
    alpha_rotary: float
    torque: float


@dataclass(frozen=True)
class RigCommand:
    """What a controller asks for over the next period.

    Attributes:
        E1, E2: fields, 0 to 0.5; at most one above zero.
        motor_torque: in N m.
    """

    E1: float = 0.0
    E2: float = 0.0
    motor_torque: float = 0.0


class SteppedRig(Protocol):
    """A rig that is stepped at its sampling rate."""

    @property
    def period(self) -> float:
        """Sampling period in s."""
        ...

    def sense(self) -> Measurement:
        """Read the sensors; the same until the next step."""
        ...

    def command(self, command: RigCommand) -> None:
        """Set the commands for the next step. What the supply would not do, it does not do, and it is counted."""
        ...

    def step(self) -> None:
        """Let one period pass."""
        ...

    def close(self) -> None:
        """Fields and torque to zero."""
        ...
