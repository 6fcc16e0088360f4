"""An attack on erclutch, part by part: what was tried, how often, and what did not hold.

    python studies/attack.py [PART ...] [--minutes 19] [--count 1000] [--pairs 100] [--first 0]

The parts come in the order of what they cost, the cheapest first. Each has its share of the time that is left, and all
processors of the machine; what a part does not need goes to those behind it. Within a part each row has its share, and
on a machine that is too slow for it one try at least. The table says how many tries each came to. A failure is printed
as it is seen. The program ends with 1 if anything failed, or if a row had no try. Behind the table stand
the seconds of processor time of each part, which do not depend on what else the machine does.

- races: two processes write to one place at one moment, for each command that writes, ``--pairs`` each. Of the writers:
  the command's own result, its rule of what may be replaced, the code that puts it in place. Of whole commands: forked
  when all is imported; what the first run reads in a child, draws or fits is kept. One pair starts as a user does.
- room: each command that writes, and an export to each target, into a folder that nobody may write to, onto a disk of
  60 kB, and where temporary files are on that disk, too.
- bombs: small files that unpack to gigabytes.
- formats: damaged logs of each format, ``--count`` each: a crash, a hang, more than 1 GB, or other numbers in silence
  where the reader says that it sees damage.
- settings: damaged files of rigs, mappings, plans, mappings beside their log, and models, ``--count`` each.
- sensors: a fault in each sensor of the loop under each control, on the TWIN. The note tells the strict figures, too.
- compilers: options that change arithmetic, in C and C++, with every compiler of this machine: the right bits or a
  refusal.
- hostile: what a machine, a plug-in or a worker may do: `tests/support/hostile.py`.
- runs, mujoco, app, places, loop: the tests of damaged runs and models, of two devices in two models, of requests and
  pages of strangers, of the one place that writes, and of clocks that jump and a disk that is full while a loop runs.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.attack_rows import CORES, Row, at_once, joined
from tests.support.pace import within

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
#: Parts that are tests: what pytest runs of each. The pairs of commands are a part of their own.
TESTS = {
    "runs": (
        "tests/report/test_bad_runs.py",
        "tests/models/test_model_file.py",
        "tests/runs/test_run_json.py",
    ),
    "mujoco": ("tests/wings/exporters/test_mujoco_actuator.py",),
    "app": (
        "tests/wings/app/test_app.py",
        "tests/wings/app/test_app_in_two_browsers.py",
        "tests/wings/live/page/test_page.py",
        "tests/wings/live/page/test_two_browsers.py",
    ),
    "loop": (
        "tests/wings/live/test_faults.py",
        "tests/wings/live/test_clock.py",
        "tests/wings/live/page/test_recording.py",
        *("-k", "clock or disk"),
    ),
    "places": (
        "tests/test_files.py",
        "--deselect",
        "tests/test_files.py::test_of_two_commands_at_once_one_is_told",
    ),
}
#: Where damage to the numbers is seen, as `LogReader.tells_damage` says: there no other number may come in silence.
SEEN = (
    *("xlsx", "ods", "csv gz", "mat 5", "hdf5 checked", "parquet checked", "mcap"),
    *("npz", "zip"),
)
#: Readers in a process of their own, whose crash is one line for the user.
IN_CHILD = (
    *("mdf", "tdms", "spreadsheet", "hdf5", "rosbag", "mat", "parquet"),
    *("feather", "numpy_arrays"),
)
#: There checksums hold the numbers, and none holds names and units: h5py writes the latter without.
UNCHECKED_NAMES = ("hdf5 checked",)
MOST_MIB = 954  # 1 GB
MOST_SECONDS = 10.0  # of processor time, for a file
#: Pairs of a command, and of each file or folder that it writes.
PAIRS = 100
#: Number of the first damaged file of each kind, and the first seed: another one makes other damage.
FIRST = 0
#: Part -> what it costs on two processors in seconds: the weights by which the parts share the time, and their order.
WEIGHTS = {
    "settings": 10,
    "mujoco": 10,
    "loop": 15,
    "runs": 15,
    "places": 15,
    "room": 50,
    "bombs": 40,
    "sensors": 60,
    "app": 80,
    "hostile": 60,
    "compilers": 110,
    "formats": 280,
    "races": 400,
}
SHARE_OF_WRITERS = 0.2  # of the time of their races
DEAR = (
    "calibrate-twin",
    "live",
    "demo",
)  # a pair takes a second or more: both processors share the pairs
LEAST_OF_TESTS, MOST_TO_END = (
    60.0,
    60.0,
)  # s for tests, however late it is, and to end in when their time is over
_COUNTS = re.compile(r"(\d+) (passed|failed|error|errors)")


def _begin() -> Callable[[], None]:
    """What a process of ours begins with."""
    return partial(_take, FIRST, PAIRS)


def _take(first: int, pairs: int) -> None:
    global FIRST, PAIRS
    FIRST, PAIRS = first, pairs


def races(until: float, count: int) -> Iterator[Row]:
    """Pairs of each command that writes."""
    from tests.support.races import EACH_ITS_OWN, WORDS, make_material

    with tempfile.TemporaryDirectory() as name:
        make_material(Path(name))
        tasks = [(command, name) for command in WORDS]
        yield from at_once(_started_pair, tasks, until, _begin())
        # A recording grows in its place, so that a power cut leaves it: it has no writer that moves it there.
        moved = [task for task in tasks if task[0] not in EACH_ITS_OWN]
        now = time.monotonic()
        yield from at_once(
            _pairs_of_writers, moved, now + (until - now) * SHARE_OF_WRITERS, _begin()
        )
        parts = [(*task, part) for task in tasks for part in ((1, 2) if task[0] in DEAR else (0,))]
        for row in joined(at_once(_pairs_of_commands, parts, until, _begin())):
            row.was_to_try(PAIRS)
            yield row


@contextmanager
def _folder_of(material: str) -> Generator[tuple[Path, Path]]:
    """A folder of a command alone with what it needs, and room beside it."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(shutil.copytree(material, Path(name) / "work")), Path(name)


