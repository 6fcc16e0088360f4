"""What each stage takes off the error of two measured dampers: `python studies/memory.py --nees FILE --utfsm FOLDER`.

FILE is `ranran_50_converted.csv` of NEES-2012-1158: a damper under random motion and switched voltage. FOLDER holds the
preprocessed recordings of the UTFSM damper, sines at constant currents, as `5mm3Hz0x5A.txt`. Parts:

    stages        each stage on both recordings
    laws          each law of the ladder with a memory of the slip, beside the same law without
    folds         UTFSM with one current left out, and with one motion left out
    frequencies   UTFSM trained at low frequencies, scored at high ones
    validation    UTFSM: laws whose yield effort saturates, judged by motions of the training rows that are left out

The last 30 % of NEES is held out; of UTFSM 0.5 A and all of 5 mm 3 Hz. Choose by the error of training; the error of
the test is there to be reported. Tables are Markdown.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import hold_out
from erclutch.models.laws import ladder, law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

Mask = NDArray[np.bool_]
NEES_PERIOD = 3.328e-4

#: Stages ahead of the memory and behind it, for each recording: UTFSM has one current a file, so no lag can be seen.
AHEAD = {"nees": "rise-fall", "utfsm": ""}
BEHIND = "inertia+effort-lag"
MEMORIES = (
    "",
    "dahl/field",
    "dahl-2/field",
    "stops-2/field",
    "stops-2",
    "lugre/field",
    "lugre",
    "bouc-wen",
    "bouc-wen-2",
    "hysteretic-tanh",
    "dahl/field+viscous",
)
#: Chains that differ from "stages ahead, memory, stages behind".
OTHERS: Mapping[str, tuple[str, ...]] = {
    "nees": (
        "none",
        "rise-fall",
        "rise-fall+dahl/field",
        "rise-fall+dahl/field+viscous+inertia",
        "rise-fall+dahl/field+inertia+effort-second-order",
        "lag+dahl/field+inertia+effort-lag",
        "second-order+dahl/field+inertia+effort-lag",
        "two-lags+dahl/field+inertia+effort-lag",
        "rise-fall+lugre/field+inertia",
        "rise-fall+spencer+stiffness+inertia",
    ),
    "utfsm": (
        "none",
        "dahl/field",
        "dahl/field+viscous+inertia",
        "dahl/field+inertia+effort-second-order",
        "spencer+stiffness+inertia",
    ),
}


@dataclass(frozen=True)
class Motion:
    """Where a file of UTFSM comes from: amplitude in mm, frequency in Hz, current in A."""

    amplitude: float
    frequency: float
    current: float

    @property
    def name(self) -> str:
        """Amplitude and frequency."""
        return f"{self.amplitude:g} mm {self.frequency:g} Hz"


@cache
def nees(path: Path) -> Dataset:
    """The damper under random motion."""
    with path.open(encoding="utf-8") as file:
        names = [name.strip('"') for name in file.readline().strip().split(",")]
    columns = [names.index(name) for name in ("V", "Y", "F")]
    slip, field, effort = np.loadtxt(
        path, delimiter=",", skiprows=1, usecols=columns, unpack=True, dtype=np.float64
    ).copy()
    clock = Clock(np.arange(field.size) * NEES_PERIOD, (Span(0, field.size, NEES_PERIOD),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N", "V", "cm/s"))


@cache
def utfsm(folder: Path) -> tuple[Dataset, tuple[Motion, ...], NDArray[np.int64]]:
    """The damper under sines, its files, and the file of each row."""
    motions: list[Motion] = []
    tables = []
    for path in sorted(folder.glob("*.txt")):
        found = re.fullmatch(r"([\dx]+)mm([\dx]+)Hz([\dx]+)A", path.stem)
        if found:
            motions.append(Motion(*(float(part.replace("x", ".")) for part in found.groups())))
            tables.append(np.loadtxt(path))
    rows = np.array([len(table) for table in tables])
    ends = np.cumsum(rows)
    spans = tuple(
        Span(int(end - count), int(end), float(table[1, 0] - table[0, 0]))
        for table, count, end in zip(tables, rows, ends, strict=True)
    )
    files = np.repeat(np.arange(rows.size), rows)
    whole = np.concatenate(tables)
    field = np.array([m.current for m in motions])[files]
    clock = Clock(whole[:, 0].copy(), spans)
    data = Dataset(
        "single",
        (Element(field, whole[:, 2].copy()),),
        whole[:, 3].copy(),
        clock,
        Units("N", "A", "mm/s"),
    )
    return data, tuple(motions), files


def _held_out(motion: Motion) -> bool:
    """The test of UTFSM."""
    return motion.current == 0.5 or motion.name == "5 mm 3 Hz"


@dataclass(frozen=True)
class Score:
    """A fit: errors in N, the test's as a share of the effort's standard deviation, numbers, and those on a bound."""

    train: float
    test: float
    share: float
    numbers: int
    bounds: tuple[str, ...]

    @property
    def cells(self) -> str:
        """Of a row in a table."""
        return f"{self.numbers} | {self.train:.1f} N | {self.test:.1f} N, {self.share:.1%} | {', '.join(self.bounds)}"


def fitted(data: Dataset, test: Mask, law: str, dynamics: str) -> Score:
    """A law with its stages, trained on the rows that are not in the test."""
    structure = Structure(
        "single", law, law_from_name(law, "single"), dynamics or "none", False, True
    )
    with one_thread():
        outcome = fit_structure(data.take(~test), structure, intervals=False)
    error = (data.effort - outcome.model.predict(data))[test]
    rmse = float(np.sqrt(np.mean(error**2)))
    train = float(np.sqrt(outcome.train_cost / outcome.train_rows))
    return Score(
        train, rmse, rmse / float(np.std(data.effort[test])), outcome.parameters, outcome.at_bounds
    )


@dataclass(frozen=True)
class Bench:
    """The recordings.

    Attributes:
        nees: file, or None.
        utfsm: folder, or None.
    """

    nees: Path | None
    utfsm: Path | None

    @property
    def there(self) -> tuple[str, ...]:
        """Names of the recordings that were given."""
        return tuple(name for name in ("nees", "utfsm") if getattr(self, name))

    def home(self, recording: str, law: str, dynamics: str) -> Score:
        """On a recording with its usual rows held out."""
        if recording == "nees":
            assert self.nees
            data = nees(self.nees)
            return fitted(data, hold_out(data, 0.3), law, dynamics)
        return self.away(law, dynamics, _held_out)

    def away(self, law: str, dynamics: str, out: Callable[[Motion], bool]) -> Score:
        """On UTFSM without the files of some motions."""
        assert self.utfsm
        data, motions, files = utfsm(self.utfsm)
        return fitted(data, np.array([out(m) for m in motions])[files], law, dynamics)


def joined(*stages: str) -> str:
    """A specification of those that are not empty."""
    return "+".join(stage for stage in stages if stage) or "none"


def _home(bench: Bench, job: tuple[str, str, str]) -> str:
    recording, law, dynamics = job
    score = bench.home(recording, law, dynamics)
    return f"| {recording} | `{law}` | `{dynamics}` | {score.cells} |"


_HEAD = (
    "| recording | law | stages | numbers | training | test | on a bound |\n| --- | --- | --- | "
    "--- | --- | --- | --- |"
)


def stages(bench: Bench, pool: ProcessPoolExecutor) -> Iterator[str]:
    """Each stage on both recordings."""
    yield _HEAD
    jobs = [
        (name, "bingham", dynamics)
        for name in bench.there
        for dynamics in (
            *OTHERS[name],
            *(joined(AHEAD[name], memory, BEHIND) for memory in MEMORIES),
        )
    ]
    yield from pool.map(partial(_home, bench), jobs)


def laws(bench: Bench, pool: ProcessPoolExecutor) -> Iterator[str]:
    """Each law with a memory and without."""
    yield _HEAD
    jobs = [
        (name, law, joined(AHEAD[name], memory))
        for name in bench.there
        for law in ladder()
        for memory in ("", "dahl/field")
    ]
    yield from pool.map(partial(_home, bench), jobs)


@dataclass(frozen=True)
class Without:
    """Motions that are left out.

    Attributes:
        name: what is left out.
        current: this current, or None.
        motion: this motion, or "".
        above: frequencies above this one in Hz.
    """

    name: str
    current: float | None = None
    motion: str = ""
    above: float = np.inf

    def __call__(self, motion: Motion) -> bool:
        """Whether a file is left out."""
        return (
            motion.current == self.current
            or motion.name == self.motion
            or motion.frequency > self.above
        )


#: No memory; a memory; that with what else helps at home.
CHAINS = (
    "none",
    "dahl/field",
    "dahl/field+viscous",
    "dahl/field+viscous+inertia+effort-lag",
    "stops-2+inertia+effort-lag",
    "lugre/field",
)


def _away(bench: Bench, job: tuple[Without, str]) -> Score:
    without, dynamics = job
    return bench.away("bingham", dynamics, without)


def _by_chain(
    bench: Bench, pool: ProcessPoolExecutor, cases: list[Without], chains: tuple[str, ...]
) -> Iterator[str]:
    scores = list(
        pool.map(partial(_away, bench), [(case, chain) for chain in chains for case in cases])
    )
    yield f"| stages | {' | '.join(case.name for case in cases)} |"
    yield "| --- |" + " --- |" * len(cases)
    for i, chain in enumerate(chains):
        row = scores[i * len(cases) : (i + 1) * len(cases)]
        yield f"| `{chain}` | {' | '.join(f'{score.test:.1f}' for score in row)} |"


def folds(bench: Bench, pool: ProcessPoolExecutor) -> Iterator[str]:
    """One current out, then one motion out: the test's error in N."""
    if not bench.utfsm:
        return
    _, motions, _ = utfsm(bench.utfsm)
    currents = [
        Without(f"{current:g} A", current=current)
        for current in sorted({m.current for m in motions})
    ]
    yield from _by_chain(bench, pool, currents, CHAINS)
    yield ""
    yield from _by_chain(
        bench,
        pool,
        [Without(name, motion=name) for name in sorted({m.name for m in motions})],
        CHAINS,
    )


