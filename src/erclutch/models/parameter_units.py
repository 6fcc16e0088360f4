"""Normalised parameters in the data's units, and the unit of each as text."""

from __future__ import annotations

from collections.abc import Mapping

from erclutch.models.laws import Dimension
from erclutch.models.laws.law import Gain
from erclutch.models.structure import Reference
from erclutch.signals.device import Units
from erclutch.signals.recording import POSITION, TEMPERATURE
from erclutch.signals.units import UNKNOWN


def in_user_units(value: float, dimension: Dimension, reference: Reference) -> float:
    """A normalised number in the data's own units."""
    scale = reference.field**dimension.field * reference.slip**dimension.slip
    return value * scale * reference.temperature**dimension.temperature


def gain_in_user_units(value: float, gain: Gain, reference: Reference) -> float:
    """A normalised gain in the data's own units; the gain of a further input is an effort per unit of the input."""
    per = 1.0 if gain.extra is None else reference.extras[gain.extra]
    return in_user_units(value, gain.dimension, reference) / per


def known_unit(extra: str, units: Units, logged: str = UNKNOWN) -> str:
    """The unit of a further input: that of the logs, or what its name tells; "?" where neither says it."""
    if logged != UNKNOWN:
        return logged
    if extra == TEMPERATURE:
        return "K"
    if extra == POSITION and units.slip.endswith("/s"):
        return units.slip.removesuffix("/s")  # the position is the slip's integral
    return UNKNOWN


def unit_of_gain(gain: Gain, units: Units, extra_units: Mapping[str, str]) -> str:
    """Unit of a gain, such as ``N`` or, of the position, ``N/m``; "?" inside where nobody gave the input's unit.

    Args:
        gain: one of a law's structure.
        units: of effort, field and slip.
        extra_units: of the further inputs, in their order.
    """
    unit = unit_text(gain.dimension, units)
    if gain.extra is None:
        return unit
    per = list(extra_units.values())[gain.extra]
    if per in ("", "-", "1"):
        return unit
    if "/" in per or "*" in per:
        per = f"({per})"
    return f"{unit}/{per}"


def unit_text(dimension: Dimension, units: Units) -> str:
    """Unit of a parameter, such as ``N/(m/s)``; "1" for a pure number, "?" inside where the log gave no unit."""
    motion = [(dimension.slip, units.slip), (dimension.time, "s")]
    if dimension.slip and dimension.time and units.slip.endswith("/s"):
        # A slip times s is a way, a slip over s an acceleration.
        way = units.slip.removesuffix("/s")
        unit = way if dimension.slip == dimension.time else f"{way}/s^2"
        motion = [(dimension.slip, unit)]

    above: list[str] = []
    below: list[str] = []
    for exponent, unit in (
        (dimension.effort, units.effort),
        (dimension.field, units.field),
        *motion,
        (dimension.temperature, "K"),
    ):
        if not exponent or not unit:
            continue
        if "/" in unit and exponent != 1:
            unit = f"({unit})"
        if abs(exponent) > 1:
            unit += f"^{abs(exponent)}"
        side = above if exponent > 0 else below
        side.append(unit)
    text = "*".join(above) or "1"
    return text + "".join(f"/{name}" for name in below)
