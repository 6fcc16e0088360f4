"""What the twin costs: `python studies/twin_speed.py [--repeats 3]`. TWIN.

Each figure from a process of its own: compiling for the first time (into an empty cache) and loading what is compiled;
290 s of rig time (the training run, all columns made, nothing written); the same as a command, with its start and its
file; what each further second of rig time takes of that command; the largest memory of the 20-minute run.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile

_RUN = """
import resource, sys, time
name, seconds = sys.argv[1], float(sys.argv[2])
began = time.process_time()
from erclutch.wings.rig.twin.scenarios import prepare
for _ in prepare("training", seconds=1.0).chunks(): pass
ready = time.process_time()
for _ in prepare(name, seconds=seconds).chunks(): pass
print(ready - began, time.process_time() - ready, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000)
"""


def run(name: str, seconds: float, cache: str | None = None) -> tuple[float, float, float]:
    """CPU s until the first second is simulated, CPU s of the run after that, MB."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": cache} if cache else dict(os.environ)
    words = [sys.executable, "-c", _RUN, name, str(seconds)]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=True)
    start, rest, memory = (float(word) for word in done.stdout.split())
    return start, rest, memory


def command(folder: str, seconds: float) -> float:
    """CPU s of `erclutch simulate training`, from its start to its file."""
    words = [sys.executable, "-m", "erclutch", "simulate", "training", "--seconds", f"{seconds:g}"]
    words += ["--force", "--out", f"{folder}/training.parquet"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Speed and memory of the digital TWIN.")
    parser.add_argument("--repeats", type=int, default=3)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as cache:
        first, again = run("training", 1.0, cache)[0], run("training", 1.0, cache)[0]
    print(f"TWIN; load of the machine {os.getloadavg()[0]:.1f}")
    print(
        f"until the first second is simulated: {first:.1f} CPU s compiling, {again:.1f} CPU s from the cache"
    )
    times = sorted(run("training", 290.0)[1] for _ in range(asked.repeats))
    print(f"290 s of rig time: {times[0]:.2f} - {times[-1]:.2f} CPU s ({asked.repeats} runs)")
    with tempfile.TemporaryDirectory() as folder:
        pairs = [(command(folder, 290.0), command(folder, 580.0)) for _ in range(asked.repeats)]
    times = sorted(short for short, _ in pairs)
    shares = f"{290.0 / times[-1]:.0f} - {290.0 / times[0]:.0f} times real time"
    print(
        f"the same by erclutch simulate training: {times[0]:.2f} - {times[-1]:.2f} CPU s, {shares}"
    )
    further = sorted((long - short) / 290.0 for short, long in pairs)  # CPU s a second of rig time
    shares = f"{1.0 / further[-1]:.0f} - {1.0 / further[0]:.0f} times real time"
    print(
        f"of it each further second: {1e3 * further[0]:.2f} - {1e3 * further[-1]:.2f} CPU ms, {shares}"
    )
    _, long, memory = run("temperature", 1200.0)
    print(f"20 minutes of rig time: {long:.1f} CPU s, at most {memory:.0f} MB")


if __name__ == "__main__":
    main()
