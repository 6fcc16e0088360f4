"""The page and the recorder beside a session on the TWIN: frames a second, processor time, kills, a full disk.

    python studies/page.py frames      a session with the page open in headless Chromium and a recording running
    python studies/page.py kills       kill -9 of the recorder at 100 random times, each followed by another recorder
    python studies/page.py page-kills  kill -9 of the page's server at 100 random times, the page open in the browser
    python studies/page.py disk        a recording onto a disk of 1 MB (a file system in memory; needs root)

``frames`` also prints how often a page with nothing but one canvas is redrawn in the same browser on the same machine:
the page cannot be faster than that.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.logs import read_table
from erclutch.wings.live.companions import Observers
from erclutch.wings.live.recording.recordings import Recordings
from erclutch.wings.live.ring import RingReader
from erclutch.wings.live.session import TWIN, Session
from erclutch.wings.live.settings import LoopProgram, LoopSettings, Mode, Waveform

_FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
]
_FLAGS += ["--disable-component-update", "--disable-sync"]
_CANVAS = """() => { window.painted = 0; const c = document.querySelector("canvas").getContext("2d");
  const draw = () => { painted++; c.clearRect(0, 0, 1100, 700); c.beginPath();
    for (let i = 0; i < 1100; i++) c.lineTo(i, 350 + 300 * Math.sin(i / 50 + painted / 10)); c.stroke();
    requestAnimationFrame(draw); }; requestAnimationFrame(draw); }"""


def session() -> Session:
    """The TWIN under PD tracking at 0.4 Hz, without a model."""
    sine = LoopProgram(
        "tracking", Mode.TRACK, Waveform.SINE, amplitude=12.6, frequency=0.4, motor_torque=0.1
    )
    return Session(TWIN, LoopSettings(programs=(sine,)))


_PROGRAMS = [("tracking", "", "rad")]


@contextmanager
def observed(folder: Path) -> Iterator[tuple[Session, Observers]]:
    """A session with its page and a recording."""
    with (
        session() as live,
        Observers(
            live.ring, live.carry_out, programs=_PROGRAMS, motor_limit=0.95, folder=folder
        ) as watched,
    ):
        watched.record(True)
        yield live, watched


def cpu(pid: int) -> float:
    """Processor time of a process so far, in s."""
    words = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def frames(seconds: float) -> dict[str, Any]:
    """Page open, recording on."""
    from playwright.sync_api import sync_playwright

    with (
        tempfile.TemporaryDirectory() as folder,
        observed(Path(folder)) as (live, watched),
        sync_playwright() as pw,
    ):
        browser, page = window(pw)
        page.set_content("<canvas width=1100 height=700></canvas>")
        page.evaluate(_CANVAS)
        page.wait_for_timeout(3000)
        bare = page.evaluate("painted") / 3
        page.goto(watched.url)
        page.wait_for_url("**-*/")
        page.wait_for_timeout(5000)
        assert watched.page is not None
        pids = {
            "server": watched.page.pid,
            "recorder": watched.recordings.pid or 0,
            "session": os.getpid(),
        }
        before, start = {name: cpu(pid) for name, pid in pids.items()}, time.monotonic()
        first = page.evaluate("({ ...erclutch })")
        page.wait_for_timeout(seconds * 1000)
        last, passed = page.evaluate("({ ...erclutch })"), time.monotonic() - start
        used = {name: 100 * (cpu(pid) - before[name]) / passed for name, pid in pids.items()}
        browser.close()
        reader = RingReader(live.ring)
        head = reader.head
        reader.close()
        watched.record(False)
        kept = read_table(watched.recordings.files[0]).columns["seq"]
        rate = {
            key: (last[key] - first[key]) / passed
            for key in ("painted", "messages", "samples", "bytes", "drawing")
        }
    return {
        "origin": "TWIN",
        "a bare canvas, redrawn a second": round(bare, 1),
        "the page, redrawn a second": round(rate["painted"], 1),
        "own drawing, ms a redraw": round(rate["drawing"] / max(rate["painted"], 1e-9), 2),
        "messages a second": round(rate["messages"], 1),
        "samples a second": round(rate["samples"], 1),
        "kB a second": round(rate["bytes"] / 1000, 1),
        "processor, % of one core": {name: round(share, 1) for name, share in used.items()},
        "frames from loop to file, lost": int((np.diff(kept) - 1).sum()),
        "frames in the file, of the loop's": [int(kept.size), head],
        "load of the machine": os.getloadavg()[0],
    }


def kills(times: int) -> dict[str, Any]:
    """What a kill leaves in its file, and what all files together miss."""
    random = np.random.default_rng(0)
    lost: list[int] = []
    with session() as live, tempfile.TemporaryDirectory() as folder:
        recordings = Recordings(live.ring, folder)
        recordings.start("run")
        reader = RingReader(live.ring)
        for _ in range(times):
            recordings.wait_for_frames()
            time.sleep(random.uniform(0.0, 0.3))
            pid = recordings.pid or 0
            os.kill(pid, signal.SIGKILL)
            head = reader.head
            while recordings.pid in (pid, None):
                recordings.poll()
                time.sleep(0.005)
            lost.append(head - 1 - int(read_table(recordings.files[-1]).columns["seq"][-1]))
        recordings.wait_for_frames()
        recordings.stop()
        reader.close()
        kept = np.concatenate([read_table(path).columns["seq"] for path in recordings.files])
    return {
        "origin": "TWIN",
        "kills": times,
        "frames not yet in the file at a kill: median, largest": [
            float(np.median(lost)),
            max(lost),
        ],
        "kills that would have cost more than 100 frames": int(np.sum(np.array(lost) > 100)),
        "files": len(recordings.files),
        "frames missing from all files together": int((np.diff(kept) - 1).sum()),
        "frames twice": int(np.sum(np.diff(kept) <= 0)),
        "load of the machine": os.getloadavg()[0],
    }


def page_kills(times: int) -> dict[str, Any]:
    """The page's server is killed; its session, its recording and the browser have to come through."""
    from playwright.sync_api import sync_playwright

    random = np.random.default_rng(0)
    back: list[float] = []
    with (
        tempfile.TemporaryDirectory() as folder,
        observed(Path(folder)) as (live, watched),
        sync_playwright() as pw,
    ):
        browser, page = window(pw)
        page.goto(watched.url)
        page.wait_for_url("**-*/")
        assert watched.page is not None
        for _ in range(times):
            page.wait_for_timeout(float(random.uniform(0.0, 500.0)))
            before = page.evaluate("erclutch.connections")
            moment = time.monotonic()
            os.kill(watched.page.pid, signal.SIGKILL)
            state = f"erclutch.connections > {before} && erclutch.samples"
            while not (drawn := page.evaluate(state)) and time.monotonic() < moment + 20:
                page.wait_for_timeout(10)
            while page.evaluate("erclutch.samples") == drawn and time.monotonic() < moment + 20:
                page.wait_for_timeout(10)
            back.append(time.monotonic() - moment)
        banner = page.evaluate(
            "document.getElementById('banner').hidden ? '' : document.getElementById('banner-text').textContent"
        )
        browser.close()
        counts = RingReader(live.ring)
        head, restarts, stalls = counts.head, watched.page.restarts, counts.counts["overrun"]
        counts.close()
        alive = live.running
        watched.record(False)
        kept = np.concatenate(
            [read_table(path).columns["seq"] for path in watched.recordings.files]
        )
    return {
        "origin": "TWIN",
        "kills": times,
        "server started again": restarts,
        "page shows new samples again, s after a kill: median, largest": [
            float(np.median(back)),
            max(back),
        ],
        "page that did not come back within 20 s": sum(wait >= 20 for wait in back),
        "banner at the end": banner,
        "the loop runs": alive,
        "steps of the loop, wake-ups late by a period": [head, stalls],
        "frames in the recording, missing in between": [
            int(kept.size),
            int((np.diff(kept) - 1).sum()),
        ],
        "load of the machine": os.getloadavg()[0],
    }


