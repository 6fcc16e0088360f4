"""Time and memory of fits to logs larger than memory, on the TWIN: `python studies/large.py [--rows 10000000]`.

Training runs of the twin with seeds 0, 1, 2, ... (a row group each) become logs of 10^5 rows up to those asked for, and
a process of its own fits each model to each log: `erclutch fit-large`. All that is done is kept in --folder, so that a
run that was stopped goes on; --minutes stops it by itself.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from erclutch.logs.log_writer import write_log
from erclutch.rig.twin.scenarios import prepare

SECONDS = 290.0
PAUSE = 1.0  # s between two runs: a gap in the log, over which no speed is differentiated
SIZES = (100_000, 1_000_000, 3_000_000, 10_000_000)
MODELS = ("rbfm-10/forward", "fnn-16")


def run_file(folder: Path, scenario: str, seed: int) -> Path:
    """The log of one run, made once."""
    path = folder / f"{scenario}-{seed}.parquet"
    if not path.exists():
        run = prepare(scenario, seed=seed, seconds=SECONDS if scenario == "training" else None)
        write_log(path, run.names, run.chunks(), run.about(), rows=run.rows)
    return path


def joined(folder: Path, rows: int) -> Path:
    """One log of so many rows, made once: a row group a run, one run after another in time."""
    path = folder / f"twin-{rows}.parquet"
    if path.exists():
        return path
    partial = path.with_suffix(".partial")
    left, seed = rows, 0
    first = run_file(folder, "training", 0)
    schema = pq.read_schema(first)
    with pq.ParquetWriter(partial, schema, compression="zstd", use_byte_stream_split=True, use_dictionary=False) as to:
        while left:
            table = pq.read_table(run_file(folder, "training", seed), schema=schema)[:left]
            at = schema.get_field_index("time")
            time = table.column(at).to_numpy() + seed * (SECONDS + PAUSE)
            to.write_table(table.set_column(at, schema.field(at), pa.array(np.round(time, 3))), row_group_size=10**9)
            left, seed = left - table.num_rows, seed + 1
    os.replace(partial, path)
    return path


def fitted(folder: Path, rows: int, model: str) -> dict[str, Any]:
    """What `erclutch fit-large` prints, in a process of its own; kept."""
    path = folder / f"fit-{rows}-{model.replace('/', '_')}.json"
    if not path.exists():
        command = [sys.executable, "-m", "erclutch", "fit-large", str(joined(folder, rows)), "--device", "coaxial"]
        command += ["--models", model, "--test-log", str(run_file(folder, "test", 1000)), "--workers", "1", "--json"]
        began = os.times()
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        ended = os.times()
        spent = ended.children_user + ended.children_system - began.children_user - began.children_system
        partial = path.with_suffix(".partial")
        partial.write_text(json.dumps({**json.loads(done.stdout), "process_cpu_seconds": spent}))
        os.replace(partial, path)
    return json.loads(path.read_text())


def line(rows: int, model: str, found: dict[str, Any]) -> str:
    """One line of the table."""
    own, costs = found["models"][0], found["cpu_seconds"]
    return (
        f"{rows:12,}  {model:16}{costs['read']:9.1f}{costs[own['name']]:9.1f}{found['process_cpu_seconds']:9.1f}"
        f"{1e6 * found['process_cpu_seconds'] / rows:9.2f}{found['peak_memory_bytes'] / 1e6:9.0f}"
        f"{own['train_mse']:12.4e}{own['test_mse']:12.4e}"
    )


def main() -> None:
    """Make what is missing, then print the table."""
    parser = argparse.ArgumentParser(description="Fits to long logs of the digital TWIN.")
    parser.add_argument("--rows", type=int, default=10_000_000)
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "erclutch-large")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after these; run again to go on")
    parser.add_argument("--processes", type=int, default=2, help="runs of the twin side by side")
    asked = parser.parse_args()
    began = monotonic()
    asked.folder.mkdir(parents=True, exist_ok=True)
    sizes = sorted({size for size in SIZES if size < asked.rows} | {asked.rows})
    print("TWIN, training runs of 290,000 rows and the test run; a process each, one thread")
    heads = "".join(f"{head:>9}" for head in ("read", "fit", "CPU s", "us/row", "peak MB"))
    print(f"{'rows':>12}  {'model':16}{heads}{'train':>12}{'test':>12}", flush=True)

    def late() -> None:
        if monotonic() - began > 60.0 * asked.minutes:
            sys.exit("not all is done; run this again to go on")

    with ProcessPoolExecutor(asked.processes) as pool:
        for rows in sizes:
            runs = [("test", 1000)] + [("training", seed) for seed in range(-(-rows // int(1000 * SECONDS)))]
            for at in range(0, len(runs), asked.processes):
                late()
                some = runs[at : at + asked.processes]
                list(pool.map(run_file, [asked.folder] * len(some), [s for s, _ in some], [k for _, k in some]))
            for model in MODELS:
                late()
                print(line(rows, model, fitted(asked.folder, rows, model)), flush=True)


if __name__ == "__main__":
    main()
