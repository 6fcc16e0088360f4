"""Lines above the rows may state how many samples were taken in how long a time: both make the time from row to row."""

from __future__ import annotations

import re
from collections.abc import Mapping

from erclutch.errors import UnitError
from erclutch.logs.columns.labels import split_label
from erclutch.signals import units

_COUNT = re.compile(
    r"(?:(?:number|no\.?|num|nr\.?|total|anzahl)[ _]*(?:of|der)?[ _]*)?(?:data[ _]*)?"
    r"(?:samples|points|rows|records|scans|readings|messwerte|werte|abtastwerte)(?:[ _]*(?:count|number))?"
    r"|sample[ _]*count|count|n",
    re.IGNORECASE,
)
_DURATION = re.compile(
    r"(?:(?:test|total|log|logging|recording|record|measurement|measuring|acquisition|sampling|elapsed)[ _]*)?"
    r"(?:duration|time|length)|messdauer|messzeit|dauer|dur[eé]e|duraci[oó]n|durata",
    re.IGNORECASE,
)
#: ``Acquisition: 2000 points in 10 s``.
_COUNT_IN_A_TIME = re.compile(
    r"(\d{1,9}) ?(?:samples|points|rows|records|scans|readings|werte)? in (\d{1,9}(?:\.\d{1,9})?) ?(s|sec|min|ms)"
)
_NEARLY_WHOLE = 1e-6  # Hz


def period_of_a_count(pairs: Mapping[str, str], rows: int) -> tuple[float, str] | None:
    """The sampling period in s of rows whose count and duration stand above them, and the two keys; else None.

    Args:
        pairs: keys and values above the rows.
        rows: how many there are, which the count must be.
    """
    counts = [
        key
        for key, value in pairs.items()
        if _COUNT.fullmatch(key.strip()) and value.strip() == str(rows)
    ]
    durations: dict[str, float] = {}  # s
    for key, value in pairs.items():
        name, unit_of_key = split_label(key)
        if not _DURATION.fullmatch(name.strip()):
            continue
        try:
            number, unit_of_value = units.quantity(value.strip())
            unit = units.parse(unit_of_value or unit_of_key or "")
        except UnitError:
            continue
        if unit.dimension == units.parse("s").dimension and number > 0.0:
            durations[key] = number * unit.factor
    for key, value in pairs.items():
        both = _COUNT_IN_A_TIME.fullmatch(value.strip())
        if both and both[1] == str(rows):
            return float(both[2]) * units.parse(both[3]).factor / rows, key
    if len(counts) != 1 or len(durations) != 1 or rows < 3:
        return None
    ((key, duration),) = durations.items()
    # From the first to the last row there is one step less than there are rows; a rate tells which is meant.
    steps = rows
    for count in (rows, rows - 1):
        rate = count / duration
        if abs(rate - round(rate)) < _NEARLY_WHOLE:
            steps = count
            break
    return duration / steps, f"{counts[0]}' and '{key}"
