"""1,000 fits over 100 SYNTHETIC logs on threads, processes and a real Dask cluster: `python studies/fleet.py`.

Printed of each: digest of the tables, wall time, load of the machine. On Dask (scheduler and workers as processes of
their own, loopback) a worker is killed with -9 on the way, and the memory of the scheduler is read at the end.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
from pathlib import Path
from time import monotonic

from erclutch.fit.comparison import Settings
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.wings.fleet.fleet import fit_many

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.dask_cluster import dask_cluster, kill_a_worker, peak

MODELS = (
    *("quadratic", "on-off", "herschel-bulkley", "rbfm-2"),
    *(
        "bingham",
        "bingham/square",
        "bingham/critical",
        "casson",
        "casson/square",
        "casson/critical",
    ),
)


def measured(logs: Path, out: Path, cluster: str | None, workers: int, kill_at: int = 0) -> str:
    """One fleet; prints a line and gives the digest."""

    def killed(done: int, total: int, name: str) -> None:
        if done == kill_at and cluster:
            kill_a_worker(cluster)

    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), monotonic()
    settings = Settings(lag="none")
    fleet = fit_many(
        logs, MODELS, out=out, settings=settings, cluster=cluster, workers=workers, progress=killed
    )
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
    parser.add_argument(
        "--folder", type=Path, help="kept, so that a study that was stopped goes on"
    )
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = asked.folder or Path(name)
        logs = folder / "logs"
        logs.mkdir(parents=True, exist_ok=True)
        for i in range(len(list(logs.iterdir())), asked.logs):
            write_synthetic_log(logs / f"unit{i + 1}.csv", asked.seconds, i)
        with dask_cluster(Path(name), 2) as (address, scheduler):
            digests = [measured(logs, folder / "dask", address, 2, kill_at=asked.logs // 4)]
            print(
                f"scheduler: at most {peak(scheduler):.0f} MB; one worker was killed with -9",
                flush=True,
            )
        for cluster, workers in (("processes", 2), ("processes", 1), (None, 2)):
            digests.append(measured(logs, folder / f"{cluster}-{workers}", cluster, workers))
    print(f"tables are {'the same' if len(set(digests)) == 1 else 'DIFFERENT'}")


if __name__ == "__main__":
    main()
