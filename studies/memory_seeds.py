"""How surely a law with memory is fitted to its best known optimum: `python studies/memory_seeds.py FOLDER`.

Each seed gives the search another scan: points drawn at random in place of the even ones, and half to twice as many of
them. The best known optimum is the lowest cost of all fits of the structure in the run, the default one too. FOLDER
holds the recordings of two real magnetorheological dampers: NEES is trained on its first 70 %, UTFSM on all logs but
those at 0.5 A and those at 5 mm and 3 Hz.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import process_time

import numpy as np
import pandas as pd

from erclutch.fit.laws import fit_law
from erclutch.fit.one_thread import one_thread
from erclutch.logs.dataset import Dataset, hold_out
from erclutch.models.law_model import Structure
from erclutch.models.laws import law_from_name
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

CASES = (
    ("NEES", "bingham", "rise-fall+dahl/field"),
    ("NEES", "bingham", "rise-fall+dahl/field+inertia+effort-lag"),
    ("NEES", "hem", "rise-fall+dahl/field+inertia+effort-lag"),
    ("NEES", "bingham", "rise-fall+dahl-2/field"),
    ("NEES", "hem", "rise-fall+dahl-2/field"),
    ("UTFSM", "bingham", "dahl+viscous+effort-lag+inertia"),
    ("UTFSM", "bingham", "dahl-2+viscous+effort-lag+inertia"),
    ("UTFSM", "hem", "dahl+viscous+effort-lag+inertia"),
)


def nees(folder: Path) -> Dataset:
    """The training rows of NEES."""
    log = pd.read_csv(folder / "mr_damper_nees" / "ranran_50_converted.csv")
    field, slip, effort = (log[name].to_numpy(float) for name in ("Y", "V", "F"))
    period = 3.328e-4
    clock = Clock(np.arange(effort.size) * period, (Span(0, effort.size, period),))
    data = Dataset("single", (Element(field, slip),), effort, clock, Units("N", "V", "cm/s"))
    return data.take(~hold_out(data, 0.3))


def utfsm(folder: Path) -> Dataset:
    """The training rows of UTFSM."""
    logs: list[np.ndarray] = []
    for path in sorted((folder / "mr_damper_utfsm" / "preprocessed").glob("*.txt")):
        current = float(path.stem.split("Hz")[1].removesuffix("A").replace("x", "."))
        if current != 0.5 and not path.name.startswith("5mm3Hz"):
            log = np.loadtxt(path)
            logs.append(np.column_stack([log, np.full(len(log), current)]))
    ends = np.cumsum([0, *map(len, logs)])
    periods = [float(log[1, 0] - log[0, 0]) for log in logs]
    spans = tuple(Span(int(a), int(b), p) for a, b, p in zip(ends, ends[1:], periods, strict=False))
    time, _, slip, effort, field = np.vstack(logs).T.copy()
    units = Units("N", "A", "mm/s")
    names = tuple(map(str, range(len(logs))))
    rows = tuple((span.start, span.stop) for span in spans)
    return Dataset(
        "single", (Element(field, slip),), effort, Clock(time, spans), units, sources=names, source_rows=rows
    )


def costs_of(train: Dataset, structure: Structure, seeds: int) -> tuple[np.ndarray, np.ndarray]:
    """Cost and CPU seconds of the default fit, then of each seed, shape (1 + seeds,)."""
    even = fit_law.scan_points
    costs, seconds = [], []
    for seed in range(seeds + 1):
        rng = np.random.default_rng(seed)
        size = fit_law._SCAN_POINTS
        if seed:
            size = int(size * 2 ** rng.uniform(-1, 1))
            fit_law.scan_points = lambda low, high, n, rng=rng: rng.uniform(low, high, (n, low.size))
        began = process_time()
        costs.append(fit_law.fit_structure(train, structure, scan=size, intervals=False).train_cost)
        seconds.append(process_time() - began)
    fit_law.scan_points = even
    return np.array(costs), np.array(seconds)


def main() -> None:
    """Print a line for each structure."""
    parser = argparse.ArgumentParser(description="Laws with memory from many seeds.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--same", type=float, default=1e-4, help="of the cost: a fit so near to the best has found it")
    parser.add_argument("--law", default="", help="only this law")
    asked = parser.parse_args()
    data = {"NEES": nees(asked.folder), "UTFSM": utfsm(asked.folder)}
    print(f"{'data':7}{'law':9}{'stages':42}{'found':>9}{'default':>10}{'worst':>10}{'CPU s':>8}{'most':>7}")
    with one_thread():
        for name, law, stages in (case for case in CASES if asked.law in ("", case[1])):
            structure = Structure("single", law, law_from_name(law, "single"), stages, name == "UTFSM", True)
            costs, seconds = costs_of(data[name], structure, asked.seeds)
            excess = costs / costs.min() - 1.0
            found = f"{np.count_nonzero(excess[1:] <= asked.same)}/{asked.seeds}"
            print(
                f"{name:7}{law:9}{stages:42}{found:>9}{excess[0]:10.1e}{excess[1:].max():10.1e}"
                f"{np.median(seconds):8.2f}{seconds.max():7.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
