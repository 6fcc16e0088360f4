"""Time and memory of fits to logs larger than memory, on SYNTHETIC logs: `python studies/large.py [--rows 10000000]`.

The parts are logs of a coaxial pair whose torque follows the command with a lag of 30 ms. A process of its own fits
the models with each number of workers: `erclutch fit-large`. All that is done is kept in --folder, so that a run that
was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.signal import lfilter
from threadpoolctl import threadpool_limits

from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.fit.kinds.network_alone import networks_for
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks.fit_network import fit_network
from erclutch.logs import read
from erclutch.logs.dataset import build_dataset
from erclutch.models.law_model import Structure
from erclutch.runs.large_fit import fit_large

RUN = 290_000  # rows at 1 kHz between two gaps of 1 s
MODELS = ("rbfm-10/forward", "fnn-16", "hem/square+lag")
UNITS = {"time": "s", "E1": "", "E2": "", "theta_dot": "rad/s", "alpha_dot": "rad/s", "T": "N*m"}


def run_columns(seed: int, rows: int) -> dict[str, np.ndarray]:
    """One recording: fields of one clutch at a time, two drives, and the torque with 1 % of noise."""
    rng = np.random.default_rng([20261123, seed])
    t = np.arange(rows) * 1e-3
    a, b, c, d = rng.uniform(0.8, 1.25, 4)
    signed = 0.5 * np.sin(2.1 * a * t) * np.sin(0.37 * b * t + seed)
    fields = np.maximum(signed, 0.0), np.maximum(-signed, 0.0)
    w, v = 30.0 + 6.0 * np.cos(3.0 * c * t), 45.0 * np.cos(1.3 * d * t)
    share = -np.expm1(-1e-3 / 0.03)
    torque = 1e-3 * rng.standard_normal(rows)
    for way, field, slip in ((1.0, fields[0], w - v), (-1.0, fields[1], w + v)):
        inside = lfilter([share], [1.0, share - 1.0], field)
        torque += way * (0.4 * inside**2 * np.tanh(slip) + 2e-4 * slip)
    return {"time": t, "E1": fields[0], "E2": fields[1], "theta_dot": w, "alpha_dot": v, "T": torque}


def part_file(folder: Path, part: int, rows: int) -> Path:
    """One part, made once: a row group a recording."""
    path = folder / f"part-{rows}-{part:03}.parquet"
    if path.exists():
        return path
    partial = path.with_suffix(".partial")
    schema = pa.schema([pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in UNITS.items()])
    with pq.ParquetWriter(partial, schema, compression="zstd", use_byte_stream_split=True, use_dictionary=False) as to:
        for k, at in enumerate(range(0, rows, RUN)):
            columns = run_columns(1000 * part + k, min(RUN, rows - at))
            columns["time"] = np.round(columns["time"] + k * (1e-3 * RUN + 1.0), 3)
            to.write_table(pa.Table.from_arrays([pa.array(x) for x in columns.values()], schema=schema))
    os.replace(partial, path)
    return path


def fitted(
    folder: Path, parts: list[Path], test: Path, models: list[str], cluster: str, workers: int
) -> dict[str, Any]:
    """What `erclutch fit-large` prints, in a process of its own; kept."""
    rows = pq.ParquetFile(parts[0]).metadata.num_rows * len(parts)
    path = folder / f"fit-{rows}-{'-'.join(models).replace('/', '_')}-{cluster}-{workers}.json"
    if not path.exists():
        command = [sys.executable, "-m", "erclutch", "fit-large", *map(str, parts), "--device", "coaxial"]
        command += ["--models", *models, "--test-log", str(test), "--cluster", cluster, "--workers", str(workers)]
        began, wall = os.times(), monotonic()
        done = subprocess.run([*command, "--scratch", str(folder), "--json"], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr)
        ended = os.times()
        spent = ended.children_user + ended.children_system - began.children_user - began.children_system
        partial = path.with_suffix(".partial")
        own = {"process_cpu_seconds": spent, "wall_seconds": monotonic() - wall}
        partial.write_text(json.dumps({**json.loads(done.stdout), **own}))
        os.replace(partial, path)
    return json.loads(path.read_text())


def table(rows: int, workers: int, found: dict[str, Any]) -> None:
    """A line for each model, and one for the process."""
    costs = found["cpu_seconds"]
    for own in found["models"]:
        fit = costs[own["name"]]
        each = 1e6 * (costs["read"] + fit) / rows
        print(
            f"{rows:12,} {own['name']:16}{workers:3}{costs['read']:8.1f}{fit:8.1f}{each:9.2f}"
            f"{own['test_mse']:12.4e}  {own['model_digest'][:12]}"
        )
    peaks = [1e-6 * (found[key] or 0) for key in ("peak_memory_bytes", "worker_memory_bytes")]
    print(
        f"all: {found['process_cpu_seconds']:.1f} CPU s, {found['wall_seconds']:.0f} s by the clock; "
        f"{peaks[0]:.0f} MB, each worker {peaks[1]:.0f} MB",
        flush=True,
    )


def compared(folder: Path, rows: int, models: list[str]) -> None:
    """Whether the models of one log are those of a fit in memory, to the bit."""
    path = part_file(folder, 0, rows)
    data = build_dataset(read(path, device="coaxial"), device="coaxial")
    found = fit_large(path, models, device="coaxial", scratch=folder)
    settings = Settings(tuple(models), lag="none")
    structures = [*structures_for(data, settings), *networks_for(data, settings)]
    for structure, entry in zip(structures, found.entries, strict=True):
        with threadpool_limits(1):
            law = isinstance(structure, Structure)
            fit: Any = partial(fit_structure, intervals=False) if law else fit_network
            digests = [o.model.to_dict()["digest"][:12] for o in (fit(data, structure), entry.outcome)]
        same = "the same" if digests[0] == digests[1] else "another"
        print(f"{rows:12,} rows in memory: {entry.name:16} {digests[0]}, on disk {digests[1]}: {same}", flush=True)


def main() -> None:
    """Make what is missing, then print the table."""
    parser = argparse.ArgumentParser(description="Fits to long SYNTHETIC logs.")
    parser.add_argument("--rows", type=int, default=10_000_000)
    parser.add_argument("--parts", type=int, default=10)
    parser.add_argument("--models", nargs="+", default=MODELS)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--cluster", default="processes")
    parser.add_argument("--memory", type=int, default=0, help="rows of one log to fit in memory too; then nothing else")
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "erclutch-large")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    if asked.memory:
        compared(asked.folder, asked.memory, asked.models)
        return
    with ProcessPoolExecutor(2) as pool:
        jobs = [pool.submit(part_file, asked.folder, k, asked.rows // asked.parts) for k in range(asked.parts)]
        jobs.append(pool.submit(part_file, asked.folder, 999, RUN))
        *parts, test = [job.result() for job in jobs]
    size = sum(part.stat().st_size for part in parts) / asked.rows
    print(f"SYNTHETIC, {asked.parts} parts of {asked.rows // asked.parts:,} rows, {size:.1f} bytes a row in Parquet")
    print(
        f"{'rows':>12} {'model':16}{'w.':>3}{'read s':>8}{'fit s':>8}{'us/row':>9}{'test MSE':>12}  digest", flush=True
    )
    for workers in asked.workers:
        table(asked.rows, workers, fitted(asked.folder, parts, test, asked.models, asked.cluster, workers))


if __name__ == "__main__":
    main()
