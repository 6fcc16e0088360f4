"""Normalised parameters in the data's units, and the unit of each as text."""

from __future__ import annotations

from erclutch.models.laws import Dimension
from erclutch.models.structure import Reference
from erclutch.signals.device import Units


def in_user_units(value: float, dimension: Dimension, reference: Reference) -> float:
    """A normalised number in the data's own units."""
    scale = reference.field**dimension.field * reference.slip**dimension.slip
    return value * scale * reference.temperature**dimension.temperature


def unit_text(dimension: Dimension, units: Units) -> str:
    """Unit of a parameter, such as ``N/(m/s)``; "1" for a pure number, "?" inside where the log gave no unit."""
    above: list[str] = []
    below: list[str] = []
    motion = ((dimension.slip, units.slip), (dimension.time, "s"))
    if dimension.slip and dimension.time and units.slip.endswith("/s"):
        way = units.slip.removesuffix("/s")
        motion = ((dimension.slip, way if dimension.slip == dimension.time else f"{way}/s^2"),)
    powers = ((dimension.effort, units.effort), (dimension.field, units.field), *motion, (dimension.temperature, "K"))
    for exponent, unit in powers:
        if exponent and unit:
            name = f"({unit})" if "/" in unit and (exponent < 0 or exponent > 1) else unit
            power = f"^{abs(exponent)}" if abs(exponent) > 1 else ""
            (above if exponent > 0 else below).append(name + power)
    text = "*".join(above) or "1"
    return text + "".join(f"/{name}" for name in below)
