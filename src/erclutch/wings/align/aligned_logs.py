"""Two logs of one experiment on two clocks become one log: A's rows, and B's columns on A's clock."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError, MappingError, placed
from erclutch.logs import map_over, table_of
from erclutch.logs.applied import apply, runs_of
from erclutch.logs.clock_planning import clock_plan
from erclutch.logs.columns import locate
from erclutch.logs.log_writer import write_log
from erclutch.logs.mapping import ColumnChoice, ColumnMap, beside
from erclutch.logs.planning import plan_of
from erclutch.logs.table import Table
from erclutch.logs.timing import LogClock
from erclutch.signals.array import Array, Mask
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import Recording
from erclutch.signals.shown import Shown, one_line
from erclutch.wings.align.clock_match import ClockMatch, match_clocks
from erclutch.wings.align.track import Track, track_of

if TYPE_CHECKING:
    from pandas import DataFrame

    from erclutch.report.notebook import Card

_TIME = "time"
_DIGITS = 1e-9  # of a number in a text file, as a share
_FINE = 0.02  # of a period that a stamp may be off in a text file


@dataclass(frozen=True, repr=False)
class AlignedLogs(Shown):
    """Two logs as one, and how their clocks were matched.

    Attributes:
        matches: B's clock against A's; one for each run of B's clock, which a restart ends.
        joined: A's columns with B's beside them at A's times, in the logs' own units; rows without B are left out.
        signal: names of the column that both logs have, in A and in B.
        traces: that column by A, and by B for each match, on the clocks of their own.
        notes: what was chosen, matched, renamed and left out, one sentence each.
    """

    matches: tuple[ClockMatch, ...]
    joined: Table
    signal: tuple[str, str]
    traces: tuple[Track, tuple[Track, ...]]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return one_line(self, self.joined.name, f"{self.joined.rows} rows", *(said(match) for match in self.matches))

    def notebook_card(self) -> Card:
        """What a notebook shows: each match with its intervals."""
        from erclutch.report.notebook import Card, as_frame, rows_as_frame, titled_column
        from erclutch.wings.align.clocks_plot import describe_clocks

        header = ("offset_s", "offset_low", "offset_high", "drift_ppm", "drift_low", "drift_high")
        rows = [
            (m.offset, *m.offset_interval, *(1e6 * drift for drift in (m.drift, *m.drift_interval)))
            for m in self.matches
        ]
        columns, units = self.joined.columns, self.joined.units
        return Card(
            self.joined.name,
            lambda: rows_as_frame(header, rows),
            badge=self.joined.origin,
            says=lambda: self.notes,
            frame=lambda: as_frame({titled_column(n, units.get(n)): x for n, x in columns.items()}, "time [s]"),
            plots={"clocks": partial(describe_clocks, self.matches, self.traces, self.signal[0], self.joined.origin)},
        )

    @property
    def offset(self) -> float:
        """What B's clock shows more than A's at the first time that both have, in s."""
        return self.matches[0].offset

    @property
    def drift_ppm(self) -> float:
        """How much faster B's clock runs, in millionths."""
        return 1e6 * self.matches[0].drift

    def recording(self, mapping: ColumnMap | None = None, *, device: DeviceName = "single") -> Recording:
        """The log as a Recording; ``mapping`` says which column is which signal, as for `erclutch.read`.

        Raises:
            MappingError, LogError: see `erclutch.read`.
        """
        own = replace(mapping or ColumnMap(), time=ColumnChoice(_TIME, "s", source="two clocks"), rate=None)
        return apply(plan_of(self.joined, own, device=device), self.joined)

    def write(self, path: str | Path) -> Path:
        """Write the log as .csv, .parquet or .mat, whole or not at all.

        Raises:
            RunError: it cannot be written.
        """
        columns = dict(self.joined.columns)
        period = float(np.median(np.diff(columns[_TIME])))
        if float(np.abs(columns[_TIME]).max()) * _DIGITS > _FINE * period:  # seconds since 1970, say
            columns[_TIME] = columns[_TIME] - columns[_TIME][0]
        labels = [(name.replace(",", " ").replace('"', " "), self.joined.units.get(name) or "") for name in columns]
        rows = np.column_stack(list(columns.values()))
        clocks = [{"offset_s": m.offset, "origin_s": m.origin, "drift_ppm": 1e6 * m.drift} for m in self.matches]
        label = {"label": self.joined.origin} if self.joined.origin else {}
        return write_log(path, labels, [rows], {**label, "aligned": self.joined.name, "clocks": clocks}, rows=len(rows))


