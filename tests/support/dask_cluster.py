"""A real Dask cluster on this machine: scheduler and workers as processes of their own, on the loopback address."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from time import sleep
from typing import Any


@contextmanager
def dask_cluster(folder: Path, workers: int) -> Generator[tuple[str, int]]:
    """A scheduler and workers as processes; gives address and the scheduler's process."""
    from distributed import Client  # its import takes longer than a test

    python, where = sys.executable, folder / "scheduler.json"
    scheduler = [
        python,
        "-m",
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
    ]
    scheduler += ["--no-dashboard", "--scheduler-file", str(where)]
    worker = [
        python,
        "-m",
        "distributed.cli.dask_worker",
        "--scheduler-file",
        str(where),
        "--host",
        "127.0.0.1",
    ]
    worker += [
        "--nworkers",
        "1",
        "--nthreads",
        "1",
        "--no-dashboard",
        "--local-directory",
        str(folder),
    ]
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
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        workers: Any = client.run(os.getpid)
        os.kill(next(iter(workers.values())), signal.SIGKILL)


def peak(process: int) -> float:
    """Largest memory of a process in MB."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1e3
