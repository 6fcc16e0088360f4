"""Units are read as engineers write them, over pint (imported for the first unit that is not a common one).

Angle is kept apart from plain numbers: ``rad/s``, ``rpm`` and ``1/s`` are three things, although pint calls the radian
dimensionless. ``Hz`` and ``1/min`` are refused for a speed, because half of the world means turns by them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, cast

import numpy as np

from erclutch.errors import UnitError, shell_word
from erclutch.signals.array import Array
from erclutch.signals.recording import SignalKind
from erclutch.signals.unit_spellings import RAISED, SPELLINGS

UNKNOWN = "?"
#: What people are told of such a unit.
AS_LOGGED = "as logged"
_LONGEST, _LONGEST_QUANTITY = 60, 200  # letters of a unit, and of a number with its unit
#: A unit of a length, a time, an angle or a speed in SI that is larger than this was meant otherwise: Mm for mm.
_LARGEST = 1e5
_LIMITED = (
    (("meter", 1.0),),
    (("second", 1.0),),
    (("radian", 1.0),),
    (("meter", 1.0), ("second", -1.0)),
    (("radian", 1.0), ("second", -1.0)),
)
#: A degree to half of the world, and the hundredth of a right angle to pint.
_DEGREE_OR_GON = re.compile(r"\s*(?:grad|[Gg]rades?)(?P<over>(?!\w).*)", re.DOTALL)
_NO_DIMENSION = {"", "-", "1", "[-]", "(-)", "none", "dimensionless"}
#: A power of ten before or behind a unit, as heads of tables have it: ``×10³ Pa``, ``Pa x 10^3``.
_TENS = re.compile(
    r"[×x*·]?\s*10\s*(?P<before>(?:\^|\*\*)[+-]?\d|-\d|[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹])\s*[×*·]?\s*(?P<unit>(?:1/)?[^\W\d_].*)"
    r"|(?P<of>[^\W\d_].*?)\s*[×x*·]\s*10\s*(?P<behind>(?:\^|\*\*)[+-]?\d|-\d|[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹])"
)
#: No tenth of a unit: a d is a difference.
_DIFFERENCE = re.compile(r"\s*d(?:rpm|V|A|T|s|rad|deg|W|Hz|°)(?!\w).*")
# A number over a unit is 1 or counts in tens, as 1/s and 1000/min do: 2/s is a unit that nobody writes.
_ODD_COUNT = re.compile(r"(?!10*/)[\d.]+/")
_FORM = re.compile(r"[\w\s.+*/()^%°µμΩ²³⁻¹-]*")
_POWER = re.compile(r"(?:\^|\*\*)\s*\(?\s*[+-]?\d(?:\.\d)?(?![\d.eE])\s*\)?(?!\s*(?:\^|\*\*))")
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
_RATE = (("second", -1.0),)
_PER_MINUTE = 1.0 / 60.0
# RPM/1000 is a thousandth of a turn a minute by its form, and thousands of turns by what most people mean.
_OVER_A_NUMBER = re.compile(r"\(?(?P<unit>.*[^\W\d]\)?)\s*/\s*(?P<number>[1-9]\d*(?:\.\d+)?)\s*\)?")

# A product of a few numbers and symbols with small powers; two signs never stand side by side.
_FACTOR = r"\(?(?:\d{1,9}(?:\.\d{1,9})?|[^\W\d_]+|[%°][^\W\d_]*)(?:\^?-?\d|[²³])?\)?"
_PRODUCT = re.compile(rf"{_FACTOR}(?:[*/ ·]{_FACTOR}){{0,5}}")

#: As logs write what is told in SI units.
_USUAL = {"rad/s": "rpm", "m/s": "cm/s", "rad": "deg", "m": "mm"}
#: Units of most logs with what pint says of them, factors by dimension, since pint takes half a second to load.
_FACTORS = {
    (("ampere", -1.0), ("gram", 1.0), ("meter", 2.0), ("second", -3.0)): {
        "V": 1e3,
        "kV": 1e6,
        "mV": 1.0,
    },
    (("ampere", -1.0), ("gram", 1.0), ("meter", 1.0), ("second", -3.0)): {"V/m": 1e3, "kV/mm": 1e9},
    (("ampere", 1.0),): {"A": 1.0, "mA": 1e-3},
    (("ampere", 1.0), ("meter", -1.0)): {"A/m": 1.0},
    (("ampere", -1.0), ("gram", 1.0), ("second", -2.0)): {"T": 1e3},
    (("radian", 1.0),): {"rad": 1.0, "deg": math.pi / 180.0, "°": math.pi / 180.0},
    (("radian", 1.0), ("second", -1.0)): {
        "rad/s": 1.0,
        "deg/s": math.pi / 180.0,
        "rpm": 2.0 * math.pi / 60.0,
        "turn/min": 2.0 * math.pi / 60.0,
        "rev/min": 2.0 * math.pi / 60.0,
        "r/min": 2.0 * math.pi / 60.0,
        "U/min": 2.0 * math.pi / 60.0,
    },
    (("meter", 1.0),): {"m": 1.0, "mm": 1e-3, "cm": 1e-2},
    (("meter", 1.0), ("second", -1.0)): {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2},
    (("gram", 1.0), ("meter", 1.0), ("second", -2.0)): {"N": 1e3, "kN": 1e6},
    (("gram", 1.0), ("meter", 2.0), ("second", -2.0)): {"N*m": 1e3, "N m": 1e3, "Nm": 1e3},
    (("gram", 1.0), ("meter", -1.0), ("second", -2.0)): {"Pa": 1e3, "kPa": 1e6, "MPa": 1e9},
    (("second", -1.0),): {"1/s": 1.0, "Hz": 1.0, "1/min": 1.0 / 60.0},
    (("second", 1.0),): {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0},
    (("meter", 1.0), ("second", -2.0)): {"m/s^2": 1.0},
    (("meter", 3.0), ("second", -1.0)): {"m^3/s": 1.0},
}
#: Unit -> factor and dimension.
COMMON = {
    unit: (factor, dimension)
    for dimension, units in _FACTORS.items()
    for unit, factor in units.items()
}
#: Temperatures of a fluid lie between these, in K; a broken sensor's do not.
LEAST_KELVIN = 150.0
MOST_KELVIN = 800.0
_CELSIUS = {"°C", "degC", "deg C", "C", "celsius", "Celsius", "℃"}
_FAHRENHEIT = {"°F", "degF", "deg F", "fahrenheit", "Fahrenheit", "℉"}
_KELVIN = {"K", "kelvin", "Kelvin"}


@dataclass(frozen=True)
class Unit:
    """A unit as a factor to SI base units.

    Attributes:
        text: the unit as written.
        factor: one of this unit in SI base units (radians for angles).
        dimension: sorted (base unit, exponent) pairs; ("radian", 1) marks an angle.
    """

    text: str
    factor: float
    dimension: tuple[tuple[str, float], ...]


def amount(numbers: str, unit: str) -> str:
    """Numbers with their unit behind, in a sentence; alone where they have none or nobody knows it."""
    return numbers if unit in ("", UNKNOWN) else f"{numbers} {unit}"


@lru_cache(maxsize=1)
def _registry() -> Any:
    """What pint knows; to load it takes half a second."""
    import pint

    return cast(Any, pint.UnitRegistry())


@lru_cache(maxsize=512)
def parse(text: str) -> Unit:
    """Read one unit, such as ``cm/s``, ``N m``, ``rpm``, ``980.665 N`` or ``-``.

    Raises:
        UnitError: the text is no unit, or one with an offset or a logarithm (degC, dB), or counts (bit, count).
    """
    if text.strip() in _NO_DIMENSION:
        return Unit(text, 1.0, ())
    if text in COMMON:
        return Unit(text, *COMMON[text])
    remedy = "Write it like cm/s, m/s^2, kN, N*m, rpm, kV/mm, % or - (a factor may stand before it: 980.665 N)"
    if len(text) > _LONGEST:  # the patterns below take the square of its length
        long = f"'{text[:_LONGEST]}...' has {len(text)} letters, a unit at most {_LONGEST}"
        raise UnitError(long, remedy=remedy)
    if _DEGREE_OR_GON.fullmatch(text):
        remedy = f"Say which: {in_other_words(text)}, or gon in place of deg"
        raise UnitError(f"'{text}' may count in degrees or in gons", remedy=remedy)
    divided = _OVER_A_NUMBER.fullmatch(text)
    if divided and is_unit(divided["unit"]):
        unit, number = divided["unit"].strip(), divided["number"]
        problem = f"'{text}' may be a part of {unit}, or {unit} that were divided"
        raise UnitError(problem, remedy=f"Say which: 1/{number} {unit}, or {number} {unit}")
    spelled = text.strip()
    tens = _TENS.fullmatch(spelled) if "10" in text else None
    if tens:
        power = (tens["before"] or tens["behind"]).translate(RAISED).lstrip("^*")
        # An e would be a charge to pint.
        times = f"{10.0 ** int(power):.9f}".rstrip("0").rstrip(".")
        spelled = f"{times} {tens['unit'] or tens['of']}"
    for pattern, replacement in SPELLINGS:
        spelled = pattern.sub(replacement, spelled)
    # pint evaluates arithmetic: a chain of powers would keep it busy for ever, so only small single powers pass.
    chained = re.search(r"\^|\*\*", _POWER.sub("", spelled))
    has_form = (
        _FORM.fullmatch(spelled)
        and not _DIFFERENCE.fullmatch(spelled)
        and not _ODD_COUNT.match(spelled)
    )
    of_temperature = text in _KELVIN | _CELSIUS - {"C"}  # pint would take a second to refuse it
    if has_form and not of_temperature and not chained:
        # In short units capitals tell one from another: mm and Mm, s and S.
        attempts = [spelled]
        if len(text.strip()) > 2:
            attempts.append(spelled.lower())
        for attempt in attempts:
            unit = evaluated(text, attempt)
            if unit is None:
                continue
            if unit.dimension in _LIMITED and unit.factor > _LARGEST:
                break
            return unit
    raise UnitError(f"'{text}' is not a unit that erclutch knows", remedy=remedy)


def evaluated(text: str, spelled: str) -> Unit | None:
    """What pint makes of a unit; None where pint knows none, or none that a factor alone converts."""
    registry = _registry()
    try:
        one = registry.Quantity(registry.parse_expression(spelled))
        base = one.to_root_units()
        double = (2.0 * one).to_root_units()
        factor = float(base.magnitude)
        # An offset or a logarithm shows: twice the unit is not twice the number.
        linear = abs(float(double.magnitude) - 2.0 * factor) <= 1e-12 * abs(factor)
        powers = [(str(name), float(power)) for name, power in base.unit_items()]
        dimension = tuple(sorted(powers))
    # Pint, its tokenizer and its arithmetic raise a dozen unrelated types on odd text.
    except Exception:
        return None
    refused = any(name in {"kelvin", "bit", "count"} for name, _ in dimension)
    if not linear or refused or not 0.0 < factor < float("inf"):
        return None
    if not dimension and not re.search(r"%|percent|permille|ppm", spelled):
        return None  # a bare number such as 3, or a count: no unit
    return Unit(text, factor, dimension)


def in_other_words(text: str) -> str:
    """What a unit that is refused most likely is: degrees where gons might be meant; "UNIT" where nobody knows."""
    degrees = _DEGREE_OR_GON.fullmatch(text)
    return f"deg{degrees['over'].rstrip()}" if degrees else "UNIT"


def is_written_well(text: str) -> bool:
    """Whether the text has the form of a unit, known to erclutch or not: ``N*m``, ``m/s^2``, none or "?"."""
    if text in ("", "-", UNKNOWN):
        return True
    return len(text) <= _LONGEST and _PRODUCT.fullmatch(text) is not None


def is_temperature(unit: str | None) -> bool:
    """Whether a column's unit is °C, °F or K."""
    return unit in _CELSIUS or unit in _FAHRENHEIT or unit in _KELVIN


