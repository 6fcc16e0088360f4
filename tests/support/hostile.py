"""What a machine, a plug-in, a worker or a file may do to erclutch, case by case: tries, and what did not hold."""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from queue import Empty, Queue

import numpy as np

from erclutch.export import ExportOptions, step_of
from erclutch.export.targets import python
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.runs.cluster import WorkerLostError, finished, in_order, task_pool
from tests.support.command import run
from tests.support.damaged_text import damaged
from tests.support.pace import within
from tests.support.warm_start import OF_OTHERS, WarmStart

#: Tries, and what did not hold.
Outcome = tuple[int, list[str]]
FIT = ("fit", "log.csv", "--models", "bingham", "--lag")
PATIENCE = 120.0  # s, of a machine that does other work
RUNS = 20_000  # in one folder of the app; a disk takes minutes to make 10^6


def bad_end(
    words: Sequence[object],
    cwd: Path,
    environment: dict[str, str] | None = None,
    most: int = 0,
    program: Sequence[str] = (sys.executable, "-m", "erclutch"),
) -> str:
    """How a program of erclutch ended wrongly; "" where it did its work, or gave one error with a remedy.

    Args:
        words: of the command.
        cwd: folder that it runs in.
        environment: variables that differ.
        most: bytes that a file of it may have, as on a full disk; 0: no limit.
        program: that takes the words; a warm one cannot have a limit.
    """

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    command = [*program, *map(str, words)]
    try:
        done = subprocess.run(
            command,
            cwd=cwd,
            env={**os.environ, **(environment or {})},
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
            preexec_fn=limit if most else None,
        )
    except subprocess.TimeoutExpired:
        return f"{words[0]}: no end"
    return _wrong(words, done.returncode, done.stderr)


def _wrong(words: Sequence[object], code: int, said: str) -> str:
    told = code == 0 or (code == 2 and said.startswith("error: ")) or code == 1
    return (
        ""
        if told and "Traceback" not in said
        else f"{' '.join(map(str, words))}: code {code}: {said[-300:]}"
    )


def fitted(folder: Path, lag: str = "none") -> None:
    write_synthetic_log(folder / "log.csv", seconds=4.0)
    assert run(*FIT, lag, "--out", "run", cwd=folder).code == 0


def no_place_to_write(folder: Path) -> Outcome:
    """Commands whose place takes no file, whose HOME does not either, and whose disk is full."""
    fitted(folder)
    wrong: list[str] = []
    nowhere = {
        name: "/proc/none"
        for name in ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME")
    }
    tries = [
        bad_end((*words, place), folder, nowhere)
        for place in ("/proc/none", "/dev/null/none")
        for words in (
            (*FIT, "none", "--out"),
            ("export", "run", "--to", "c", "--out"),
            ("report", "run", "--out"),
            ("predict", "log.csv", "--run", "run", "--out"),
        )
    ]
    tries += [
        bad_end((*words, f"small-{place}"), folder, most=most)
        for most in (0x400, 0x4000)
        for place, words in enumerate(
            (
                (*FIT, "none", "--out"),
                ("report", "run", "--out"),
                ("export", "run", "--to", "c", "--out"),
            )
        )
    ]
    wrong += filter(None, tries)
    wrong += [f"left {path.name}" for path in folder.rglob(".*partial*")]
    return len(tries), wrong


def mutated_exports(folder: Path) -> Outcome:
    """`verify` of an export of which one file is damaged: it fails, or the damage changes no number."""
    fitted(folder)
    assert run("export", "run", "--to", "c", "--out", "made", cwd=folder).code == 0
    rng, wrong, tries = np.random.default_rng(34), list[str](), 0
    files = sorted(path for path in (folder / "made").rglob("*") if path.is_file())
    with _warm_program() as program:
        for place in files:
            whole = place.read_bytes()
            for _ in range(3):
                place.write_bytes(damaged(whole, rng))
                wrong.append(bad_end(("verify", "made"), folder, program=program))
                tries += 1
            place.write_bytes(whole)
    return tries, [each for each in wrong if each]


@contextmanager
def _warm_program() -> Iterator[list[str]]:
    """`erclutch` without the second that its start takes; of erclutch itself nothing is imported before."""
    # Only the path of a short folder fits a socket.
    with (
        tempfile.TemporaryDirectory(prefix="erclutch-") as place,
        WarmStart(Path(place), OF_OTHERS) as warm,
    ):
        yield [str(warm.folder / "erclutch")]


