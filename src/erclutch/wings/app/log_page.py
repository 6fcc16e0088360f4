"""What the page of a log shows of its columns: which signal each is, why, its range and its course."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from erclutch.logs.columns.labels import own_unit
from erclutch.report.numbers.number_text import number
from erclutch.wings.app import actions


def signals_of(found: Mapping[str, Any], chosen: actions.Chosen) -> list[dict[str, Any]]:
    """For each signal of the device: its column, unit and sign as the log is read now, and what was given."""
    taken: Mapping[str, Any] = found["choices"]
    rows: list[dict[str, Any]] = []
    for signal in actions.ASKED[chosen.device]:
        about: dict[str, Any] = taken.get(signal) or {}
        column = str(about.get("column", ""))
        unit = str(about.get("unit") or "")
        turned = float(about.get("scale", 1.0)) < 0
        values = found["columns"].get(column, {})
        # Who chose the column of the signal, and whether somebody should look at that again.
        why = ""
        check = False
        if about:
            source = str(about["source"])
            unit_of_file = about["file_unit"] or ""
            why = "chosen" if source == "given" else source
            if unit_of_file and unit != unit_of_file:
                why += f"; the file says {unit_of_file}"
                # A speed of turns in 1/min is in turn/min, whatever the file leaves unsaid.
                check = own_unit(column, unit_of_file, ("rad/s",)) != unit
            elif source == "guessed from its unit":
                why = f"guessed from the unit {unit} alone"
                check = True
            elif not unit and source != "given":
                why = f"{source}; the file has no unit"
                check = True
            if check:
                why += ": check"
        without = "not logged"  # what stands in place of a column
        if signal == "time" and not column:
            # What the time is taken from where no column of numbers is it: dates, a rate, the row number.
            notes: Sequence[str] = found.get("reading", ())
            of_time = [note.removeprefix("time ") for note in notes if note.startswith("time ")]
            if of_time:
                without = of_time[0].removeprefix("<- ") or without
        extent = ""  # smallest and largest value of the column as it is read, with its unit
        if values and values["min"] is not None:
            low = -values["max"] if turned else values["min"]
            high = -values["min"] if turned else values["max"]
            extent = f"{number(low, 4)} to {number(high, 4)} {unit}".strip()
        rows.append(
            {
                "name": signal,
                "meaning": actions.MEANING[signal],
                "column": column,
                "without": without,
                "unit": unit,
                "turned": turned,
                "was": actions.label(column, unit, turned),
                "given": chosen.columns.get(signal, ""),
                "why": why,
                "check": check,
                "range": extent,
                "sketch": polyline(values.get("sketch", []), turned),
            }
        )
    return rows


def polyline(sketch: list[list[float]], turned: bool = False) -> str:
    """Corners of a column's picture, 120 by 24: its smallest values along, and its largest back."""
    if not sketch:
        return ""
    if turned:
        sketch = [[-high, -low] for low, high in sketch]
    lowest = min(low for low, _ in sketch)
    highest = max(high for _, high in sketch)
    across = 118 / max(len(sketch) - 1, 1)
    up = 20 / (highest - lowest) if highest > lowest else 0.0
    along: list[str] = []
    back: list[str] = []
    for place, (low, high) in enumerate(sketch):
        x = 1 + place * across
        along.append(f"{x:.1f},{22 - (low - lowest) * up:.1f}")
        # A little higher, so that a signal without noise is a line to be seen.
        back.append(f"{x:.1f},{21.2 - (high - lowest) * up:.1f}")
    return " ".join([*along, *reversed(back)])
