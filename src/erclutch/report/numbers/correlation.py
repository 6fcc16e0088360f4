"""Spectrum and autocorrelation say what of a residual is not noise, on the held-out rows, gap by gap."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.fit.choice.scoring import independent_rows
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Span, cut_spans, stretches

_WINDOW = 4096  # rows at most
_POINTS = 140  # of a spectrum
_SHORTEST = 64  # rows of the longest stretch, below which nothing is said
_SAME_PERIOD = 0.02  # share by which periods may differ


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
    inside: list[Span] = []
    for start, stop in stretches(mask):
        # Rows of these spans are counted from the start of the stretch.
        for span in cut_spans(rows.data.clock.spans, start, stop):
            first = start + span.start
            behind = start + span.stop
            inside.append(Span(first, behind, span.period))
    return inside


def period_of(rows: RunRows) -> float:
    """Sampling period in s of most of the rows held out."""
    steps = [_steps(rows, span)[:-1] for span in held_out_spans(rows)]
    if not steps:
        steps = [np.diff(rows.data.clock.time)]
    return float(np.median(np.concatenate(steps)))


def _steps(rows: RunRows, span: Span) -> Array:
    """Step after each row of a span, the last one's as the one before."""
    if span.period is not None:
        return np.full(span.stop - span.start, span.period)
    time = rows.data.clock.time[span.start : span.stop]
    steps = np.diff(time)
    return np.append(steps, steps[-1:])


def _alike(rows: RunRows) -> tuple[list[Span], int, float]:
    """Stretches of the rows held out that are sampled like most of them, rows of the longest, and the period."""
    period = period_of(rows)
    alike: list[Span] = []
    for span in held_out_spans(rows):
        own = float(np.median(_steps(rows, span)))
        if abs(own - period) < _SAME_PERIOD * period:
            alike.append(span)
    longest = max((span.stop - span.start for span in alike), default=0)
    return alike, longest, period


def spectrum(rows: RunRows, models: Sequence[str]) -> Spectrum | None:
    """Densities by averaged, windowed periodograms (Welch); None where no stretch is long enough."""
    spans, longest, period = _alike(rows)
    if longest < _SHORTEST:
        return None
    power_of_two = 1 << (longest // 2).bit_length() - 1  # at least twice in the longest
    width = min(_WINDOW, power_of_two)
    frequency = np.fft.rfftfreq(width, period)[1:]
    # Groups of frequencies, evenly over the logarithm, for a curve of few points.
    even = np.geomspace(1, frequency.size, _POINTS)
    edges = np.unique(even.astype(int))
    groups: list[slice] = []
    for first, stop in itertools.pairwise(edges):
        groups.append(slice(first - 1, max(stop - 1, first)))

    signals = {"measured": rows.data.effort}
    for name in models:
        signals[name] = rows.residual(name)
    taper = np.hanning(width)
    density: dict[str, Array] = {}
    for name, values in signals.items():
        # Power spectral density, shape (width / 2 + 1,): the mean over windows that overlap by half.
        total = np.zeros(width // 2 + 1)
        count = 0
        for span in spans:
            for first in range(span.start, span.stop - width + 1, width // 2):
                piece = values[first : first + width]
                tapered = (piece - piece.mean()) * taper
                total += np.abs(np.fft.rfft(tapered)) ** 2
                count += 1
        windows = float(taper @ taper) * max(count, 1)
        power = (total * (2.0 * period / windows))[1:]
        of_groups = np.array([power[group].mean() for group in groups])
        density[name] = np.sqrt(of_groups)
    middles = np.array([frequency[group].mean() for group in groups])
    return Spectrum(middles, density)


def autocorrelation(rows: RunRows, models: Sequence[str]) -> Autocorrelation | None:
    """Autocorrelations up to where they have died away; None where no stretch is long enough."""
    spans, longest, period = _alike(rows)
    if longest < _SHORTEST:
        return None
    two_seconds = max(50, round(2.0 / period))
    most = min(longest // 3, two_seconds)  # rows of lag
    whole: dict[str, Array] = {}
    independent: dict[str, float] = {}
    gone: list[int] = []  # rows of lag at which a correlation has first fallen to a tenth
    for name in models:
        residual = rows.residual(name)
        # At lags of 0 to so many rows, shape (most + 1,); pairs of rows across a gap do not count.
        pieces = [residual[span.start : span.stop] for span in spans]
        mean = np.mean(np.concatenate(pieces))
        total = np.zeros(most + 1)
        for piece in pieces:
            size = 1 << (piece.size + most).bit_length()  # room enough that the ends do not meet
            power = np.abs(np.fft.rfft(piece - mean, size)) ** 2
            total += np.fft.irfft(power, size)[: most + 1]
        values = np.zeros(most + 1)
        values[0] = 1.0  # of a residual of nothing
        if total[0] > 0:
            values = total / total[0]
        whole[name] = values
        independent[name] = independent_rows(residual[rows.test] ** 2)
        is_gone = np.append(values, 0.0) < 0.1
        gone.append(int(np.argmax(is_gone)))
    # Up to three times the lag at which the longest memory is gone.
    fewest = min(30, most)
    last = int(np.clip(3 * max(gone), fewest, most))
    count = sum(span.stop - span.start for span in spans)
    return Autocorrelation(
        lag=np.arange(last + 1, dtype=np.float64) * period,
        values={name: values[: last + 1] for name, values in whole.items()},
        white=1.96 / count**0.5,
        independent=independent,
    )
