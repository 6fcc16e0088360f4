"""A SYNTHETIC log of any length, with rests, rare commands and a slow drift, and what a fit to it takes.

    python studies/large_log.py LOG.parquet --rows 100000000 --fit --cluster processes --workers 2 --out RUN

No law of the ladder is its truth: chains strain elastically before they yield (Dahl's model), the yield torque follows
the critical-field form, the viscosity thins with slip, the field lags behind the command, and the fluid warms up. The
log is made run by run, one row group a run, so that its length is bounded by the disk alone.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import numba
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

RATE = 1000.0  # rows a second
RUN = 250_000  # rows between two gaps of 1 s
_DAY = 40_000_000  # rows in which the laboratory warms and cools
UNITS = {"time": "s", "field": "V", "slip": "rad/s", "torque": "N*m"}


def run_of(number: int, rows: int) -> dict[str, np.ndarray]:
    """One run: a programme of commands and a programme of motion, and the torque with 0.4 % of noise.

    Args:
        number: of the run, counted from 0; the runs differ, and a run is the same each time.
        rows: its length.

    Returns:
        Time, field, slip and torque, each of shape (rows,).
    """
    rng = np.random.default_rng([20261125, number])
    time = np.arange(rows) / RATE
    command = _commands(rng, rows)  # [V]
    slip = _motion(rng, time)  # [rad/s]
    row = number * RUN + np.arange(rows)
    warmth = 1.0 - 0.08 * np.sin(2.0 * np.pi * row / _DAY)  # share of the yield torque that is left
    torque = _torque(command, slip, warmth) + 2.0e-3 * rng.standard_normal(rows)
    return {"time": time, "field": command, "slip": slip, "torque": np.round(torque, 4)}


def _commands(rng: np.random.Generator, rows: int) -> np.ndarray:
    """A square command of random height and length; zero in a third of the pieces, above 1600 V in 1 % of them."""
    lengths = rng.integers(10, 400, rows // 100 + 8)
    heights = np.round(rng.uniform(0.0, 1600.0, lengths.size))
    heights[rng.random(lengths.size) < 1 / 3] = 0.0
    rare = rng.random(lengths.size) < 0.01
    heights[rare] = np.round(rng.uniform(1600.0, 2000.0, int(rare.sum())))
    return np.resize(np.repeat(heights, lengths), rows)


def _motion(rng: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Slip of several sines, with rests of up to 6 s after motions of up to 20 s; a tenth of the runs is fast."""
    slip = np.zeros(time.size)
    for frequency in rng.uniform(0.05, 4.0, 4):
        slip += rng.uniform(1.0, 5.0) * np.sin(2.0 * np.pi * (frequency * time + rng.random()))
    if rng.random() < 0.1:
        slip *= 3.0
    pieces = time.size // 2_000 + 2
    seconds = np.column_stack([rng.uniform(3.0, 20.0, pieces), rng.uniform(0.5, 6.0, pieces)])
    moves = np.repeat(np.tile([1.0, 0.0], pieces), np.round(RATE * seconds.ravel()).astype(int))[
        : time.size
    ]
    ramp = int(0.2 * RATE)
    return slip * np.convolve(moves, np.full(ramp, 1.0 / ramp), "same")


@numba.njit(cache=True)
def _torque(command: np.ndarray, slip: np.ndarray, warmth: np.ndarray) -> np.ndarray:
    torque = np.empty(command.size)
    field = command[0]
    strain = 0.0  # of the chains over the strain at which they yield, from -1 to 1
    share = -np.expm1(-1.0 / (RATE * 4.0e-3))  # of the step of the command that is taken in a row
    for k in range(command.size):
        field += share * (command[k] - field)
        strength = field / 1500.0
        yield_torque = 0.02 + 0.45 * warmth[k] * strength**1.5 * np.tanh(strength**0.5)
        rate = slip[k] / 0.02
        strain = (strain + rate / RATE) / (1.0 + abs(rate) / RATE)
        viscosity = 4.0e-3 * (1.0 + 1.5 * strength) / (1.0 + abs(slip[k]) / 60.0) ** 0.3
        torque[k] = yield_torque * strain + viscosity * slip[k]
    return torque


def write_log(path: Path, rows: int) -> None:
    """Write the first rows of the log, whatever their number, with units in the columns' metadata."""
    schema = pa.schema(
        [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in UNITS.items()]
    )
    with pq.ParquetWriter(
        path, schema, compression="zstd", use_byte_stream_split=True, use_dictionary=False
    ) as out:
        for number, first in enumerate(range(0, rows, RUN)):
            run = run_of(number, min(RUN, rows - first))
            run["time"] = np.round(run["time"] + number * (RUN / RATE + 1.0), 3)
            out.write_table(
                pa.Table.from_arrays([pa.array(run[name]) for name in UNITS], schema=schema)
            )


def measured(words: list[str], rows: int) -> None:
    """Run ``erclutch`` with these words; print CPU s, us a row, and the peak memory of each process."""
    began, wall = os.times(), monotonic()
    process = subprocess.Popen([sys.executable, "-m", "erclutch", *words])
    peaks: dict[int, int] = {}  # bytes by process
    while process.poll() is None:
        for number in (process.pid, *_children(process.pid)):
            peaks[number] = max(peaks.get(number, 0), _peak(number))
        sleep(0.2)
    ended = os.times()
    spent = (
        ended.children_user + ended.children_system - began.children_user - began.children_system
    )
    main, *others = [f"{1e-9 * peak:.2f}" for peak in peaks.values()]
    print(
        f"SYNTHETIC, {rows:,} rows: {spent:.1f} CPU s, {1e6 * spent / rows:.2f} us a row, "
        f"{monotonic() - wall:.0f} s by the clock; {main} GB, workers {', '.join(others) or 'none'} GB"
    )


def _children(parent: int) -> list[int]:
    with contextlib.suppress(OSError):
        return [
            int(word) for word in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
        ]
    return []


def _peak(process: int) -> int:
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{process}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return 1024 * int(line.split()[1])
    return 0


def main() -> None:
    """Write the log where it is not there, and fit it where words for `erclutch fit` are given."""
    parser = argparse.ArgumentParser(
        description="Write a SYNTHETIC log of any length, and measure a fit to it."
    )
    parser.add_argument("log", type=Path)
    parser.add_argument("--rows", type=int, default=100_000_000)
    parser.add_argument(
        "--fit", nargs=argparse.REMAINDER, help="options of erclutch fit; the log is fitted then"
    )
    asked = parser.parse_args()
    if not asked.log.exists():
        write_log(asked.log, asked.rows)
        each = asked.log.stat().st_size / asked.rows
        print(f"SYNTHETIC, {asked.rows:,} rows, {each:.1f} bytes a row in Parquet", flush=True)
    if asked.fit is not None:
        measured(["fit", str(asked.log), *asked.fit], pq.read_metadata(asked.log).num_rows)


if __name__ == "__main__":
    main()
