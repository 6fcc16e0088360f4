"""This plot shows measured and estimated effort over a section of the log, the residual and the command under it."""

from __future__ import annotations

import numpy as np

from erclutch.errors import SettingError
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import (
    Axis,
    Line,
    Mark,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
    Shade,
)


def describe_trace(
    material: Material,
    *,
    start: float | None = None,
    seconds: float | None = None,
    band: bool = True,
) -> Plot:
    """A section: by default the liveliest of the rows held out (`Windows.lively`).

    Args:
        material: the run.
        start: first second, on the log's own clock.
        seconds: length; None: to the section's usual length.
        band: whether the recommended model's prediction band is drawn.

    Raises:
        SettingError: no row lies there.
    """
    section = _rows(material, start, seconds)
    rows = material.rows
    start_of_log = material.clock_start(section.start)
    time = rows.data.clock.time[section] - start_of_log
    factor = material.effort.factor
    # A paper's column has room for two estimates, so the best model stays out.
    models = {name: role for name, role in reversed(material.shown.items()) if role != "best"}
    if not models:
        models = material.shown

    efforts: list[Mark] = []
    ends = material.band_ends if band else None
    if ends is not None:
        low, high = ends
        low_end = low[section] * factor
        high_end = high[section] * factor
        efforts.append(Shade(low_end, high_end, x=time))
    measured = rows.data.effort[section] * factor
    efforts.append(Line(time, measured, "measured", "measured"))
    residuals: list[Mark] = [ReferenceLine(0.0)]
    for name, role in models.items():
        estimated = rows.predicted[name][section] * factor
        residual = rows.residual(name)[section] * factor
        efforts.append(Line(time, estimated, role, material.titles[name]))
        residuals.append(Line(time, residual, role))

    commands: list[Mark] = []
    for place, (element, style) in enumerate(
        zip(rows.data.elements, ("series0", "series6"), strict=False)
    ):
        field = element.field[section] * material.field.factor
        title = material.element_name(place)
        commands.append(Line(time, field, style, title, dashed=place > 0))

    # The table has all models of the run, not only those that are drawn.
    names = [material.element_name(place) for place in range(len(rows.data.elements))]
    columns = {"time": rows.data.clock.time}
    for name, element in zip(names, rows.data.elements, strict=True):
        columns[f"field {name}".strip()] = element.field
    for name, element in zip(names, rows.data.elements, strict=True):
        columns[f"slip {name}".strip()] = element.slip
    columns["effort"] = rows.data.effort
    for name in material.run.names:
        columns[f"effort:{name}"] = rows.predicted[name]
    numbers = np.column_stack([column[section] for column in columns.values()])

    counted = f" from {start_of_log:.2f} s" if start_of_log else ""
    x = Axis.over(f"time{counted}", "s", time)
    if rows.data.in_no_time:
        x = Axis.over("point of the table", "", time / rows.data.period)
    y = Axis(material.word, material.effort.unit)
    panels = [
        Panel(x, y, efforts, f"Measured and estimated {material.word}.", share=2.2),
        Panel(x, Axis("residual", material.effort.unit), residuals, "Measured less estimated."),
    ]
    if not material.without_field:
        panels.append(
            Panel(x, Axis("field", material.field.unit), commands, "The command.", share=1.2)
        )
    return Plot(
        panels,
        PlotTable(list(columns), numbers.tolist()),
        height=3.3,
        badge=material.print_badge,
        legend="above",
    )


def _rows(material: Material, start: float | None, seconds: float | None) -> slice:
    """Rows of the section that is asked for.

    Raises:
        SettingError: there are none.
    """
    usual_first, usual_stop = material.windows.lively
    if start is None and seconds is None:
        return slice(usual_first, usual_stop)
    time = material.rows.data.clock.time
    first = float(time[usual_first]) if start is None else start
    length = (usual_stop - usual_first) * material.period if seconds is None else seconds
    if not length > 0.0:
        raise SettingError(f"a section of {length:g} s", remedy="Give --seconds above 0")
    # Time restarts with each log. Where several logs have such times, the rows of the first are taken.
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
