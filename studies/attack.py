"""An attack on erclutch, part by part: what was tried, how often, and what did not hold.

    python studies/attack.py [races bombs formats settings runs sensors mujoco compilers app places] [--minutes 18]

Each part has its share of the time and ends there; the table says how many tries it came to. A failure is printed as it
is seen. The program ends with 1 if anything failed.

- races: two processes write to one place at one moment, for each command that writes, ``--count`` / 10 pairs each, of
  those that take seconds a twentieth.
- bombs: small files that unpack to gigabytes.
- formats: damaged logs of each format, ``--count`` each: a crash, a hang, more than 1 GB, or other numbers in silence
  where the reader says that it sees damage.
- settings: damaged TOML of rigs and mappings, ``--count`` each.
- runs: damaged runs, models and mapping files.
- sensors: a fault in each sensor of the loop under each control, on the TWIN.
- mujoco, compilers, app, places: the tests of two devices in two models, of flags that change arithmetic, of requests
  and pages of strangers, and of the one place that writes.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

#: Parts that are tests: what pytest runs of each.
TESTS = {
    "runs": ("tests/report/test_bad_runs.py", "tests/models/test_model_file.py", "tests/runs/test_run_json.py"),
    "mujoco": ("tests/wings/exporters/test_mujoco_actuator.py",),
    "compilers": ("tests/export/test_self_check.py", "tests/export/test_compilers.py"),
    "app": ("tests/wings/app", "tests/wings/live/page/test_page.py"),
    "places": ("tests/test_files.py",),
}
#: Where damage to the numbers is seen, as `LogReader.tells_damage` says: there no other number may come in silence.
SEEN = ("xlsx", "ods", "csv gz", "mat 5", "hdf5 checked", "parquet checked", "mcap")
#: Readers in a process of their own, whose crash is one line for the user.
IN_CHILD = ("mdf", "tdms", "spreadsheet", "hdf5", "ros2", "mat")
#: Share of the time that a part may take.
SHARES = (
    {"races": 0.26, "bombs": 0.07, "formats": 0.21, "sensors": 0.13, "settings": 0.04}
    | dict.fromkeys(TESTS, 0.05)
    | {"compilers": 0.09}
)
_COUNTS = re.compile(r"(\d+) (passed|failed|error|errors)")


@dataclass
class Row:
    """A row of the table."""

    name: str
    tries: int = 0
    failures: list[str] = field(default_factory=list[str])
    note: str = ""

    def fail(self, what: str) -> None:
        """Note a failure, and tell it at once."""
        self.failures.append(what)
        print(f"{self.name}: {what}", file=sys.stderr, flush=True)


def races(until: float, count: int) -> Iterator[Row]:
    """Pairs of each command that writes; the commands take turns, so that each has its pairs when the time is over."""
    from tests.support.races import SLOW, WORDS, forked, make_material, warm

    rows = {name: Row(f"races of {name}") for name in WORDS}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_material(folder)
        warm(folder)
        for pair in range(max(count // 10, 1)):
            for command, row in rows.items():
                if time.monotonic() > until:
                    break
                if command in SLOW and pair % 20 > 0:
                    continue
                lost = forked(command, pair, folder).lost(command)
                row.tries += 1
                if lost:
                    row.fail(lost)
    yield from rows.values()


def bombs(until: float, count: int) -> Iterator[Row]:
    """Each bomb once: it does not depend on chance."""
    from tests.support.bombs import BOMBS, read_alone

    row, most_mib, most_seconds = Row("bombs"), 0.0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        for name, (file, make) in BOMBS.items():
            if time.monotonic() > until:
                break
            make(Path(folder) / file)
            taken = read_alone(Path(folder) / file)
            row.tries += 1
            most_mib, most_seconds = max(most_mib, taken.mib), max(most_seconds, taken.seconds)
            if not taken.held:
                row.fail(f"{name}: {taken}")
    row.note = f"at most {most_mib:.0f} MiB, {most_seconds:.1f} s"
    yield row


def formats(until: float, count: int) -> Iterator[Row]:
    """Damaged logs of each format, in chunks, in turns."""
    from studies import formats as study
    from tests.support.log_formats import FORMATS

    rows, told = {name: Row(f"damaged {name}") for name in FORMATS}, set[str]()
    with tempfile.TemporaryDirectory() as work:
        study.CHUNK = 10  # so that all formats have their turns in the time
        for reached in range(study.CHUNK, max(count, study.CHUNK) + 1, study.CHUNK):
            for name, row in rows.items():
                if time.monotonic() > until:
                    break
                place = Path(work) / name
                place.mkdir(exist_ok=True)
                outcomes = study.mutate(name, reached, Path(work), place)
                row.tries, row.failures = sum(outcomes.values()), []
                silent = 0
                for said, times in outcomes.items():
                    silent += times if said.startswith("silent") and said.endswith("then silent") else 0
                    told_by_child = said.startswith("crash: signal") and FORMATS[name][0] in IN_CHILD
                    bad = (said.startswith(("crash", "hang")) and not told_by_child) or (
                        name in SEEN and said.endswith("then silent")
                    )
                    row.failures += [said] * times if bad else []
                for said in sorted(set(row.failures) - told):
                    told.add(said)
                    print(f"{row.name}: {said}", file=sys.stderr, flush=True)
                row.note = f"{silent} other numbers in silence" if silent else ""
    yield from rows.values()


def settings(until: float, count: int) -> Iterator[Row]:
    """Damaged TOML of rigs and mappings."""
    from tests.support.damaged_settings import KINDS, fault_of, make_settings

    with tempfile.TemporaryDirectory() as folder:
        make_settings(Path(folder))
        for kind in KINDS:
            row = Row(f"damaged {kind} files")
            while row.tries < count and time.monotonic() < until:
                fault = fault_of(kind, row.tries, Path(folder))
                row.tries += 1
                if fault:
                    row.fail(fault)
            yield row


def sensors(until: float, count: int) -> Iterator[Row]:
    """As many seeds of `studies/sensor_faults.py` as the time allows."""
    from tests.support.sensor_faults import OUTCOMES

    row, program = Row("faults of sensors"), str(ROOT / "studies" / "sensor_faults.py")
    words, within = [sys.executable, program, "--seeds", "2"], 0
    try:
        said = subprocess.run(
            words, capture_output=True, check=False, timeout=max(until - time.monotonic(), 1.0)
        ).stdout
    except subprocess.TimeoutExpired as over:
        said, row.note = over.stdout or b"", "the time was over"
    for line in said.decode().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) < 7 or not cells[3].isdecimal():
            continue
        held, safe, bounded, not_held = map(int, cells[3:7])
        row.tries += held + safe + bounded + not_held
        within += bounded
        for _ in range(not_held):
            row.fail(f"{' / '.join(cells[:3])}: {OUTCOMES[-1]}")
    row.note = "; ".join(filter(None, (row.note, f"{within} where nothing tells the fault: bounded")))
    yield row


def tested(name: str, until: float) -> Iterator[Row]:
    """A part that is tests: each is a try."""
    row = Row(name)
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rfE", *TESTS[name]]
    done = subprocess.run(
        words, cwd=ROOT, capture_output=True, text=True, check=False, timeout=max(until - time.monotonic(), 1.0) + 300.0
    )
    counts = {what: int(number) for number, what in _COUNTS.findall(done.stdout.splitlines()[-1])}
    row.tries = sum(counts.values())
    for line in done.stdout.splitlines():
        if line.startswith(("FAILED", "ERROR")):
            row.fail(line[:200])
    row.note = done.stdout.splitlines()[-1]
    yield row


PARTS: dict[str, Callable[[float, int], Iterator[Row]]] = {
    "bombs": bombs,
    "races": races,
    "formats": formats,
    "settings": settings,
    "sensors": sensors,
}


def main() -> int:
    """Run the parts and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join((*PARTS, *TESTS))}; none: all")
    parser.add_argument("--minutes", type=float, default=18.0, help="for all parts together")
    parser.add_argument("--count", type=int, default=1000, help="damaged files of a format")
    asked = parser.parse_args()
    if wrong := set(asked.parts) - {*PARTS, *TESTS}:
        parser.error(f"there is no part {', '.join(sorted(wrong))}")
    parts = asked.parts or [*PARTS, *TESTS]
    whole = sum(SHARES[part] for part in parts)
    rows: list[Row] = []
    for part in parts:
        began = time.monotonic()
        until = began + 60.0 * asked.minutes * SHARES[part] / whole
        try:
            rows += PARTS[part](until, asked.count) if part in PARTS else tested(part, until)
        except subprocess.TimeoutExpired:
            rows.append(Row(part, note="the time was over"))
        print(f"{part}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    print("| row | tries | failures | |\n| --- | --- | --- | --- |")
    for row in rows:
        print(f"| {row.name} | {row.tries} | {len(row.failures)} | {row.note} |")
    return 1 if any(row.failures or not row.tries for row in rows) else 0


if __name__ == "__main__":
    raise SystemExit(main())
