"""Beside the curves a ring tells events with their counts, how late the loop woke up, and whether it still runs."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from erclutch.wings.live.layout import EVENT_BITS, EVENTS
from erclutch.wings.live.ring import RingReader, State
from erclutch.wings.live.session_figures import SHARES, Histogram, SessionFigures

#: Upper edges of the histogram's bars in us; the last bar holds all above.
EDGES = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000)
_SILENT = 0.1  # s without a frame
_JOINED = 0.5  # s: an event that comes again within goes to the same line
_KEPT = 300  # lines
_BAD = ("sample-lost", "sample-invalid", "glitch")
#: A bad sample has one line: that the command was held for its want follows from it.
_HOLD = np.uint32(EVENT_BITS["hold"])
_DOUBTED = tuple(name for name in EVENT_BITS if name.endswith("-doubted"))
_BAD_SAMPLE = np.uint32(sum(EVENT_BITS[name] for name in {*_BAD, *_DOUBTED}))
#: How an event is shown: what fails safe, what is worth a look, what is only told.
_ALARMS = {"trip", "rig-watchdog", "rig-fault", "both-fields", "send-failed", "command-not-finite"}
_NOTES = {"order", "wrap", "stopping", "rate-limited"}


def level_of(event: str) -> str:
    """Alarm, warning or note."""
    if event in _ALARMS:
        return "alarm"
    return "note" if event in _NOTES else "warning"


@dataclass
class EventLine:
    """A line of the log of events.

    Attributes:
        number: of the line; a client that has seen up to ``version`` needs what is newer.
        version: grows with each change of any line.
        name, text, level: what it says; level is alarm, warning or note.
        first, last: s since the start of the session.
        count: how often.
    """

    number: int
    version: int
    name: str
    text: str
    level: str
    first: float
    last: float
    count: int

    def body(self) -> dict[str, Any]:
        """As JSON values."""
        return {**asdict(self), "first": round(self.first, 3), "last": round(self.last, 3)}


def _told(times: Histogram) -> dict[str, Any]:
    """Percentiles in us and the histogram's bars, as JSON values."""
    count = int(times.counts.sum())
    names = ("p50", "p99", "p999") if count else ()
    figures = dict(zip(names, times.percentiles(SHARES), strict=False))
    return {"count": count, **figures, "max": round(times.largest, 1), "bars": times.between(EDGES)}


class Watcher:
    """Follows a ring. Call `look` some twenty times a second.

    Args:
        reader: a reader of its own.
    """

    def __init__(self, reader: RingReader) -> None:
        self.reader, self._figures = reader, SessionFigures(reader)
        self.version = 0
        self._lines: deque[EventLine] = deque(maxlen=_KEPT)
        self._open: dict[str, EventLine] = {}
        self._head = reader.head
        self._moved = time.monotonic()

    def look(self) -> None:
        """Take in the frames that came."""
        frames = self._figures.poll()
        if self.reader.head != self._head:
            self._head = self.reader.head
            self._moved = time.monotonic()
        if not frames.size:
            return
        without_hold = frames["events"] & ~_HOLD
        events = np.where(frames["events"] & _BAD_SAMPLE, without_hold, frames["events"])
        present = int(np.bitwise_or.reduce(events))
        if not present:
            return
        since = frames["time_ns"].astype(np.int64) - self.reader.info.start_ns
        seconds = since * 1e-9
        for bit, (name, meaning) in enumerate(EVENTS):
            if present >> bit & 1:
                hit = np.flatnonzero(events >> np.uint32(bit) & 1)
                first = float(seconds[hit[0]])
                last = float(seconds[hit[-1]])
                self._log(name, meaning, level_of(name), first, last, int(hit.size))

    def say(self, text: str, at: int, level: str = "note") -> None:
        """A line that is no event of the loop, with its time by the monotonic clock in ns."""
        self._open.pop("session", None)
        seconds = (at - self.reader.info.start_ns) * 1e-9
        self._log("session", text, level, seconds, seconds, 1)

    def _log(
        self,
        name: str,
        text: str,
        level: str,
        first: float,
        last: float,
        count: int,
    ) -> None:
        self.version += 1
        line = self._open.get(name)
        if line is not None and first - line.last <= _JOINED:
            line.last, line.count, line.version = last, line.count + count, self.version
            return
        number = self._lines[-1].number + 1 if self._lines else 0
        line = EventLine(number, self.version, name, text, level, first, last, count)
        self._open[name] = line
        self._lines.append(line)

    def lines(self, seen: int) -> list[dict[str, Any]]:
        """Lines that changed after version ``seen``."""
        return [line.body() for line in self._lines if line.version > seen]

    @property
    def state(self) -> str:
        """starting, running, tripped, ready, stopped, or silent: the loop says that it runs, but no frame comes."""
        state = self.reader.state
        runs = state not in (State.STARTING, State.STOPPED)
        if runs and time.monotonic() - self._moved > _SILENT:
            return "silent"
        return state.name.lower()

    def status(self) -> dict[str, Any]:
        """All but the lines, as JSON values."""
        reader = self.reader
        return {
            "state": self.state,
            "trip": reader.trip_reason,
            "doubt": reader.doubt,
            "busy": self._figures.busy,
            "realtime": reader.realtime,
            "program": reader.program,
            "missed": reader.missed,
            "head": reader.head,
            "counts": {name: count for name, count in reader.counts.items() if count},
            "lateness": _told(self._figures.lateness),
            "step": _told(self._figures.step),
        }
