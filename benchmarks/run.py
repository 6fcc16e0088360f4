"""Compare erclutch's fits with named peers, on the same rows of the digital twin, in one run.

Each contender runs in a process of its own, one after another; see README.md for what is measured.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from contenders import CONTENDERS, GROUPS, Contender

_NEAR = 1.02  # of the best known test MSE
_POOLS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)

#: One contender's figures, by column.
Line = dict[str, Any]
COLUMNS = {
    "contender": "contender",
    "near": "CPU s to 2 %",
    "test": "test MSE",
    "train": "train MSE",
    "cpu": "CPU s",
    "wall": "wall s",
    "peak": "peak MB",
    "ratio": "time/ours",
    "notes": "notes",
}
CALL_COLUMNS = {
    "contender": "contender",
    "microseconds": "us a call",
    "ratio": "time/ours",
    "notes": "notes",
}


def environment(threads: int) -> dict[str, str]:
    """This process's environment with the threads of all numerical libraries set."""
    serial = (
        "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1" if threads == 1 else ""
    )
    own = {name: str(threads) for name in _POOLS}
    return {**os.environ, **own, "XLA_FLAGS": serial, "JAX_PLATFORMS": "cpu"}


def child(words: Sequence[str], threads: int, patience: float | None = None) -> dict[str, Any]:
    """The line of JSON that a child process prints."""
    command = [sys.executable, str(Path(__file__).with_name("peer.py")), *words]
    try:
        done = subprocess.run(
            command, env=environment(threads), capture_output=True, text=True, timeout=patience
        )
    except subprocess.TimeoutExpired:
        return {"error": "ended by the wall clock"}
    lines = done.stdout.strip().splitlines()
    if done.returncode or not lines:
        said = done.stderr.strip().splitlines()[-1:] or [""]
        return {"error": f"exit {done.returncode} {said[0]}"[:160]}
    return json.loads(lines[-1])


def compete(
    chosen: Sequence[Contender], rows: Path, options: argparse.Namespace
) -> list[dict[str, Any]]:
    """Run the contenders one after another."""
    results: list[dict[str, Any]] = []
    for i, contender in enumerate(chosen, start=1):
        print(
            f"[{i}/{len(chosen)}] {contender.group}: {contender.name}", file=sys.stderr, flush=True
        )
        words = [
            contender.group,
            str(rows),
            "--name",
            contender.name,
            "--limit",
            str(options.limit),
        ]
        words += ["--seed", str(options.seed), "--threads", str(options.threads)]
        results.append(child(words, options.threads, 4.0 * options.limit + 120.0))
    return results


def lines_of(chosen: Sequence[Contender], results: Sequence[Mapping[str, Any]]) -> list[Line]:
    """The lines of one group's table."""
    best = min((r["test"] for r in results if r.get("test") is not None), default=float("nan"))
    lines: list[Line] = []
    for contender, result in zip(chosen, results, strict=True):
        line: Line = {"group": contender.group, "contender": contender.name, "ours": contender.ours}
        if "missing" in result:
            line["notes"] = f"not installed ({result['missing']}): pip install {contender.package}"
        elif "error" in result:
            line["notes"] = f"failed: {result['error']}"
        elif "microseconds" in result:
            line |= {"microseconds": result["microseconds"], "notes": ""}
        else:
            near = next((cpu for cpu, test in result["trace"] if test <= _NEAR * best), None)
            line |= {
                key: result[key] for key in ("test", "train", "cpu", "wall", "peak", "limited")
            }
            line |= {"near": "never" if near is None else near, "notes": "; ".join(result["notes"])}
        lines.append(line)
    return with_ratios(lines)


def with_ratios(lines: list[Line]) -> list[Line]:
    """Add each line's time over erclutch's: to within 2 % of the best, or a call."""
    key = "microseconds" if any("microseconds" in line for line in lines) else "near"
    ours = min(
        (line[key] for line in lines if line["ours"] and isinstance(line.get(key), float)),
        default=None,
    )
    for line in lines:
        if ours is None or key not in line:
            line["ratio"] = "-"
        elif line[key] == "never":
            line["ratio"] = (
                f"> {line['cpu'] / ours:.3g}" if line["limited"] and not line["ours"] else "never"
            )
        else:
            line["ratio"] = f"{line[key] / ours:.3g}"
    return lines


