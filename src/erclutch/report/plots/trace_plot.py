"""This plot shows measured and estimated effort over a section of the log, the residual and the command under it."""

from __future__ import annotations

import numpy as np

from erclutch.errors import SettingError
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Axis, Line, Mark, Panel, Plot, PlotTable, ReferenceLine, Shade


def describe_trace(
    material: Material, *, start: float | None = None, seconds: float | None = None, band: bool = True
) -> Plot:
    """A section: by default that of the rows held out in which most happens (`Windows.lively`).

    Args:
        material: the run.
        start: first second, on the log's own clock.
        seconds: length; None: to the section's usual length.
        band: whether the recommended model's prediction band is drawn.

    Raises:
        SettingError: no row lies there.
    """
    at = _rows(material, start, seconds)
    rows, effort, field = material.rows, material.effort, material.field
    data, time = rows.data, rows.data.clock.time[at]
    models = {n: role for n, role in reversed(material.shown.items()) if role != "best"} or material.shown
    measured = Line(time, data.effort[at] * effort.factor, "measured", "measured")
    estimates = [
        Line(time, rows.predicted[n][at] * effort.factor, role, material.titles[n]) for n, role in models.items()
    ]
    residuals = [Line(time, rows.residual(n)[at] * effort.factor, role) for n, role in models.items()]
    commands = [
        Line(time, e.field[at] * field.factor, style, material.element_name(i), dashed=i > 0)
        for i, (e, style) in enumerate(zip(data.elements, ("series0", "series6"), strict=False))
    ]
    ends = material.band_ends if band else None
    shade: list[Mark] = []
    if ends is not None:
        shade.append(Shade(ends[0][at] * effort.factor, ends[1][at] * effort.factor, x=time))
    x = Axis("time", "s", float(time[0]), float(time[-1]))
    word = material.word
    return Plot(
        [
            Panel(
                x, Axis(word, effort.unit), [*shade, measured, *estimates], f"Measured and estimated {word}.", share=2.2
            ),
            Panel(x, Axis("residual", effort.unit), [ReferenceLine(0.0), *residuals], "Measured less estimated."),
            Panel(x, Axis("field", field.unit), commands, "The command.", share=1.2),
        ],
        _table(material, at),
        3.3,
        badge=material.print_badge,
        legend="above",
    )


def _table(material: Material, at: slice) -> PlotTable:
    """All models of the run, not only those that are drawn."""
    data = material.rows.data
    names = [material.element_name(i) for i in range(len(data.elements))]
    columns = {"time": data.clock.time}
    columns |= {f"field {n}".strip(): e.field for n, e in zip(names, data.elements, strict=True)}
    columns |= {f"slip {n}".strip(): e.slip for n, e in zip(names, data.elements, strict=True)}
    columns |= {"effort": data.effort, **{f"effort:{n}": material.rows.predicted[n] for n in material.run.names}}
    return PlotTable(list(columns), np.column_stack([c[at] for c in columns.values()]).tolist())


def _rows(material: Material, start: float | None, seconds: float | None) -> slice:
    if start is None and seconds is None:
        return slice(*material.windows.lively)
    time = material.rows.data.clock.time
    usual = material.windows.lively
    first = float(time[usual[0]]) if start is None else start
    length = (usual[1] - usual[0]) * material.period if seconds is None else seconds
    if not length > 0.0:
        raise SettingError(f"a section of {length:g} s", remedy="Give --seconds above 0")
    # The first log's rows where several have such times: time restarts with each.
    inside = np.flatnonzero((time >= first) & (time <= first + length))
    if inside.size < 2:
        raise SettingError(
            f"no rows from {first:g} s to {first + length:g} s",
            where=str(material.run.folder),
            remedy=f"The log reaches from {time.min():g} to {time.max():g} s",
        )
    breaks = np.flatnonzero(np.diff(inside) > 1)
    last = inside[breaks[0]] if breaks.size else inside[-1]
    return slice(int(inside[0]), int(last) + 1)
