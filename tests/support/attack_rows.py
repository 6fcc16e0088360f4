"""Rows of the table of `studies/attack.py`, and many of them at once."""

from __future__ import annotations

import multiprocessing
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field

CORES = os.cpu_count() or 1


@dataclass
class Row:
    """A row of the table."""

    name: str
    tries: int = 0
    failures: list[str] = field(default_factory=list[str])
    note: str = ""
    counts: Counter[str] = field(default_factory=Counter[str])

    def fail(self, what: str) -> None:
        """Note a failure, and tell it at once."""
        self.failures.append(what)
        print(f"{self.name}: {what}", file=sys.stderr, flush=True)

    def fail_each(self, of_these: Sequence[str]) -> None:
        """The same for several."""
        for what in of_these:
            self.fail(what)

    def was_to_try(self, count: int) -> None:
        """Note how many tries were asked for, if the time was over before."""
        if self.tries < count:
            self.note = f"the time was over after {self.tries} of {count}{'; ' if self.note else ''}{self.note}"


def at_once(
    work: Callable[..., Row],
    tasks: Sequence[tuple[object, ...]],
    until: float,
    begin: Callable[[], None],
) -> Iterator[Row]:
    """What ``work(*task, until=...)`` gives for each task, on all processors; each has its share of the time left.

    The processes start small, and ``begin()`` in each: a fork costs what its process has imported.
    """
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(CORES, mp_context=spawn, initializer=begin) as pool:
        shared = [
            pool.submit(_in_its_time, work, task, until, len(tasks) - place)
            for place, task in enumerate(tasks)
        ]
        for each in shared:
            yield each.result()


def joined(rows: Iterator[Row]) -> Iterator[Row]:
    """Rows of one name that come one after another as one row: parts of a dear task, so that no processor waits."""
    whole: Row | None = None
    for row in rows:
        if whole is None or whole.name != row.name:
            if whole is not None:
                yield whole
            whole = row
        else:
            whole.tries += row.tries
            whole.failures += row.failures
            whole.counts += row.counts
    if whole is not None:
        yield whole


def _in_its_time(
    work: Callable[..., Row], task: tuple[object, ...], until: float, waiting: int
) -> Row:
    now = time.monotonic()
    try:
        return work(*task, until=now + (until - now) * min(CORES / waiting, 1.0))
    except Exception as error:  # whatever it is, the other rows have their try
        row = Row(" ".join(map(str, task)), tries=1)
        row.fail(f"{type(error).__name__}: {error}")
        return row
