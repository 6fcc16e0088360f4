"""Numbers and units are written as people read them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.signals.units import AS_LOGGED, UNKNOWN

#: A space at which no line breaks, between a number and its unit.
_TIGHT = "\u00a0"
_MOST_SHARE = 1000.0  # of the standard deviation of the effort
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def plain(text: str) -> str:
    """Text for a terminal: with spaces as everybody types them."""
    return text.replace(_TIGHT, " ")


def number(value: float | None, digits: int = 3) -> str:
    """A number to a few significant digits; no exponent where it can be read without one."""
    if value is None or math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if -4 <= size < 6:
        rounded = round(value, digits - 1 - size)
        places = 0
        if rounded:
            size_of_rounded = math.floor(math.log10(abs(rounded)))
            places = max(0, digits - 1 - size_of_rounded)
        text = f"{rounded:.{places}f}"
    else:
        mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa}·10{str(int(power)).translate(_RAISED)}"
    return text.replace("-", "−")


def capital(text: str) -> str:
    """A text with a large first letter."""
    return text[:1].upper() + text[1:]


def count(value: int) -> str:
    """A number of things, thousands apart."""
    return f"{value:,}".replace(",", _TIGHT)


def r2_text(value: float, places: int = 3) -> str:
    """R2 with fixed places; how far below -1000 says nothing.

    A fit that ran away ends there, and the band of a log whose effort stands still over whole stretches: resampled, its
    variance is next to nothing, and any error is a huge multiple.
    """
    return "below -1000" if value <= -1000.0 else f"{value:z.{places}f}"


def percent_text(value: float | None, digits: int = 3) -> str:
    """A share as per cent."""
    return "–" if value is None else f"{number(100.0 * value, digits)}{_TIGHT}%"


def span(low: float | None, high: float | None, digits: int = 3) -> str:
    """An interval."""
    return f"{number(low, digits)} to {number(high, digits)}"


def share_span(low: float, high: float) -> str:
    """The band of a share in per cent; how far above 1000 times all an end lies says nothing, see `r2_text`."""
    if high > _MOST_SHARE:
        return f"{number(100.0 * low)} to more than {count(round(100.0 * _MOST_SHARE))}"
    return span(100.0 * low, 100.0 * high)


def interval(estimate: Mapping[str, Any], factor: float) -> tuple[str, bool]:
    """The 95 % interval of a parameter in run.json, and whether the data identify the parameter."""
    low, high = estimate["low"], estimate["high"]
    known = "" if low is None or high is None else span(low * factor, high * factor)
    if estimate["at_bound"]:
        bound = f"at its {estimate['at_bound']} bound"
        return f"{bound}, {known}" if known else bound, False
    return (known, True) if known else ("not identified", False)


def unit_text(unit: str) -> str:
    """A unit as printed."""
    if UNKNOWN in unit:
        return f"units {AS_LOGGED}"
    return unit.replace("*", "·").replace("^2", "²").replace("^", "")


def brief(unit: str) -> str:
    """A printed unit where room is short: in brackets and after a number."""
    return unit.removeprefix("units ")


def titled(name: str, unit: str) -> str:
    """A heading with the unit in brackets."""
    return f"{name} [{brief(unit)}]" if unit else name


@dataclass(frozen=True)
class Scale:
    """How a signal's numbers are shown.

    Attributes:
        factor: shown number over the one in the run.
        unit: as printed; empty for a pure number.
    """

    factor: float
    unit: str

    def of(self, value: float | None, digits: int = 3) -> str:
        """A number with its unit."""
        shown = self.bare(value, digits)
        return f"{shown}{_TIGHT}{brief(self.unit)}" if self.unit and shown != "–" else shown

    def bare(self, value: float | None, digits: int = 3) -> str:
        """A number without its unit."""
        return number(None if value is None else value * self.factor, digits)

    def band(self, figure: Sequence[float | None], digits: int = 3) -> str:
        """The 95 % band of (value, low, high)."""
        return f"{self.bare(figure[1], digits)} to {self.bare(figure[2], digits)}"

    def titled(self, name: str) -> str:
        """A heading with the unit in brackets."""
        return titled(name, self.unit)


def scale_for(unit: str, size: float) -> Scale:
    """Milli or kilo, where numbers of this size read better so."""
    if unit in ("N*m", "N", "V", "A", "m", "m/s") and size > 0:
        if size < 0.2:
            return Scale(1e3, f"m{unit_text(unit)}")
        if size > 5e3:
            return Scale(1e-3, f"k{unit_text(unit)}")
    if unit == "V/m" and size > 1e5:
        return Scale(1e-6, "kV/mm")
    return Scale(1.0, unit_text(unit))


#: In s: a device warms in so long a time and longer, and ms have too many digits.
_LONG_TIME = 10.0


def constant_scale(unit: str, size: float) -> Scale:
    """How a model's constant of this size is shown: times in ms or s, a pure number without a unit."""
    if unit == "s":
        return Scale(1e3, "ms") if size < _LONG_TIME else Scale(1.0, "s")
    return scale_for("" if unit == "1" else unit, size)


def chart_scale(unit: str, size: float) -> Scale:
    """Numbers of this size with few digits beside the ticks of a chart, whatever their unit is."""
    scale = constant_scale(unit, size)
    shown = size * scale.factor
    if shown == 0.0 or 1e-2 <= shown < 1e5:
        return scale
    power = 3 * math.floor(math.log10(shown) / 3)
    return Scale(
        scale.factor * 10.0**-power, f"10{str(power).translate(_RAISED)} {scale.unit}".strip()
    )


def effort_word(unit: str, unit_of_slip: str) -> str:
    """Torque, force, stress or pressure, where the units of effort and slip tell."""
    if (unit, unit_of_slip) == ("Pa", "m^3/s"):
        return "pressure"
    return {"N*m": "torque", "N": "force", "Pa": "stress"}.get(unit, "effort")
