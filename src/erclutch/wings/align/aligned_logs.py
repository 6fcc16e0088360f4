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

from erclutch.errors import LogError, MappingError, placed
from erclutch.logs import map_over, table_of_log
from erclutch.logs.applied import apply, clocked_runs
from erclutch.logs.clock.timing import LogClock
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.log_writer import write_log
from erclutch.logs.mapping import ColumnChoice, ColumnMap, file_mapping
from erclutch.logs.planning.clock_planning import clock_plan
from erclutch.logs.planning.named_columns import locate
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.readers.found_recordings import turn_after_which_it_starts_again
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask, largest_size
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
        return one_line(
            self,
            self.joined.name,
            f"{self.joined.rows} rows",
            *(in_words(match) for match in self.matches),
        )

    def notebook_card(self) -> Card:
        """What a notebook shows: each match with its intervals."""
        from erclutch.report.notebook import Card, as_frame, rows_as_frame, titled_column
        from erclutch.wings.align.clocks_plot import describe_clocks

        header = ("offset_s", "offset_low", "offset_high", "drift_ppm", "drift_low", "drift_high")
        rows: list[tuple[float, ...]] = []
        for match in self.matches:
            drifts_ppm = (1e6 * drift for drift in (match.drift, *match.drift_interval))
            rows.append((match.offset, *match.offset_interval, *drifts_ppm))
        columns = self.joined.columns
        units = self.joined.units
        titled = {titled_column(name, units.get(name)): values for name, values in columns.items()}
        signal = self.signal[0]
        return Card(
            self.joined.name,
            lambda: rows_as_frame(header, rows),
            badge=self.joined.origin,
            says=lambda: self.notes,
            frame=lambda: as_frame(titled, "time [s]"),
            plots={
                "clocks": partial(
                    describe_clocks, self.matches, self.traces, signal, self.joined.origin
                )
            },
        )

    @property
    def offset(self) -> float:
        """What B's clock shows more than A's at the first time that both have, in s."""
        return self.matches[0].offset

    @property
    def drift_ppm(self) -> float:
        """How much faster B's clock runs, in millionths."""
        return 1e6 * self.matches[0].drift

    def recording(
        self, mapping: ColumnMap | None = None, *, device: DeviceName = "single"
    ) -> Recording:
        """The log as a Recording; ``mapping`` says which column is which signal, as for `erclutch.read`.

        Raises:
            MappingError, LogError: see `erclutch.read`.
        """
        time = ColumnChoice(_TIME, "s", source="two clocks")
        own = replace(mapping or ColumnMap(), time=time, rate=None)
        return apply(plan_of(self.joined, own, device=device), self.joined)

    def write(self, path: str | Path) -> Path:
        """Write the log as .csv, .parquet or .mat, whole or not at all.

        Raises:
            RunError: it cannot be written.
        """
        columns = dict(self.joined.columns)
        time = columns[_TIME]
        period = float(np.median(np.diff(time)))  # [s]
        rounding = largest_size(time) * _DIGITS  # [s]
        if rounding > _FINE * period:  # seconds since 1970, say
            columns[_TIME] = time - time[0]

        units = self.joined.units
        labels: list[tuple[str, str]] = []  # a label of a .csv holds no comma and no quote
        for name in columns:
            plain = name.replace(",", " ").replace('"', " ")
            labels.append((plain, units.get(name) or ""))
        rows = np.column_stack(list(columns.values()))
        metadata: dict[str, Any] = {}
        if self.joined.origin:
            metadata["label"] = self.joined.origin
        metadata["aligned"] = self.joined.name
        metadata["clocks"] = [
            {"offset_s": match.offset, "origin_s": match.origin, "drift_ppm": 1e6 * match.drift}
            for match in self.matches
        ]
        return write_log(path, labels, [rows], metadata, rows=len(rows))


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
        times: for A and for B what is not guessed of its time, such as ``{"rate": 1000}``; of a file that holds several
            recordings which is meant (``{"variable": "Run 2"}``), where more than one is a log of a device, or none.

    Raises:
        LogError: a log cannot be read, nothing correlates, or several offsets fit equally well.
        MappingError: no such column.
    """
    table_a, map_a = _opened(a, times[0])
    table_b, map_b = _opened(b, times[1])
    if table_a.digest == table_b.digest:
        raise LogError(
            "both are the same log", where=table_b.name, remedy="Give two logs of one experiment"
        )
    if table_a.name == table_b.name:
        table_a = replace(table_a, name=f"{table_a.name} A")
        table_b = replace(table_b, name=f"{table_b.name} B")
    names = (on,) if isinstance(on, str) else on
    return align_tables(table_a, table_b, names, maps=(map_a, map_b), near=near)


def _opened(log: str | Path | DataFrame, said: Mapping[str, Any] | None) -> tuple[Table, ColumnMap]:
    """A log's table, and what is known of it: what was said goes over the mapping beside its file."""
    known = map_over(said, file_mapping(log))
    return table_of_log(log, known, None, known.variable), known


