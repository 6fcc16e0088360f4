"""What is scored of logs of which stretches were fitted: their rows, which of them are held out, and in which parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from erclutch.fit.comparison import Comparison
from erclutch.logs.any_size import Cut, RowsOfLogs
from erclutch.signals.array import Mask
from erclutch.signals.device import DeviceName

_MOST_BINS, _SHORTEST_BIN = 65_536, 256


@dataclass(frozen=True)
class HeldOut:
    """Which rows of a log are held out: a row that was not kept is what the kept row before it is.

    Attributes:
        turns: places among the log's usable rows from which on that changes, increasing.
        held: whether rows from there on are held out, one for each turn; rows before the first turn are as behind it.
    """

    turns: tuple[int, ...]
    held: tuple[bool, ...]

    def of(self, first: int, rows: int) -> Mask:
        """Whether each of so many rows from a place on is held out, shape (rows,)."""
        behind = np.searchsorted(self.turns, np.arange(first, first + rows), side="right") - 1
        return np.array(self.held, np.bool_)[np.maximum(behind, 0)]


@dataclass(frozen=True)
class LogToScore:
    """A log whose rows are scored.

    Attributes:
        path, number, name, digest: see `LogInBlocks`.
        rows: usable rows.
        period: sampling period in s; None where steps differ.
        cuts: where its tasks begin.
        held_out: which of its rows are held out.
    """

    path: str
    number: int | None
    name: str
    digest: str
    rows: int
    period: float | None
    cuts: tuple[Cut, ...]
    held_out: HeldOut


@dataclass(frozen=True)
class ScoringPlan:
    """What is scored.

    Attributes:
        run: digest of run.json; "" where the run is in no folder.
        device: how signals become elements.
        logs: in the order of the fit.
        kept_rows: rows that the models were fitted to or judged on before.
        bin_rows: rows of a bin.
        middle: effort near the mean, which sums of the effort are counted from.
        seed: of the bands.
    """

    run: str
    device: DeviceName
    logs: tuple[LogToScore, ...]
    kept_rows: int
    bin_rows: int
    middle: float
    seed: int

    @property
    def rows(self) -> int:
        """All rows."""
        return sum(log.rows for log in self.logs)

    @property
    def parts(self) -> list[Part]:
        """What the tasks read."""
        parts: list[Part] = []
        for log in self.logs:
            for number, cut in enumerate(log.cuts):
                is_last = number + 1 == len(log.cuts)
                stop = None if is_last else log.cuts[number + 1].file_row
                parts.append(Part(log, number, cut, stop))
        return parts


@dataclass(frozen=True)
class Part:
    """Rows of one task.

    Attributes:
        log: the log.
        at: which of its parts, counted from 0.
        begin: its first row.
        stop: row of the file behind its last; None is the end of the log.
    """

    log: LogToScore
    at: int
    begin: Cut
    stop: int | None

    @property
    def rows(self) -> int:
        """Usable rows."""
        end = self.log.rows
        if self.stop is not None:
            end = self.log.cuts[self.at + 1].place
        return end - self.begin.place


def plan_of(rows: RowsOfLogs, comparison: Comparison, run: str = "") -> ScoringPlan:
    """The plan for logs of which stretches were kept, and for the comparison of these."""
    return plan_of_rows(rows, comparison.test, seed=comparison.settings.seed, run=run)


def plan_of_rows(
    rows: RowsOfLogs,
    test: Mask,
    *,
    seed: int = 0,
    run: str = "",
) -> ScoringPlan:
    """The plan for logs of which stretches were kept, and for the mask of those that are held out."""
    total = sum(log.rows for log in rows.in_blocks)
    bin_rows = _SHORTEST_BIN
    while total > bin_rows * _MOST_BINS:
        bin_rows *= 2
    kept_of = dict(zip(rows.numbers, rows.data.source_rows, strict=True))
    logs: list[LogToScore] = []
    for number, log in enumerate(rows.in_blocks):
        held_out = HeldOut((0,), (True,))  # nothing of the log was seen
        if number in kept_of:
            kept = slice(*kept_of[number])
            places = rows.places[kept]
            is_test = test[kept]
            turns = np.flatnonzero(is_test[1:] != is_test[:-1])  # the last rows before a turn
            begins = np.concatenate([[0], 1 + turns])
            held_out = HeldOut(
                turns=tuple(places[begins].tolist()),
                held=tuple(is_test[begins].tolist()),
            )
        logs.append(
            LogToScore(
                path=str(log.path),
                number=log.number,
                name=log.name,
                digest=log.digest,
                rows=log.rows,
                period=log.period if log.uniform else None,
                cuts=log.cuts,
                held_out=held_out,
            )
        )
    return ScoringPlan(
        run=run,
        device=rows.data.device,
        logs=tuple(logs),
        kept_rows=rows.data.rows,
        bin_rows=bin_rows,
        middle=float(rows.data.effort.mean()),
        seed=seed,
    )
