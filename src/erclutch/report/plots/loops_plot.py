"""This plot shows loops of effort over slip and over travel, measured and modelled, a row of panels a field."""

from __future__ import annotations

from erclutch.errors import CheckError
from erclutch.report.numbers.effort_loops import EffortLoop
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import PAGE, Axis, Line, Panel, Plot, PlotTable
from erclutch.signals.array import Array
from erclutch.signals.device import largest_field

_STEADY = 0.01  # share of the largest field by which a field may move and still be one


def describe_loops(material: Material) -> Plot:
    """A row of two panels a field: effort over slip, and effort over travel. Of a pair both clutches.

    Raises:
        CheckError: the slip never turns.
    """
    loops = material.effort_loops
    if not loops:
        raise CheckError(
            "the slip does not go to and fro, so there are no loops",
            where=str(material.run.folder),
            remedy="Log a motion of several periods without a gap",
        )
    panels: list[Panel] = []
    rows: list[tuple[object, ...]] = []
    over_slip = Axis("slip", material.slip.unit)
    over_travel = Axis("travel", material.travel.unit)
    for loop in loops:
        slip = loop.slip * material.slip.factor
        travel = loop.travel * material.travel.factor
        panels.append(_panel(material, loop, over_slip, slip))
        panels.append(_panel(material, loop, over_travel, travel))
        same = (loop.element + 1, *loop.fields, loop.start)  # in all rows of the loop
        for name, efforts in {"measured": loop.measured, **loop.modelled}.items():
            for point in zip(
                loop.slip.tolist(), loop.travel.tolist(), efforts.tolist(), strict=True
            ):
                slip_there, travel_there, effort = point
                rows.append((*same, slip_there, travel_there, name, effort))
    header = ("element", "field_low", "field_high", "time_s", "slip", "travel", "curve", "effort")
    return Plot(
        panels,
        PlotTable(header, rows),
        0.35 + 1.75 * len(loops),
        PAGE,
        2,
        badge=material.print_badge,
        legend="shared",
    )


def _panel(
    material: Material,
    loop: EffortLoop,
    x: Axis,
    values: Array,
) -> Panel:
    """A loop over one axis, measured and modelled."""
    factor = material.effort.factor
    lines = [Line(values, loop.measured * factor, "measured", "measured")]
    for name, role in material.looped.items():
        lines.append(Line(values, loop.modelled[name] * factor, role, material.titles[name]))
    at = ""
    if not material.without_field:
        low, high = loop.fields
        name = f"{material.element_name(loop.element)} ".lstrip()
        if not material.field.unit:
            name += "E = "
        largest = largest_field(material.rows.data.elements)
        field = f"{material.field.bare(low, 2)} to {material.field.of(high, 2)}"
        if high - low < _STEADY * largest:
            field = material.field.of(0.5 * (low + high), 2)
        at = f" at {name}{field}"
    data = material.rows.data
    place = data.sources.index(loop.log) if loop.log else 0
    first_row, _ = data.source_rows[place]
    where = f"from {loop.start - material.clock_start(first_row):.4g} s"
    if loop.log:
        where += f" of {loop.log}"
    if not loop.held:
        where += ", training rows"
    return Panel(
        x,
        Axis(material.word, material.effort.unit),
        lines,
        f"{material.word} over {x.label}{at}, measured and estimated by "
        f"{', '.join(material.titles[name] for name in loop.modelled)}.",
        f"{at.removeprefix(' at ')}, {where}".removeprefix(", "),
        caption=f"Over {x.label}{at}, {where}.",
        size=(430, 250),
    )
