"""1,000 fits over 100 SYNTHETIC logs on threads, processes and a real Dask cluster: `python studies/fleet.py`.

Printed of each: digest of the tables, wall time, load of the machine. On Dask (scheduler and workers as processes of
their own, loopback) a worker is killed with -9 on the way, and the memory of the scheduler is read at the end.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from distributed import Client

from erclutch.fit.comparison import Settings
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.wings.fleet.fleet import fit_many

MODELS = (
    *("quadratic", "on-off", "herschel-bulkley", "rbfm-2"),
    *("bingham", "bingham/square", "bingham/critical", "casson", "casson/square", "casson/critical"),
)


@contextmanager
def dask_cluster(folder: Path, workers: int) -> Generator[tuple[str, int]]:
    """A scheduler and workers as processes; gives address and the scheduler's process."""
    python, where = sys.executable, folder / "scheduler.json"
    scheduler = [python, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
    scheduler += ["--no-dashboard", "--scheduler-file", str(where)]
    worker = [python, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(where), "--host", "127.0.0.1"]
    worker += ["--nworkers", "1", "--nthreads", "1", "--no-dashboard", "--local-directory", str(folder)]
    quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    begun = [subprocess.Popen(scheduler, **quiet)]
    try:
        while not where.exists():
            sleep(0.1)
        begun += [subprocess.Popen(worker, **quiet) for _ in range(workers)]
        with Client(scheduler_file=str(where), set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=120)
            address = str(client.scheduler.address)  # pyright: ignore[reportOptionalMemberAccess]
        yield address, begun[0].pid
    finally:
        for process in reversed(begun):  # a worker ends with its nanny
            process.kill()
            process.wait()


def kill_a_worker(address: str) -> None:
    """Kill one worker with -9; its nanny starts another."""
    with Client(address, set_as_default=False) as client:
        workers: Any = client.run(os.getpid)
        os.kill(next(iter(workers.values())), signal.SIGKILL)


def peak(process: int) -> float:
    """Largest memory of a process in MB."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1e3


def measured(logs: Path, out: Path, cluster: str | None, workers: int, kill_at: int = 0) -> str:
    """One fleet; prints a line and gives the digest."""

    def killed(done: int, total: int, name: str) -> None:
        if done == kill_at and cluster:
            kill_a_worker(cluster)

    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), monotonic()
    settings = Settings(lag="none")
    fleet = fit_many(logs, MODELS, out=out, settings=settings, cluster=cluster, workers=workers, progress=killed)
    wall, after = monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    words = f"{len(fleet.fits)} fits, {len(fleet.failed)} failed, {wall:.1f} s, children {cpu:.1f} CPU s"
    print(f"{cluster or 'threads'} x {workers}: {words}, load {os.getloadavg()[0]:.1f}", flush=True)
    taken = f", {fleet.taken} devices taken from an earlier start" if fleet.taken else ""
    print(f"  digest {fleet.digest}{taken}", flush=True)
    return fleet.digest


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--folder", type=Path, help="kept, so that a study that was stopped goes on")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = asked.folder or Path(name)
        logs = folder / "logs"
        logs.mkdir(parents=True, exist_ok=True)
        for i in range(len(list(logs.iterdir())), asked.logs):
            write_synthetic_log(logs / f"unit{i + 1}.csv", asked.seconds, i)
        with dask_cluster(Path(name), 2) as (address, scheduler):
            digests = [measured(logs, folder / "dask", address, 2, kill_at=asked.logs // 4)]
            print(f"scheduler: at most {peak(scheduler):.0f} MB; one worker was killed with -9", flush=True)
        for cluster, workers in (("processes", 2), ("processes", 1), (None, 2)):
            digests.append(measured(logs, folder / f"{cluster}-{workers}", cluster, workers))
    print(f"tables are {'the same' if len(set(digests)) == 1 else 'DIFFERENT'}")


if __name__ == "__main__":
    main()
