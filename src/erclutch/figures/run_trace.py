"""Measured and estimated effort over a section of the log, the residual and the command under it."""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.diagnostics.material import Material
from erclutch.errors import SettingError
from erclutch.figures.parts import Numbers, role_line, titled
from erclutch.figures.style import BLACK, BLUE, GREY


def draw_trace(figure: Any, material: Material, *, start: float | None = None, seconds: float | None = None) -> Numbers:
    """Draw a section: by default a typical one of the rows held out.

    Args:
        figure: to draw in.
        material: the run.
        start: first second, on the log's own clock.
        seconds: length; None: to the section's usual length.

    Raises:
        SettingError: no row lies there.
    """
    rows = _rows(material, start, seconds)
    data, time = material.rows.data, material.rows.data.clock.time[rows]
    axes: Any = figure.subplots(3, 1, sharex=True, height_ratios=[2.2, 1, 0.8])
    models = [s for s in material.shown if s.role != "best"] or list(material.shown)
    factor = material.effort.factor
    axes[0].plot(time, data.effort[rows] * factor, color=BLACK, label="measured")
    for shown in models:
        axes[0].plot(
            time, material.rows.predicted[shown.name][rows] * factor, label=shown.name, **role_line(shown.role)
        )
        axes[1].plot(time, material.rows.residual(shown.name)[rows] * factor, **role_line(shown.role))
    axes[1].axhline(0.0, color=GREY, linewidth=0.5)
    for i, element in enumerate(data.elements):
        label = material.element_name(i)
        line = {"color": BLUE} if i == 0 else {"color": BLACK, "linestyle": "--"}
        axes[2].plot(time, element.field[rows] * material.field.factor, label=label or None, **line)
    axes[0].legend(ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2, handlelength=1.6)
    if len(data.elements) > 1:
        axes[2].legend(ncols=2, loc="upper right", borderaxespad=0.2)
    axes[0].set_ylabel(material.effort.titled(material.word.capitalize()))
    axes[1].set_ylabel(material.effort.titled("Residual"))
    axes[2].set_ylabel(material.field.titled("Field"))
    axes[2].set_xlabel(titled(material, "Time [s]"))
    axes[2].set_xlim(float(time[0]), float(time[-1]))
    figure.align_ylabels(list(axes))
    columns = [time, *(e.field[rows] for e in data.elements), *(e.slip[rows] for e in data.elements), data.effort[rows]]
    names = [material.element_name(i) for i in range(len(data.elements))]
    header = ["time", *(f"field {n}".strip() for n in names), *(f"slip {n}".strip() for n in names), "effort"]
    for name in material.run.names:
        columns.append(material.rows.predicted[name][rows])
        header.append(f"effort:{name}")
    return Numbers(header, list(zip(*(c.tolist() for c in columns), strict=True)))


def _rows(material: Material, start: float | None, seconds: float | None) -> slice:
    if start is None and seconds is None:
        return slice(*material.windows.typical)
    time = material.rows.data.clock.time
    usual = material.windows.typical
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
