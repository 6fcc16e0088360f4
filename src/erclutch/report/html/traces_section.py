"""This section shows measured against estimated rows, in as much detail as fits, with zoom, cursor and residual."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np

from erclutch.report.html.packed_rows import BUDGET, Packer
from erclutch.report.html.section import Section
from erclutch.report.numbers.number_text import Scale, brief, count, number
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.trace_plot import describe_trace
from erclutch.signals.array import Array, largest_size, noise_of
from erclutch.signals.clock import stretches

_FINE = 1 / 20  # resolution of efforts, as a share of the recommended model's RMSE
_RANGE = 1 / 2000  # resolution of fields and slips, as a share of their range
# Largest resolution as a share of a signal's noise, so that rounding is not seen as steps.
_NOISE = 1 / 2
_BUCKETS = 3000  # of a coarse layer; half of them where there are many models
_MANY = 12  # models
_KNOT = 64  # rows between two knots of an uneven clock
_DRAWN = 1000  # rows on paper
_WIDE = 920  # width of a plot on paper, in the units of its drawing
#: Stretches of rows held out that are packed each on its own; points all over a table are thousands.
_MOST_STRETCHES = 64
_HIGH = 105  # height of a panel with a share of 1, in the same units


def _fill(material: Material) -> dict[str, Any]:
    """The interactive plot."""
    packer, inputs = _packed(material)
    models: list[dict[str, Any]] = []
    data = material.rows.data
    to_pack = _held_out(material)
    for name in material.run.names:
        channel = f"estimate:{name}"
        if channel not in packer.channels:
            continue
        detail = "coarse"  # how many of its rows are whole
        if packer.has(channel, 0, data.rows):
            detail = "all"
        elif all(packer.has(channel, start, stop) for start, stop in to_pack):
            detail = "test"
        role = material.shown.get(name, "")
        models.append(
            {"name": name, "title": material.titles[name], "role": role, "detail": detail}
        )
    logs: list[list[Any]] = []  # name, first row, and the row behind the last one
    for log, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        logs.append([log, start, stop])
    windows = material.windows

    # For paper: traces under one another over the whole width, and which rows these are.
    first, stop = windows.lively
    time = data.clock.time[first : min(stop, first + _DRAWN)]
    begin = float(time[0])
    since_start = begin - material.clock_start(first)  # of the log, where its clock is an epoch
    seconds = float(time[-1] - time[0])
    panels = describe_trace(material, start=begin, seconds=seconds, band=False).panels
    drawn = [replace(panel, size=(_WIDE, round(_HIGH * panel.share))) for panel in panels]
    ends = f"{number(since_start, 4)} to {number(since_start + seconds, 4)} s"
    start_of_log = material.clock_start(0)
    layers = [layer for channel in packer.channels.values() for layer in channel.layers]
    coarsest = max(layer.bucket for layer in layers)  # rows that a value stands for
    return {
        "data": {
            "rows": data.rows,
            "time": _clock(material),
            "breaks": [span.start for span in data.clock.spans][1:],
            "logs": logs,
            "test": stretches(material.rows.test),
            "windows": {"typical": list(windows.typical), "worst": list(windows.worst)},
            "recommended": material.recommended,
            "models": models,
            "effort": {
                "name": material.word,
                "unit": brief(material.effort.unit),
                "factor": material.effort.factor,
            },
            "inputs": inputs,
            "channels": {name: made.to_dict() for name, made in packer.channels.items()},
        },
        "counted_from": f"{start_of_log:.2f} s" if start_of_log else "",
        "detail": _said(packer, material, models),
        "step": material.effort.of(packer.channels["measured"].step, 2),
        "bucket": count(coarsest),
        "word": material.word,
        "drawn": drawn,
        "drawn_rows": f"Held-out rows from {ends}, in which much happens.",
    }


TRACES = Section("traces", "Measured against estimated", "Traces", _fill)


def _packed(material: Material) -> tuple[Packer, list[dict[str, Any]]]:
    """Channels with as many whole rows as fit: rows held out first, recommended before the others."""
    rows = material.rows
    data = rows.data
    packer = Packer(data.rows, BUDGET)
    finite: list[str] = []  # models
    for name in material.run.names:
        if np.all(np.isfinite(rows.predicted[name])):
            finite.append(name)

    # All of each signal, coarse.
    buckets = _BUCKETS if len(finite) <= _MANY else _BUCKETS // 2
    rmse, *_ = material.run.entry(material.recommended)["test"]["rmse"]
    size_of_error = rmse or float(np.std(data.effort))
    fine = _resolution(data.effort, _FINE * size_of_error)
    packer.add("measured", data.effort, fine, buckets)
    inputs: list[dict[str, Any]] = []  # fields and slips; those of a pair in two plots
    kinds: dict[str, Scale] = {"field": material.field, "slip": material.slip}
    if material.without_field:
        del kinds["field"]
    for kind, scale in kinds.items():
        for place, element in enumerate(data.elements):
            channel = f"{kind}{place}"
            values = element.field if kind == "field" else element.slip
            reach = float(np.ptp(values)) or 1.0
            packer.add(channel, values, _resolution(values, _RANGE * reach), buckets)
            label = f"{kind} {material.element_name(place)}".strip()
            shown_as = {"label": label, "unit": brief(scale.unit), "factor": scale.factor}
            inputs.append({"channel": channel, "kind": kind, **shown_as})
    limit = 3.0 * largest_size(data.effort)  # a model that runs away shall not take the resolution
    for name in finite:
        estimate = np.clip(rows.predicted[name], -limit, limit)
        packer.add(f"estimate:{name}", estimate, fine, buckets)
        packer.add(f"residual:{name}", data.effort - estimate, fine, buckets)

    # Whole rows, the most wanted first.
    shown = [name for name in material.shown if name in finite]
    estimates = [f"estimate:{name}" for name in dict.fromkeys([*shown, *finite])]
    main = ["measured", *estimates[:1], *(signal["channel"] for signal in inputs)]
    others = estimates[1:]
    whole = [(0, data.rows)]
    held = _held_out(material)
    wanted = [
        *itertools.product(main, held),
        *itertools.product(others[:2], held),
        *itertools.product(main, whole),
        *itertools.product(others, [*held, *whole]),
    ]
    for channel, (start, stop) in wanted:
        packer.whole(channel, start, stop)
    return packer, inputs


def _held_out(material: Material) -> list[tuple[int, int]]:
    """The stretches of rows held out, each packed on its own; of very many as many blocks that hold all rows."""
    test = material.rows.test
    held = stretches(test)
    if len(held) <= _MOST_STRETCHES:
        return held
    edges = np.linspace(0, test.size, _MOST_STRETCHES + 1).round().astype(int).tolist()
    return list(itertools.pairwise(edges))


def _resolution(values: Array, wanted: float) -> float:
    return min(wanted, _NOISE * noise_of(values) or wanted)


def _said(packer: Packer, material: Material, models: list[dict[str, Any]]) -> str:
    """Which rows are whole, in a sentence."""
    whole = [model["title"] for model in models if model["detail"] == "all"]
    held_out = [model["title"] for model in models if model["detail"] == "test"]
    rows = material.rows.data.rows
    all_measured = packer.has("measured", 0, rows)
    if all_measured and len(whole) == len(models):
        whole_page = f"Each of the {count(rows)} rows is in this page."
        if material.rows.data.in_no_time:
            return f"The points stand in the order of the file, a second apart: no time passes. {whole_page}"
        return whole_page
    if all_measured:
        parts = ["Each measured row is in this page"]
    elif whole or held_out:
        parts = ["Of the measured rows each one held out is in this page"]
    else:
        parts = ["No row is in this page by itself"]
    if whole:
        parts.append(f"each row of {_named(whole)}")
    if held_out:
        parts.append(f"each row held out of {_named(held_out)}")
    return ", ".join(parts) + "; the rest is"


def _named(names: list[str]) -> str:
    if len(names) > 4:
        return f"{len(names)} models"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _clock(material: Material) -> list[list[float]]:
    """Knots [row, s] between which time is a straight line; logs follow one another with a second between.

    An epoch is counted from the first log's start: ten digits beside each other could not be read.
    """
    data = material.rows.data
    knots: list[list[float]] = []
    first_rows = {start for start, _ in data.source_rows}
    shift = -material.clock_start(0)
    last: float | None = None  # shown time of the row before
    for span in data.clock.spans:
        time = data.clock.time[span.start : span.stop]
        if span.start in first_rows and last is not None:
            shift = last + 1.0 - float(time[0])
        end = time.size - 1
        places = [0, end]
        if span.period is None:
            places = np.unique([*range(0, time.size, _KNOT), end]).tolist()
        for place in places:
            shown = float(time[place]) + shift
            knots.append([span.start + place, round(shown, 7)])
        last = float(time[-1]) + shift
    return knots