def to_kelvin(values: Array, unit: str | None, column: str) -> tuple[float, float]:
    """What takes temperatures of a column to K: the factor, and what is added then.

    Args:
        values: of the column, shape (n,); what is not finite is passed over.
        unit: of the column.
        column: its name, for messages.

    Raises:
        UnitError: no unit, another unit than °C, °F or K, or temperatures that no fluid of a device has.
    """
    if unit in _CELSIUS:
        factor, offset = 1.0, 273.15
    elif unit in _FAHRENHEIT:
        factor, offset = 1 / 1.8, 459.67 / 1.8
    elif unit in _KELVIN:
        factor, offset = 1.0, 0.0
    else:
        own = f"the unit '{unit}'" if unit else "no unit"
        raise UnitError(
            f"column '{column}' has {own}, and a temperature needs °C, °F or K",
            remedy=f"Give it as --temperature {shell_word(f'{column} [°C]')}, or [K]",
        )
    known = factor * values[np.isfinite(values)] + offset
    if known.size and (known.min() < LEAST_KELVIN or known.max() > MOST_KELVIN):
        raise UnitError(
            f"column '{column}' goes from {known.min():g} K to {known.max():g} K; a fluid's temperature is between "
            f"{LEAST_KELVIN:g} K and {MOST_KELVIN:g} K",
            remedy="Check the unit and the sensor, or leave --temperature out",
        )
    return factor, offset


