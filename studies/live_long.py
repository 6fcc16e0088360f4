"""Does the loop leak, drift or lose anything? A day on the TWIN as fast as it goes, and twenty minutes of real time.

    python studies/live_long.py --hours 24          # accelerated: the loop's C core and the twin in one process
    python studies/live_long.py --minutes 20        # real time: loop, rig and recorder, each a process

The accelerated twin takes internal steps of 1/3 ms in place of 0.05 ms; what is tested is the loop. In real time
cyclictest (Debian: rt-tests) runs beside, where it is there: deadlines that it misses too are the machine's.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from live_lateness import cyclictest, of_cyclictest, process

from erclutch.logs import read_table
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.companions import Observers
from erclutch.wings.live.layout import EVENTS
from erclutch.wings.live.offered_programs import standard_programs, starting_with
from erclutch.wings.live.ring import State
from erclutch.wings.live.session import TWIN, Session, SessionOptions
from erclutch.wings.live.session_figures import SessionFigures
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.parameters import default_rig

STRETCH = 60_000
HOUR = 3_600_000


def resident(pid: int) -> float:
    """Resident memory of a process in MB."""
    words = Path(f"/proc/{pid}/statm").read_text().split()
    return int(words[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def model_of(rig: Any) -> Any:
    """The network that `erclutch live` takes on the twin."""
    from rich.console import Console

    from erclutch.wings.live.live_model import live_model
    from erclutch.wings.rig.twin_model import twin_model

    return live_model(twin_model(rig, Console(stderr=True)), "coaxial")


def accelerated(hours: float) -> None:
    """A long run of the core; a line an hour."""
    rig = default_rig().changed({"integration.step": 1e-3 / 3.0})
    settings = LoopSettings(
        programs=starting_with(standard_programs(rig, model=True), "tracking-slow")
    )
    run = AcceleratedRun(settings, model_of(default_rig()).library, rig, speed=40.0)
    total, began, start = round(hours * HOUR), time.monotonic(), 0.0
    seen, frames_seen, wrong = 0, 0, 0
    print(
        f"{'hour':>5}{'RSS MB':>9}{'tracking rms rad':>18}{'estimate off, rms mN m':>24}{'warmer K':>10}"
    )
    squares = np.zeros(3)
    for frames in run.stretches(total, STRETCH):
        wrong += int(
            np.count_nonzero(frames["seq"] != np.arange(frames_seen, frames_seen + len(frames)))
        )
        frames_seen += len(frames)
        seen |= int(np.bitwise_or.reduce(frames["events"]))
        errors = (frames["reference"] - frames["alpha"], frames["estimate"] - frames["torque"])
        wrong += int(np.count_nonzero(~np.isfinite(errors[0]) | ~np.isfinite(errors[1])))
        squares += (float(np.sum(errors[0] ** 2)), float(np.sum(errors[1] ** 2)), len(frames))
        if frames_seen == 5 * STRETCH:
            start = resident(os.getpid())
        if frames_seen % HOUR == 0 or frames_seen == total:
            rms = np.sqrt(squares[:2] / squares[2])
            now = resident(os.getpid())
            print(
                f"{frames_seen / HOUR:5.1f}{now:9.1f}{rms[0]:18.5f}{1e3 * rms[1]:24.4f}{run.warming:10.3f}",
                flush=True,
            )
            squares[:] = 0.0
    grown = resident(os.getpid()) - start
    names = [name for i, (name, _) in enumerate(EVENTS) if seen >> i & 1]
    took = time.monotonic() - began
    print(
        f"TWIN, {frames_seen / HOUR:g} h in {took / 60:.1f} min: {frames_seen} frames, {wrong} wrong or not finite; "
        f"events {names or 'none'}; resident memory grew by {grown:.2f} MB after the first five minutes"
    )


def real_time(minutes: float) -> None:
    """Loop, rig and recorder as users run them; a trip is reset, and counted.

    Memory is read after 90 s or a tenth of the time: by then each page of the ring (65 s) has been seen by its reader.
    """
    rig = default_rig()
    settings = LoopSettings(
        programs=starting_with(standard_programs(rig, model=True), "tracking-slow")
    )
    first: dict[str, float] = {}
    last: dict[str, float] = {}
    load = os.getloadavg()
    with (
        tempfile.TemporaryDirectory() as name,
        Session(TWIN, settings, model_of(rig), SessionOptions(60.0 * minutes)) as session,
        contextlib.ExitStack() as beside,
    ):
        measured = Path(name) / "cyclictest.json"
        if words := cyclictest(60.0 * minutes - 5.0, measured):
            beside.enter_context(process(words))
        with Observers(session.ring, session.carry_out, folder=name, page=False) as observers:
            observers.record(True)
            watch, warm = (
                SessionFigures(session.reader()),
                time.monotonic() + min(90.0, 6.0 * minutes),
            )
            while session.running:
                watch.poll()
                time.sleep(0.1)
                last = memory(session, observers) or last
                if watch.reader.state is State.TRIPPED:
                    session.run_again()
                if not first and time.monotonic() > warm:
                    first = last
            watch.poll()
            observers.record(False)
            kept = np.concatenate(
                [read_table(path).columns["seq"] for path in observers.recordings.files]
            )
        report(minutes, watch, of_cyclictest(measured))
        head = watch.reader.head
        for which, size in first.items():
            print(
                f"resident memory of the {which} in MB: {size:.2f} at first, {last[which] - size:+.2f} at the end"
            )
        print(
            f"recording: {kept.size} frames of the loop's {head}, first {kept[0]:.0f}, last {kept[-1]:.0f}, "
            f"missing in between {int((np.diff(kept) - 1).sum())}"
        )
        print(
            "load of the machine before and after:",
            *(f"{x[0]:.1f}" for x in (load, os.getloadavg())),
        )


def memory(session: Session, observers: Observers) -> dict[str, float]:
    """Resident memory of each process in MB; empty as soon as one of them ends."""
    recorder = observers.recordings.pid
    pids = {**session.pids, **({} if recorder is None else {"recorder": recorder})}
    with contextlib.suppress(OSError):
        found = {process: resident(pid) for process, pid in pids.items()}
        return found if len(found) == 3 and all(found.values()) else {}
    return {}


def report(minutes: float, watch: SessionFigures, beside: list[float]) -> None:
    """Print what the loop did, and cyclictest's lateness beside."""
    counts = {event: n for event, n in watch.reader.counts.items() if n}
    late = [*watch.lateness.percentiles((0.5, 0.99, 0.999)), watch.lateness.largest]
    print(f"TWIN, {minutes:g} min real time, {watch.reader.realtime}: {watch.frames} frames read")
    print(
        f"missed {watch.reader.missed}, lost by the observer {watch.reader.lost}, events {counts}"
    )
    for name, values in (("loop", late), ("cyclictest", beside)):
        if values:
            p50, p99, p999, largest = values
            print(
                f"lateness us, {name}: p50 {p50:.0f} p99 {p99:.0f} p99.9 {p999:.0f} largest {largest:.0f}"
            )


def main() -> None:
    """One of the two, or both."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hours", type=float, default=0.0)
    parser.add_argument("--minutes", type=float, default=0.0)
    given = parser.parse_args()
    if given.hours:
        accelerated(given.hours)
    if given.minutes:
        real_time(given.minutes)


if __name__ == "__main__":
    main()