def _started_pair(command: str, material: str, *, until: float) -> Row:
    from tests.support.races import started

    row = Row(f"programs of {command}", tries=1)
    with _folder_of(material) as (folder, _):
        if lost := started(command, 0, folder).lost(command):
            row.fail(lost)
    return row


def _pairs_of_writers(command: str, material: str, *, until: float) -> Row:
    from tests.support.raced_writers import lost_in, written_by

    row = Row(f"writers of {command}")
    with _folder_of(material) as (folder, beside):
        for number, written in enumerate(written_by(command, folder, beside)):
            pairs = PAIRS if time.monotonic() < until else max(PAIRS // 10, 1)
            row.tries += pairs
            for lost in lost_in(written, pairs, beside / f"raced-{number}"):
                row.fail(lost)
    return row


def _pairs_of_commands(command: str, material: str, part: int, *, until: float) -> Row:
    from tests.support.races import lost_in_pairs

    row = Row(f"races of {command}")
    with _folder_of(material) as (folder, _):
        pairs = (0, (PAIRS + 1) // 2, PAIRS // 2)[part] or PAIRS
        row.tries, lost = lost_in_pairs(command, pairs, folder, lambda: time.monotonic() > until)
    row.fail_each(lost)
    return row


def bombs(until: float, count: int) -> Iterator[Row]:
    """Each bomb once: it does not depend on chance."""
    from tests.support.bombs import BOMBS

    each = list(at_once(_one_bomb, [(name,) for name in BOMBS], until, _begin()))
    row = Row(
        "bombs", sum(one.tries for one in each), [what for one in each for what in one.failures]
    )
    most_mib, most_ms = (max(one.counts[unit] for one in each) for unit in ("MiB", "ms"))
    row.note = f"at most {most_mib} MiB, {1e-3 * most_ms:.1f} s"
    yield row


def _one_bomb(name: str, *, until: float) -> Row:
    from tests.support.bombs import BOMBS, read_alone

    row, (file, make) = Row(name, tries=1), BOMBS[name]
    with tempfile.TemporaryDirectory() as folder:
        make(Path(folder) / file)
        taken = read_alone(Path(folder) / file)
    row.counts.update({"MiB": round(taken.mib), "ms": round(1e3 * taken.seconds)})
    if not taken.held:
        row.fail(f"{taken}")
    return row


def formats(until: float, count: int) -> Iterator[Row]:
    """Damaged logs of each format."""
    from tests.support.log_formats import FORMATS

    with tempfile.TemporaryDirectory() as kept:
        of_all = at_once(_one_format, [(name, count, kept) for name in FORMATS], until, _begin())
        rows = dict(zip(FORMATS, of_all, strict=True))
        # What the quick ones left of their shares goes to the slow ones, which go on where they were.
        short = [name for name, row in rows.items() if row.tries < count and not row.failures]
        again = at_once(_one_format, [(name, count, kept) for name in short], until, _begin())
        yield from (rows | dict(zip(short, again, strict=True))).values()


def _one_format(name: str, count: int, kept: str, *, until: float) -> Row:
    from studies import formats as study
    from tests.support.log_formats import FORMATS

    row, silent = Row(f"damaged {name}"), 0
    study.CHUNK = 20  # so that it ends in time
    with tempfile.TemporaryDirectory() as place:
        outcomes, peak, seconds = study.mutate(name, count, Path(kept), Path(place), until, FIRST)
    row.tries = sum(outcomes.values())
    for said, times in outcomes.items():
        unseen = said.startswith("silent") and said.endswith("then silent")
        told_by_child = said.startswith("crash: signal") and FORMATS[name][0] in IN_CHILD
        silent += times if unseen else 0
        of_name = name in UNCHECKED_NAMES and "names or units" in said
        if (said.startswith(("crash", "hang")) and not told_by_child) or (
            unseen and name in SEEN and not of_name
        ):
            row.fail(f"{said} ({times})")
    if peak > MOST_MIB:
        row.fail(f"{peak} MiB")
    if not within(seconds, MOST_SECONDS):
        row.fail(f"{seconds:.1f} s of processor time")
    of_what = "names or units" if name in UNCHECKED_NAMES else "numbers"
    row.note = f"at most {peak} MiB, {seconds:.1f} s"
    row.note += (
        f"; {silent} other {of_what} in silence: the format has no checksum of them"
        if silent
        else ""
    )
    row.was_to_try(count)
    return row


def settings(until: float, count: int) -> Iterator[Row]:
    """Damaged files of rigs, mappings, plans and models."""
    from tests.support.damaged_settings import KINDS

    yield from at_once(_one_kind_of_settings, [(kind, count) for kind in KINDS], until, _begin())


def _one_kind_of_settings(kind: str, count: int, *, until: float) -> Row:
    from tests.support.damaged_settings import fault_of, make_settings

    row = Row(f"damaged {kind} files")
    with tempfile.TemporaryDirectory() as folder:
        make_settings(Path(folder))
        while row.tries < count and not (row.tries and time.monotonic() > until):
            fault = fault_of(kind, FIRST + row.tries, Path(folder))
            row.tries += 1
            if fault:
                row.fail(fault)
    row.was_to_try(count)
    return row


def sensors(until: float, count: int) -> Iterator[Row]:
    """Four seeds of `studies/sensor_faults.py`, as far as the time goes."""
    from tests.support.sensor_faults import CONTROLS

    seeds = range(FIRST, FIRST + max(count // 250, 1))
    rows = list(
        at_once(
            _faults,
            [(control, seed) for seed, control in product(seeds, CONTROLS)],
            until,
            _begin(),
        )
    )
    for control in CONTROLS:
        row, strictly = Row(f"faults of sensors, {control}"), Counter[str]()
        for part in rows:
            if part.name == control:
                row.tries += part.tries
                row.failures += part.failures
                strictly.update(part.counts)
        row.note = ", ".join(f"{times} {said}" for said, times in strictly.items())
        yield row
    yield from at_once(_faults_of_exported, [(FIRST,)], until, _begin())


def _faults_of_exported(seed: int, *, until: float) -> Row:
    from tests.support.exported_controller import UNTOLD, sessions

    row = Row("faults of sensors, exported controller")
    untold = 0
    for sensor, kind, (run,) in sessions(range(seed, seed + 1)):
        row.tries += 1
        untold += (sensor, kind) in UNTOLD and not run.held
        if (sensor, kind) not in UNTOLD and not run.never_above:
            row.fail(f"{sensor} / {kind}, seed {seed}: too high for {run.above} ms")
    row.note = (
        f"{untold} not told by what it gets: a meter that is none, a drive's speed that falls"
    )
    return row


def _faults(control: str, seed: int, *, until: float) -> Row:
    from tests.support.sensor_faults import CAUSES, NOT_HELD, ZERO_WITHIN, sessions

    row = Row(control)
    for sensor, kind, run in sessions(control, seed):
        if row.tries and time.monotonic() > until:
            break
        row.tries += 1
        row.counts["too high for more than 5 ms"] += not run.never_above
        row.counts[f"not zero within {ZERO_WITHIN} ms"] += not run.zero_in_time
        if run.cause:
            row.counts[f"of these sessions where {CAUSES[run.cause]}"] += 1
        if run.outcome == NOT_HELD or not (run.held or run.cause):
            row.fail(f"{sensor} / {kind}, seed {seed}: {run.outcome}, and nobody knows why")
    return row


def compilers(until: float, count: int) -> Iterator[Row]:
    """Each option with each compiler, in C and C++, as written and as old compilers see it."""
    from erclutch.export.c.compilers import natives

    places = range(len(natives()))
    yield from at_once(
        _one_language, list(product(places, ("C", "C++"), (True, False))), until, _begin()
    )


def _one_language(place: int, language: str, guarded: bool, *, until: float) -> Row:
    from erclutch.export.c.compilers import natives
    from tests.support.changed_arithmetic import (
        ALWAYS_TOLD_IN_CPP,
        CPP,
        MODELS,
        OPTIONS,
        PRECISIONS,
        REFUSED,
        RIGHT,
        C,
        answer,
        without_macros_and_pragmas,
        written,
    )
    from tests.support.exported_models import MODELS as MADE

    compiler, flags = natives()[place], CPP if language == "C++" else C
    row = Row(f"{compiler.name}, {language}, {'guarded' if guarded else 'old compiler'}")
    answers, by_precision = Counter[int](), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        made = list(product(MODELS, PRECISIONS))
        files = [
            written(MADE[label], Path(folder) / label / precision, precision)
            for label, precision in made
        ]
        for file in files:
            if not guarded:
                without_macros_and_pragmas(file)
        if answer(compiler, files[0], ["-O2"], flags) != RIGHT:
            row.fail("wrong without any option")
        # All options with one file, then all of them with the next: where time is short, each was tried with some.
        for number, (turn, options) in product(range(len(files)), enumerate(OPTIONS)):
            if row.tries and time.monotonic() > until:
                break
            if language == "C++" and not guarded and options in ALWAYS_TOLD_IN_CPP:
                continue
            said = answer(compiler, files[(number + turn) % len(files)], options.split(), flags)
            row.tries += 1
            answers[said] += 1
            by_precision[made[(number + turn) % len(files)][1]] += 1
            if said not in (RIGHT, REFUSED):
                row.fail(f"{options}: {said}")
    row.note = f"{answers[RIGHT]} right, {answers[REFUSED]} refused; "
    row.note += ", ".join(
        f"{times} of {precision}" for precision, times in sorted(by_precision.items())
    )
    if language == "C++" and not guarded:
        row.note += f"; not tried: {', '.join(ALWAYS_TOLD_IN_CPP)}, which each compiler of C++17 tells by a macro"
    return row


def room(until: float, count: int) -> Iterator[Row]:
    """Each command that writes, where it cannot, in a folder of its own."""
    from tests.support.no_room import exports
    from tests.support.races import WORDS, make_material

    with tempfile.TemporaryDirectory() as name:
        make_material(Path(name))
        commands = (*WORDS, *exports())
        yield from at_once(_one_room, [(command, name) for command in commands], until, _begin())


def _one_room(command: str, material: str, *, until: float) -> Row:
    from tests.support.no_room import full_disk, full_disks, read_only

    row = Row(f"no room for {command}")
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(material, folder, dirs_exist_ok=True)
        for how in (read_only, full_disk, full_disks):
            if row.tries and time.monotonic() > until:
                break
            row.tries += 1
            if wrong := how(command, Path(folder)).wrong:
                row.fail(f"{how.__name__}: {wrong}")
    return row


def hostile(until: float, count: int) -> Iterator[Row]:
    """Each case of `tests/support/hostile.py` once."""
    from tests.support.hostile import CASES

    yield from at_once(_one_case, [(name,) for name in CASES], until, _begin())


def _one_case(name: str, *, until: float) -> Row:
    from tests.support.hostile import CASES

    row = Row(name)
    with tempfile.TemporaryDirectory() as folder:
        row.tries, wrong = CASES[name](Path(folder))
    row.fail_each(wrong)
    return row


def tested(name: str, until: float) -> Iterator[Row]:
    """A part that is tests: each is a try. When the time is over, those that have ended count."""
    row = Row(name)
    words = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-n",
        str(CORES),
        "-p",
        "no:cacheprovider",
        "-rfE",
        *TESTS[name],
    ]
    pipe = subprocess.PIPE
    with subprocess.Popen(words, cwd=ROOT, stdout=pipe, text=True, start_new_session=True) as tests:
        try:
            said = tests.communicate(timeout=max(until - time.monotonic(), LEAST_OF_TESTS))[0]
        except subprocess.TimeoutExpired:
            row.note = "the time was over: "
            tests.send_signal(signal.SIGINT)  # pytest tells what came of those that have ended
            try:
                said = tests.communicate(timeout=MOST_TO_END)[0]
            except subprocess.TimeoutExpired:
                tests.kill()
                said = tests.communicate()[0]
            with suppress(ProcessLookupError):  # servers of tests that were cut off
                os.killpg(tests.pid, signal.SIGKILL)
    lines = said.splitlines() or [""]
    summed = next((line for line in reversed(lines) if _COUNTS.search(line)), lines[-1])
    row.tries = sum(int(number) for number, _ in _COUNTS.findall(summed))
    for line in lines:
        if line.startswith(("FAILED", "ERROR")):
            row.fail(line[:200])
    row.note += summed
    yield row


PARTS: dict[str, Callable[[float, int], Iterator[Row]]] = {
    "bombs": bombs,
    "settings": settings,
    "sensors": sensors,
    "compilers": compilers,
    "hostile": hostile,
    "room": room,
}
PARTS |= {"races": races, "formats": formats}


def main() -> int:
    """Run the parts and print the table."""
    global FIRST, PAIRS
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "parts", nargs="*", metavar="PART", help=f"of {', '.join(WEIGHTS)}; none: all"
    )
    parser.add_argument("--minutes", type=float, default=19.0, help="for all parts together")
    parser.add_argument("--count", type=int, default=1000, help="damaged files of a format")
    parser.add_argument("--pairs", type=int, default=PAIRS, help="that race for a command")
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first damaged file, and first seed"
    )
    asked = parser.parse_args()
    FIRST, PAIRS = asked.first, asked.pairs
    if wrong := set(asked.parts) - set(WEIGHTS):
        parser.error(f"there is no part {', '.join(sorted(wrong))}")
    parts = [part for part in WEIGHTS if part in asked.parts or not asked.parts]
    signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # a shell's background job ignores it, and tests would too
    end = time.monotonic() + 60.0 * asked.minutes
    print("| row | tries | failures | |\n| --- | --- | --- | --- |", flush=True)
    rows: list[Row] = []
    taken: dict[str, float] = {}
    for place, part in enumerate(parts):
        began, used = time.monotonic(), sum(os.times()[:4])
        share = WEIGHTS[part] / sum(WEIGHTS[later] for later in parts[place:])
        until = began + max(end - began, 0.0) * share
        for row in PARTS[part](until, asked.count) if part in PARTS else tested(part, until):
            # Whoever ends the attack has the rows so far.
            print(f"| {row.name} | {row.tries} | {len(row.failures)} | {row.note} |", flush=True)
            rows.append(row)
        taken[part] = sum(os.times()[:4]) - used  # of this process and of those that it waited for
        clock = time.monotonic() - began
        print(
            f"{part}: {clock:.0f} s, {taken[part]:.0f} s of processors", file=sys.stderr, flush=True
        )
    print("\n| part | s of processors |\n| --- | ---: |")
    for part, seconds in (*taken.items(), ("all", sum(taken.values()))):
        print(f"| {part} | {seconds:.0f} |", flush=True)
    return 1 if any(row.failures or not row.tries for row in rows) else 0


if __name__ == "__main__":
    raise SystemExit(main())