def broken_plug_ins(folder: Path) -> Outcome:
    """Packages whose entry points raise, end the program, print, or are of no use: other work goes on."""
    # A law without memory, with noise: no stage pays, and the search ends after one look at each.
    slip = np.sin(np.arange(250) / 9.0)
    effort = np.tanh(9.0 * slip) + slip + np.random.default_rng(0).normal(0.0, 0.1, slip.size)
    rows = np.column_stack([np.arange(250) / 1000.0, slip, effort])
    head = "time [s],slip [rad/s],torque [N*m]"
    np.savetxt(folder / "log.csv", rows, "%.6g", ",", header=head, comments="")
    texts = {
        "raises": "1 / 0\n",
        "ends": "raise SystemExit(0)\n",
        "interrupts": "raise KeyboardInterrupt\n",
        "needs": "import no_such_module_at_all\n",
        "nothing": "THING = None\n",
        "odd": "class THING:\n    name = 5\n    def __getattr__(self, name):\n        raise RuntimeError('odd')\n",
        "grammar": "def (:\n",
    }
    wrong, tries = list[str](), 0
    with _warm_program() as program:
        for name, text in texts.items():
            package = folder / name
            about = package / f"{name}_plug-1.0.dist-info"
            about.mkdir(parents=True)
            (package / f"{name}_plug.py").write_text(text, encoding="utf-8")
            (about / "METADATA").write_text(
                f"Metadata-Version: 2.1\nName: {name}-plug\nVersion: 1.0\n", encoding="utf-8"
            )
            groups = ("laws", "readers", "stages", "targets", "commands", "rigs")
            points = "".join(
                f"[erclutch.{group}]\n{name} = {name}_plug:THING\n" for group in groups
            )
            (about / "entry_points.txt").write_text(points, encoding="utf-8")
            path = os.pathsep.join([str(package), *(entry for entry in sys.path if entry)])
            # A fit that searches for stages looks at those of all packages.
            fit = (*FIT, "auto", "--out", f"run-{name}")
            for words in (("laws", "--plugins"), fit, ("--help",)):
                wrong.append(bad_end(words, folder, {"PYTHONPATH": path}, program=program))
                tries += 1
            if not (folder / f"run-{name}" / "run.json").is_file():
                wrong.append(f"a plug-in that {name} stops a fit")
    return tries, [each for each in wrong if each]


def two_models_in_one_program(folder: Path) -> Outcome:
    """Exports for Python that take turns: each gives what it gives alone, to the bit."""
    from tests.support.exported_models import MODELS

    labels = ("bingham, single", "casson+lag, single", "fnn-3+rise-fall, single")
    rows = np.random.default_rng(5).uniform(0.0, 2.0, (200, 2)).tolist()
    models = []
    for place, label in enumerate(labels):
        home = folder / str(place)
        home.mkdir()
        step = step_of(MODELS[label], ExportOptions(name="m", period=1e-3))
        models.append(python.load(python.build(step, home)))
    alone = []
    for model in models:
        model.reset()
        alone.append([model.step(*row) for row in rows])
        model.reset()
    turns = [[model.step(*row) for model in models] for row in rows]
    wrong = [
        f"{label} beside others"
        for place, label in enumerate(labels)
        if [each[place] for each in turns] != alone[place]
    ]
    return len(labels) * len(rows), wrong


def float32_on_a_long_run(folder: Path) -> Outcome:
    """100 s at 1 kHz through models with states: float32 stays beside float64, at the end as near as at the start."""
    from tests.support.exported_models import MODELS

    rows = np.random.default_rng(6).uniform(0.0, 2.0, (100_000, 2))
    rows = np.cumsum(rows - 1.0, axis=0) * 1e-2 % 2.0  # slow, as a rig moves
    wrong, labels = list[str](), ("casson+lag, single", "fnn-3+rise-fall, single")
    for label in labels:
        efforts = []
        for precision in ("float64", "float32"):
            home = folder / f"{precision}-{labels.index(label)}"
            home.mkdir()
            options = ExportOptions(name="m", precision=precision, period=1e-3)
            model = python.load(python.build(step_of(MODELS[label], options), home))
            efforts.append(np.asarray(model.run(rows)[0]))
        off = np.abs(efforts[1] - efforts[0]) / np.max(np.abs(efforts[0]))
        first, last = np.max(off[:10_000]), np.max(off[-10_000:])
        if not (np.max(off) < 1e-4 and last < 10.0 * first + 1e-6):
            wrong.append(
                f"{label}: {np.max(off):.1e} of the largest effort; first {first:.1e}, last {last:.1e}"
            )
    return len(labels), wrong


