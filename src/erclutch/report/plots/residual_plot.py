"""This plot shows the spectrum and the autocorrelation of the residual."""

from __future__ import annotations

import itertools

import numpy as np

from erclutch.errors import CheckError
from erclutch.report.numbers.correlation import Autocorrelation, Spectrum
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.plot_description import Axis, Line, Panel, Plot, PlotTable, ReferenceLine, Shade

_POINTS = 400  # of a curve that is drawn; the table has them all


def describe_residual(material: Material) -> Plot:
    """Two panels: amplitude densities, autocorrelations.

    Raises:
        CheckError: no stretch of the rows held out is long enough.
    """
    power, memory = material.spectrum, material.autocorrelation
    if power is None or memory is None:
        raise CheckError(
            "no stretch of 64 rows without a gap is held out, so there is no spectrum",
            where=str(material.run.folder),
            remedy="Hold out more rows with --test",
        )
    panels = [_spectrum(material, power), _correlation(material, memory)]
    return Plot(panels, _table(power, memory), 4.0, badge=material.print_badge, legend="above")


def _spectrum(material: Material, found: Spectrum) -> Panel:
    frequency = found.frequency
    # A logarithmic axis has no place for zero.
    curves = {name: np.maximum(d * material.effort.factor, 1e-300) for name, d in found.density.items()}
    lines = [Line(frequency, curves["measured"], "measured", "measured")]
    for name, role in reversed(material.shown.items()):
        lines.append(Line(frequency, curves[name], role, material.titles[name]))

    # A few densities near zero shall not stretch the axis over decades.
    positive = np.concatenate([d[d > 1e-300] for d in curves.values()])
    low = float(np.quantile(positive, 0.002)) / 1.5
    high = 1.6 * float(positive.max())
    unit = f"{material.effort.unit or '1'}/√Hz"
    return Panel(
        Axis("frequency", "Hz", float(frequency[0]), float(frequency[-1]), log=True),
        Axis("amplitude density", unit, low, high, log=True),
        lines,
        f"Spectra of the measured {material.word} and of the residuals of {', '.join(material.shown)}.",
        caption="A residual that keeps to the measured line at some frequency is not explained there; flat and low is "
        "noise.",
    )


def _correlation(material: Material, found: Autocorrelation) -> Panel:
    scale, unit = (1e3, "ms") if found.lag[-1] < 1.0 else (1.0, "s")
    lag = found.lag * scale
    thin = slice(None, None, max(1, lag.size // _POINTS))
    lines = [Line(lag[thin], found.values[name][thin], role) for name, role in reversed(material.shown.items())]

    lowest = min(-0.1, *(float(v.min()) for v in found.values.values()))
    slack = 0.04 * (1.0 - lowest)
    return Panel(
        Axis("lag", unit, 0.0, float(lag[-1])),
        Axis("autocorrelation", "", lowest - slack, 1.0 + slack),
        [Shade(-found.white, found.white), ReferenceLine(0.0), *lines],
        f"Autocorrelation of the residuals of {', '.join(material.shown)} over the lag.",
        caption="White noise stays in the grey band. A slow decay: something the model does not know lasts that long.",
    )


def _table(power: Spectrum, memory: Autocorrelation) -> PlotTable:
    """Both tables side by side, the shorter one filled up with nothing."""
    left_header = ["frequency_Hz", *(f"density:{name}" for name in power.density)]
    right_header = ["lag_s", *(f"acf:{name}" for name in memory.values)]
    left = np.column_stack([power.frequency, *power.density.values()]).tolist()
    right = np.column_stack([memory.lag, *memory.values.values()]).tolist()
    rows: list[list[object]] = []
    for left_cells, right_cells in itertools.zip_longest(left, right):
        left_row = left_cells or [""] * len(left_header)
        right_row = right_cells or [""] * len(right_header)
        rows.append([*left_row, *right_row])
    return PlotTable([*left_header, *right_header], rows)
