"""Two clocks are matched: offset and drift between two logs, found from a signal that both of them have.

A coarse search (`coarse_search`) finds the peak among all offsets and drifts. Newton steps on finer and finer grids
(`fine_steps`) sharpen it. The last step is a straight line through the offsets of some twenty windows; their scatter
about the line gives the intervals, so noise that is correlated over less than a window does not make them too narrow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from erclutch.errors import LogError
from erclutch.signals.array import Array
from erclutch.wings.align.clock_line import ClockLine, overlap_of
from erclutch.wings.align.coarse_search import REMEDY, search_of_all
from erclutch.wings.align.fine_steps import WINDOWS, StepSeen, by_agreement, flat, stepped
from erclutch.wings.align.track import Track

_COARSEST = 200  # rows of the overlap on the coarsest grid: those that are needed, and a filter's reach at both ends


@dataclass(frozen=True)
class ClockMatch:
    """The clock of log B against that of log A: ``t_B = t_A + offset + drift * (t_A - origin)``.

    Attributes:
        origin: first time of A that B has too, in s on A's clock.
        offset: what B's clock shows more than A's at the origin, in s.
        offset_interval: 95 % interval of it.
        drift: by which share B's clock runs faster (1e-6 is 1 ppm).
        drift_interval: 95 % interval of it.
        overlap: first and last time in s on A's clock that both logs have.
        gain: signal of B over signal of A.
        correlation: of both signals after matching, over the frequencies at which they agree.
        independent: how many independent samples the overlap is worth.
        centres: middle of each window in s on A's clock, shape (windows,).
        residuals: offset of each window less the line, in s, shape (windows,).
    """

    origin: float
    offset: float
    offset_interval: tuple[float, float]
    drift: float
    drift_interval: tuple[float, float]
    overlap: tuple[float, float]
    gain: float
    correlation: float
    independent: float
    centres: Array
    residuals: Array

    def on_b(self, time: Array) -> Array:
        """Times of A, in s, as B's clock shows them."""
        return time + self.offset + self.drift * (time - self.origin)

    def on_a(self, time: Array) -> Array:
        """Times of B, in s, as A's clock shows them."""
        return self.origin + (time - self.offset - self.origin) / (1.0 + self.drift)

    def turned(self) -> ClockMatch:
        """The clock of log A against that of log B."""
        rate = 1.0 + self.drift
        overlap = np.array(self.overlap)
        origin, stop = self.on_b(overlap).tolist()
        least, most = self.offset_interval
        slowest, fastest = self.drift_interval
        return replace(
            self,
            origin=origin,
            offset=-self.offset,
            offset_interval=(-most, -least),
            drift=-self.drift / rate,
            drift_interval=(-fastest / rate, -slowest / rate),
            overlap=(origin, stop),
            gain=1.0 / self.gain,
            centres=self.on_b(self.centres),
            residuals=-self.residuals,
        )


def match_clocks(a: Track, b: Track, *, near: float | None = None) -> ClockMatch:
    """Find offset and drift of B's clock against A's.

    Args:
        a: the signal by log A.
        b: the signal by log B.
        near: about the offset in s, where several offsets fit equally well (a periodic signal).

    Raises:
        LogError: nothing correlates, too little overlaps, or several offsets fit equally well.
    """
    for track, name in ((a, "A"), (b, "B")):
        if not np.ptp(track.values) > 0.0:
            raise LogError(f"the signal never changes in log {name}", remedy=REMEDY)
    # The slower log is taken at its own times, so that it is not interpolated.
    if b.period > 1.01 * a.period:
        return _matched(b, a, near, -1.0).turned()
    return _matched(a, b, near, 1.0)


def _matched(
    a: Track,
    b: Track,
    near: float | None,
    sign: float,
) -> ClockMatch:
    """The match of two logs; the user's offset is the one found here times the sign."""
    line, width, independent = search_of_all(a, b, near, sign)
    period = a.period
    low, high = overlap_of(a, b, line)
    # From rows as coarse as the peak to A's own, each grid twice as fine as the last: a Newton step finds the summit
    # only from within the peak of its grid.
    width = min(width, 4.0 * (high - low) / _COARSEST)
    while width > 2.0 * period:
        line, _ = stepped(a, b, line, width / 4.0, flat)
        width /= 2.0
    line, _ = stepped(a, b, line, period, flat)
    line, _ = stepped(a, b, line, period, by_agreement)
    line, last = stepped(a, b, line, period, by_agreement)
    return _described(a, b, line, last, independent)


