"""What a spectrum is drawn over is no signal: a frequency f, and the angular frequency w beside it."""

from __future__ import annotations

import numpy as np

from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.planning.draft import Draft

_FREQUENCIES = frozenset(
    {"f", "fx", "freq", "freqs", "frequency", "frequencies", "frequenz", "fvec", "hz"}
)
_ANGULAR = frozenset({"w", "wout", "omega", "om", "wvec", "angfreq"})
#: Words that a spectrum beside them has in its name.
_SPECTRA = set_of(
    "mag magnitude phase fft psd spectrum spectra spectral bode amplitude amplituden spektrum spectre espectro "
    "frf gain db coherence"
)
_LAST_DIGITS = 1e-6  # by which 2 pi f and w may differ, as a share
_FEWEST = 3  # rows, from which on even steps say something
_FEWEST_SHIFTED = 64  # rows, from which on even steps through 0 are no ramp of a force by hand


def pass_over_axes_of_spectra(draft: Draft) -> None:
    """Take a frequency for no effort and an angular frequency for no speed, where both grow by even steps from 0 on.

    One of them tells itself by the other, which is 2 pi times as large, or by a spectrum beside it. An axis from minus
    the highest frequency to it, as a transform is shifted to, tells itself.
    """
    named = {*draft.taken}
    axes: list[SeenColumn] = []
    for column in draft.seen.columns.values():
        is_called_so = column.spoken.plain_stem in _FREQUENCIES | _ANGULAR
        values = column.values
        if column.name in named or not is_called_so or values.size < _FEWEST:
            continue
        if not np.isfinite(values).all() or not column.has_equal_steps:
            continue
        step = float(np.median(column.steps))
        first, last = float(values[0]), float(values[-1])
        begins_at_zero = first in (0.0, step)  # or behind it
        # An even number of frequencies around 0 ends a step before the one that mirrors the first.
        mirrors = first < 0.0 and abs(first + last) <= step * (1.0 + _LAST_DIGITS)
        is_shifted = mirrors and values.size >= _FEWEST_SHIFTED
        if step > 0.0 and (begins_at_zero or is_shifted):
            axes.append(column)
    has_a_spectrum = any(column.spoken.says(_SPECTRA) for column in draft.seen.columns.values())
    ends = np.array([float(column.values[-1]) for column in axes])
    for column in axes:
        is_shifted = float(column.values[0]) < 0.0
        ratios = ends / float(column.values[-1])
        by_2_pi = np.concatenate((ratios / (2.0 * np.pi), ratios * 2.0 * np.pi))
        has_a_twin = bool(np.any(np.abs(by_2_pi - 1.0) <= _LAST_DIGITS))
        if not (is_shifted or has_a_spectrum or has_a_twin):
            continue
        where = "from minus its end" if is_shifted else "beside a spectrum"
        draft.no_signals.append(column.name)
        draft.notes.append(
            f"column {column.name} grows by even steps {where}: taken for its frequencies, left out"
        )