def frequencies(bench: Bench, pool: ProcessPoolExecutor) -> Iterator[str]:
    """Trained at low frequencies, scored at high ones: the test's error in N."""
    if not bench.utfsm:
        return
    more = (
        "inertia",
        "effort-lag",
        "dahl/field+inertia",
        "dahl/field+effort-lag",
        "stops/field",
        "hysteretic-tanh",
        "bouc-wen",
    )
    cases = [Without(f"above {f:g} Hz", above=f) for f in (0.5, 1.0)]
    yield from _by_chain(bench, pool, cases, (*CHAINS, *more))


#: Laws and chains that the motions of the training rows choose from.
CANDIDATES = tuple(
    (law, f"{memory}+viscous+{BEHIND}")
    for memory in ("dahl/field", "lugre/field", "lugre", "bouc-wen")
    for law in ("bingham", "bingham/saturating")
)


def _validated(bench: Bench, job: tuple[str, str]) -> str:
    assert bench.utfsm
    data, motions, files = utfsm(bench.utfsm)
    test = np.array([_held_out(m) for m in motions])
    squares, rows = 0.0, 0
    for name in sorted({m.name for m, out in zip(motions, test, strict=True) if not out}):
        left = ~test & np.array([m.name == name for m in motions])
        kept = ~test[files]
        score = fitted(data.take(kept), left[files][kept], *job)
        squares, rows = squares + score.test**2 * left[files].sum(), rows + int(left[files].sum())
    home = bench.home("utfsm", *job)
    cells = (
        f"{home.numbers} | {home.train:.1f} N | {np.sqrt(squares / rows):.1f} N | {home.test:.1f} N"
    )
    return f"| `{job[0]}` | `{job[1]}` | {cells} | {', '.join(home.bounds)} |"


def validation(bench: Bench, pool: ProcessPoolExecutor) -> Iterator[str]:
    """Candidates: training, motions of the training rows left out in turn, test."""
    if bench.utfsm:
        yield "| law | stages | numbers | training | motions left out | test | on a bound |"
        yield "| --- | --- | --- | --- | --- | --- | --- |"
        yield from pool.map(partial(_validated, bench), CANDIDATES)


PARTS = {
    "stages": stages,
    "laws": laws,
    "folds": folds,
    "frequencies": frequencies,
    "validation": validation,
}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description="What each stage takes off the error of two measured dampers."
    )
    parser.add_argument("--nees", type=Path)
    parser.add_argument("--utfsm", type=Path)
    parser.add_argument("--parts", nargs="+", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--workers", type=int, default=1)
    asked = parser.parse_args()
    bench = Bench(asked.nees, asked.utfsm)
    with ProcessPoolExecutor(asked.workers) as pool:
        for part in asked.parts:
            print(f"\n{PARTS[part].__doc__}\n", flush=True)
            for line in PARTS[part](bench, pool):
                print(line, flush=True)


if __name__ == "__main__":
    main()
