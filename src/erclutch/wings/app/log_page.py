"""What the page of a log shows of its columns: which signal each is, why, its range and its course."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from erclutch.logs.labels import own_unit
from erclutch.wings.app import actions


def signals_of(found: Mapping[str, Any], chosen: actions.Chosen) -> list[dict[str, Any]]:
    """For each signal of the device: its column, unit and sign as the log is read now, and what was given."""
    taken: Mapping[str, Any] = found["choices"]
    rows: list[dict[str, Any]] = []
    for signal in actions.ASKED[chosen.device]:
        about: dict[str, Any] = taken.get(signal) or {}
        column, unit = str(about.get("column", "")), str(about.get("unit") or "")
        turned = float(about.get("scale", 1.0)) < 0
        was = actions.label(column, unit, turned)
        given = chosen.columns.get(signal, "")
        row = {"name": signal, "meaning": actions.MEANING[signal], "column": column, "unit": unit, "turned": turned}
        why, check = _why(about) if about else ("", False)
        values = found["columns"].get(column, {})
        row |= {"was": was, "given": given, "why": why, "check": check}
        rows.append(
            {**row, "range": _range(values, unit, turned), "sketch": polyline(values.get("sketch", []), turned)}
        )
    return rows


def _why(about: Mapping[str, Any]) -> tuple[str, bool]:
    """Who chose the column of a signal, and whether somebody should look at that again."""
    unit, own, source = about["unit"] or "", about["file_unit"] or "", str(about["source"])
    if own and unit != own:
        # A speed of turns in 1/min is in turn/min, whatever the file leaves unsaid.
        certain = own_unit(str(about.get("column", "")), own, ("rad/s",)) == unit
        said = f"{'chosen' if source == 'given' else source}; the file says {own}"
        return (said, False) if certain else (f"{said}: check", True)
    if source == "guessed from its unit":
        return f"guessed from the unit {unit} alone: check", True
    if not unit and source != "given":
        return f"{source}; the file has no unit: check", True
    return ("chosen" if source == "given" else source), False


def _range(values: Mapping[str, Any], unit: str, turned: bool) -> str:
    """Smallest and largest value of a column as it is read, with its unit."""
    if not values or values["min"] is None:
        return ""
    low, high = (-values["max"], -values["min"]) if turned else (values["min"], values["max"])
    return f"{low:.4g} to {high:.4g} {unit}".strip()


def polyline(sketch: list[list[float]], turned: bool = False) -> str:
    """Corners of a column's picture, 120 by 24: its smallest values along, and its largest back."""
    if not sketch:
        return ""
    sketch = [[-high, -low] for low, high in sketch] if turned else sketch
    low, high = min(pair[0] for pair in sketch), max(pair[1] for pair in sketch)
    across, up = 118 / max(len(sketch) - 1, 1), 20 / (high - low) if high > low else 0.0
    places = [(1 + i * across, pair) for i, pair in enumerate(sketch)]
    along = [f"{x:.1f},{22 - (pair[0] - low) * up:.1f}" for x, pair in places]
    back = [f"{x:.1f},{21.2 - (pair[1] - low) * up:.1f}" for x, pair in reversed(places)]
    return " ".join(along + back)
