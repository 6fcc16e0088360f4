"""A device combines elements: signals become the field and slip of each element.

coaxial: two clutches driven in opposite directions by one motor, efforts added (equations 5 - 7 of the paper)::

    w1 = theta_dot - alpha_dot,   w2 = -theta_dot - alpha_dot,   T = T1 + T2

single: one clutch, brake or damper: field and slip in, effort out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from erclutch.signals.array import Array, largest_size

DeviceName = Literal["single", "coaxial"]
DEVICES: tuple[DeviceName, ...] = ("single", "coaxial")

#: The sign in which each element drives: one for each element of the device.
WAYS_OF: Mapping[DeviceName, tuple[float, ...]] = {"single": (1.0,), "coaxial": (1.0, -1.0)}
#: Position signal -> the speed that it is differentiated to where that is not logged.
SPEED_OF = {"position": "slip", "theta": "theta_dot", "alpha": "alpha_dot"}
EFFORT_OF: Mapping[DeviceName, str] = {"single": "effort", "coaxial": "T"}


@dataclass(frozen=True)
class Element:
    """One gap full of fluid.

    Attributes:
        field: command, shape (n,).
        slip: relative speed, shape (n,).
    """

    field: Array
    slip: Array


def largest_field(elements: Sequence[Element]) -> float:
    """The largest magnitude of the field of any element, in the field's unit."""
    largest = [largest_size(element.field) for element in elements]
    return max(largest)


@dataclass(frozen=True)
class Units:
    """Units of a device's signals, as text; "" is dimensionless, "?" unknown (as logged)."""

    effort: str
    field: str
    slip: str

    def text(self) -> str:
        """The three as words, for messages."""
        words: list[str] = []
        for name, unit in (("effort", self.effort), ("field", self.field), ("slip", self.slip)):
            shown = "units as logged" if unit == "?" else unit or "1"
            words.append(f"{name} in {shown}")
        return ", ".join(words)


def names_in_elements(device: DeviceName, name: str) -> tuple[str, ...]:
    """What a number of an element is called in each: ``eta`` of a single device, ``eta_1``, ``eta_2`` of the pair."""
    count = len(WAYS_OF[device])
    if count == 1:
        return (name,)
    return tuple(f"{name}_{element}" for element in range(1, count + 1))


def slips_of(device: DeviceName, speeds: Sequence[Any]) -> list[Any]:
    """Slip of each element from the speeds: (slip,) of a single device, (theta_dot, alpha_dot) of the coaxial pair.

    Elementwise on any operand.
    """
    if device == "single":
        return [speeds[0]]
    theta_dot, alpha_dot = speeds
    return [theta_dot - alpha_dot, -theta_dot - alpha_dot]


def speeds_of(device: DeviceName, slips: Sequence[Any]) -> list[Any]:
    """The speeds that give the slips; the inverse of `slips_of`."""
    if device == "single":
        return [slips[0]]
    w1, w2 = slips
    theta_dot = 0.5 * (w1 - w2)
    alpha_dot = -0.5 * (w1 + w2)
    return [theta_dot, alpha_dot]


def elements_of(device: DeviceName, signals: Mapping[str, Array]) -> tuple[Element, ...]:
    """Field and slip of each element of a device.

    Args:
        device: "single" or "coaxial".
        signals: for single ``field, slip``; for coaxial ``E1, E2`` or the signed ``E``, and ``theta_dot, alpha_dot``.

    Returns:
        One element for a single device, (CH1, CH2) for the coaxial pair.
    """
    if device == "single":
        return (Element(signals["field"], signals["slip"]),)
    if "E1" in signals:
        first = signals["E1"]
        second = signals["E2"]
    else:
        first = np.maximum(signals["E"], 0.0)
        second = np.maximum(-signals["E"], 0.0)
    slips = slips_of(device, (signals["theta_dot"], signals["alpha_dot"]))
    return Element(first, slips[0]), Element(second, slips[1])