def as_text(value: Any, column: str) -> str:
    """A cell."""
    if value is None:
        return "-"
    if not isinstance(value, float):
        return str(value)
    digits = {"test": ".5g", "train": ".5g", "peak": ".0f", "near": ".3g", "microseconds": ".1f"}
    return format(value, digits.get(column, ".3g"))


def table(title: str, columns: Mapping[str, str], lines: Sequence[Line]) -> str:
    """Lines as plain text, columns aligned."""
    cells = [
        list(columns.values()),
        *([as_text(line.get(key), key) for key in columns] for line in lines),
    ]
    widths = [max(len(row[i]) for row in cells) for i in range(len(columns))]
    text = [title]
    for row in cells:
        middle = (cell.rjust(width) for cell, width in zip(row[1:-1], widths[1:-1], strict=True))
        text.append("  ".join([row[0].ljust(widths[0]), *middle, row[-1]]).rstrip())
    return "\n".join(text)


def write(path: Path, lines: Sequence[Line]) -> None:
    """All lines as CSV."""
    columns = [
        "group",
        "contender",
        "near",
        "test",
        "train",
        "cpu",
        "wall",
        "peak",
        "microseconds",
        "ratio",
        "notes",
    ]
    names = {"near": "cpu_s_to_2_percent", "test": "twin_test_mse", "train": "twin_train_mse", "cpu": "cpu_s",
             "wall": "wall_s", "peak": "peak_mb", "ratio": "time_over_erclutch"}  # fmt: skip
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([names.get(column, column) for column in columns])
        writer.writerows([line.get(column, "") for column in columns] for line in lines)


def options_of(words: Sequence[str] | None = None) -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="30 s of rows and 5 CPU s a contender, as a smoke test"
    )
    parser.add_argument(
        "--seconds", type=float, default=290.0, help="length of the twin's training run"
    )
    parser.add_argument("--limit", type=float, default=120.0, help="CPU s a contender")
    parser.add_argument(
        "--only",
        metavar="NAME",
        help="groups or contenders with this in their name: fnn, torch, ...",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the twin's runs and of the starts")
    parser.add_argument(
        "--threads", type=int, default=1, choices=(1, 2), help="threads a contender"
    )
    parser.add_argument("--out", type=Path, help="CSV file for the figures")
    options = parser.parse_args(words)
    if options.quick:
        options.seconds, options.limit = min(options.seconds, 30.0), min(options.limit, 5.0)
    return options


def main() -> None:
    """Make the rows, run all contenders, print a table as each group ends."""
    options = options_of()
    chosen = [
        c
        for c in CONTENDERS
        if not options.only or options.only.lower() in f"{c.group}/{c.name}".lower()
    ]
    if not chosen:
        sys.exit(f"no group or contender with {options.only!r} in its name")
    everything: list[Line] = []
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.npz"
        counts = child(
            ["rows", str(rows), "--seconds", str(options.seconds), "--seed", str(options.seed)], 1
        )
        if "error" in counts:
            sys.exit(f"no rows: {counts['error']}")
        print(
            f"TWIN (digital twin, no measurement): {counts['training']} training rows, {counts['test']} test rows, "
            f"seed {options.seed}\n{options.threads} thread(s), {options.limit:g} CPU s a contender, MSE in (N m)^2, "
            f"Python {platform.python_version()} on {platform.system()} {platform.machine()}"
        )
        for group, title in GROUPS.items():
            picked = [c for c in chosen if c.group == group]
            if picked:
                lines = lines_of(picked, compete(picked, rows, options))
                columns = CALL_COLUMNS if group == "call" else COLUMNS
                print("\n" + table(f"TWIN, {title}", columns, lines), flush=True)
                everything += lines
    if options.out is not None:
        write(options.out, everything)


if __name__ == "__main__":
    main()
