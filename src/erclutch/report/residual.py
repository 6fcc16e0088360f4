"""Spectrum and autocorrelation of the residual: what of it is not noise."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from erclutch.diagnostics.correlation import Autocorrelation, Spectrum, autocorrelation, spectrum
from erclutch.diagnostics.material import Material
from erclutch.diagnostics.text import count, number
from erclutch.report.section import Section
from erclutch.report.svg import Axis, Plot, padded


class ResidualSection(Section):
    """In frequency and in time."""

    name: ClassVar[str] = "residual"
    title: ClassVar[str] = "What is left in the residual"
    short: ClassVar[str] = "Residual"

    def fill(self, material: Material) -> dict[str, Any] | None:
        """See `Section.fill`."""
        power = spectrum(material.rows, material.shown_names)
        memory = autocorrelation(material.rows, material.shown_names)
        if power is None or memory is None:
            return None
        return {
            "spectrum": _spectrum(material, power),
            "correlation": _correlation(material, memory),
            "lead": _lead(material, power, memory),
        }


def _spectrum(material: Material, found: Spectrum) -> Any:
    factor, unit = material.effort.factor, material.effort.unit
    x = found.frequency
    curves = {name: d * factor for name, d in found.density.items()}
    positive = np.concatenate([d[d > 0] for d in curves.values()])
    low, high = float(np.quantile(positive, 0.002)), float(positive.max())
    plot = Plot(
        Axis(float(x[0]), float(x[-1]), "frequency [Hz]", log=True),
        Axis(low / 1.5, 1.6 * high, f"amplitude density [{unit or '1'}/√Hz]", log=True),
        height=300,
    )
    plot.line(x, np.maximum(curves["measured"], 1e-300), "line measured")
    for shown in reversed(material.shown):
        plot.line(x, np.maximum(curves[shown.name], 1e-300), f"line {shown.role}")
    return plot.svg(
        f"Spectra of the measured {material.word} and of the residuals of {', '.join(material.shown_names)}."
    )


def _correlation(material: Material, found: Autocorrelation) -> Any:
    milli = found.lag[-1] < 1.0
    x = found.lag * (1e3 if milli else 1.0)
    low, high = padded([*found.values.values(), np.array([-0.1, 1.0])])
    plot = Plot(
        Axis(0.0, float(x[-1]), f"lag [{'ms' if milli else 's'}]"), Axis(low, high, "autocorrelation"), height=300
    )
    plot.band(-found.white, found.white, "white")
    plot.level(0.0, "zero")
    thin = max(1, x.size // 400)
    for shown in reversed(material.shown):
        plot.line(x[::thin], found.values[shown.name][::thin], f"line {shown.role}")
    return plot.svg(f"Autocorrelation of the residuals of {', '.join(material.shown_names)} over the lag.")


def _lead(material: Material, power: Spectrum, memory: Autocorrelation) -> str:
    name = material.recommended
    rows = material.body["test_rows"]
    free = min(memory.independent[name], float(rows))
    mine, whole = power.density[name] ** 2, power.density["measured"] ** 2
    width = np.gradient(power.frequency)
    total = float(np.sum(mine * width))
    running = np.cumsum(mine * width) / (total or 1.0)
    half = float(power.frequency[int(np.searchsorted(running, 0.5))])
    bad = power.frequency[mine > 0.5 * whole]
    text = (
        f"Half of the residual's power lies below {number(half, 2)} Hz. Errors come in bouts: {count(rows)} rows held "
        f"out tell as much of their size as {count(max(1, round(free)))} independent ones."
    )
    if bad.size and bad.size < mine.size:
        text += f" From about {number(float(bad[0]), 2)} Hz on, the model explains less than half of what is measured."
    return text
