#!/usr/bin/env python
"""Does the recommendation hold on logs that no fit and no choice has seen?

Two real recordings, 18 cases. Of the UTFSM damper, 30 logs of six sines at five currents: each current is left out in
turn, each sine is, and the sines of 1 Hz and more are left out of the slow ones. Of the NEES damper, one log of random
motion: each of six stretches of 30 % of its rows is. All models are fitted to the rows that are left, these choose the
model that is recommended and make its band, and the rows left out judge both. Nothing here chooses by the judging
rows: they are looked at when all is decided.

    python studies/blind.py --utfsm FOLDER --nees FILE [--models all] [--cases "1 A" slow] [--seeds 8]

Printed for each case: the recommended model with its RMSE, the best ranked one with its RMSE, how many times larger the
first is, the share of the rows that the band of the recommended model holds, and the same of the worst log (of one
log: the worst second). With --seeds the networks and the choice are made anew for so many seeds, on the same laws:
printed is how often the model of the most seeds is recommended, and how far the RMSE of a seed's recommended model
is from the mean of all. The last lines count the cases within the limits.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset, joined
from studies.bands import BEGIN, LENGTH, NEES, UTFSM

#: Currents of the recording in A, and its sines, as the names of its files write them; the sines of 1 Hz and more.
CURRENTS = ("0", "0x25", "0x5", "0x75", "1")
SINES = ("2mm5Hz", "5mm3Hz", "10mm1Hz", "25mm0x1Hz", "25mm0x25Hz", "25mm0x5Hz")
FAST = ("2mm5Hz*", "5mm3Hz*", "10mm1Hz*")
#: What the errors and bands should keep to: of the most cases, and of all.
NEAR, FAR, HELD, WORST = 1.1, 1.3, (0.90, 0.99), 0.80


@dataclass(frozen=True)
class Case:
    """Rows, and the patterns of those logs among them that are left out."""

    name: str
    data: Dataset
    left_out: tuple[str, ...]


@dataclass(frozen=True)
class Blind:
    """How the recommendation of some rows does on others.

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

    @property
    def band_holds(self) -> bool:
        """Whether the band holds as much as it should."""
        return HELD[0] <= self.inside <= HELD[1] and self.worst >= WORST


def utfsm_cases(folder: Path) -> Iterator[Case]:
    """Each current, each sine, and all fast sines."""
    logs = build_dataset([read(path, UTFSM) for path in sorted(folder.glob("*.txt"))])
    for current in CURRENTS:
        yield Case(f"{current.replace('x', '.')} A", logs, (f"*Hz{current}A.txt",))
    for sine in SINES:
        yield Case(
            sine.replace("x", ".").replace("mm", " mm ").replace("Hz", " Hz"), logs, (f"{sine}*",)
        )
    yield Case("slow to fast", logs, FAST)


def nees_cases(file: Path) -> Iterator[Case]:
    """Each stretch of the log."""
    data = build_dataset(read(file, NEES))
    for begin in BEGIN:
        held = np.zeros(data.rows, np.bool_)
        held[round(begin * data.rows) : round((begin + LENGTH) * data.rows)] = True
        parts = [
            replace(data.take(rows), sources=(name,))
            for rows, name in ((~held, "known"), (held, "held"))
        ]
        yield Case(f"NEES {begin:.0%} to {begin + LENGTH:.0%}", joined(parts), ("held",))


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


def of_seeds(case: Case, first: Comparison, seeds: int) -> list[Blind]:
    """The recommendation for each seed: networks and choice are made anew, on laws that no seed changes."""
    laws = {entry.name: entry.outcome for entry in first.entries if not entry.outcome.weights}
    names = tuple(entry.name for entry in first.entries)
    found = [judged_blind(case.name, first)]
    for seed in range(1, seeds):
        settings = replace(first.settings, models=names, lag="none", seed=seed)
        found.append(judged_blind(case.name, compare(case.data, settings, known=laws)))
    return found


def print_case(blind: Blind, comparison: Comparison, *, every: bool) -> None:
    """The line of a case, and all its models where they are asked for."""
    unit = comparison.data.units.effort
    print(
        f"{blind.case:<16} {blind.recommended} {blind.errors[0]:.4g} {unit}, "
        f"best {blind.best} {blind.errors[1]:.4g} {unit}: {blind.ratio:.2f} times; "
        f"band holds {blind.inside:.0%}, worst {blind.worst:.0%}",
        flush=True,
    )
    for entry in comparison.entries if every else ():
        print(
            f"    {entry.name:<60} {entry.test.rmse.value:>8.4g} {unit} {entry.test.share.value:>6.1%}",
            flush=True,
        )


def print_seeds(found: Sequence[Blind]) -> None:
    """How the recommendation moves with the seed."""
    (usual, count), *_ = Counter(blind.recommended for blind in found).most_common()
    errors = np.array([blind.errors[0] for blind in found])
    away = np.abs(errors / errors.mean() - 1.0).max()
    worst = max(blind.ratio for blind in found)
    print(
        f"    {len(found)} seeds: {usual} {count} times, RMSE within {away:.1%}, at most {worst:.2f} times",
        flush=True,
    )


def print_count(found: Sequence[Blind]) -> None:
    """How many cases keep to the limits."""
    near, most = sum(blind.ratio <= NEAR for blind in found), max(blind.ratio for blind in found)
    held, limits = sum(blind.band_holds for blind in found), f"{HELD[0]:.0%} to {HELD[1]:.0%}"
    print(
        f"\n{near} of {len(found)} at most {NEAR} times the best ranked, the largest {most:.2f} times (limit {FAR})"
    )
    print(f"{held} of {len(found)} bands hold {limits}, and {WORST:.0%} of the worst log or second")


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--utfsm", type=Path, help="folder with the logs of the UTFSM damper")
    parser.add_argument("--nees", type=Path, help="log of the NEES damper")
    parser.add_argument("--models", nargs="+", default=["all"])
    parser.add_argument(
        "--cases", nargs="+", default=[], help="words that a case's name begins with; none: all"
    )
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--every", action="store_true", help="print every model of a case")
    asked = parser.parse_args()
    cases = [] if asked.utfsm is None else list(utfsm_cases(asked.utfsm))
    cases += [] if asked.nees is None else list(nees_cases(asked.nees))
    found: list[Blind] = []
    for case in cases:
        if asked.cases and not any(case.name.startswith(word) for word in asked.cases):
            continue
        comparison = compare(case.data, Settings(tuple(asked.models), test=case.left_out))
        found.append(judged_blind(case.name, comparison))
        print_case(found[-1], comparison, every=asked.every)
        if asked.seeds > 1:
            print_seeds(of_seeds(case, comparison, asked.seeds))
    if found:
        print_count(found)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