def is_unit(text: str) -> bool:
    """Whether the text reads as a unit."""
    try:
        parse(text)
    except UnitError:
        return False
    return True


def is_over_a_number(text: str) -> bool:
    """Whether the text is a unit that a number divides, RPM/1000: nobody knows which way."""
    divided = _OVER_A_NUMBER.fullmatch(text)
    return divided is not None and is_unit(divided["unit"])


def is_known_unit(text: str) -> bool:
    """Whether the text reads as a unit, of a temperature too."""
    return is_unit(text) or is_temperature(text)


def is_per_minute(unit: str | None) -> bool:
    """Whether a unit is 1/min, in any spelling: min⁻¹, мин-1, 1/perc. It may count turns, without a word of them."""
    return _is_rate(unit, _PER_MINUTE)


def is_per_second(unit: str | None) -> bool:
    """Whether a unit is 1/s, in any spelling but Hz."""
    return _is_rate(unit, 1.0) and not _is_in_hertz(unit or "")


def _is_rate(unit: str | None, factor: float) -> bool:
    if not unit or not is_unit(unit):
        return False
    given = parse(unit)
    return given.dimension == _RATE and math.isclose(given.factor, factor)


def _is_in_hertz(unit: str) -> bool:
    return "z" in unit.lower()


def _may_count_turns(unit: str) -> bool:
    """Whether a rate may be one of turns or one of nothing: 1/min, Hz."""
    return is_per_minute(unit) or (parse(unit).dimension == _RATE and _is_in_hertz(unit))


