"""Spectrum and autocorrelation of the residual."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from erclutch.diagnostics.correlation import autocorrelation, spectrum
from erclutch.diagnostics.material import Material
from erclutch.errors import CheckError
from erclutch.figures.parts import Numbers, role_line, titled
from erclutch.figures.style import BLACK


def draw_residual(figure: Any, material: Material) -> Numbers:
    """Two panels: amplitude densities, autocorrelations.

    Raises:
        CheckError: no stretch of the rows held out is long enough.
    """
    power = spectrum(material.rows, material.shown_names)
    memory = autocorrelation(material.rows, material.shown_names)
    if power is None or memory is None:
        raise CheckError(
            "no stretch of 64 rows without a gap is held out, so there is no spectrum",
            where=str(material.run.folder),
            remedy="Hold out more rows with --test",
        )
    factor = material.effort.factor
    left, right = figure.subplots(2, 1)
    left.loglog(power.frequency, power.density["measured"] * factor, color=BLACK, label="measured")
    scale = 1e3 if memory.lag[-1] < 1.0 else 1.0
    right.axhspan(-memory.white, memory.white, color="#CCCCCC", linewidth=0)
    for shown in material.shown:
        left.loglog(power.frequency, power.density[shown.name] * factor, label=shown.name, **role_line(shown.role))
        right.plot(memory.lag * scale, memory.values[shown.name], **role_line(shown.role))
    left.set_xlabel(titled(material, "Frequency [Hz]"))
    left.set_ylabel(f"Amplitude density [{material.effort.unit or '1'}/√Hz]")
    left.legend(loc="lower left", handlelength=1.6)
    right.set_xlabel(f"Lag [{'ms' if scale > 1 else 's'}]")
    right.set_ylabel("Autocorrelation")
    right.set_xlim(0.0, float(memory.lag[-1]) * scale)
    header = ["frequency_Hz", *(f"density:{n}" for n in power.density), "lag_s", *(f"acf:{n}" for n in memory.values)]
    one = np.column_stack([power.frequency, *power.density.values()]).tolist()
    two = np.column_stack([memory.lag, *memory.values.values()]).tolist()
    empty = ([""] * len(one[0]), [""] * len(two[0]))
    rows = [[*(a or empty[0]), *(b or empty[1])] for a, b in itertools.zip_longest(one, two)]
    return Numbers(header, rows)
