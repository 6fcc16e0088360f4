"""One contender in a process of its own. Prints one line of JSON.

python benchmarks/peer.py rows ROWS.npz --seconds 290 --seed 0
python benchmarks/peer.py GROUP ROWS.npz --name NAME --limit 120 --seed 0 --threads 1
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import calls
import fnn
import laws
import rows
import scipy.linalg
import scipy.optimize  # noqa: F401  # here, so that no contender pays for loading it
from task import Fit, Task
from watch import OutOfTimeError, Watch, mse, peak_megabytes


def measure(task: Task, fit: Fit) -> dict[str, Any]:
    """Run a fit against the clock and score what came out."""
    watch = task.watch
    limited = False
    watch.start()
    try:
        predict = fit(task)
        if not watch.recorded:
            watch.stop()
            watch.finish(predict)
    except OutOfTimeError:
        limited = True
        task.notes.append("CPU limit")
        if watch.latest is None:
            return {"error": "nothing within the CPU limit"}
        predict = watch.latest
        watch.finish(predict)
    peak = peak_megabytes()
    task.check()
    return {
        "trace": watch.points,
        "cpu": watch.points[-1][0],
        "wall": watch.wall,
        "train": mse(predict, task.train),
        "test": watch.points[-1][1],
        "peak": peak,
        "limited": limited,
        "notes": task.notes,
    }


def contend(arguments: argparse.Namespace) -> dict[str, Any]:
    """What one contender reached, or why it reached nothing."""
    train, test, scaling = rows.load(arguments.rows)
    watch = Watch(test, arguments.limit)
    task = Task(arguments.group, train, scaling, watch, arguments.seed, arguments.threads)
    try:
        if arguments.group == "call":
            return {
                "microseconds": calls.microseconds(task, arguments.name),
                "peak": peak_megabytes(),
            }
        fits = fnn.FITS if arguments.group == "fnn" else laws.FITS
        return measure(task, fits[arguments.name])
    except ModuleNotFoundError as error:
        return {"missing": error.name}
    except Exception as error:  # a peer that breaks must not end the run
        return {"error": f"{type(error).__name__}: {error}".splitlines()[0][:160]}


def main() -> None:
    """Make the rows, or run one contender."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("group")
    parser.add_argument("rows", type=Path)
    parser.add_argument("--name", default="")
    parser.add_argument("--seconds", type=float, default=290.0)
    parser.add_argument("--limit", type=float, default=120.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    warnings.filterwarnings("ignore")
    if arguments.group == "rows":
        rows.save(arguments.rows, arguments.seconds, arguments.seed)
        train, test, _ = rows.load(arguments.rows)
        print(json.dumps({"training": train.data.rows, "test": test.data.rows}))
        return
    print(json.dumps(contend(arguments)))


if __name__ == "__main__":
    main()