def fits(unit: str, si_units: Iterable[str]) -> tuple[float, str] | None:
    """Factor and SI unit of the first of ``si_units`` with the same dimension, or None.

    A plain 1/s or number passes for rad/s or rad when nothing fits better; per cent, Hz and 1/min do not.

    Raises:
        UnitError: the unit cannot be read at all.
    """
    given = parse(unit)
    wanted = [parse(si) for si in si_units]
    for si in wanted:
        is_ambiguous = si.dimension == _RATE and _may_count_turns(unit)
        if given.dimension == si.dimension and not is_ambiguous:
            return given.factor / si.factor, si.text
    plain = given.factor == 1.0 and not _is_in_hertz(unit)  # no per cent
    for si in wanted:
        without_angle = tuple(power for power in si.dimension if power != ("radian", 1.0))
        if plain and given.dimension == without_angle != si.dimension:
            return 1.0, si.text
    return None


def conversion(unit: str, kind: SignalKind, column: str) -> tuple[float, str]:
    """Factor that takes a column's unit to the first fitting SI unit of a signal, and that unit.

    Raises:
        UnitError: the unit is unknown or of another kind; the message names column, unit, what fits and the remedy.
    """
    in_si = [si or "dimensionless" for si in kind.si_units]
    usual = [_USUAL[si] for si in kind.si_units if si in _USUAL]
    allowed = ", ".join([*in_si, *usual, "..."])
    examples = [shell_word(f"{column} [{_USUAL.get(si, si) or '-'}]") for si in kind.si_units[:2]]
    option = f"--{kind.name} {' or '.join(examples)}"
    problem = f"column '{column}' has the unit '{unit}', which"
    try:
        fitting = fits(unit, (*kind.si_units, *kind.if_named))
    except UnitError as error:
        remedy = f"Name one for {kind.name} ({allowed}), such as {option}"
        raise UnitError(f"{problem} erclutch does not know", remedy=remedy) from error
    if fitting is not None:
        return fitting
    if _may_count_turns(unit) and any("/s" in si for si in kind.si_units):
        remedy = f"Say which: --{kind.name} {shell_word(f'{column} [rpm]')}, [turn/s] or [1/s]"
        raise UnitError(f"{problem} may mean turns or plain 1/s", remedy=remedy)
    remedy = f"Choose another column or give its unit, such as {option}"
    raise UnitError(f"{problem} does not fit {kind.name} (allowed: {allowed})", remedy=remedy)


def quantity(text: str) -> tuple[float, str | None]:
    """Split ``0.5 A`` into 0.5 and ``A`` (None where no unit follows).

    Raises:
        UnitError: the text does not begin with a number.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST_QUANTITY else None
    if match is None:
        problem = f"'{text[:_LONGEST_QUANTITY]}' is not a number with a unit"
        raise UnitError(problem, remedy="Write it like 0.5 A")
    return float(match.group(1)), match.group(2) or None


def in_unit(text: str, unit: str) -> float:
    """A quantity such as ``2``, ``500 ms`` or ``-0.2 N*m`` as a number of a unit; a plain number has that unit.

    Raises:
        UnitError: no finite number, no unit, or a unit of something else.
    """
    number, own = quantity(text)
    factor = 1.0
    if own not in (None, unit):
        given = parse(own or "")
        wanted = parse(unit)
        fits_it = given.dimension == wanted.dimension
        factor = given.factor / wanted.factor if fits_it else math.inf
    converted = number * factor
    if not math.isfinite(converted):
        raise UnitError(
            f"'{text}' is no quantity in {unit or '1 or %'}",
            remedy=f"Write it like {f'2 {unit}'.strip()}",
        )
    return converted
