"""Recalibration from 1 % of a log beside a fit to all its rows: `python studies/recalibrate.py [--utfsm FOLDER]`.

TWIN: a model of clutch CH1 (scenario brake) goes to CH2. UTFSM: a model of all amplitudes but one goes to that one.
Errors are RMSE over the 99 % of the rows that the adaptation did not see. A fit to all rows has seen them.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from time import process_time

import numpy as np

import erclutch
from erclutch.fit.recalibration import AS_IT_IS
from erclutch.logs.dataset import Dataset, joined
from erclutch.models.laws import law_from_name
from erclutch.models.load import Model
from erclutch.models.structure import Structure
from erclutch.runs.recalibrated_run import seen_rows
from erclutch.wings.rig.twin.parameters import default_rig
from erclutch.wings.rig.twin.scenarios import prepare

AMPLITUDES = ("2mm5Hz", "5mm3Hz", "10mm1Hz", "25mm0x1Hz", "25mm0x25Hz", "25mm0x5Hz")
COLUMNS = {
    "name_pattern": "{amplitude}mm{frequency}Hz{field}A",
    "time": "c1 [s]",
    "columns": {"slip": "c3 [mm/s]", "effort": "c4 [N]"},
}


def twin_pairs(seconds: float) -> Iterator[tuple[str, Dataset, Dataset]]:
    """Logs of CH1 and of CH2, each alone, with other commands."""
    rig = default_rig()
    swapped = {
        f"clutch.{name}_1": rig.value(f"clutch.{name}_2")
        for name in ("rated_torque", "viscosity", "seal")
    }
    other_rig = rig.changed({**swapped, "supply.leakage_1": rig.value("supply.leakage_2")})
    for scenario in ("brake", "clutch"):
        first = prepare(scenario, rig=rig, seconds=seconds, seed=1).recording()
        second = prepare(scenario, rig=other_rig, seconds=seconds, seed=2).recording()
        yield (
            f"TWIN {scenario}, CH1 to CH2",
            erclutch.build_dataset(first),
            erclutch.build_dataset(second),
        )


def utfsm_pairs(folder: Path) -> Iterator[tuple[str, Dataset, Dataset]]:
    """All amplitudes but one, and that one."""
    data: dict[str, Dataset] = {}
    for name in AMPLITUDES:
        logs = [erclutch.read(path, COLUMNS) for path in sorted(folder.glob(f"{name}*"))]
        data[name] = erclutch.build_dataset(logs)
    for name, new in data.items():
        others = [rows for other, rows in data.items() if other != name]
        yield f"UTFSM, to {name}", joined(others), new


def rmse(model: Model, data: Dataset, rows: np.ndarray) -> float:
    """Root mean square error over some rows."""
    residual = data.effort - model.predict(data)
    return float(np.sqrt(np.mean(residual[rows] ** 2)))


def line(title: str, base: Model, whole: Model, new: Dataset, share: float, stretches: int) -> str:
    """One adaptation; where it is worse than the base on the other rows, the base is kept as the command does."""
    seen = seen_rows(new, share, stretches)
    began = process_time()
    adapted = erclutch.recalibrate(base, new, seen)
    seconds = process_time() - began
    before, after, best = (rmse(model, new, ~seen) for model in (base, adapted.model, whole))
    way = (
        adapted.way
        if after <= before
        else f"{AS_IT_IS} (not {adapted.way}: {after / before:.2f} of the base)"
    )
    ratio = min(before, after) / best
    return f"{title:30}{stretches:>10}{int(seen.sum()):>7}{before / best:>9.3f}{ratio:>9.3f}{seconds:>8.2f}  {way}"


def main() -> None:
    """Print a line for each pair of logs and each way to take the rows."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--utfsm",
        type=Path,
        help="folder of the measured damper's preprocessed logs; default: left out",
    )
    parser.add_argument("--law", default="bingham")
    parser.add_argument("--lag", default="lag")
    parser.add_argument("--share", type=float, default=0.01)
    parser.add_argument("--stretches", type=int, nargs="+", default=[1, 10, 40])
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the twin's logs")
    asked = parser.parse_args()
    structure = Structure(
        "single", asked.law, law_from_name(asked.law, "single"), asked.lag, True, True
    )
    print(
        f"{structure.specification}+{asked.lag}, {asked.share:.1%} of the rows; errors over that of a fit to all rows"
    )
    print(
        f"{'logs':30}{'stretches':>10}{'rows':>7}{'base':>9}{'adapted':>9}{'CPU s':>8}  what moved"
    )
    pairs = [*twin_pairs(asked.seconds), *(utfsm_pairs(asked.utfsm) if asked.utfsm else ())]
    for title, old, new in pairs:
        base, whole = (
            erclutch.fit_structure(data, structure, intervals=False).model for data in (old, new)
        )
        for stretches in asked.stretches:
            print(line(title, base, whole, new, asked.share, stretches), flush=True)


if __name__ == "__main__":
    main()
