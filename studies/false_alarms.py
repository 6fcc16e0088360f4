"""Rows that the check of sensors leaves out of logs in which nothing is wrong: `python studies/false_alarms.py`.

REAL: the recordings of shared/data, those beside the project. TWIN: logs of `erclutch simulate` by several seeds.
Printed: a line a log with its rows, and each word on rows left out; the exit code is 1 where any row was left out.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from erclutch.logs import read
from erclutch.signals.recording import Recording

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
NEES = {"field": "Y [V]", "slip": "V [cm/s]", "position": "D [cm]", "effort": "F [N]"}
SMOOTHED = {
    "time": 1,
    "columns": {"position": "2 [mm]", "slip": "3 [mm/s]", "effort": "4 [N]"},
    "name_pattern": "{amplitude}mm{frequency}Hz{field}A",
}
RAW = {
    "columns": {"position": "CHANNEL0 [cm]", "effort": "CHANNEL1 [980.665 N]"},
    "constants": {"field": "0.5 A"},
}
SEEDS = range(5)
LEFT_OUT = "left out and the log cut there"


def recordings(data: Path, folder: Path) -> Iterator[tuple[str, Recording]]:
    """Each log with the word on where it comes from."""
    yield "REAL", read(data / "mr_damper_nees" / "ranran_50_converted.csv", NEES)
    for path in sorted((data / "mr_damper_utfsm" / "preprocessed").glob("*.txt")):
        yield "REAL", read(path, SMOOTHED)
    for path in sorted((data / "mr_damper_utfsm" / "raw").glob("*.txt")):
        yield "REAL", read(path, RAW)
    for seed in SEEDS:
        log = folder / f"twin-{seed}.parquet"
        words = ["simulate", "training", "--seed", str(seed), "--out", str(log)]
        subprocess.run([sys.executable, "-m", "erclutch", *words], check=True, capture_output=True)
        yield "TWIN", read(log, device="coaxial")


def main() -> int:
    """Print a line a log; the exit code says whether any row was left out."""
    data = Path(sys.argv[1]) if len(sys.argv) > 1 else DATA
    logs = alarms = 0
    with tempfile.TemporaryDirectory() as folder:
        for origin, log in recordings(data, Path(folder)):
            said = [note for note in log.notes if LEFT_OUT in note or "no measurement" in note]
            print(f"{origin} {log.name}: {log.rows:,} rows", *said, sep="\n    ", flush=True)
            logs, alarms = logs + 1, alarms + len(said)
    print(f"{logs} logs, {alarms} false alarms")
    return int(alarms > 0)


if __name__ == "__main__":
    sys.exit(main())
