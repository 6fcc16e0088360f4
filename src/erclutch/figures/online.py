"""Figures 7 to 13: inputs above, measured and estimated torque below, of a run of the live loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.experiments.online import Trace
from erclutch.figures.style import (
    BLACK,
    BLUE,
    COLUMN,
    GREEN,
    ORANGE,
    PAGE,
    PINK,
    RED,
    SKY,
    new_figure,
    save,
    save_numbers,
    style,
)

Array = NDArray[np.float64]
_ESTIMATES = (RED, BLUE, GREEN, ORANGE, PINK, SKY)


def draw_online(trace: Trace, path: Path, title: str, *, start: int = 0, rows: int = 4000) -> list[Path]:
    """Draw a stretch of a run and write its numbers beside it.

    Args:
        trace: the run.
        path: .png, .pdf or .svg; the numbers go to the same name with .csv.
        title: above it, with TWIN, RECORDING or HARDWARE in it.
        start: first row.
        rows: how many.

    Returns:
        The files written.
    """
    at = slice(start, min(start + rows, len(trace.frames)))
    frames = trace.frames[at]
    seconds = 1e-9 * (frames["time_ns"] - frames["time_ns"][0]).astype(np.float64)
    panels = _panels(trace, at)
    with style():
        crowded = max(len(group) for _, group in panels) > 4
        figure: Any = new_figure(0.55 + 0.95 * len(panels) + 0.5 * crowded, PAGE if crowded else COLUMN)
        axes: Any = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (label, lines) in zip(axes, panels, strict=True):
            for name, values, colour, dashed in lines:
                axis.plot(seconds, values, color=colour, label=name, linestyle=(0, (3, 1.5)) if dashed else "-")
            axis.set_ylabel(label)
            if len(lines) > 4:
                axis.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, -0.5))
            elif len(lines) > 1:
                axis.legend(ncols=len(lines), loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0.0)
        axes[-1].set_xlabel("Time [s]")
        axes[-1].set_xlim(0.0, float(seconds[-1]))
        figure.suptitle(title, x=0.02, ha="left", fontsize=8.0)
        figure.align_ylabels()
        save(figure, path)
    lines = [line for _, group in panels for line in group]
    table = zip(seconds.tolist(), *(values.tolist() for _, values, _, _ in lines), strict=True)
    return [path, save_numbers(path.with_suffix(".csv"), ["time", *(name for name, *_ in lines)], table)]


_Lines = list[tuple[str, Array, str, bool]]


def _panels(trace: Trace, at: slice) -> list[tuple[str, _Lines]]:
    f = trace.frames[at]
    speeds: _Lines = [("motor", f["theta_dot"], BLUE, False), ("output", f["alpha_dot"], ORANGE, False)]
    panels: list[tuple[str, _Lines]] = [("Speed\n[rad/s]", speeds)]
    if np.any(f["field1"] + f["field2"] > 0.0):
        panels.append(("Field", [("E1", f["field1"], BLUE, False), ("E2", f["field2"], RED, False)]))
    if float(np.ptp(f["motor_torque"])) > 0.0:
        panels.append(("Motor torque\n[N m]", [("motor torque", f["motor_torque"], BLACK, False)]))
    if np.isfinite(f["reference"]).all():
        pair: _Lines = [("reference", f["reference"], BLACK, False), ("output", f["alpha"], ORANGE, True)]
        panels.append(("Angle\n[rad]", pair))
    torque: _Lines = [("measured", f["torque"], BLACK, False)]
    names = list(trace.estimates)
    torque += [(n, trace.estimates[n][at], c, n == names[0]) for n, c in zip(names, _ESTIMATES, strict=False)]
    if trace.other_alpha is not None:
        alpha, estimate = trace.other_alpha
        panels.insert(1, ("Difference\n[mrad]", [("linear - rotary", 1e3 * (f["alpha"] - alpha[at]), BLACK, False)]))
        torque = [("linear encoder", trace.estimates[names[0]][at], BLUE, False)]
        torque.append(("rotary encoder", estimate[at], RED, True))
    panels.append(("Torque\n[N m]", torque))
    return panels
