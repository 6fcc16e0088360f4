"""This plot shows the spectrum and the autocorrelation of the residual."""

from __future__ import annotations

import itertools

import numpy as np

from erclutch.errors import CheckError
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
from erclutch.signals.array import Array

_POINTS = 400  # of a curve that is drawn; the table has them all


def describe_residual(material: Material) -> Plot:
    """Two panels: amplitude densities, autocorrelations.

    Raises:
        CheckError: no stretch of the rows held out is long enough.
    """
    power = material.spectrum
    memory = material.autocorrelation
    if power is None or memory is None:
        raise CheckError(
            "no stretch of 64 rows without a gap is held out, so there is no spectrum",
            where=str(material.run.folder),
            remedy="Hold out more rows with --test",
        )

    # Amplitude densities of the measured effort and of the residuals.
    frequency = power.frequency
    # A logarithmic axis has no place for zero.
    nothing = 1e-300
    curves: dict[str, Array] = {}
    for name, density in power.density.items():
        curves[name] = np.maximum(density * material.effort.factor, nothing)
    lines = [Line(frequency, curves["measured"], "measured", "measured")]
    for name, role in reversed(material.shown.items()):
        lines.append(Line(frequency, curves[name], role, material.titles[name]))

    # A few densities near zero shall not stretch the axis over decades.
    lively = [curve[curve > nothing] for curve in curves.values()]
    positive = np.concatenate(lively)
    low = float(np.quantile(positive, 0.002)) / 1.5
    high = 1.6 * float(positive.max())
    unit = f"{material.effort.unit or '1'}/√Hz"
    spectra = Panel(
        Axis.over("frequency", "Hz", frequency, log=True),
        Axis("amplitude density", unit, low, high, log=True),
        lines,
        f"Spectra of the measured {material.word} and of the residuals of {', '.join(material.shown)}.",
        caption="A residual that keeps to the measured line at some frequency is not explained there; flat and low is "
        "noise.",
    )

    # Autocorrelations of the residuals, and the band that white noise stays in.
    in_ms = memory.lag[-1] < 1.0
    lag = memory.lag * 1e3 if in_ms else memory.lag
    thin = slice(None, None, max(1, lag.size // _POINTS))
    marks: list[Mark] = [Shade(-memory.white, memory.white), ReferenceLine(0.0)]
    for name, role in reversed(material.shown.items()):
        values = memory.values[name]
        marks.append(Line(lag[thin], values[thin], role))

    lowest_values = [float(values.min()) for values in memory.values.values()]
    lowest = min(-0.1, *lowest_values)
    slack = 0.04 * (1.0 - lowest)
    autocorrelations = Panel(
        Axis("lag", "ms" if in_ms else "s", 0.0, float(lag[-1])),
        Axis("autocorrelation", "", lowest - slack, 1.0 + slack),
        marks,
        f"Autocorrelation of the residuals of {', '.join(material.shown)} over the lag.",
        caption="White noise stays in the grey band. A slow decay: something the model does not know lasts that long.",
    )

    # Both tables side by side, the shorter one filled up with nothing.
    left_header = ["frequency_Hz", *(f"density:{name}" for name in power.density)]
    right_header = ["lag_s", *(f"acf:{name}" for name in memory.values)]
    densities = np.column_stack([power.frequency, *power.density.values()])
    left = densities.tolist()
    memories = np.column_stack([memory.lag, *memory.values.values()])
    right = memories.tolist()
    rows: list[list[object]] = []
    for left_cells, right_cells in itertools.zip_longest(left, right):
        left_row = left_cells or [""] * len(left_header)
        right_row = right_cells or [""] * len(right_header)
        rows.append([*left_row, *right_row])
    return Plot(
        [spectra, autocorrelations],
        PlotTable([*left_header, *right_header], rows),
        height=4.0,
        badge=material.print_badge,
        legend="above",
    )