def align(
    a: str | Path | DataFrame,
    b: str | Path | DataFrame,
    on: str | Sequence[str] = (),
    *,
    near: float | None = None,
    times: Sequence[Mapping[str, Any] | None] = (None, None),
) -> AlignedLogs:
    """Join two logs of one experiment whose clocks differ, by a signal that both have.

    Args:
        a: a file or a DataFrame (see `read`): the log whose clock and rows are kept.
        b: the log whose columns are brought to them.
        on: the column of that signal: one name for both, or A's and B's; by default the only name that both have.
        near: about what B's clock shows more than A's, in s, where several offsets fit equally well.
        times: for A and for B what is not guessed of its time, such as ``{"rate": 1000}``.

    Raises:
        LogError: a log cannot be read, nothing correlates, or several offsets fit equally well.
        MappingError: no such column.
    """
    own, others = (beside(Path(log)) if isinstance(log, str | Path) else None for log in (a, b))
    one, other = (table_of(log, None if its is None else its.variable) for log, its in ((a, own), (b, others)))
    if one.digest == other.digest:
        raise LogError("both are the same log", where=other.name, remedy="Give two logs of one experiment")
    if one.name == other.name:
        one, other = replace(one, name=f"{one.name} A"), replace(other, name=f"{other.name} B")
    maps = map_over(times[0], own), map_over(times[1], others)
    return align_tables(one, other, (on,) if isinstance(on, str) else on, maps=maps, near=near)


def align_tables(
    a: Table, b: Table, on: Sequence[str] = (), *, maps: tuple[ColumnMap, ColumnMap], near: float | None = None
) -> AlignedLogs:
    """Match the clocks of two logs and join them.

    Args:
        a: the log whose clock and rows are kept.
        b: the log whose columns are brought to them.
        on: the column that both have: one name, or A's and B's; empty where just one name is in both.
        maps: what is known of time or rate of A and of B.
        near: about the offset in s, where several fit equally well.

    Raises:
        MappingError: no such column, or A's clock restarts; LogError: see `match_clocks`.
    """
    (runs_a, clocks_a, notes_a), (runs_b, clocks_b, notes_b) = (
        _runs(log, told) for log, told in zip((a, b), maps, strict=True)
    )
    if len(runs_a) > 1:
        problem = f"the clock restarts {len(runs_a) - 1} times"
        raise MappingError(
            problem, where=a.name, remedy="Give the log whose clock runs through first, or split this log"
        )
    names, factors = _shared(a, b, on, clocks_a, clocks_b)
    rows_a, clock_a = runs_a[0]
    with placed(a.name):
        first = track_of(clock_a.time, factors[0] * a.columns[names[0]][rows_a], clock_a.period)
    with placed(b.name):
        seconds = [track_of(clock.time, factors[1] * b.columns[names[1]][rows], clock.period) for rows, clock in runs_b]
    with placed(f"{a.name} and {b.name}"):
        matches = tuple(match_clocks(first, second, near=near) for second in seconds)
    moved: dict[str, Array] = {name: np.full(clock_a.time.size, np.nan) for name in b.columns if name not in clocks_b}
    there = np.zeros(clock_a.time.size, np.bool_)
    for match, (rows, clock) in zip(matches, runs_b, strict=True):
        wanted = match.on_b(clock_a.time)
        within = _sampled(clock.time, clock.time, clock.period, wanted, clock_a.period)[1]
        there |= within
        for name, values in moved.items():
            found, fine = _sampled(clock.time, b.columns[name][rows], clock.period, wanted, clock_a.period)
            values[within] = np.where(fine, found, np.nan)[within]
    table, renamed = _joined(
        a, b, clock_a.time, {n: v[rows_a] for n, v in a.columns.items() if n not in clocks_a}, moved, there
    )
    notes = [f"{t.name}: {note}" for t, own in ((a, notes_a), (b, notes_b)) for note in dict.fromkeys(own)]
    both = " and ".join(dict.fromkeys(names))
    notes += [f"clock of {b.name} against {a.name} by {both}: {said(match)}" for match in matches]
    if lost := int((~there).sum()):
        notes.append(f"{lost:,} rows of {a.name} left out: {b.name} has none there, or none around a filter's reach")
    if renamed:
        notes.append(f"columns of {b.name} renamed: " + ", ".join(f"{old} is {new}" for old, new in renamed.items()))
    table = replace(table, notes=(*a.notes, *b.notes, *notes))
    return AlignedLogs(matches, table, names, (first, tuple(seconds)), tuple(notes))


