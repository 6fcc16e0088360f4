"""Wake-up lateness of the live loop beside cyclictest in the same minute, on the TWIN.

    python studies/live_lateness.py [--seconds 60] [--busy] [--no-page] [--no-model]

The page is open in a headless Chromium where there is one, and a recording runs. ``--busy`` adds a Python process that
never rests. cyclictest (Debian: rt-tests) runs at the same priority with the same period; where it is missing, that
line is. All times are of this machine at this moment.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.wings.live.companions import Observers
from erclutch.wings.live.offered_programs import standard_programs, starting_with
from erclutch.wings.live.session import TWIN, Session, SessionOptions
from erclutch.wings.live.session_figures import SessionFigures
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.parameters import default_rig

BUSY = "while True: junk = [{'a': i, 'b': str(i)} for i in range(20000)]"
SHARES = (0.5, 0.99, 0.999)


@contextmanager
def process(words: list[str]) -> Iterator[subprocess.Popen[bytes]]:
    """A program beside, ended at the end."""
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as started:
        try:
            yield started
        finally:
            started.terminate()
            try:
                started.wait(5)
            except subprocess.TimeoutExpired:
                started.kill()


def browser(url: str, folder: Path) -> list[str]:
    """Chromium with the page open, or nothing."""
    program = (
        shutil.which("chromium")
        or shutil.which("chromium-browser")
        or shutil.which("google-chrome")
    )
    if program is None:
        return []
    flags = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--no-first-run",
        "--disable-background-networking",
    ]
    flags += [
        "--disable-component-update",
        "--disable-sync",
        "--disable-quic",
        "--remote-debugging-port=0",
    ]
    return [program, *flags, f"--user-data-dir={folder}", "--window-size=1400,900", url]


def cyclictest(seconds: float, file: Path) -> list[str]:
    """The measure that everybody knows, or nothing."""
    if shutil.which("cyclictest") is None:
        return []
    words = [
        "cyclictest",
        "-t1",
        "-p80",
        "-m",
        "-i1000",
        f"-l{int(1000 * seconds)}",
        "-q",
        f"--json={file}",
    ]
    return [*words, "-h100000"]


def of_cyclictest(file: Path) -> list[float]:
    """Percentiles in us and the largest; empty without a result."""
    try:
        thread = json.loads(file.read_text())["thread"]["0"]
    except (OSError, ValueError, KeyError):
        return []
    counts = {int(us): int(n) for us, n in thread["histogram"].items()}
    at = np.array(sorted(counts))
    total = np.cumsum([counts[int(us)] for us in at])
    found = [float(at[np.searchsorted(total, share * total[-1])]) for share in SHARES]
    return [*found, float(thread["max"])]


def session_minute(given: argparse.Namespace, folder: Path) -> None:
    """A minute of the loop, everything running."""
    rig = default_rig()
    programs = starting_with(standard_programs(rig, model=False), "tracking-slow")
    with ExitStack() as stack:
        model = fitted(rig) if not given.no_model else None
        session = stack.enter_context(
            Session(TWIN, LoopSettings(programs=programs), model, SessionOptions(given.seconds))
        )
        observers = stack.enter_context(
            Observers(session.ring, session.carry_out, folder=folder, page=not given.no_page)
        )
        words = browser(observers.url, folder / "browser") if observers.url else []
        seen = stack.enter_context(process(words)) if words else None
        if given.busy:
            stack.enter_context(process([sys.executable, "-c", BUSY]))
        observers.record(True)
        file = folder / "cyclictest.json"
        words = cyclictest(0.95 * given.seconds, file)
        if words:
            stack.enter_context(process(words))
        watch = SessionFigures(session.reader())
        used = cpu_of(observers.page.pid) if observers.page else 0.0
        began = time.monotonic()
        while session.running:
            watch.poll()
            time.sleep(0.1)
        watch.poll()
        share = (
            (cpu_of(observers.page.pid) - used) / (time.monotonic() - began)
            if observers.page
            else 0.0
        )
        time.sleep(1.0)  # the recorder takes the last frames
        observers.record(False)
        recorded = observers.recordings.progress
        report(watch, of_cyclictest(file), given, seen is not None, share)
        if recorded is not None:
            print(
                f"recording: {recorded.frames} frames, {recorded.lost} lost between loop and file"
            )


def fitted(rig: Any) -> Any:
    """The network that `erclutch live` takes on the twin."""
    from rich.console import Console

    from erclutch.wings.live.live_model import live_model
    from erclutch.wings.rig.twin_model import twin_model

    return live_model(twin_model(rig, Console(stderr=True)), "coaxial")


def cpu_of(pid: int) -> float:
    """Processor time of a process so far, in s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def report(
    watch: SessionFigures, beside: list[float], given: argparse.Namespace, page: bool, share: float
) -> None:
    """Print what was measured."""
    busy = ", a busy Python process" if given.busy else ""
    print(
        f"TWIN, {watch.frames} steps, {watch.reader.realtime}; page {'open' if page else 'closed'}{busy}"
    )
    print(f"{'us':24}{'p50':>8}{'p99':>8}{'p99.9':>8}{'largest':>9}")
    for name, values in (
        ("loop, wake-up", [*watch.lateness.percentiles(SHARES), watch.lateness.largest]),
        ("cyclictest", beside),
        ("loop, step", [*watch.step.percentiles(SHARES), watch.step.largest]),
    ):
        if values:
            print(f"{name:24}" + "".join(f"{v:8.0f}" for v in values[:3]) + f"{values[3]:9.0f}")
    counts = {name: n for name, n in watch.reader.counts.items() if n}
    print(
        f"deadlines missed: {watch.reader.missed} of {watch.frames + watch.reader.missed}; events {counts}"
    )
    print(
        f"frames lost by the observer: {watch.reader.lost}; page's server: {share:.1%} of a processor"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=60.0)
    for flag in ("--busy", "--no-page", "--no-model"):
        parser.add_argument(flag, action="store_true")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        session_minute(parser.parse_args(), Path(name))


if __name__ == "__main__":
    main()