def align_tables(
    a: Table,
    b: Table,
    on: Sequence[str] = (),
    *,
    maps: tuple[ColumnMap, ColumnMap],
    near: float | None = None,
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
    map_a, map_b = maps
    with placed(a.name):
        plan_a = clock_plan(seen_columns(a), map_a, ())
        runs_a, clocks_a, notes_a = clocked_runs(plan_a, a)
    with placed(b.name):
        plan_b = clock_plan(seen_columns(b), map_b, ())
        runs_b, clocks_b, notes_b = clocked_runs(plan_b, b)
    if len(runs_a) > 1:
        raise MappingError(
            f"the clock restarts {len(runs_a) - 1} times",
            where=a.name,
            remedy="Give the log whose clock runs through first, or split this log",
        )
    signal_a, signal_b = _shared(a, b, on, clocks_a, clocks_b)
    rows_a, clock_a = runs_a[0]
    with placed(a.name):
        track_a = track_of(clock_a.time, signal_a.of(a)[rows_a], clock_a.period)
    with placed(b.name):
        values_b = signal_b.of(b)
        tracks_b = tuple(
            track_of(clock.time, values_b[rows], clock.period) for rows, clock in runs_b
        )
    with placed(f"{a.name} and {b.name}"):
        matches = tuple(match_clocks(track_a, track_b, near=near) for track_b in tracks_b)

    own = {name: values[rows_a] for name, values in a.columns.items() if name not in clocks_a}
    count = clock_a.time.size
    moved: dict[str, Array] = {}  # columns of B at A's times
    # A full turn of each of them that starts again after it, in its unit.
    turns: dict[str, float] = {}
    for name, values in b.columns.items():
        if name in clocks_b:
            continue
        moved[name] = np.full(count, np.nan)
        known = values[np.isfinite(values)]
        turn = turn_after_which_it_starts_again(name, b.units.get(name), known)
        if turn is not None:
            turns[name] = turn
    there = np.zeros(count, np.bool_)  # rows of A that B has
    for match, (rows, clock) in zip(matches, runs_b, strict=True):
        wanted = match.on_b(clock_a.time)  # [s], on B's clock
        _, within = _sampled(clock, clock.time, wanted, clock_a.period)
        there |= within
        for name, column in moved.items():
            turn = turns.get(name)
            of_run = b.columns[name][rows]
            if turn is not None:
                of_run = _drawn_out(of_run, turn)
            values, finite = _sampled(clock, of_run, wanted, clock_a.period)
            if turn is not None:  # within the same turn as in B
                least = float(np.nanmin(b.columns[name]))
                values = least + np.mod(values - least, turn)
            column[within] = np.where(finite, values, np.nan)[within]
    table, renamed = _joined(a, b, clock_a.time, own, moved, there)

    notes: list[str] = []
    for log, words in ((a, notes_a), (b, notes_b)):
        notes += [f"{log.name}: {note}" for note in dict.fromkeys(words)]
    names = signal_a.name, signal_b.name
    by = " and ".join(dict.fromkeys(names))
    notes += [f"clock of {b.name} against {a.name} by {by}: {in_words(match)}" for match in matches]
    lost = int(np.count_nonzero(~there))
    if lost:
        notes.append(
            f"{lost:,} rows of {a.name} left out: {b.name} has none there, or none around a filter's reach"
        )
    if turns:
        notes.append(
            f"columns of {b.name} brought over along the shorter way where they start again after a full turn: "
            f"{', '.join(turns)}"
        )
    if renamed:
        listed = ", ".join(f"{old} is {new}" for old, new in renamed.items())
        notes.append(f"columns of {b.name} renamed: {listed}")
    table = replace(table, notes=(*a.notes, *b.notes, *notes))
    return AlignedLogs(matches, table, names, (track_a, tracks_b), tuple(notes))


def in_words(match: ClockMatch) -> str:
    """Offset and drift with their intervals, in a phrase."""
    low, high = match.offset_interval  # [s]
    slowest, fastest = match.drift_interval
    offset_half = 0.5e3 * (high - low)  # [ms]
    drift_half = 1e3 * (0.5e3 * (fastest - slowest))  # [ppm]
    return (
        f"offset {1e3 * match.offset:.4f} ms (+- {offset_half:.4f}) at {match.origin:.6g} s, "
        f"drift {1e6 * match.drift:.2f} ppm (+- {drift_half:.2f})"
    )


@dataclass(frozen=True)
class _Signal:
    """A column of a log, and the sign to take it with."""

    name: str
    sign: float

    def of(self, log: Table) -> Array:
        """Its values in the log."""
        return self.sign * log.columns[self.name]


def _shared(
    a: Table,
    b: Table,
    on: Sequence[str],
    clocks_a: set[str],
    clocks_b: set[str],
) -> tuple[_Signal, _Signal]:
    """The signal that both logs have, in A and in B.

    Raises:
        MappingError: none or several, or no such column.
    """
    if len(on) > 2:
        raise MappingError(
            f"--on has {len(on)} names", remedy="Give one name, or that of A and that of B"
        )
    if not on:
        clocks = clocks_a | clocks_b
        both = [name for name in a.columns if name in b.columns and name not in clocks]
        if len(both) != 1:
            shared = (
                f"share the columns {', '.join(both)}" if both else "share no column by its name"
            )
            raise MappingError(
                f"the logs {shared}; {a.name} has {a.listed}; {b.name} has {b.listed}",
                remedy="Say which signal both have: --on NAME, or --on NAME_IN_A NAME_IN_B",
            )
        on = both

    def signal(log: Table, label: str, clocks: set[str]) -> _Signal:
        with placed(log.name):
            name, _, sign = locate(log, ColumnChoice(label), "on")
            if name in clocks:
                raise MappingError(
                    f"column {name} is the log's own time",
                    remedy="Choose a measured signal with --on",
                )
        return _Signal(name, sign)

    return signal(a, on[0], clocks_a), signal(b, on[-1], clocks_b)


def _drawn_out(angle: Array, turn: float) -> Array:
    """An angle without its jumps after a full turn, shape (n,); a row without a number stays so."""
    known = np.isfinite(angle)
    drawn = np.array(angle)
    drawn[known] = np.unwrap(angle[known], period=turn)
    return drawn


def _sampled(
    clock: LogClock,
    values: Array,
    wanted: Array,
    period: float,
) -> tuple[Array, Mask]:
    """A column of such a clock at the times that are wanted, a period apart, and where it has any value."""
    if np.isfinite(values).sum() < 2:
        return np.full(wanted.size, np.nan), np.zeros(wanted.size, np.bool_)
    track = track_of(clock.time, values, clock.period)
    return track.sampler(period, plain=True)(wanted)


def _joined(
    a: Table,
    b: Table,
    time: Array,
    own: Mapping[str, Array],
    moved: Mapping[str, Array],
    there: Mask,
) -> tuple[Table, dict[str, str]]:
    """One table of both logs' columns, and what columns of B are called in it."""
    columns: dict[str, Array] = {_TIME: time}
    units: dict[str, str | None] = {_TIME: "s"}
    renamed: dict[str, str] = {}
    for log, log_columns, mark in ((a, own, "_A"), (b, moved, "_B")):
        for name, values in log_columns.items():
            free = name
            while free in columns:
                free += mark
            columns[free] = values
            units[free] = log.units.get(name)
            if free != name and log is b:
                renamed[name] = free

    metadata: dict[str, Any] = {}
    origin = a.origin or b.origin
    if origin:
        metadata["erclutch"] = json.dumps({"label": origin})
    both_digests = f"{a.digest} {b.digest}".encode()
    table = Table(
        f"{a.name} + {b.name}",
        {name: values[there] for name, values in columns.items()},
        units,
        hashlib.sha256(both_digests).hexdigest(),
        constants={**b.constants, **a.constants},
        metadata=metadata,
    )
    return table, renamed
