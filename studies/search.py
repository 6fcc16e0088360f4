"""What the fitting's choices cost and gain: `python studies/search.py [LOG --field ... --slip ... --effort ...]`.

For each law with a lag: how far the default search ends above one with ten times as many points and five times as many
local solves, and the CPU time of both; then how much wider intervals get by the residuals' correlation; then the lag's
recursion against a Python loop. Without a log: on the SYNTHETIC one of `erclutch demo`.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import erclutch
from erclutch.fit.laws import fit_law
from erclutch.logs.dataset import Dataset
from erclutch.logs.synthetic import LABEL, write_synthetic_log
from erclutch.models.law_model import Structure
from erclutch.models.laws import ladder, law_from_name
from erclutch.models.stages import command_lag


def training_rows() -> tuple[str, Dataset]:
    """The rows that the study fits, and what they are."""
    parser = argparse.ArgumentParser(description="The default search against a wide one.")
    parser.add_argument("log", nargs="?")
    for signal in ("field", "slip", "effort"):
        parser.add_argument(f"--{signal}")
    asked = parser.parse_args()
    given = {name: value for name in ("field", "slip", "effort") if (value := getattr(asked, name))}
    if asked.log:
        name, log = Path(asked.log).name, erclutch.read(asked.log, given)
    else:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "synthetic.csv"
            write_synthetic_log(path)
            name, log = LABEL, erclutch.read(path)
    data = erclutch.build_dataset(log)
    return name, data.take(~erclutch.hold_out(data, 0.3))


def search(data: Dataset) -> None:
    """The default search against a wide one, law by law."""
    print(f"{'law':20}{'excess':>10}{'default [s]':>13}{'wide [s]':>10}")
    usual = fit_law._ROUGH_STARTS
    for name in ladder():
        structure = Structure("single", name, law_from_name(name), "lag", True, True)
        costs, seconds = [], []
        for starts, points in ((usual, fit_law._SCAN_POINTS), (5 * usual, 10 * fit_law._SCAN_POINTS)):
            fit_law._ROUGH_STARTS = starts
            began = time.process_time()
            costs.append(fit_law.fit_structure(data, structure, scan=points).train_cost)
            seconds.append(time.process_time() - began)
        fit_law._ROUGH_STARTS = usual
        print(f"{name:20}{costs[0] / min(costs) - 1:10.1e}{seconds[0]:13.2f}{seconds[1]:10.2f}", flush=True)


def intervals(data: Dataset) -> None:
    """Widths of the intervals with the order in time over those without, for Bingham with a lag."""
    structure = Structure("single", "bingham", law_from_name("bingham"), "lag", True, True)
    ordered, classical = (fit_law.fit_structure(data, structure, ordered=o) for o in (True, False))
    pairs = zip(ordered.estimates, classical.estimates, strict=True)
    ratios = {a.name: (a.high - a.low) / (b.high - b.low) for a, b in pairs if not a.at_bound}
    print("interval over the classical one:", ", ".join(f"{name} {ratio:.1f}" for name, ratio in ratios.items()))


def recursion(data: Dataset) -> None:
    """The lag in machine code against the same row by row."""
    field = data.elements[0].field
    share = np.broadcast_to(command_lag._share(data.clock, 5e-3), field.shape)

    def loop() -> None:
        for span in data.clock.spans:
            state = float(field[span.start])
            for command, gone in zip(
                field[span.start : span.stop].tolist(), share[span.start : span.stop].tolist(), strict=True
            ):
                state += gone * (command - state)

    times = {}
    for name, run in (("machine code", lambda: command_lag._filter(field, data.clock, share)), ("loop", loop)):
        times[name] = min(_seconds(run) for _ in range(5))
    print(
        f"lag of {field.size} rows: machine code {1e3 * times['machine code']:.2f} ms, "
        f"loop {times['loop'] / times['machine code']:.0f} times that"
    )


def _seconds(run: Any) -> float:
    began = time.perf_counter()
    run()
    return time.perf_counter() - began


def main() -> None:
    """Print all three, with one BLAS thread."""
    limits: Any = import_module("threadpoolctl").threadpool_limits
    name, data = training_rows()
    print(f"{name}: {np.size(data.effort)} training rows")
    with limits(1):
        search(data)
        intervals(data)
        recursion(data)


if __name__ == "__main__":
    main()
