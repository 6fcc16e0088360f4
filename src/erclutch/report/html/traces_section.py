"""This section shows measured against estimated rows, in as much detail as fits, with zoom, cursor and residual."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from erclutch.report.html.packed_rows import BUDGET, Packer
from erclutch.report.html.section import Section
from erclutch.report.numbers.correlation import noise_of
from erclutch.report.numbers.number_text import Scale, brief, count, number
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Panel
from erclutch.report.plots.trace_plot import describe_trace
from erclutch.signals.array import Array
from erclutch.signals.clock import stretches

#: Resolution of efforts, as a share of the recommended model's RMSE; of fields and slips, of their range; of each at
#: most this share of its noise, so that rounding is not seen as steps.
_FINE, _RANGE, _NOISE = 1 / 20, 1 / 2000, 1 / 2
_BUCKETS = 3000
_KNOT = 64
_DRAWN = 1000  # rows on paper
_WIDE, _HIGH = 920, 105  # of a plot on paper, in the units of its drawing; of a panel with a share of 1


def _fill(material: Material) -> dict[str, Any]:
    """The interactive plot."""
    packer, inputs = _packed(material)
    models = [
        {
            "name": name,
            "title": material.titles[name],
            "role": material.shown.get(name, ""),
            "detail": _detail(packer, material, name),
        }
        for name in material.run.names
        if f"estimate:{name}" in packer.channels
    ]
    data, windows = material.rows.data, material.windows
    drawn, drawn_rows = _on_paper(material)
    return {
        "data": {
            "rows": data.rows,
            "time": _clock(material),
            "breaks": [span.start for span in data.clock.spans][1:],
            "logs": [[name, a, b] for name, (a, b) in zip(data.sources, data.source_rows, strict=True)],
            "test": stretches(material.rows.test),
            "windows": {"typical": list(windows.typical), "worst": list(windows.worst)},
            "recommended": material.recommended,
            "models": models,
            "effort": {"name": material.word, "unit": brief(material.effort.unit), "factor": material.effort.factor},
            "inputs": inputs,
            "channels": {name: made.to_dict() for name, made in packer.channels.items()},
        },
        "detail": _said(packer, material, models),
        "step": material.effort.of(packer.channels["measured"].step, 2),
        "bucket": count(max(layer.bucket for c in packer.channels.values() for layer in c.layers)),
        "word": material.word,
        "drawn": drawn,
        "drawn_rows": drawn_rows,
    }


TRACES = Section("traces", "Measured against estimated", "Traces", _fill)


def _on_paper(material: Material) -> tuple[list[Panel], str]:
    """The same for paper, under one another over the whole width, and which rows these are."""
    first, stop = material.windows.lively
    time = material.rows.data.clock.time[first : min(stop, first + _DRAWN)]
    start, seconds = float(time[0]), float(time[-1] - time[0])
    panels = describe_trace(material, start=start, seconds=seconds, band=False).panels
    said = f"Held-out rows from {number(start, 4)} to {number(start + seconds, 4)} s, in which much happens."
    return [replace(panel, size=(_WIDE, round(_HIGH * panel.share))) for panel in panels], said


def _packed(material: Material) -> tuple[Packer, list[dict[str, Any]]]:
    """Channels with as many whole rows as fit: rows held out first, recommended before the others."""
    rows, data = material.rows, material.rows.data
    packer = Packer(data.rows, BUDGET)
    finite = [n for n in material.run.names if np.all(np.isfinite(rows.predicted[n]))]
    buckets = _BUCKETS if len(finite) <= 12 else _BUCKETS // 2
    rmse = material.run.entry(material.recommended)["test"]["rmse"][0] or float(np.std(data.effort))
    fine = _resolution(data.effort, _FINE * rmse)
    packer.add("measured", data.effort, fine, buckets)
    inputs = _inputs(material, packer, buckets)
    limit = 3.0 * float(np.abs(data.effort).max())
    for name in finite:
        estimate = np.clip(rows.predicted[name], -limit, limit)
        packer.add(f"estimate:{name}", estimate, fine, buckets)
        packer.add(f"residual:{name}", data.effort - estimate, fine, buckets)
    names = list(dict.fromkeys([*(n for n in material.shown if n in finite), *finite]))
    whole = (0, data.rows)
    held = stretches(rows.test)
    first = ["measured", *(f"estimate:{n}" for n in names[:1]), *(i["channel"] for i in inputs)]
    wanted = [(c, part) for c in first for part in held]
    wanted += [(f"estimate:{n}", part) for n in names[1:3] for part in held]
    wanted += [(c, whole) for c in first]
    wanted += [(f"estimate:{n}", part) for n in names[1:] for part in (*held, whole)]
    for channel, (start, stop) in wanted:
        packer.whole(channel, start, stop)
    return packer, inputs


def _resolution(values: Array, wanted: float) -> float:
    return min(wanted, _NOISE * noise_of(values) or wanted)


def _inputs(material: Material, packer: Packer, buckets: int) -> list[dict[str, Any]]:
    """Fields and slips as channels; those of a pair in two plots."""
    made: list[dict[str, Any]] = []
    kinds: tuple[tuple[str, Scale], ...] = (("field", material.field), ("slip", material.slip))
    for kind, scale in kinds:
        for i, element in enumerate(material.rows.data.elements):
            values = element.field if kind == "field" else element.slip
            packer.add(f"{kind}{i}", values, _resolution(values, _RANGE * (float(np.ptp(values)) or 1.0)), buckets)
            label = f"{kind} {material.element_name(i)}".strip()
            made.append(
                {
                    "channel": f"{kind}{i}",
                    "kind": kind,
                    "label": label,
                    "unit": brief(scale.unit),
                    "factor": scale.factor,
                }
            )
    return made


def _detail(packer: Packer, material: Material, model: str) -> str:
    name = f"estimate:{model}"
    if packer.has(name, 0, material.rows.data.rows):
        return "all"
    return "test" if all(packer.has(name, a, b) for a, b in stretches(material.rows.test)) else "coarse"


def _said(packer: Packer, material: Material, models: list[dict[str, Any]]) -> str:
    """Which rows are whole, in a sentence."""
    by = {kind: [m["title"] for m in models if m["detail"] == kind] for kind in ("all", "test", "coarse")}
    rows = material.rows.data.rows
    if packer.has("measured", 0, rows) and not by["test"] and not by["coarse"]:
        return f"Each of the {count(rows)} rows is in this page."
    parts = ["No row is in this page by itself"]
    if packer.has("measured", 0, rows):
        parts = ["Each measured row is in this page"]
    elif by["test"] or by["all"]:
        parts = ["Of the measured rows each one held out is in this page"]
    if by["all"]:
        parts.append(f"each row of {_named(by['all'])}")
    if by["test"]:
        parts.append(f"each row held out of {_named(by['test'])}")
    return ", ".join(parts) + "; the rest is"


def _named(names: list[str]) -> str:
    if len(names) > 4:
        return f"{len(names)} models"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _clock(material: Material) -> list[list[float]]:
    """Knots [row, s] between which time is a straight line; logs follow one another with a second between."""
    data = material.rows.data
    knots: list[list[float]] = []
    shift, last = 0.0, None
    starts = {a for a, _ in data.source_rows}
    for span in data.clock.spans:
        time = data.clock.time[span.start : span.stop]
        if span.start in starts and last is not None:
            shift = last + 1.0 - float(time[0])
        at = (
            np.array([0, time.size - 1])
            if span.period is not None
            else np.unique([*range(0, time.size, _KNOT), time.size - 1])
        )
        knots += [[int(span.start + k), round(float(time[k]) + shift, 7)] for k in at]
        last = float(time[-1]) + shift
    return knots
