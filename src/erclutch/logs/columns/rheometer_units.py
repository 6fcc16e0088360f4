"""Units of shear rates, stresses and viscosities, also as instruments of rheology spell them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from erclutch.errors import UnitError, listed
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.rheometer_names import Quantity, Role, said_by_name
from erclutch.logs.table import Table
from erclutch.signals.units import is_known_unit, is_temperature, parse

SI: Mapping[Quantity, str] = {"rate": "1/s", "stress": "Pa", "viscosity": "Pa*s"}

#: A shear rate counts no events: 1 Hz of an oscillation is 2 pi rad/s of nothing sheared.
_NO_RATE = re.compile(r"hz|cps|rpm", re.IGNORECASE)
#: A second in Russian, whose letters look like Latin ones and are mixed with them.
_SECOND = "[cс](?:[eе][kк])?"
#: Spellings that mean nothing, or another unit, outside of rheology: a cP in small letters is a cup, a D a debye.
_SPELLED: Mapping[Role, Mapping[str, str]] = {
    "rate": {
        "1/s": r"/s(?:ec)?|s(?:ec)?\.?(?:\^|\*\*)?[({]*-1[)}]*|1/s(?:ec(?:onds?)?)?\.?|reciprocalsec(?:onds?)?|1/秒"
        rf"|1/{_SECOND}|{_SECOND}\^?-1",
        "1/min": r"/min|min\^?[({]*-1[)}]*|1/мин|мин\^?-1",
    },
    "stress": {
        "Pa": r"pa|pascals?|па",
        "kPa": r"kpa|кпа",
        "mPa": r"mpa|мпа",
        "dyn/cm^2": r"(?:d(?:yne?s?)?|дин)/(?:sq\.?cm|[cс][mм]\^?2)",
        "lbf/(100*ft^2)": r"lb[fs]?/100(?:ft\^?2|sqft|sq\.ft\.?)",
    },
    "viscosity": {
        "Pa*s": rf"pa[.*x-]?s(?:ec)?|па[.*]?{_SECOND}",
        "mPa*s": rf"mpa[.*x-]?s(?:ec)?|мпа[.*]?{_SECOND}",
        "cP": r"cps?|centipoises?|сп(?:з|уаз)?",
        "P": r"poises?|п(?:з|уаз)",
    },
}
_MARK = re.compile(r"\s*[(\[{<]\s*|\s*[,:;=|]\s*|\s+in\s+|\s+[-–—]\s+|[\s_./]+")
_BRACKETS = " ()[]{}<>"
#: In front of a unit; 1/s has none.
_NUMBER_IN_FRONT = re.compile(r"[\d.,+-]+(?!/)")
_IN_BRACKETS = re.compile(r"[(\[]([^()\[\]]+)[)\]]\s*$")
_LONGEST = 100  # letters of a name with a unit at its end


def in_plain_units(quantity: Role, unit: str) -> str:
    """A unit of a quantity as everybody writes it; as it is where no instrument spells that quantity's unit so."""
    bare = unit.replace("−", "-").replace("⁻", "-").replace("¹", "1").replace("²", "2")
    bare = re.sub(r"[·•⋅∙×]", ".", bare).replace(" ", "").lower()
    if unit.lstrip().startswith(("M", "М")):
        return unit  # a megapascal is no millipascal
    for plain, pattern in _SPELLED.get(quantity, {}).items():
        if re.fullmatch(pattern, bare):
            return plain
    return unit


def said_by_unit(unit: str | None) -> Role:
    """What a unit alone says: a rate, a stress, a viscosity, another quantity, or nothing."""
    if not unit:
        return "unknown"
    try:
        dimension = parse(unit).dimension
    except UnitError:
        return "unknown"
    for role, si in SI.items():
        if dimension == parse(si).dimension:
            counted = role == "rate" and _NO_RATE.search(unit)
            return "other" if counted else role
    return "other"


def units_above(table: Table, quantity: Quantity) -> list[str]:
    """Units of a quantity, other than the SI's, that stand in the lines above a table, beside other words."""
    lines = [*(f"{key} {text}" for key, text in table.metadata.items())]
    lines += [note for note in table.notes if note.startswith("text above the table")]
    spoken: list[str] = []
    for word in re.split(r"[\s,;:()\[\]'\"]+", " ".join(lines)):
        plain = in_plain_units(quantity, word)
        is_spelled = plain in _SPELLED[quantity] and (len(word) > 2 or word == "cP")
        if is_spelled and plain not in (SI[quantity], *spoken):
            spoken.append(plain)
    return spoken


def unit_of(table: Table, name: str) -> str | None:
    """The unit of a column in its file, or the end of its name (``Viscosity_cP``) where that measures a flow curve."""
    named = said_by_name(name)
    unit = table.units.get(name)
    at_the_end = _unit_at_the_end(name, named)
    # Of Viscosity, Pa.s a reader of labels may have seen the s alone.
    if unit and not (at_the_end and said_by_unit(unit) != named and at_the_end.endswith(unit)):
        return in_plain_units(named, unit)
    if named == "unknown":  # the whole name may be a unit: cP, D/cm2
        for quantity in SI:
            plain = in_plain_units(quantity, name)
            if plain in _SPELLED[quantity]:
                return plain
    if at_the_end:
        return at_the_end
    _, end = split_end(name)
    return end if end and said_by_unit(end) in SI else None


def _unit_at_the_end(name: str, named: Role) -> str | None:
    """The longest end of a name that is a unit of its quantity: ``mPa s`` of ``Viscosity - mPa s``; None for none."""
    if len(name) > _LONGEST:
        return None
    for mark in _MARK.finditer(name):
        end = name[mark.end() :].strip(_BRACKETS)
        # The 2 of Stress run 2 Pa tells this column from others; in brackets a number is a part of the unit.
        if _NUMBER_IN_FRONT.match(end) and not mark[0].strip().startswith(tuple("([{<")):
            continue
        # The slash of Shear rate, /s is of the unit.
        ends = [f"/{end}", end] if mark[0].endswith("/") and mark[0] != "/" else [end]
        for each in ends:
            plain = in_plain_units(named, each)
            measured = said_by_unit(plain)
            if measured == named != "unknown" or (named == "unknown" and measured == "rate"):
                return plain  # rate_1/s
    return None


def unit_or_end(table: Table, name: str) -> str | None:
    """The unit of a column of any quantity: as the file gives it, or the end of its name (``T_K``, ``T (K)``)."""
    if table.units.get(name):
        return table.units[name]
    _, _, end = name.rpartition("_")
    if end != name and is_known_unit(end):
        return end
    in_brackets = _IN_BRACKETS.search(name)
    return in_brackets[1] if in_brackets and is_temperature(in_brackets[1]) else None


def without_a_unit(viscosities: Sequence[str]) -> str:
    """What is asked about viscosities without a unit, which no reader can guess."""
    columns = f"the column {viscosities[0]!r} has"
    if len(viscosities) > 1:
        columns = f"the columns {listed(viscosities, 6)} have"
    return f"{columns} no unit: viscosities are written in Pa s, and as often in mPa s or cP"
