"""Signals have names, units and meanings; a Recording carries them.

The vocabulary is that of the design: field, slip, effort, theta, alpha. A log's own column names end at the mapping.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from erclutch.signals.array import Array
from erclutch.signals.device import SPEED_OF
from erclutch.signals.full_turns import ROUNDED
from erclutch.signals.shown import Shown, one_line


@dataclass(frozen=True)
class SignalKind:
    """What a signal means and which SI units it may be converted to.

    Attributes:
        name: the name used in mappings, run folders and reports.
        meaning: one phrase for people.
        si_units: the units, one of which the signal is converted to; the first that fits the log's unit is taken.
        if_named: further ones, for a column that the user names: no column is guessed to be the signal for them.
    """

    name: str
    meaning: str
    si_units: tuple[str, ...]
    if_named: tuple[str, ...] = ()


#: Begins the note of a log without a field; its field is written as 0 in all rows.
NO_FIELD = "no field is logged"
#: Stands in the note of rows that are left out.
CUT_THERE = "the log cut there"

#: A field is a voltage, a current, what they are over a length, or a flux density.
SI_UNITS_OF_FIELDS = ("V", "A", "V/m", "T", "A/m")
_FIELD_UNITS = ("", *SI_UNITS_OF_FIELDS)

SIGNALS: Mapping[str, SignalKind] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            # The gap of a magnet sets an eddy-current brake, and a load or a pressure a dry one.
            SignalKind(
                "field", "command to the fluid of a single element", _FIELD_UNITS, ("m", "N", "Pa")
            ),
            # The fluid of a valve flows through a gap that stands still.
            SignalKind(
                "slip",
                "relative speed across the element's fluid, or the flow rate of a valve",
                ("rad/s", "m/s", "1/s"),
                ("m^3/s",),
            ),
            SignalKind("position", "relative position across the element's fluid", ("rad", "m")),
            SignalKind(
                "effort",
                "torque or force that the device transmits, or the pressure drop of a valve",
                ("N*m", "N", "Pa"),
            ),
            SignalKind("E1", "field of clutch CH1", _FIELD_UNITS),
            SignalKind("E2", "field of clutch CH2", _FIELD_UNITS),
            SignalKind("E", "signed field: positive drives CH1, negative CH2", _FIELD_UNITS),
            SignalKind("theta", "angle of the motor", ("rad",)),
            SignalKind("theta_dot", "speed of the motor", ("rad/s",)),
            SignalKind("alpha", "angle of the output", ("rad",)),
            SignalKind("alpha_dot", "speed of the output", ("rad/s",)),
            SignalKind("alpha_raw", "position of the table on the screw", ("m",)),
            SignalKind("T", "torque that the pair transmits", ("N*m",)),
            SignalKind("motor_torque", "torque that the motor is commanded", ("N*m",)),
        )
    }
)

#: A further input: the temperature of the fluid, in K whatever the log has.
TEMPERATURE = "temperature_K"
#: A further input: the position that is logged beside the slip, in the unit whose rate the slip has.
POSITION = "position"
#: What a mapping may give a column to.
NAMED_COLUMNS = (*SIGNALS, "temperature")


class LogFacts(Protocol):
    """What is said of a log that was read, whether all of its rows are in memory or not; see `Recording`."""

    @property
    def name(self) -> str:
        """What it is called in tables."""
        ...

    @property
    def digest(self) -> str:
        """SHA-256 of its bytes."""
        ...

    @property
    def rows(self) -> int:
        """Number of samples."""
        ...

    @property
    def segments(self) -> tuple[tuple[int, int], ...]:
        """Rows of each stretch without a gap."""
        ...

    @property
    def period(self) -> float:
        """Sampling period in s."""
        ...

    @property
    def duration(self) -> float:
        """Recorded time in s, gaps left out."""
        ...

    @property
    def origin(self) -> str:
        """The label that the file gives itself."""
        ...

    @property
    def mapping(self) -> tuple[str, str] | None:
        """Name and SHA-256 of its mapping file."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What was done on the way."""
        ...


