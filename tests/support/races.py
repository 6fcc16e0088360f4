"""Two commands at once that write to one place: which commands, in which folder, and what came of a pair."""

from __future__ import annotations

import gc
import multiprocessing
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

from erclutch.cli import main
from erclutch.logs.readers import child_process
from erclutch.logs.synthetic import write_synthetic_log
from tests.support.command import run

COMMAND = (sys.executable, "-m", "erclutch")
FIT = ("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out")
_CALIBRATION = ("--evaluations", "2", "--workers", "1", "--vary", "screw.coulomb")
#: Take seconds: in the tests they have fewer pairs.
SLOW = ("demo", "experiment", "live")
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
    "live": ("live", "--no-model", "--headless", "--seconds", "0.2", "--record", "--folder"),
    "demo": ("demo", "--seconds", "10", "--out"),
}
_ENDINGS = {
    "predict": ".csv",
    "report": ".html",
    "compare": ".html",
    "table": ".md",
    "inspect": ".toml",
}
_ENDINGS |= {"align": ".csv", "excite": ".csv", "simulate": ".csv", "calibrate-twin": ".toml"}
#: The second may come when the first has ended; a report is replaced then, a fleet and a figure are made again.
AGAIN = ("report", "compare", "fit-many", "reproduce", "figure", "experiment", "demo")
#: What takes most of the time of a command, and has no part in how it writes.
LONG_WORK = {
    "demo": "erclutch.fit.comparison.compare",
    "calibrate-twin": "erclutch.wings.paper.calibration.calibrate.calibrate",
}
#: Each of the two makes a recording of its own in one folder.
EACH_ITS_OWN = ("live",)
_TOLD = ("is writing it", "already", "exists", "there is such a file", "made it meanwhile")
_FORK = multiprocessing.get_context("fork")


class Raced(NamedTuple):
    """Exit codes of a pair, the smaller first, what both said, what they left half-written, and how many recordings."""

    codes: tuple[int, ...]
    said: tuple[str, ...]
    left: tuple[str, ...]
    recordings: int

    def lost(self, name: str) -> str:
        """What a pair of a command did wrong; "" where of two results none is lost and the other writer was told."""
        if self.left:
            return f"left {self.left[0]}"
        if name in EACH_ITS_OWN:
            kept = self.codes == (0, 0) and self.recordings == 2
            return "" if kept else f"{self.recordings} recordings; codes {self.codes}: {self.said}"
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
        (
            "fit",
            "pair.csv",
            "--device",
            "coaxial",
            "--models",
            "bingham",
            "--lag",
            "none",
            "--out",
            "pair",
        ),
    ):
        assert run(*words, cwd=folder).code == 0, words


def words_of(name: str, pair: int) -> tuple[str, ...]:
    """The words of a command for the place of a pair."""
    return (*WORDS[name], f"{name}-{pair}{_ENDINGS.get(name, '')}")


def left_in(folder: Path) -> tuple[str, ...]:
    """Names of what is half-written."""
    return tuple(
        path.name for path in folder.rglob(".*") if "partial" in path.name or "writing" in path.name
    )


def started(name: str, pair: int, folder: Path) -> Raced:
    """A pair of programs, each started as a user does."""
    words = [*COMMAND, *words_of(name, pair)]
    pipe = subprocess.PIPE
    both = [
        subprocess.Popen(words, cwd=folder, stdout=pipe, stderr=pipe, text=True) for _ in range(2)
    ]
    said = tuple(process.communicate(timeout=120)[1] for process in both)
    return _raced([process.returncode for process in both], said, folder / words[-1], folder)


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
    return _raced(codes, said, folder / words_of(name, pair)[-1], folder)


def _raced(codes: list[int], said: tuple[str, ...], place: Path, folder: Path) -> Raced:
    return Raced(tuple(sorted(codes)), said, left_in(folder), len(list(place.glob("*.mcap"))))


def lost_in_pairs(
    name: str, pairs: int, folder: Path, over: Callable[[], bool] = lambda: False
) -> tuple[int, list[str]]:
    """How many pairs of a whole command were raced in a folder with the material, and what was lost in them.

    Args:
        name: of the command.
        pairs: how many.
        folder: with the material; nobody else writes there.
        over: says when the time is over; one pair is raced in any case.
    """
    lost = list[str]()
    with slow_work_kept(name):
        first = run(*words_of(name, -1), cwd=folder)  # imports all, and does what is kept
        assert first.code == 0, first.error
        gc.freeze()  # or each collection of a child copies the pages that it shares with this process
        for pair in range(1, pairs + 1):
            lost.append(forked(name, pair, folder).lost(name))
            place = folder / words_of(name, pair)[-1]
            shutil.rmtree(place) if place.is_dir() else place.unlink(missing_ok=True)
            if over():
                break
        gc.unfreeze()
    return len(lost), [each for each in lost if each]


@contextmanager
def slow_work_kept(name: str) -> Generator[None]:
    """What a command's first run reads in a child process and draws is kept for the runs after it.

    So is what `demo` fits and `calibrate-twin` finds.
    The place is looked at, reserved and written anew each time: a pair costs a tenth of what it costs a user.
    """
    from matplotlib.figure import Figure

    from erclutch.report.plots import paper_style

    save = Figure.savefig
    drawings = dict[str, bytes]()

    def saved(figure: Figure, file: Any, *, format: str, **options: Any) -> None:
        if format not in drawings:
            save(figure, file, format=format, **options)
            drawings[format] = file.getvalue()
        else:
            file.write(drawings[format])

    with (
        mock.patch.object(child_process, "run", _first_answer(child_process.run)),
        mock.patch.object(Figure, "savefig", saved),
        mock.patch.object(paper_style, "settle", _first_answer(paper_style.settle)),
        ExitStack() as further,
    ):
        if name in LONG_WORK:
            module, _, work = LONG_WORK[name].rpartition(".")
            place: Any = import_module(module)
            further.enter_context(
                mock.patch.object(place, work, _first_answer(getattr(place, work)))
            )
        yield


def _first_answer(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, which answers words and paths as it did at first; other arguments count as the same."""
    answers = dict[tuple[str, ...], Any]()

    def answered(*given: Any, **options: Any) -> Any:
        key = tuple(str(each) for each in given if isinstance(each, str | Path))
        if key not in answers:
            answers[key] = function(*given, **options)
        return answers[key]

    return answered


def _run(name: str, pair: int, folder: Path, begin: Any, who: int) -> None:
    os.chdir(folder)
    with (
        open(f"said-{who}", "w", encoding="utf-8") as said,
        open(os.devnull, "w", encoding="utf-8") as nothing,
    ):
        sys.stdout, sys.stderr = nothing, said
        begin.wait()
        code = main(words_of(name, pair))
    os._exit(code)
