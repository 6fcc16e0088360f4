#!/usr/bin/env python
"""Does the recommendation hold on logs that no fit and no choice has seen?

Logs of the UTFSM damper, a real recording at five currents. Each current is left out in turn: all models are fitted to
the logs of the other four, these choose the model that is recommended and make its band, and the logs at the current
left out judge both. Nothing here chooses by the judging logs: they are looked at when all is decided.

    python studies/blind.py FOLDER [--models all] [--currents 0 1]

Printed for each case: the recommended model with its RMSE, the best ranked one with its RMSE, how many times larger
the first is, the share of the rows that the band of the recommended model holds, and the same of the worst log.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from pathlib import Path

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset
from studies.bands import UTFSM

#: Currents of the recording in A, as the names of its files write them.
CURRENTS = ("0", "0x25", "0x5", "0x75", "1")


@dataclass(frozen=True)
class Blind:
    """How the recommendation of some logs does on others.

    Attributes:
        case: what was left out.
        recommended, best: names.
        errors: RMSE of the two on the rows left out, in the effort's unit.
        inside, worst: shares of these rows that the band of the recommended model holds, of all and of the worst log.
    """

    case: str
    recommended: str
    best: str
    errors: tuple[float, float]
    inside: float
    worst: float

    @property
    def ratio(self) -> float:
        """Error of the recommended model over that of the best ranked one."""
        return self.errors[0] / self.errors[1]


def judged_blind(case: str, comparison: Comparison) -> Blind:
    """The recommendation of a comparison on the rows that it held out."""
    taken, best = comparison.entry(comparison.recommended), comparison.entries[0]
    held = None if taken.band is None else taken.band.held
    return Blind(
        case,
        taken.name,
        best.name,
        (taken.test.rmse.value, best.test.rmse.value),
        float("nan") if held is None else held.share,
        float("nan") if held is None else held.worst,
    )


def without_current(logs: Dataset, current: str, models: tuple[str, ...]) -> Comparison:
    """All models fitted to the logs of the other currents, and judged at this one."""
    return compare(logs, Settings(models, test=(f"*Hz{current}A.txt",)))


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="logs of the UTFSM damper")
    parser.add_argument("--models", nargs="+", default=["all"])
    parser.add_argument("--currents", nargs="+", default=list(CURRENTS), choices=CURRENTS)
    asked = parser.parse_args()
    logs = build_dataset([read(path, UTFSM) for path in sorted(asked.folder.glob("*.txt"))])
    for current in asked.currents:
        comparison = without_current(logs, current, tuple(asked.models))
        blind = judged_blind(f"{current.replace('x', '.')} A left out", comparison)
        unit = logs.units.effort
        print(
            f"{blind.case:<16} recommended {blind.recommended} {blind.errors[0]:.4g} {unit}, "
            f"best {blind.best} {blind.errors[1]:.4g} {unit}: {blind.ratio:.2f} times; "
            f"band holds {blind.inside:.0%}, worst log {blind.worst:.0%}",
            flush=True,
        )
        for entry in comparison.entries:
            share = entry.test.share.value
            print(f"    {entry.name:<44} {entry.test.rmse.value:>8.4g} {unit} {share:>6.1%}", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
