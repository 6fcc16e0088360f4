"""These sections show pictures: the error map, how errors are distributed, what is left, flow curves, loops."""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.fit.choice.standing import standing_of_run
from erclutch.report.html.section import Section
from erclutch.report.numbers.model_stages import remembers_slip
from erclutch.report.numbers.number_text import brief, count, number, percent_text
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.error_map_plot import describe_error_map, worst_cell
from erclutch.report.plots.flow_curves_plot import flow_panels
from erclutch.report.plots.loops_plot import describe_loops
from erclutch.report.plots.parity_plot import describe_parity
from erclutch.report.plots.residual_plot import describe_residual
from erclutch.report.plots.svg_painter import RAMP, inside

#: Share of its box below which a loop is closed.
_NARROW = 0.02


def _error_map(material: Material) -> dict[str, Any]:
    """Two maps an element."""
    panels = describe_error_map(material).panels
    (error,) = panels[0].cells()
    (rows,) = panels[1].cells()

    largest_errors = [worst_cell(material, cells) for cells in material.error_maps]
    worst = " ".join(filter(None, largest_errors))
    blind = max(cells.blind_share for cells in material.error_maps)
    holes = "Every row held out lies in a cell that training rows reach."
    if blind:
        holes = f"{percent_text(blind, 2)} of the rows held out lie in cells without a training row (crossed)."
    grids: list[dict[str, Any]] = []  # for the readout under the pointer
    units = [brief(scale.unit) for scale in (material.field, material.slip, material.effort)]
    for cells in material.error_maps:
        shown_rmse = cells.rmse * material.effort.factor
        rmse = np.where(np.isfinite(cells.rmse), shown_rmse, -1.0)
        grids.append(
            {
                "name": material.element_name(cells.element),
                "field": [float(f"{v:.4g}") for v in cells.field_edges * material.field.factor],
                "slip": [float(f"{v:.4g}") for v in cells.slip_edges * material.slip.factor],
                "train": cells.train.tolist(),
                "test": cells.test.tolist(),
                "rmse": [[float(f"{v:.3g}") for v in line] for line in rmse],
                "units": units,
                "fieldless": material.without_field,
                # Where the axes lie in the drawing, the same in all.
                "inside": inside(panels[0]),
            }
        )
    error_steps = [number(top, 2) for top in error.largest(RAMP)]
    if error.go_beyond:
        error_steps[-1] = "more"
    return {
        "pairs": list(zip(panels[::2], panels[1::2], strict=True)),
        "grids": grids,
        "error_steps": error_steps,
        "row_steps": [count(round(top)) for top in rows.largest(RAMP)],
        "error_label": error.label,
        "lead": f"{worst} {holes}",
    }


def _residual(material: Material) -> dict[str, Any] | None:
    """In frequency and in time; in words how many rows are independent, and what the model does not explain."""
    power, memory = material.spectrum, material.autocorrelation
    if power is None or memory is None:
        return None
    name = material.recommended
    rows = material.body["test_rows"]
    free = min(memory.independent[name], float(rows))
    width = np.gradient(power.frequency)
    residual = power.density[name] ** 2 * width  # power in each group of frequencies
    measured = power.density["measured"] ** 2 * width
    total = float(np.sum(residual)) or 1.0
    below = np.cumsum(residual) / total
    middle = int(np.searchsorted(below, 0.5))
    half = float(power.frequency[middle])

    # All that lies above a frequency is compared: a single valley of the measured power says nothing.
    residual_above = np.cumsum(residual[::-1])[::-1]
    measured_above = np.cumsum(measured[::-1])[::-1]
    explained = np.flatnonzero(residual_above <= 0.5 * measured_above)
    unexplained = power.frequency[int(explained[-1]) + 1 :] if explained.size else power.frequency
    text = (
        f"Half of the residual's power lies below {number(half, 2)} Hz. Errors come in bouts: {count(rows)} rows held "
        f"out tell as much of their size as {count(max(1, round(free)))} independent ones."
    )
    if 0 < unexplained.size < residual.size:
        first = number(float(unexplained[0]), 2)
        text += f" From about {first} Hz on, the model explains less than half of what is measured."
    return {"figures": describe_residual(material).panels, "lead": text}


def _flow_curves(material: Material) -> dict[str, Any] | None:
    """One small plot a law."""
    curves = material.flow_curves
    if not curves[0]:
        return None
    groups: list[dict[str, Any]] = []
    levels: list[tuple[str, str]] = []  # style and label of each field, the same in all panels
    dots = False
    for place, laws in enumerate(curves):
        panels = flow_panels(material, laws)
        plots: list[dict[str, Any]] = []
        for law, panel in zip(laws, panels, strict=True):
            plots.append({"name": material.titles[law.model], "panel": panel})
            dots = dots or any(near.size for near in law.dots)
        groups.append({"element": material.element_name(place), "plots": plots})
        levels = levels or panels[0].legend()
    if not material.field.unit:
        levels = [(style, f"E = {label}") for style, label in levels]
    return {"groups": groups, "levels": levels, "about": material.about_flow_curves, "dots": dots}


def _loops(material: Material) -> dict[str, Any] | None:
    """A row of two plots a field."""
    if not material.effort_loops:
        return None
    panels = describe_loops(material).panels
    models = {material.titles[name]: role for name, role in material.looped.items()}

    # How much of the measured loops the models draw.
    areas = material.loop_areas
    if areas is None and material.without_field:
        lead = "Hardly a period was held out."
    elif areas is None:
        lead = "Hardly a period was held out at a steady field, and at a moving field a loop is no sign of memory."
    else:
        lead = (
            f"Over {count(areas.periods)} periods held out at a steady field, the loops of {material.word} over slip "
            f"fill {percent_text(areas.measured, 2)} of the boxes around them"
        )
        if areas.measured < _NARROW:
            lead += ", next to nothing: they show no memory of the motion."
            # Closed loops seem to deny the memory of the recommended model, where it has one.
            if remembers_slip(material.run.entry(material.recommended)):
                standing = standing_of_run(material.body).word
                lead += (
                    f" The {standing} model has a memory all the same: “Lag and memory” says what it gains over all "
                    "rows."
                )
        else:
            shares: list[str] = []
            for name, share in areas.drawn.items():
                shares.append(f"{material.titles[name]} draws {percent_text(max(share, 0.0), 2)}")
            lead += f"; of that area {' and '.join(shares)}."
    return {"figures": panels, "models": models, "lead": lead}


ERROR_MAP = Section(
    "error_map", "Where it errs, and where there are data", "Where it errs", _error_map
)
PARITY = Section(
    "parity",
    "How errors are distributed",
    "Errors",
    lambda material: {"figures": describe_parity(material).panels},
)
RESIDUAL = Section("residual", "What is left in the residual", "Residual", _residual, folded=True)
FLOW_CURVES = Section(
    "flow_curves", "Flow curves of all laws", "Flow curves", _flow_curves, folded=True
)
LOOPS = Section("loops", "Loops of effort over slip and over travel", "Loops", _loops)
