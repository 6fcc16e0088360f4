"""Spectrum and autocorrelation say what of a residual is not noise, on the held-out rows, gap by gap."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.fit.scoring import independent_rows
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Span, cut_spans, stretches

_WINDOW = 4096
_POINTS = 140


@dataclass(frozen=True)
class Spectrum:
    """Amplitude spectral densities.

    Attributes:
        frequency: in Hz, shape (n,).
        density: by name ("measured" or a model, whose residual it is): effort per root of Hz, each (n,).
    """

    frequency: Array
    density: dict[str, Array]


@dataclass(frozen=True)
class Autocorrelation:
    """Autocorrelations of residuals.

    Attributes:
        lag: in s, shape (n,), from 0.
        values: by model, each (n,).
        white: half width of the band that white residuals stay in, 95 % of the lags.
        independent: by model: how many independent rows tell as much of the error's size as all rows held out.
    """

    lag: Array
    values: dict[str, Array]
    white: float
    independent: dict[str, float]


def held_out_spans(rows: RunRows) -> list[Span]:
    """Gapless stretches of the rows held out."""
    return spans_inside(rows, rows.test)


def spans_inside(rows: RunRows, mask: Mask) -> list[Span]:
    """Gapless stretches of the rows of a mask."""
    return [
        Span(a + s.start, a + s.stop, s.period)
        for a, b in stretches(mask)
        for s in cut_spans(rows.data.clock.spans, a, b)
    ]


def noise_of(values: Array) -> float:
    """Standard deviation of a signal's noise, from the median of its second differences; 0 where most rows repeat."""
    apart = np.abs(np.diff(values, 2))
    return 1.4826 * float(np.median(apart)) / 6.0**0.5 if apart.size else 0.0


def period_of(rows: RunRows) -> float:
    """Sampling period in s of most of the rows held out."""
    step = np.concatenate([_steps(rows, span)[:-1] for span in held_out_spans(rows)] or [np.diff(rows.data.clock.time)])
    return float(np.median(step))


def _steps(rows: RunRows, span: Span) -> Array:
    """Step after each row of a span, the last one's as the one before."""
    if span.period is not None:
        return np.full(span.stop - span.start, span.period)
    steps = np.diff(rows.data.clock.time[span.start : span.stop])
    return np.append(steps, steps[-1:])


def _alike(rows: RunRows) -> tuple[list[Span], int, float]:
    """Stretches of the rows held out that are sampled like most of them, rows of the longest, and the period."""
    period = period_of(rows)
    alike = [s for s in held_out_spans(rows) if abs(float(np.median(_steps(rows, s))) - period) < 0.02 * period]
    return alike, max((s.stop - s.start for s in alike), default=0), period


def spectrum(rows: RunRows, models: Sequence[str]) -> Spectrum | None:
    """Densities by averaged, windowed periodograms (Welch); None where no stretch is long enough."""
    spans, longest, period = _alike(rows)
    if longest < 64:
        return None
    width = min(_WINDOW, 1 << (longest // 2).bit_length() - 1)
    signals = {"measured": rows.data.effort, **{m: rows.residual(m) for m in models}}
    whole = {name: _welch(values, spans, width, period) for name, values in signals.items()}
    frequency = np.fft.rfftfreq(width, period)[1:]
    edges = np.unique(np.geomspace(1, frequency.size, _POINTS).astype(int))
    groups = [slice(a - 1, max(b - 1, a)) for a, b in itertools.pairwise(edges)]
    return Spectrum(
        np.array([frequency[g].mean() for g in groups]),
        {name: np.sqrt(np.array([power[1:][g].mean() for g in groups])) for name, power in whole.items()},
    )


def _welch(values: Array, spans: Sequence[Span], width: int, period: float) -> Array:
    taper = np.hanning(width)
    total, count = np.zeros(width // 2 + 1), 0
    for span in spans:
        for at in range(span.start, span.stop - width + 1, width // 2):
            piece = values[at : at + width]
            total += np.abs(np.fft.rfft((piece - piece.mean()) * taper)) ** 2
            count += 1
    return total * (2.0 * period / (float(taper @ taper) * max(count, 1)))


def autocorrelation(rows: RunRows, models: Sequence[str]) -> Autocorrelation | None:
    """Autocorrelations up to where they have died away; None where no stretch is long enough."""
    spans, longest, period = _alike(rows)
    if longest < 64:
        return None
    most = min(longest // 3, max(50, round(2.0 / period)))
    values = {m: _correlate(rows.residual(m), spans, most) for m in models}
    # Up to three times the lag at which the longest memory has first fallen to a tenth.
    gone = [int(np.argmax(np.append(v, 0.0) < 0.1)) for v in values.values()]
    last = int(np.clip(3 * max(gone), min(30, most), most))
    n = sum(s.stop - s.start for s in spans)
    return Autocorrelation(
        np.arange(last + 1, dtype=np.float64) * period,
        {m: v[: last + 1] for m, v in values.items()},
        1.96 / n**0.5,
        {m: independent_rows(rows.residual(m)[rows.test] ** 2) for m in models},
    )


def _correlate(residual: Array, spans: Sequence[Span], most: int) -> Array:
    mean = np.mean(np.concatenate([residual[s.start : s.stop] for s in spans]))
    total = np.zeros(most + 1)
    for span in spans:
        piece = residual[span.start : span.stop] - mean
        size = 1 << (piece.size + most).bit_length()
        power = np.abs(np.fft.rfft(piece, size)) ** 2
        total += np.fft.irfft(power, size)[: most + 1]
    return total / total[0] if total[0] > 0 else np.eye(1, most + 1)[0]