def window(playwright: Any) -> tuple[Any, Any]:
    """A browser and an empty page in it."""
    browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=_FLAGS)
    return browser, browser.new_page(viewport={"width": 1440, "height": 900})


def disk() -> dict[str, Any]:
    """A disk of 1 MB, full after some 10 s."""
    said: list[str] = []
    with session() as live, tempfile.TemporaryDirectory() as folder:
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", folder], check=True)
        try:
            recordings = Recordings(
                live.ring, folder, lambda text, level: said.append(f"{level}: {text}")
            )
            recordings.start("run")
            limit = time.monotonic() + 60
            while recordings.running and time.monotonic() < limit:
                recordings.poll()
                time.sleep(0.05)
            reader = RingReader(live.ring)
            before = reader.head
            time.sleep(1.0)
            after = reader.head
            reader.close()
            table = read_table(recordings.files[0])
        finally:
            subprocess.run(["umount", folder], check=True)
        return {
            "origin": "TWIN",
            "said": said,
            "frames in the file": table.rows,
            "gaps in it": int((np.diff(table.columns["seq"]) - 1).sum()),
            "steps of the loop in the second after": after - before,
            "the loop runs": live.running,
        }


def main() -> None:
    """Print what was asked for as JSON."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["frames", "kills", "page-kills", "disk"])
    parser.add_argument("--seconds", type=float, default=30.0, help="of frames")
    parser.add_argument("--times", type=int, default=100, help="of kills")
    given = parser.parse_args()
    found = {
        "frames": lambda: frames(given.seconds),
        "kills": lambda: kills(given.times),
        "page-kills": lambda: page_kills(given.times),
        "disk": disk,
    }[given.what]()
    sys.stdout.write(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
