"""Two commands at once that write to one place: which commands, in which folder, and what came of a pair."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

from erclutch.cli import main
from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import run

COMMAND = (sys.executable, "-m", "erclutch")
FIT = ("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out")
_CALIBRATION = ("--evaluations", "2", "--workers", "1", "--vary", "screw.coulomb")
#: Take seconds: they have fewer pairs.
SLOW = ("demo", "experiment")
#: What each command that writes is told, but for the place, which comes last.
WORDS = {
    "fit": FIT,
    "export": ("export", "run", "--to", "c", "--out"),
    "predict": ("predict", "log.csv", "--run", "run", "--out"),
    "predict-many": ("predict", "logs", "--run", "run", "--out"),
    "recalibrate": ("recalibrate", "run", "log.csv", "--out"),
    "report": ("report", "run", "--out"),
    "compare": ("compare", "run", "other", "--out"),
    "table": ("table", "run", "--out"),
    "inspect": ("inspect", "log.csv", "--write-mapping"),
    "align": ("align", "logs/a.csv", "logs/b.csv", "--on", "torque", "--out"),
    "fit-many": ("fit-many", "logs", "--models", "bingham", "--lag", "none", "--out"),
    "excite": ("excite", "--sequence", "paper", "--seconds", "1", "--out"),
    "simulate": ("simulate", "training", "--seconds", "2", "--out"),
    "reproduce": ("reproduce", "fig3", "--seconds", "5", "--out"),
    "figure": ("figure", "trace", "run", "--as", "svg", "--out"),
    "tune": ("tune", "lagged", "--bandwidth", "5", "--as", "svg", "--out"),
    "experiment": ("experiment", "sine", "--run", "pair", "--seconds", "1", "--out"),
    "calibrate-twin": ("calibrate-twin", "pair.csv", "--device", "coaxial", *_CALIBRATION, "--out"),
    "demo": ("demo", "--seconds", "10", "--out"),
}
_ENDINGS = {"predict": ".csv", "report": ".html", "compare": ".html", "table": ".md", "inspect": ".toml"}
_ENDINGS |= {"align": ".csv", "excite": ".csv", "simulate": ".csv", "calibrate-twin": ".toml"}
#: The second may come when the first has ended; a report is replaced then, a fleet and a figure are made again.
AGAIN = ("report", "compare", "fit-many", "reproduce", "figure", "experiment", "demo")
_TOLD = ("is writing it", "already", "exists", "there is such a file", "made it meanwhile")
_FORK = multiprocessing.get_context("fork")


class Raced(NamedTuple):
    """Exit codes of a pair, the smaller first, what both said, and files that they left half-written."""

    codes: tuple[int, ...]
    said: tuple[str, ...]
    left: tuple[str, ...]

    def lost(self, name: str) -> str:
        """What a pair of a command did wrong; "" where of two results none is lost and the other writer was told."""
        if self.left:
            return f"left {self.left[0]}"
        if self.codes == (0, 0):
            return "" if name in AGAIN else "both are done, and only one of them is there"
        told = any(words in text for text in self.said for words in _TOLD)
        return "" if self.codes == (0, 2) and told else f"codes {self.codes}: {self.said}"


def make_material(folder: Path) -> None:
    """A log, two logs and two runs, made in this process: what that imports, processes of `forked` have imported."""
    write_synthetic_log(folder / "log.csv", seconds=4.0)
    (folder / "logs").mkdir()
    rows = (folder / "log.csv").read_text().splitlines(keepends=True)
    for name, last in (("a", 4000), ("b", 3000)):
        (folder / "logs" / f"{name}.csv").write_text("".join(rows[:last]))
    for words in (
        (*FIT, "run"),
        (*FIT, "other"),
        ("fit", "log.csv", "--models", "bingham", "--lag", "lag", "--out", "lagged"),
        ("simulate", "training", "--seconds", "5", "--out", "pair.csv"),
        ("fit", "pair.csv", "--device", "coaxial", "--models", "bingham", "--lag", "none", "--out", "pair"),
    ):
        assert run(*words, cwd=folder).code == 0, words


def words_of(name: str, pair: int) -> tuple[str, ...]:
    """The words of a command for the place of a pair."""
    return (*WORDS[name], f"{name}-{pair}{_ENDINGS.get(name, '')}")


def left_in(folder: Path) -> tuple[str, ...]:
    """Names of what is half-written."""
    return tuple(path.name for path in folder.rglob(".*") if "partial" in path.name or "writing" in path.name)


def started(name: str, pair: int, folder: Path) -> Raced:
    """A pair of programs, each started as a user does."""
    words = [*COMMAND, *words_of(name, pair)]
    pipe = subprocess.PIPE
    both = [subprocess.Popen(words, cwd=folder, stdout=pipe, stderr=pipe, text=True) for _ in range(2)]
    said = tuple(process.communicate(timeout=120)[1] for process in both)
    return Raced(tuple(sorted(process.returncode for process in both)), said, left_in(folder))


def forked(name: str, pair: int, folder: Path) -> Raced:
    """A pair of processes that have all imported and begin at one moment: the start of Python hides most races."""
    begin = _FORK.Barrier(2)
    both = [_FORK.Process(target=_run, args=(name, pair, folder, begin, who)) for who in range(2)]
    for process in both:
        process.start()
    for process in both:
        process.join(120.0)
        if process.is_alive():
            process.kill()
            process.join()
    notes = [folder / f"said-{who}" for who in range(2)]
    said = tuple(note.read_text(errors="replace") for note in notes)
    codes = [1 if process.exitcode is None else process.exitcode for process in both]
    return Raced(tuple(sorted(codes)), said, left_in(folder))


def warm(folder: Path) -> None:
    """Run each command once in this process, so that all that `forked` takes from it is imported."""
    for name in WORDS:
        run(*words_of(name, -1), cwd=folder)


def _run(name: str, pair: int, folder: Path, begin: Any, who: int) -> None:
    os.chdir(folder)
    with open(f"said-{who}", "w", encoding="utf-8") as said, open(os.devnull, "w", encoding="utf-8") as nothing:
        sys.stdout, sys.stderr = nothing, said
        begin.wait()
        code = main(words_of(name, pair))
    os._exit(code)