def controller_in_float32_on_a_long_run(folder: Path) -> Outcome:
    """20 s at 1 kHz through controllers: in float32 each gives the flags of float64, and the torque that it asks for.

    Each inverse ends within 1/1600 of the largest effort (`ENOUGH` and `torque_scale` of c/erc_torque.c), so both may
    be apart by twice that, and no further at the end than at the start.
    """
    from erclutch.wings.live.targets import controller
    from tests.support.exported_models import MODELS

    count, rng = 20_000, np.random.default_rng(6)
    time_, noise = np.arange(count) * 1e-3, rng.standard_normal(count)
    wrong, labels = list[str](), ("hem+rise-fall, coaxial", "bingham+rise-fall, coaxial")
    for label in labels:
        efforts, flags = [], []
        for precision in ("float64", "float32"):
            options = ExportOptions(name="m", precision=precision, period=1e-3)
            step = step_of(MODELS[label], options)
            fastest = float(np.max(np.abs(controller.sample_rows(step, odd=0)[:, 2]))) / 1.5
            wanted = 0.3 * step.scale * np.sin(2.0 * np.pi * time_ / 1.28)
            drive = fastest * (1.0 + 0.5 * np.sin(2.0 * np.pi * time_ / 3.0))
            output = 0.25 * fastest * np.sin(2.0 * np.pi * time_ / 0.97)
            torque = 0.9 * wanted + 0.02 * step.scale * noise
            rate = np.asarray(np.gradient(wanted), np.float64) * 1e3
            columns = [wanted, rate, drive, output, 0.0 * wanted, torque, 0.0 * wanted + 0.1]
            home = folder / f"{precision}-{labels.index(label)}"
            home.mkdir()
            controller.write_core(step, home)
            bits = controller.answers(step, np.column_stack(columns), home)
            words = bits[:, 2].astype(f"u{step.precision.width // 8}")
            efforts.append(words.view(step.precision.dtype).astype(np.float64) / step.scale)
            flags.append(bits[:, 3])
        off = np.abs(efforts[1] - efforts[0])
        first, last = np.max(off[: count // 10]), np.max(off[-count // 10 :])
        if np.any(flags[0] != flags[1]):
            wrong.append(f"{label}: other flags in {np.count_nonzero(flags[0] != flags[1])} rows")
        if not (np.max(off) < 2.0 / 1600.0 and last < 2.0 * first):
            wrong.append(
                f"{label}: {np.max(off):.1e} of the scale; first {first:.1e}, last {last:.1e}"
            )
    return len(labels), wrong


def damaged_pairs_of_logs(folder: Path) -> Outcome:
    """`align` of a log beside a damaged copy."""
    write_synthetic_log(folder / "a.csv", seconds=4.0)
    whole, rng, wrong, count = (
        (folder / "a.csv").read_bytes(),
        np.random.default_rng(8),
        list[str](),
        30,
    )
    for number in range(count):
        (folder / "b.csv").write_bytes(
            damaged(whole, rng) if number % 3 else damaged(whole[: 200 * number + 100], rng)
        )
        words = ("align", "a.csv", "b.csv", "--on", "torque", "--out", f"{number}.csv")
        done = run(*words, cwd=folder)
        wrong.append(_wrong(words, done.code, done.error))
    return count, [each for each in wrong if each]


def tuning_of_damaged_runs(folder: Path) -> Outcome:
    """`tune` of a run whose model or whose record is damaged."""
    fitted(folder, "lag")
    rng, wrong, count = np.random.default_rng(9), list[str](), 30
    files = [folder / "run" / "run.json", *sorted((folder / "run" / "models").glob("*.json"))]
    wholes = [file.read_bytes() for file in files]
    for number in range(count):
        place = number % len(files)
        files[place].write_bytes(damaged(wholes[place], rng))
        words = ("tune", "run", "--as", "svg", "--force", "--out", "tuning")
        done = run(*words, cwd=folder)
        wrong.append(_wrong(words, done.code, done.error))
        files[place].write_bytes(wholes[place])
    return count, [each for each in wrong if each]


def make_runs(folder: Path, count: int) -> None:
    """So many folders of runs: a record each, by links to a few files."""
    first = folder
    body = json.dumps({"format": "erclutch run"})
    for number in range(count):
        run_folder = folder / f"run{number}"
        run_folder.mkdir()
        if number % 10_000 == 0:  # no file system takes any number of links to a file
            first = run_folder / "run.json"
            first.write_text(body, encoding="utf-8")
        else:
            os.link(
                first, run_folder / "run.json"
            )  # half the files: those of 10^6 are made in a minute


def many_runs_in_the_app(folder: Path) -> Outcome:
    """`RUNS` in the folder of the app: a look takes 1 s of CPU and 50 us a run at most, and no run is left out."""
    count, most = RUNS, 1.0 + 5e-5 * RUNS
    make_runs(folder, count)
    from erclutch.wings.app.workspace import Workspace  # a wing: tests of the core do without

    space = Workspace(folder)
    wrong: list[str] = []
    began = time.process_time()
    found = len(space.runs())
    took = time.process_time() - began
    logs = len(space.logs())
    if found != count or logs:
        wrong.append(f"{found} runs and {logs} logs of {count} runs")
    if not within(took, most):
        wrong.append(f"{took:.1f} s of CPU for a list")
    return count, wrong


def dies_once(mark: str) -> float:
    """Kill the worker the first time."""
    if not Path(mark).exists():
        Path(mark).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 1.0


def dies(_: str) -> float:
    """Kill the worker each time."""
    os.kill(os.getpid(), signal.SIGKILL)
    return 0.0


def is_slow(mark: str) -> float:
    """Later tasks end first."""
    time.sleep(0.3 if mark == "0" else 0.0)
    return float(mark)


class Unreadable:
    """Sent, and nobody can read it."""

    def __reduce__(self) -> tuple[type[int], tuple[str]]:
        return int, ("no number",)


def lies(_: str) -> object:
    """An answer that is none."""
    return Unreadable()


def dask_workers(folder: Path) -> Outcome:
    """Dask's workers on this machine: one that dies once, that dies each time, that is slow, that lies."""
    wrong = list[str]()
    with task_pool("local", 2) as pool:
        slow = list(in_order(pool, is_slow, [str(place) for place in range(4)]))
        if any(later - earlier != 1.0 for earlier, later in pairwise(slow)):
            wrong.append(f"results of a slow worker are out of order: {slow}")
        if list(in_order(pool, dies_once, [str(folder / "mark")])) != [1.0]:
            wrong.append("a worker that died once costs its result")
        (lie,) = finished(pool, lies, ["0"])
        if not isinstance(lie[1], WorkerLostError):
            wrong.append(f"an answer that nobody can read: {lie[1]!r}")
        (lost,) = finished(pool, dies, ["0"])
        if not isinstance(lost[1], WorkerLostError):
            wrong.append(f"a task that kills each worker: {lost[1]!r}")
    return 4, wrong


def stands_still_once(mark: str) -> float:
    """Stop the worker the first time: it keeps its connection."""
    if not Path(mark).exists():
        Path(mark).touch()
        os.kill(os.getpid(), signal.SIGSTOP)
    return 1.0


def standing_worker_of_dask(folder: Path) -> Outcome:
    """A worker that stands still: after a minute its task is done anew."""
    with task_pool("local", 2) as pool:
        began = time.monotonic()
        (result,) = in_order(pool, stands_still_once, [str(folder / "mark")])
        took = time.monotonic() - began
    wrong = [f"{took:.0f} s"] if took > 60.0 + PATIENCE else []
    return 1, wrong + ([] if result == 1.0 else [f"another result: {result}"])


def dies_now_and_then(number: int) -> bytes:
    """An answer of 20 MB, and often a worker that dies while it is fetched, or soon after."""
    chance = random.Random(f"{number} {os.getpid()}")
    if chance.random() < 0.15:
        threading.Timer(chance.uniform(0.0, 0.15), os.kill, (os.getpid(), signal.SIGKILL)).start()
    return os.urandom(1000) * 20_000


def dying_workers_of_dask(folder: Path) -> Outcome:
    """Tasks on two workers that die again and again: each is answered, in time, by its result or an error."""
    count, answers, over = 40, Queue[object](), object()

    def ask() -> None:
        with task_pool("local", 2) as pool:
            for _, result in finished(pool, dies_now_and_then, range(count)):
                answers.put(result)
        answers.put(over)

    threading.Thread(target=ask, daemon=True).start()
    answered, wrong = 0, list[str]()
    with suppress(Empty):
        while (result := answers.get(timeout=2.0 * PATIENCE)) is not over:
            answered += 1
            if not isinstance(result, bytes | WorkerLostError):
                wrong.append(f"{result!r}")
    if answered < count:
        wrong.append(f"{count - answered} tasks have no answer")
    return count, wrong


CASES: dict[str, Callable[[Path], Outcome]] = {
    "no place to write, disk full": no_place_to_write,
    "damaged exports under verify": mutated_exports,
    "plug-ins that are broken": broken_plug_ins,
    "models that take turns": two_models_in_one_program,
    "float32 beside float64, 100 s": float32_on_a_long_run,
    "controllers, float32 beside float64, 20 s": controller_in_float32_on_a_long_run,
    "align of damaged logs": damaged_pairs_of_logs,
    "tune of damaged runs": tuning_of_damaged_runs,
    "many runs in the app": many_runs_in_the_app,
    "workers of Dask": dask_workers,
    "worker of Dask that stands still": standing_worker_of_dask,
    "workers of Dask that die often": dying_workers_of_dask,
}