@dataclass(frozen=True, repr=False)
class Recording(Shown):
    """A log after reading: signals in SI units on one clock, cut into segments without gaps.

    Attributes:
        name: what the log is called in tables (the file's name).
        signals: signal name -> samples, shape (n,), float64, read-only, all finite.
        units: signal name -> SI unit as text; "" is dimensionless, "?" is unknown (taken as logged).
        time: time of each sample in s, shape (n,), strictly increasing inside each segment.
        period: the sampling period in s (the median step).
        segments: half-open row ranges, in order, covering all rows; no gap inside one.
        uniform: whether the steps inside segments are equal up to the rounding of the time column.
        digest: SHA-256 of the file's bytes, hexadecimal.
        constants: numbers that hold for the whole log (from its name, its header or the mapping).
        origin: "TWIN", "SYNTHETIC" or another label that the file gives itself; "" for a measurement.
        extras: further inputs for networks, as logged (`TEMPERATURE` in K): name -> samples, shape (n,).
        extra_units: further input or spare column -> its unit as logged; "?" is unknown.
        spare: further columns that nothing has taken, in the same way.
        notes: what was guessed, converted, dropped or split, one sentence each, to be shown to the user.
        mapping: name and SHA-256 of the mapping file that said which column is which, if there was one.
        told: the keywords that `erclutch.read` was given, which a run keeps for the next logs.
    """

    name: str
    signals: Mapping[str, Array]
    units: Mapping[str, str]
    time: Array
    period: float
    segments: tuple[tuple[int, int], ...]
    uniform: bool
    digest: str
    constants: Mapping[str, float] = field(default_factory=dict[str, float])
    origin: str = ""
    extras: Mapping[str, Array] = field(default_factory=dict[str, Array])
    extra_units: Mapping[str, str] = field(default_factory=dict[str, str])
    spare: Mapping[str, Array] = field(default_factory=dict[str, Array])
    notes: tuple[str, ...] = ()
    mapping: tuple[str, str] | None = None
    told: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def __repr__(self) -> str:
        extent = f"{self.duration:.4g} s at {1.0 / self.period:.4g} Hz"
        words = [f"{self.rows} rows", extent]
        if len(self.segments) > 1:
            words.append(f"{len(self.segments)} stretches")
        for name in list(self.signals)[:8]:
            unit = self.units.get(name)
            words.append(f"{name} [{unit}]" if unit else name)
        return one_line(self, self.name, *words)

    def __getstate__(self) -> dict[str, object]:
        """For copies and other processes: views of mappings as mappings."""
        return {k: dict(v) if isinstance(v, Mapping) else v for k, v in vars(self).items()}  # pyright: ignore[reportUnknownArgumentType]

    def __setstate__(self, state: dict[str, object]) -> None:
        """Read-only again."""
        for name, value in state.items():
            for part in value.values() if isinstance(value, dict) else (value,):  # pyright: ignore[reportUnknownVariableType]
                if isinstance(part, np.ndarray):
                    part.setflags(write=False)
            kept = MappingProxyType(value) if isinstance(value, dict) else value  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
            object.__setattr__(self, name, kept)

    @property
    def rows(self) -> int:
        """Number of samples."""
        return int(self.time.size)

    @property
    def duration(self) -> float:
        """Recorded time in s, gaps left out."""
        # The last row of a segment lasts a period too.
        total = 0.0
        for start, stop in self.segments:
            total += float(self.time[stop - 1] - self.time[start] + self.period)
        return total

    def only(self, segments: Sequence[tuple[int, int]]) -> Recording:
        """The recording with some of its segments or their parts, [start, stop) each."""
        rows = np.concatenate([np.arange(start, stop) for start, stop in segments])
        lengths = [stop - start for start, stop in segments]
        edges = np.cumsum([0, *lengths]).tolist()
        return replace(
            self,
            signals={name: values[rows] for name, values in self.signals.items()},
            extras={name: values[rows] for name, values in self.extras.items()},
            spare={name: values[rows] for name, values in self.spare.items()},
            time=self.time[rows],
            segments=tuple(pairwise(edges)),
        )

    def without_jumps(self) -> Recording:
        """The recording with each angle drawn out whose sensor starts again after a full turn: its jump is no motion.

        Only angles in rad whose speed is not logged are looked at; a note says how often such an angle starts again.
        """
        signals = dict(self.signals)
        notes: list[str] = []
        for position, speed in SPEED_OF.items():
            angle = signals.get(position)
            if angle is None or speed in signals or self.units.get(position) != "rad":
                continue
            parts = [angle[start:stop] for start, stop in self.segments]
            turns = sum(int(np.count_nonzero(np.abs(np.diff(part)) > np.pi)) for part in parts)
            goes_beyond = np.ptp(angle) > 2.0 * np.pi * (1.0 + ROUNDED)
            if turns and not goes_beyond:
                signals[position] = np.concatenate([np.unwrap(part) for part in parts])
                anew = f"{position} starts again after a full turn, {turns} times"
                notes.append(f"{anew}: drawn out without jumps")
        return replace(self, signals=signals, notes=(*self.notes, *notes)) if notes else self
