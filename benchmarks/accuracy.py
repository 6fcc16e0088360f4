"""Errors of `erclutch fit` beside those of peers on rows that none of them has seen, and the CPU seconds of each.

    python benchmarks/accuracy.py DATA PUBLIC [--seconds 12] [--seeds 2] [--only NEES] [--peers LightGBM]

DATA holds the recordings `mr_damper_nees` and `mr_damper_utfsm`, PUBLIC a copy of the folder "Comparative data" of
github.com/longshike/NNFM-A-Novel-Neural-Network-Modeling-Approach-for-Robot-Flexible-Joints-Friction: friction of robot
joints without a field, measured by its authors. The peers are in `requirements-peers.txt`.

Each contender gets field and slip of the same training rows, and the position of the robot joints, and gives the effort
of the test rows from these alone. erclutch's model is the one that `fit` recommends; nobody chooses by the test rows. A
peer with chance in it runs once a seed, and its errors are averaged. Printed: a row a case, RMSE of each and its CPU
seconds, a star at the best.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    for pool in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(pool, "1")

import numpy as np
from accuracy_peers import PEERS, Rows, Stretch, rms_error
from numpy.typing import NDArray

from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.held_out import hold_out

NEES = {"columns": {"field": "Y [V]", "slip": "V [cm/s]", "effort": "F [N]"}}
UTFSM = {
    "time": "c1 [s]",
    "columns": {"slip": "c3 [mm/s]", "effort": "c4 [N]"},
    "name_pattern": "{amplitude}mm{frequency}Hz{field}A",
}
JOINTS = {
    "S": 3,
    "luoxuan": 2,
    "yuanhu": 1,
    "zhixian": 3,
}  # which joint a file of the FAIRINO robot is of
FRANKA = {3: 2, 4: 7}  # which joint a case of the Franka robot is of
_CHANCE = ("LightGBM, 50 lags", "GRU, 16 units")
_VALIDATION = 0.2  # of each stretch, its end
_LEAD = 400  # rows ahead of those that are judged, of which a peer sees the inputs


@dataclass(frozen=True)
class Case:
    """Logs, and what of them is the test.

    Attributes:
        name: for the table.
        files: of the logs.
        mapping: how they are read.
        test: share or patterns, as in `Settings`.
    """

    name: str
    files: list[Path]
    mapping: dict[str, Any]
    test: float | tuple[str, ...]

    def logs(self) -> Dataset:
        """All rows."""
        return build_dataset([read(file, self.mapping) for file in self.files])


def cases(data: Path, public: Path) -> list[Case]:
    """All cases whose files are there."""
    damper = sorted((data / "mr_damper_utfsm" / "preprocessed").glob("*.txt"))
    nees = [data / "mr_damper_nees" / "ranran_50_converted.csv"]
    found = [
        Case("NEES, last 30 %", nees, NEES, 0.3),
        Case("UTFSM, 0.5 A left out", damper, UTFSM, ("*Hz0x5A.txt",)),
        Case("UTFSM, 1 A left out", damper, UTFSM, ("*Hz1A.txt",)),
        Case("UTFSM, 5 mm 3 Hz left out", damper, UTFSM, ("5mm3Hz*",)),
    ]
    for motion, joint in JOINTS.items():
        file = public / "FAIRINO Robot" / f"verify_robot_{motion}_slow_processed.csv"
        found.append(
            Case(f"FAIRINO joint {joint}, {motion}, last 30 %", [file], _joint(joint), 0.3)
        )
    for case, joint in FRANKA.items():
        files = [
            public / "Franka Robot" / f"case{case}_{speed}.csv"
            for speed in ("slow", "middle", "high")
        ]
        found.append(
            Case(
                f"Franka joint {joint}, fast left out",
                files,
                _joint(joint),
                (f"case{case}_high.csv",),
            )
        )
    return [case for case in found if case.files and all(file.is_file() for file in case.files)]


def _joint(number: int) -> dict[str, Any]:
    effort = f"q{number}_tau_J_compensate"
    return {
        "time": "time [s]",
        "columns": {
            "field": "none",
            "position": f"q{number} [rad]",
            "slip": f"dq{number} [rad/s]",
            "effort": f"{effort} [N*m]",
        },
    }


def stretches_of(
    data: Dataset, rows: NDArray[np.bool_], train: NDArray[np.bool_], lead: int = 0
) -> list[Stretch]:
    """Some rows as stretches, standardised by the training rows; each begins a few rows earlier."""
    inputs = np.column_stack([data.elements[0].field, data.elements[0].slip, *data.extras.values()])
    wide = inputs[train].std(axis=0)
    scaled = (inputs - inputs[train].mean(axis=0)) / np.where(wide > 0, wide, 1.0)
    effort = (data.effort - data.effort[train].mean()) / data.effort[train].std()
    found: list[Stretch] = []
    for span in data.clock.spans:
        own = np.arange(span.start, span.stop)[rows[span.start : span.stop]]
        if own.size > 50:
            begin = max(span.start, int(own[0]) - lead)
            at = slice(begin, int(own[-1]) + 1)
            found.append(
                Stretch(scaled[at], effort[at], span.period or data.period, int(own[0]) - begin)
            )
    return found


def parted(stretches: list[Stretch]) -> Rows:
    """Training and validation rows: every fourth stretch where there are many, else the end of each."""
    if len(stretches) >= 8:
        held = stretches[3::4]
        return Rows([s for i, s in enumerate(stretches) if i % 4 != 3], held)
    cuts = [int((1.0 - _VALIDATION) * len(s.effort)) for s in stretches]
    first = [
        Stretch(s.inputs[:k], s.effort[:k], s.period) for s, k in zip(stretches, cuts, strict=True)
    ]
    leads = [min(_LEAD, k) for k in cuts]
    last = [
        Stretch(s.inputs[k - lead :], s.effort[k - lead :], s.period, lead)
        for s, k, lead in zip(stretches, cuts, leads, strict=True)
    ]
    return Rows(first, last)


def measured(
    case: Case, seconds: float, seeds: int, peers: Sequence[str]
) -> dict[str, tuple[float, float]]:
    """RMSE in the effort's unit and CPU seconds of erclutch and of the peers."""
    data = case.logs()
    start = time.process_time()
    comparison = compare(data, Settings(test=case.test))
    taken = comparison.entry(comparison.recommended)
    found = {"erclutch fit": (taken.test.rmse.value, time.process_time() - start)}
    print(f"  {case.name}: erclutch recommends {taken.name}", flush=True)
    test = hold_out(data, case.test)
    train = ~test
    rows = parted(stretches_of(data, train, train))
    judged = stretches_of(data, test, train, _LEAD)
    scale = float(data.effort[train].std())
    for name in peers:
        peer = PEERS[name]
        errors, spent = [], time.process_time()
        tries = seeds if name in _CHANCE else 1
        for seed in range(tries):
            errors.append(scale * rms_error(peer(rows, seed, seconds), judged))
        found[name] = float(np.mean(errors)), (time.process_time() - spent) / tries
        print(f"  {case.name}: {name} {found[name][0]:.4g}, {found[name][1]:.0f} CPU s", flush=True)
    return found


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path)
    parser.add_argument("public", type=Path)
    parser.add_argument(
        "--seconds", type=float, default=12.0, help="CPU s of a GRU, of Bouc-Wen, of Spencer"
    )
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--only", default="", help="cases with this in their name")
    parser.add_argument(
        "--peers", nargs="+", default=[""], help="words that a peer's name begins with"
    )
    asked = parser.parse_args()
    peers = [name for name in PEERS if any(name.startswith(word) for word in asked.peers)]
    names = ["erclutch fit", *peers]
    lines = [f"| case | {' | '.join(names)} |", "| --- |" + " --- |" * len(names)]
    for case in cases(asked.data, asked.public):
        if asked.only.lower() not in case.name.lower():
            continue
        found = measured(case, asked.seconds, asked.seeds, peers)
        best = min(error for error, _ in found.values())
        cells = [
            f"{found[n][0]:.4g}{' *' if found[n][0] <= 1.02 * best else ''} ({found[n][1]:.0f} s)"
            for n in names
        ]
        lines.append(f"| {case.name} | {' | '.join(cells)} |")
        print(lines[-1], flush=True)
    print("\n".join(["", *lines]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
