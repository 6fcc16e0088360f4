"""A column in volts or counts becomes a signal by what a volt or a count of its sensor means: ``2.5 N*m/V``."""

from __future__ import annotations

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.labels import COUNTS
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS


def by_sensor(
    signal: str,
    name: str,
    unit: str | None,
    text: str,
) -> tuple[float, str, str]:
    """Factor, SI unit and note of a column that a scale makes a signal of: ``2.5 N*m/V`` for a sensor in volts."""
    number, made, sensor = scaled(text, signal)
    unit = None if unit in COUNTS else unit
    if sensor is not None and unit is not None:
        fitting = units.fits(unit, (sensor,))
        if fitting is None:
            problem = f"column '{name}' has the unit '{unit}', and the scale of {signal} is {text}"
            raise UnitError(problem, remedy=f"Give the scale in {signal} per {unit}, or the column's unit")
        number *= fitting[0]
    elif unit is not None and made is not None:
        problem = f"column '{name}' has the unit '{unit}', and the scale of {signal}, {text}, names no unit of a sensor"
        raise UnitError(problem, remedy=f"Write it like --scale {shell_word(f'{signal}={text}/{unit}')}")
    made = made if made is not None else unit
    if made is None:
        return number, units.UNKNOWN, f", times {text}, no unit: taken as logged"
    factor, si = units.conversion(made, SIGNALS[signal], name)
    return number * factor, si, f", times {text}"


def scaled(text: str, signal: str) -> tuple[float, str | None, str | None]:
    """A scale such as ``2.5 N*m/V`` as 2.5, ``N*m`` and ``V``; None where it names no unit, or none of a sensor.

    Raises:
        MappingError: no number with a unit, or zero.
    """
    try:
        number, unit = units.quantity(text)
        over, _, under = (unit or "").rpartition("/")
        whole = not unit or (units.is_unit(unit) and units.fits(unit, SIGNALS[signal].si_units))
        whole = whole and under.strip() != "%"  # a per cent of the rated torque is the unit of a drive's sensor
        if not whole:
            over = units.parse(over).text
            under = None if under in COUNTS else units.parse(under).text
    except UnitError:
        number, whole, over, under, unit = 0.0, False, "", None, None
    if not 0 < abs(number) < float("inf"):
        problem = f"the scale of {signal} is '{text}'"
        example = f"{signal}=2.5 {SIGNALS[signal].si_units[0] or '1'}/V"
        raise MappingError(problem, remedy=f"Write it like --scale {shell_word(example)}")
    return (number, unit, None) if whole else (number, over, under)