def _described(
    a: Track,
    b: Track,
    line: ClockLine,
    step: StepSeen,
    independent: float,
) -> ClockMatch:
    """The match with its intervals, by the scatter of the windows' scores.

    A window pulls the line towards itself: its score is that against the line of all other windows (jackknife, CR3 of
    MacKinnon and White 1985). A window at an end says most of the drift, so the degrees of freedom are fewer than
    windows (Satterthwaite; Bell and McCaffrey 2002).
    """
    from scipy.special import stdtrit

    # Windows of equal rows would leave some with nothing to say, and windows of equal information would be too wide
    # where the signal rests: half by the rows, half by the information.
    information = step.slope.clip(0.0)
    by_information = information.cumsum() / information.sum()
    by_rows = np.linspace(0.0, 1.0, step.time.size)
    share = 0.5 * (by_information + by_rows)
    window = np.minimum((share * WINDOWS).astype(np.int64), WINDOWS - 1)  # of each row

    def total(rows: Array) -> Array:
        """Sum over each window."""
        return np.asarray(np.bincount(window, rows, WINDOWS), np.float64)

    # The line in two numbers: its offset at `line.at`, and what its drift adds until the end.
    scale = 0.5 * (step.time[-1] - step.time[0])  # [s]
    along = (step.time - line.at) / scale
    scores = np.array([total(step.score), total(along * step.score)])  # shape (2, windows)
    constant = total(step.slope)
    linear = total(along * step.slope)
    square = total(along**2 * step.slope)
    information_by_place = np.array([[constant, linear], [linear, square]])
    each = information_by_place.transpose(2, 0, 1)  # of each window, shape (windows, 2, 2)
    of_all_windows = each.sum(axis=0)
    inverse = np.asarray(np.linalg.pinv(of_all_windows), np.float64)
    of_others = np.eye(2) - each @ inverse  # share of the information that all other windows have
    columns = scores.T[:, :, None]  # shape (windows, 2, 1)
    against = np.asarray(np.linalg.solve(of_others, columns), np.float64)
    moves = inverse @ against[:, :, 0].T  # of the line by each window, shape (2, windows)

    def half_width(direction: Array) -> float:
        """Half the 95 % interval of a sum of the line's two numbers."""
        shares = np.einsum("i,gij,j->g", inverse @ direction, each, inverse @ direction)
        freedom = float(shares.sum() ** 2 / (shares @ shares))
        variance = (1.0 - 1.0 / WINDOWS) * np.sum((direction @ moves) ** 2)
        return float(stdtrit(freedom, 0.975) * np.sqrt(variance))

    # The steps saw both signals scaled to a deviation of one.
    gain = step.gain * float(np.std(b.values)) / float(np.std(a.values))
    overlap = overlap_of(a, b, line)
    origin = overlap[0]
    offset = float(line.middle + line.drift * (origin - line.at))  # [s]
    offset_half = half_width(np.array([1.0, (origin - line.at) / scale]))
    drift_half = half_width(np.array([0.0, 1.0 / scale]))

    lively = constant > 0.1 * np.median(constant)  # windows whose own offset means something
    rows = np.maximum(np.bincount(window, minlength=WINDOWS), 1)
    centres = total(step.time) / rows  # [s]
    residuals = scores[0] / np.where(lively, constant, 1.0)  # [s]
    return ClockMatch(
        origin=origin,
        offset=offset,
        offset_interval=(offset - offset_half, offset + offset_half),
        drift=line.drift,
        drift_interval=(line.drift - drift_half, line.drift + drift_half),
        overlap=overlap,
        gain=gain,
        correlation=step.correlation,
        independent=independent,
        centres=centres[lively],
        residuals=residuals[lively],
    )
