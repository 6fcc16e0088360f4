"""The figures of a session grow as it runs: lateness, step time, events; in bounded memory, however long it runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import plural
from erclutch.signals.channels import LiveChannel
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.live.ring import RingReader

_BINS = 100_000  # of 1 us
_BEFORE = 1_000_000_000  # ns before a trip that are looked at
_BUSY = 3  # of these events within, and nobody can tell what is wrong from what came late
_TOLD = 0.05  # ms of lateness that are worth a word
_LOST, _OVERRUN, _TRIP = (EVENT_BITS[name] for name in ("sample-lost", "overrun", "trip"))


@dataclass
class Histogram:
    """Times in bins of 1 us, up to 0.1 s; the largest is kept as it is.

    Attributes:
        counts: how many in each bin, shape (100000,).
        largest: in us.
    """

    counts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(_BINS, np.int64))
    largest: float = 0.0

    def add(self, times_ns: NDArray[np.int64]) -> None:
        """Take more times."""
        if times_ns.size:
            us = np.clip(times_ns // 1000, 0, _BINS - 1).astype(np.int64)
            self.counts += np.bincount(us, minlength=_BINS)
            slowest = float(times_ns.max()) / 1e3  # [us]
            self.largest = max(self.largest, slowest)

    def percentiles(self, shares: Sequence[float]) -> list[float]:
        """Upper ends of the bins that hold these shares, in us; nan while it is empty."""
        total = self.counts.cumsum()
        if not total[-1]:
            return [float("nan")] * len(shares)
        ends: list[float] = []
        for share in shares:
            place = np.searchsorted(total, share * int(total[-1]))
            ends.append(min(float(place) + 1.0, self.largest))
        return ends

    def between(self, edges: Sequence[int]) -> list[int]:
        """How many lie below the first of some rising edges in us, between each two, and above the last."""
        below = self.counts.cumsum()[np.array(edges) - 1]
        counts = np.diff(below, prepend=0, append=self.counts.sum())
        return [int(count) for count in counts]


#: What is told of a time: median, 99 % and 99.9 %.
SHARES = (0.5, 0.99, 0.999)


@dataclass
class SessionFigures:
    """What one reader of a ring has seen.

    Attributes:
        reader: of the ring.
        role: of the channel that is to follow the reference; empty where none is.
        lateness, step: histograms of the wake-up's lateness and of the step's time.
        frames: how many were read.
        busy: that samples or steps came late just before the last trip, and who was at fault; empty where they did
            not.
    """

    reader: RingReader
    role: str = ""
    lateness: Histogram = field(default_factory=Histogram)
    step: Histogram = field(default_factory=Histogram)
    frames: int = 0
    busy: str = ""
    _squares: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    _estimates: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    # Rows of the last second.
    _last: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 3), np.int64))

    def poll(self) -> NDArray[Any]:
        """Take what is new; returns it."""
        new = self.reader.read()
        if new.size:
            self.lateness.add(new["lateness_ns"].astype(np.int64))
            self.step.add(new["step_ns"].astype(np.int64))
            self.frames += int(new.size)
            self._follow(new)
            self._estimate(new)
            self._explain_trips(new)
        return new

    @property
    def follower(self) -> LiveChannel | None:
        """The channel that is to follow the reference: of a pair's two angles the output's, which comes last."""
        return self._of_role(self.role)

    def _of_role(self, role: str) -> LiveChannel | None:
        return next(
            (channel for channel in reversed(self.reader.info.channels) if channel.role == role),
            None,
        )

    @property
    def effort(self) -> LiveChannel | None:
        """The channel of the measured effort; None where the device has none."""
        return self._of_role("effort")

    def _follow(self, new: NDArray[Any]) -> None:
        if self.follower is not None:
            self._squares += _squares_of(new["reference"], new[self.follower.name])

    def _estimate(self, new: NDArray[Any]) -> None:
        estimate = self._of_role("estimate")
        if self.effort is not None and estimate is not None:
            self._estimates += _squares_of(new[self.effort.name], new[estimate.name])

    def _explain_trips(self, new: NDArray[Any]) -> None:
        """At a trip say what came late in the second before it."""
        columns = (new["time_ns"], new["events"], new["lateness_ns"])
        rows = np.stack([column.astype(np.int64) for column in columns], axis=1)  # ns, bits, ns
        last = np.concatenate([self._last, rows])
        for tripped in rows[rows[:, 1] & _TRIP > 0, 0]:
            before = last[(last[:, 0] <= tripped) & (last[:, 0] > tripped - _BEFORE)]
            lost = int(np.count_nonzero(before[:, 1] & _LOST))
            overran = int(np.count_nonzero(before[:, 1] & _OVERRUN))
            self.busy = ""
            if np.count_nonzero(before[:, 1] & (_LOST | _OVERRUN)) >= _BUSY:
                latest = before[:, 2].max() / 1e6  # ms
                # Where no wake-up was late, a step took long.
                by = f", by up to {latest:.1f} ms" if latest >= _TOLD else ""
                late: list[str] = []
                if lost:
                    samples = f"{lost} {plural(lost, 'sample')} of the rig"
                    late.append(f"{samples} did not come in time")
                if overran:
                    late.append(f"{overran} {plural(overran, 'step')} came late{by}")
                told = f"in the second before, {' and '.join(late)}"
                # A program of ours that plays the rig needs this machine, too; a device does not.
                without = before[before[:, 1] & _LOST > 0]
                on_time = without[without[:, 2] < self.reader.info.period_ns]
                device_silent = 2 * len(on_time) > len(without)
                if device_silent and self.reader.info.origin == "HARDWARE":
                    self.busy = f"The rig was silent: {told}. Look at the rig, its supply and its cable first."
                else:
                    self.busy = f"This machine was busy: {told}. Close other programs first."
        self._last = last[last[:, 0] > rows[-1, 0] - _BEFORE]

    @property
    def followed(self) -> tuple[float, float] | None:
        """How far the channel was off its reference, and the reference itself, RMS; None where nothing follows."""
        return _rms_of(self._squares)

    @property
    def estimated(self) -> tuple[float, float] | None:
        """How far the estimate was off the measured effort, and this effort itself, RMS; None where either lacks."""
        return _rms_of(self._estimates)

    def rows(self) -> list[list[str]]:
        """Lateness and step time as rows of a table, in us."""
        rows: list[list[str]] = []
        for name, times in (("wake-up after its deadline", self.lateness), ("step", self.step)):
            figures = [*times.percentiles(SHARES), times.largest]
            rows.append([name, *(f"{figure:.0f}" for figure in figures)])
        return rows


def _squares_of(wanted: NDArray[Any], got: NDArray[Any]) -> tuple[float, float, int]:
    """Sums of squares of the difference and of what was wanted, and how many frames have both."""
    finite = np.isfinite(wanted) & np.isfinite(got)
    off = wanted[finite] - got[finite]
    square_off = float((off**2).sum())
    square = float((wanted[finite] ** 2).sum())
    return square_off, square, off.size


def _rms_of(squares: NDArray[np.float64]) -> tuple[float, float] | None:
    off, whole, count = squares.tolist()
    if not count:
        return None
    return (off / count) ** 0.5, (whole / count) ** 0.5
