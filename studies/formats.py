"""Logs of each format, written by the usual library of the format, then damaged: what do the readers make of them?

    python studies/formats.py mutate [--formats mdf tdms ...] [--count 10000] [--results build/formats]

A process that has imported the reader's library forks a child for ten damaged files. The child may take for each what
`child_process` allows beyond what the process had, and 60 s by the clock. It runs the function that the reader's own
child runs; only the start of Python is left out. What is silent or breaks is asked again in a child of its own.
Readers of text and MCAP have no child of their own: what they raise but `LogError` is a crash here.
Counted are errors that are told, files that read as before, files that read otherwise with a note or in silence (and
what `erclutch.read` makes of these), children that crash or hang (an error for the user), and the largest memory. A
mutation is known by format and number, so the study can be stopped and goes on where it was.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import resource
import runpy
import shutil
import signal
import sys
import tempfile
import time
import zlib
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from importlib import import_module
from math import ceil
from pathlib import Path
from typing import NamedTuple
from unittest import mock

os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")  # as a reader's child has it

import numpy as np

import erclutch
from erclutch.errors import LogError
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers import child_process
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.table import Table

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.log_formats import FORMATS, choices, mutated, small_log

SECONDS, CHUNK = 60, 250  # by the clock; `child_process` limits processor time
TOGETHER = 10  # damaged logs for a child: its fork takes longer than a read
UNLIMITED = 1_000_000  # s; each log has its own limit
#: Such an outcome of a log that came after another one in the child is asked again of the log alone.
ALONE = ("silent", "crash", "hang", "error: memory", "error: time")


def finder(reader: str) -> Callable[[str], Table]:
    """What the child of a reader runs; readers of text run in the process itself."""
    module = import_module(f"erclutch.logs.readers.{reader}")
    if hasattr(module, "find") and module.READER.windows is None:
        return lambda path: module.find(path, None)

    # A reader that starts a child has what runs there under a name of its own.
    names = [name for name in ("_read", f"read_{reader}") if hasattr(module, name)]
    own = getattr(module, names[0]) if names else module.READER.read
    windows = getattr(
        module, f"{reader}_windows", module.READER.windows
    )  # not those that start a child

    def read(path: str) -> Table:
        source = LogSource(Path(path), Path(path).read_bytes(), "")
        try:
            if windows is not None:  # as a file larger than memory
                with suppress(LogError):
                    for _ in windows(replace(source, data=b""), 50, 10, 0, None):
                        pass
            return own(source)
        except (LogError, MemoryError):
            raise
        except Exception as error:  # here no `child_process.serve` makes an error of it
            raise SystemExit(f"crash: {type(error).__name__}") from error

    return read


def difference(table: Table, whole: Table) -> str:
    """In which way a table is not that of the whole file; "" where it is."""
    if list(table.columns) != list(whole.columns) or dict(table.units) != dict(whole.units):
        return "names or units"
    if table.rows != whole.rows:
        return "rows"
    pairs = [(table.columns[name], whole.columns[name]) for name in whole.columns]
    if whole.clock is not None:
        pairs.append(
            (table.clock if table.clock is not None else whole.clock * np.nan, whole.clock)
        )
    return (
        "" if all(np.array_equal(one, other, equal_nan=True) for one, other in pairs) else "values"
    )


def outcome(
    find: Callable[[str], Table], log: Path, whole: Table, notes: Callable[[], bool | None]
) -> str:
    """What a damaged log gives, as one phrase."""
    try:
        table = find(str(log))
    except LogError as error:
        return "error" if error.remedy else "crash: no remedy"
    except MemoryError:
        return "error: memory"
    except Exception as error:  # `child_process.serve` makes an error of it, as here
        return f"error: {type(error).__name__}"
    found = difference(table, whole)
    if not table.columns or not table.rows:
        return "error"  # by `read_table`
    if not found:
        return "same"
    if table.notes != whole.notes:
        return f"noted: {found}"
    more = notes()
    return f"silent: {found}, then {'refused' if more is None else 'noted' if more else 'silent'}"


def notes_of(log: Path, name: str) -> frozenset[str] | None:
    """What `erclutch.read` notes of a log; None where it refuses the log."""
    try:
        return frozenset(erclutch.read(log, choices(name)).notes)
    except erclutch.ErclutchError:
        return None


def address_space() -> int:
    """Bytes of address space that this process has: libraries reserve gigabytes that they never touch."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    return pages * resource.getpagesize()


def run_here(
    module: str,
    path: Path,
    *arguments: str,
    memory: int | None = None,
    seconds: float | None = None,
) -> child_process.Answer:
    """`child_process.run` without a child of its own: a fork is one already, and the start of Python is what costs."""
    allowed = budget_of(path)
    most = address_space() + (memory or allowed.memory)
    with tempfile.TemporaryDirectory() as folder:
        words = [
            module,
            str(path),
            folder,
            str(most),
            str(round(seconds or allowed.seconds)),
            *arguments,
        ]
        with mock.patch.object(sys, "argv", words):
            try:
                runpy.run_module(module, run_name="__main__")
            except SystemExit as end:
                return child_process._answer(Path(folder), int(end.code or 0), b"", most)
    raise AssertionError("a reader's module ends its process")


class Read(NamedTuple):
    """What a damaged log gave: the outcome, the largest memory so far in KiB, and its processor time in s."""

    said: str
    kib: int
    seconds: float