def said(match: ClockMatch) -> str:
    """Offset and drift with their intervals, in a phrase."""
    half, wide = (0.5e3 * (high - low) for low, high in (match.offset_interval, match.drift_interval))
    return (
        f"offset {1e3 * match.offset:.4f} ms (+- {half:.4f}) at {match.origin:.6g} s, "
        f"drift {1e6 * match.drift:.2f} ppm (+- {1e3 * wide:.2f})"
    )


def _runs(log: Table, told: ColumnMap) -> tuple[list[tuple[NDArray[np.int64], LogClock]], set[str], list[str]]:
    """See `erclutch.logs.applied.runs_of`."""
    with placed(log.name):
        return runs_of(clock_plan(log, told, ()), log)


def _shared(
    a: Table, b: Table, on: Sequence[str], clocks_a: set[str], clocks_b: set[str]
) -> tuple[tuple[str, str], tuple[float, float]]:
    """The column of each log that both have, and the sign to take it with.

    Raises:
        MappingError: none or several, or no such column.
    """
    if len(on) > 2:
        raise MappingError(f"--on has {len(on)} names", remedy="Give one name, or that of A and that of B")
    if not on:
        both = [name for name in a.columns if name in b.columns and name not in clocks_a | clocks_b]
        if len(both) != 1:
            listed = f"share the columns {', '.join(both)}" if both else "share no column by its name"
            problem = f"the logs {listed}; {a.name} has {a.listed}; {b.name} has {b.listed}"
            raise MappingError(problem, remedy="Say which signal both have: --on NAME, or --on NAME_IN_A NAME_IN_B")
        on = both
    found: list[tuple[str, float]] = []
    for table, label, clocks in zip((a, b), (on[0], on[-1]), (clocks_a, clocks_b), strict=True):
        with placed(table.name):
            name, _, factor = locate(table, ColumnChoice(label), "on")
            if name in clocks:
                raise MappingError(f"column {name} is the log's own time", remedy="Choose a measured signal with --on")
        found.append((name, factor))
    return (found[0][0], found[1][0]), (found[0][1], found[1][1])


def _sampled(time: Array, values: Array, period: float, wanted: Array, coarse: float) -> tuple[Array, Mask]:
    """A column at the times that are wanted, and where it has any."""
    if np.isfinite(values).sum() < 2:
        return np.full(wanted.size, np.nan), np.zeros(wanted.size, np.bool_)
    return track_of(time, values, period).sampler(coarse, plain=True)(wanted)


def _joined(
    a: Table, b: Table, time: Array, own: Mapping[str, Array], moved: Mapping[str, Array], there: Mask
) -> tuple[Table, dict[str, str]]:
    """One table of both logs' columns, and what columns of B are called in it."""
    columns, units = {_TIME: time}, dict[str, str | None]({_TIME: "s"})
    renamed: dict[str, str] = {}
    for table, each, mark in ((a, own, "_A"), (b, moved, "_B")):
        for name, values in each.items():
            new = name
            while new in columns:
                new += mark
            columns[new], units[new] = values, table.units.get(name)
            if new != name and table is b:
                renamed[name] = new
    digest = hashlib.sha256(f"{a.digest} {b.digest}".encode()).hexdigest()
    metadata: dict[str, Any] = {"erclutch": json.dumps({"label": a.origin or b.origin})} if a.origin or b.origin else {}
    kept = {name: values[there] for name, values in columns.items()}
    constants = {**b.constants, **a.constants}
    return Table(f"{a.name} + {b.name}", kept, units, digest, constants=constants, metadata=metadata), renamed