def in_child(
    damages: Sequence[Callable[[], object]], log: Path, look: Callable[[], str]
) -> list[Read]:
    """The outcomes of damages, one after the other in a forked child with its limits; a shorter list: the child died.

    Args:
        damages: each writes a damaged log.
        log: file or folder.
        look: the outcome of what is there.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        child_process.run = run_here
        silence = os.open(os.devnull, os.O_WRONLY)
        for standard in (1, 2):
            os.dup2(silence, standard)
        child_process.limit_process(address_space() + budget_of(log).memory, UNLIMITED)
        for damage in damages:
            damage()
            before = time.process_time()
            signal.alarm(SECONDS)
            most = ceil(before + budget_of(log).seconds)
            resource.setrlimit(
                resource.RLIMIT_CPU, (most, resource.getrlimit(resource.RLIMIT_CPU)[1])
            )
            try:
                said = look()
            except SystemExit as crash:
                said = str(crash)
            read = Read(
                said[:200],
                resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
                time.process_time() - before,
            )
            os.write(writing, json.dumps(read).encode() + b"\n")
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        found = [Read(*json.loads(line)) for line in pipe.read().splitlines()]
    _, status, usage = os.wait4(child, 0)
    if len(found) < len(damages):
        if os.WIFSIGNALED(status):
            number = os.WTERMSIG(status)
            told: dict[int, str] = {signal.SIGXCPU: "error: time", signal.SIGALRM: "hang"}
            said = told.get(number, f"crash: signal {number}")
        else:
            said = f"crash: code {status}"
        taken = usage.ru_utime + usage.ru_stime - sum(read.seconds for read in found)
        found.append(Read(said, usage.ru_maxrss, taken))
    return found


class Damage(NamedTuple):
    """What came of damaged logs of a format: outcomes, and the most MiB and s of processor time for one."""

    outcomes: Counter[str]
    mib: int
    seconds: float


def mutate(
    name: str, count: int, results: Path, folder: Path, until: float = float("inf"), begin: int = 0
) -> Damage:
    """Damage a log of a format ``count`` times, from number ``begin`` on, or as long as the monotonic clock allows.

    The outcomes are kept in chunks, so that a second call goes on.
    """
    reader, file, write = FORMATS[name]
    log, kept = folder / file, results / f"{name.replace(' ', '-')}.jsonl"
    if log.is_dir():
        shutil.rmtree(log)  # a bag is not written over
    write(log, small_log())
    parts = sorted(log.iterdir(), reverse=True) if log.is_dir() else [log]
    data, find = {part: part.read_bytes() for part in parts}, finder(reader)
    whole, usual = find(str(log)), notes_of(log, name) or frozenset[str]()

    def notes() -> bool | None:
        found = notes_of(log, name)
        return None if found is None else bool(found - usual)

    def damage(number: int) -> Path:
        damaged = parts[0] if len(parts) == 1 or number % 5 == 0 else parts[1]
        seed = (zlib.crc32(name.encode()), number)
        for part in parts:
            part.write_bytes(mutated(data[part], seed) if part == damaged else data[part])
        return damaged

    def look() -> str:
        return outcome(find, log, whole, notes)

    gc.freeze()  # or each collection of a child copies the pages that it shares with this process
    chunks = [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []
    for first in range(len(chunks) * CHUNK, count, CHUNK):
        if chunks and time.monotonic() > until:
            break
        began, found, peak, longest = time.perf_counter(), Counter[str](), 0, 0.0
        numbers = range(begin + first, begin + first + CHUNK)
        done = 0
        while done < CHUNK:
            damages = [partial(damage, number) for number in numbers[done : done + TOGETHER]]
            for place, read in enumerate(in_child(damages, log, look)):
                number = numbers[done]
                if place and read.said.startswith(
                    ALONE
                ):  # what a damaged log before it did to a library counts not
                    (read,) = in_child([partial(damage, number)], log, look)
                found[read.said], peak, longest = (
                    found[read.said] + 1,
                    max(peak, read.kib),
                    max(longest, read.seconds),
                )
                if read.said.startswith(("crash", "hang")):
                    part = damage(number)
                    (results / f"{read.said.split(':')[0]}-{name}-{number}").write_bytes(
                        part.read_bytes()
                    )
                done += 1
        took = {"seconds": round(time.perf_counter() - began, 1), "longest": round(longest, 2)}
        chunks.append({"found": found, "peak_mib": peak >> 10, **took})
        with kept.open("a", encoding="utf-8") as out:
            out.write(json.dumps(chunks[-1]) + "\n")
    total = sum((Counter[str](chunk["found"]) for chunk in chunks), Counter[str]())
    return Damage(
        total, max(chunk["peak_mib"] for chunk in chunks), max(chunk["longest"] for chunk in chunks)
    )


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["mutate"])
    parser.add_argument("--formats", nargs="+", default=list(FORMATS), choices=list(FORMATS))
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--results", type=Path, default=Path("build/formats"))
    given = parser.parse_args()
    given.results.mkdir(parents=True, exist_ok=True)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for name in given.formats:
        with tempfile.TemporaryDirectory() as folder:
            total, peak, longest = mutate(name, given.count, given.results, Path(folder))
        kinds = Counter[str]()
        for said, times in total.items():
            kinds[
                said if said.startswith(("silent", "noted", "crash")) else said.split(":")[0]
            ] += times
        most = f"at most {peak} MiB, {longest:.1f} s"
        print(
            f"{name}: {sum(total.values())} mutations, {dict(sorted(kinds.items()))}, {most}",
            flush=True,
        )


if __name__ == "__main__":
    main()
