"""``erclutch reproduce`` makes the paper's tables and sweeps, on the twin or on a user's log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.cli.quantities import SECONDS
from erclutch.errors import SettingError, require
from erclutch.files import may_fill
from erclutch.files.groups import together
from erclutch.files.places import nothing, reserve
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.rig.twin.parameters import RigParameters, load_rig

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset
    from erclutch.runs.cluster import TaskPool
    from erclutch.wings.paper.sweep_points import Points
    from erclutch.wings.paper.sweeps import RunsRecipe

COMMAND = {
    "help": "Print the paper's tables and draw its sweeps, on the digital TWIN or on your log.",
    "panel": "The digital TWIN and the paper",
    "place": 3,
}

_TRAINING = 290.0  # s: the paper's training run
_FIGURES = ("mse", "low", "high", "paper")
#: Figures of the live loop, and the experiment that each shows.
_ONLINE = {
    "fig7": "sine",
    "fig8": "square",
    "fig9": "tracking",
    "fig10": "tracking",
    "fig11": "zero-field",
    "fig12": "zero-motion",
    "fig13": "encoders",
}
_Table = Literal["table2", "table3", "memory"]
_Figure = Literal[
    "fig3",
    "fig4",
    "fig5",
    "fig6",
    "fig7",
    "fig8",
    "fig9",
    "fig10",
    "fig11",
    "fig12",
    "fig13",
    "kernels",
]
What = Literal[_Table, _Figure]


def reproduce(
    what: Annotated[What, Parameter(name="WHAT")],
    /,
    *,
    log: Annotated[tuple[Path, ...], Parameter(negative=())] = (),
    test_log: Path | None = None,
    zero_field: Path | None = None,
    zero_motion: Path | None = None,
    out: Path = Path("reproduced"),
    seconds: Annotated[float | None, SECONDS] = None,
    seed: int = 0,
    rig_file: Path | None = None,
    polish: Annotated[bool, Parameter(negative=())] = False,
    cluster: str | None = None,
    workers: int = 2,
    json: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Print a table of the paper, or draw one of its figures: on the digital TWIN, or on your own log.

    Args:
        what: table2, table3, memory (table2 with memory and with past samples), fig3 (a section of the training
            log), fig4 (RBFN: spread and neurons), fig5 (FNN: neurons), fig6 (what each approach estimates), kernels
            (RBFM); fig7 to fig13 (the live loop, on the TWIN alone).
        log: Your training log, in place of the twin.
        test_log: Your test log; default: the last 30 % of the training log.
        zero_field: Your log without field, for table3.
        zero_motion: Your log with the output held, for table3.
        out: Folder for figures and numbers; a sweep and the table of memory resume from what is there.
        seconds: Rig time of the twin's training run, 290 s if not given, or of an experiment of the live loop.
        seed: Seed of the twin's runs and of the networks' starts.
        rig_file: A rig file (TOML) for the twin.
        polish: Train networks longer, and on all rows at the end, not only on centroids.
        cluster: Where points of fig4, fig5 and kernels run: threads (default), processes, local (Dask here), or
            tcp://HOST:PORT of a Dask scheduler whose workers see the logs under the same paths.
        workers: Points of fig4, fig5 and kernels side by side; changes no figure.
        json: Print a table as JSON.
        reading: How to read your logs.
    """
    from erclutch.runs.cluster import task_pool
    from erclutch.wings.paper.commands.experiment import run_online
    from erclutch.wings.paper.section_figures import COMPARED, draw_estimates, draw_training_section
    from erclutch.wings.paper.sweep_points import make_folder
    from erclutch.wings.paper.sweeps import RunsRecipe
    from erclutch.wings.paper.tables import table
    from erclutch.wings.rig.twin.scenarios import prepare

    require(5, 86400, " s", seconds=_TRAINING if seconds is None else seconds)
    require(0, seed=seed)
    if what in _ONLINE and log:
        problem = f"{what} shows the live loop on the TWIN, and a log is no rig"
        raise SettingError(problem, remedy="Leave out --log, or run erclutch live on your rig")
    may_fill(out)
    make_folder(out)
    reserve(out / what, nothing)  # its figures, its numbers and the points that it resumes from

    if what in _ONLINE:
        options = {"seconds": seconds, "seed": seed}
        run_online([_ONLINE[what]], None, rig_file, out, options, int(what[3:]))
        return
    seconds = _TRAINING if seconds is None else seconds
    if what == "fig3":
        if log:
            recording = reading.read(log)[0]
        else:
            run = prepare("training", rig=load_rig(rig_file), seed=seed, seconds=min(seconds, 20.0))
            recording = run.recording()
        terminal.say(*draw_training_section(recording, out))
        return

    if log:
        others = {"test": test_log}
        if what == "table3":
            others = {"zero-field": zero_field, "zero-motion": zero_motion}
        own = (
            ("log", tuple(path.resolve() for path in log)),
            ("others", tuple((name, path.resolve()) for name, path in others.items() if path)),
            ("what", what),
            ("reading", reading),
        )
        recipe = RunsRecipe(_own_runs, own)
    else:
        of_twin = (("what", what), ("rig", rig_file), ("seed", seed), ("seconds", seconds))
        recipe = RunsRecipe(_twin_runs, of_twin)

    if what in ("fig4", "fig5", "kernels"):
        with task_pool(cluster, workers) as pool:
            _sweep(what, recipe, pool, out, seed)
        return
    runs, origin = _runs_of(recipe)
    if what == "memory":
        _memory(runs, origin, out, seed, polish, None if log else load_rig(rig_file), json)
    elif what == "fig6":
        train, test = runs.values()
        models = _of_device(COMPARED, train)
        with terminal.progress("fitting") as bar:
            rows = table({"training": train}, models=models, seed=seed, polish=polish, progress=bar)
        terminal.say(*draw_estimates(test, rows, out, origin))
    else:
        _table(what, runs, origin, out, seed, polish, json)


def _runs_of(recipe: RunsRecipe) -> tuple[dict[str, Dataset], str]:
    """The runs by name, and where they are from."""
    runs = recipe.make(**dict(recipe.options))
    train = next(iter(runs.values()))
    origin = train.origins[0] or "your log"
    return dict(runs), origin


def _of_device(models: Sequence[str], train: Dataset) -> Sequence[str]:
    """Names of the paper's models for a device: the slip of a single one turns, so no law keeps the sign of driving."""
    if train.device == "coaxial":
        return models
    return [name.removesuffix("/forward") for name in models]


def _twin_runs(what: What, rig: Path | None, seed: int, seconds: float) -> dict[str, Dataset]:
    from erclutch.wings.paper.tables import twin_runs

    names = ("training", "zero-field", "zero-motion") if what == "table3" else ("training", "test")
    return twin_runs(names, rig=load_rig(rig), seed=seed, seconds=seconds)


def _own_runs(
    log: tuple[Path, ...],
    others: tuple[tuple[str, Path], ...],
    what: What,
    reading: LogOptions,
) -> dict[str, Dataset]:
    """Rows of the training log and of the other logs; where there are none, the end of the first is the test."""
    from erclutch.logs.held_out import hold_out

    data = reading.dataset(reading.read(log))
    other_runs = {name: reading.dataset(reading.read([path])) for name, path in others}
    if other_runs:
        return {"training": data, **other_runs}
    if what == "table3":
        problem = "table3 needs runs without field or with the output held"
        raise SettingError(problem, remedy="Give --zero-field or --zero-motion")
    held = hold_out(data, 0.3)
    return {"training": data.take(~held), "test": data.take(held)}


def _table(
    what: What,
    runs: dict[str, Dataset],
    origin: str,
    out: Path,
    seed: int,
    polish: bool,
    json: bool,
) -> None:
    from erclutch.report.plots.paper_style import placed, save_numbers
    from erclutch.wings.paper.beside_the_paper import in_latex, on_screen
    from erclutch.wings.paper.tables import printed, table

    # Table III has figures of some approaches alone.
    names: list[str] = []
    for name, approach in APPROACHES.items():
        if what == "table2" or approach.zero_field is not None:
            names.append(name)
    train = next(iter(runs.values()))
    models = _of_device(names, train)
    with terminal.progress("fitting") as bar:
        rows = table(runs, models=models, seed=seed, polish=polish, progress=bar)

    header = ["model", "parameters", "cpu_s"]
    for run in runs:
        header += [f"{run}_{figure}" for figure in _FIGURES]
    lines: list[tuple[object, ...]] = []
    for row in rows:
        line: list[object] = [row.name, row.parameters, row.seconds]
        for run in runs:
            paper = printed(row.name).get(run)
            in_paper = "" if paper is None else paper
            line += [row.errors[run], *row.bands[run], in_paper]
        lines.append(tuple(line))
    latex = out / f"{what}.tex"
    shown = list(runs) if what == "table2" else list(runs)[1:]
    with together():
        numbers = save_numbers(out / f"{what}.csv", header, lines)
        with placed(latex) as unfinished:
            unfinished.write_text(in_latex(rows, shown, origin), encoding="utf-8")
    if json:
        _say_json(origin, header, lines, [numbers, latex])
        return

    screen = terminal.console()
    lengths = ", ".join(f"{name} {data.rows:,} rows" for name, data in runs.items())
    terminal.tell(
        f"{origin}: {lengths}. Mean squared errors; paper: as Huang and Ishikawa print them."
    )
    screen.print(on_screen(what, rows, shown, origin, screen.width))
    seconds = sum(row.seconds for row in rows)
    terminal.tell(f"{len(rows)} models in {seconds:.1f} CPU s")
    terminal.say(numbers, latex)


def _say_json(
    origin: str, header: Sequence[str], lines: Sequence[Sequence[object]], files: Sequence[object]
) -> None:
    """The numbers of a table, an entry a model; null where there is none."""
    rows: list[dict[str, object]] = []
    for line in lines:
        entry: dict[str, object] = {}
        for key, cell in zip(header, line, strict=True):
            entry[key] = None if cell == "" else cell
        rows.append(entry)
    terminal.say_json(
        {
            "data": origin,
            "rows": rows,
            "files": [str(file) for file in files],
        }
    )


def _memory(
    runs: dict[str, Dataset],
    origin: str,
    out: Path,
    seed: int,
    polish: bool,
    rig: RigParameters | None,
    json: bool,
) -> None:
    from erclutch.report.plots.paper_style import save_numbers
    from erclutch.wings.paper.beside_the_paper import or_dash
    from erclutch.wings.paper.memory_table import PAST, memory_table, noise_floor

    points = _points("memory", runs, out, {"seed": seed, "polish": polish})
    with terminal.progress("fitting") as bar:
        stages, variants = memory_table(runs, points, seed, polish, bar)

    header = ["variant", "model", "parameters"]
    for run in runs:
        header += [f"{run}_{figure}" for figure in ("mse", "low", "high")]
    lines: list[tuple[object, ...]] = []
    for variant, models in variants.items():
        for name, figures in models.items():
            line: list[object] = [variant, name, figures["parameters"]]
            for run in runs:
                line += figures[run]
            lines.append(tuple(line))
    file = save_numbers(out / "memory.csv", header, lines)
    if json:
        _say_json(origin, header, lines, [file])
        return

    screen = terminal.console()
    past = ", ".join(PAST)
    terminal.tell(
        f"{origin}: mean squared errors. Memory: {stages}, as the ladder chose. Past: {past}."
    )
    titles = {
        name.removesuffix("/forward"): approach.title for name, approach in APPROACHES.items()
    }
    for run in runs:
        cells = {"model": list(titles.values())}
        for variant, models in variants.items():
            errors: list[str] = []
            for name in titles:
                error = models[name][run][0] if name in models else None
                errors.append(or_dash(error, "{:.2e}"))
            heading = variant.replace(" ", "\n", 1)
            cells[heading] = errors
        screen.print(terminal.narrowed(f"{origin}, {run}", cells, (), screen.width))
    if rig is not None:
        terminal.tell(
            f"Noise of the TWIN's torque meter: {noise_floor(rig):.1e}. No model can come below."
        )
    terminal.say(file)


def _points(
    what: str, runs: Mapping[str, Dataset], out: Path, settings: Mapping[str, Any]
) -> Points:
    """What is known already of these rows and settings."""
    from erclutch.wings.paper.sweep_points import Points, digest_of_rows

    digests: list[str] = []  # one a run
    for run in runs.values():
        signals = [run.effort, run.clock.time, *run.extras.values()]
        for element in run.elements:
            signals += [element.field, element.slip]
        digests.append(digest_of_rows(signals))
    return Points(out / f"{what}.points.jsonl", {"what": what, "rows": digests, **settings})


def _sweep(what: What, recipe: RunsRecipe, pool: TaskPool, out: Path, seed: int) -> None:
    from erclutch.wings.paper import sweeps
    from erclutch.wings.paper.sweep_figures import (
        draw_fnn_sweep,
        draw_kernel_sweep,
        draw_rbfn_sweep,
    )

    runs, origin = _runs_of(recipe)
    points = _points(what, runs, out, {"seed": seed})
    # The paper's own errors stand beside those of its device alone.
    of_paper: dict[int, float] = {}
    if origin == "TWIN":
        of_paper = {neurons: APPROACHES[f"fnn-{neurons}"].train for neurons in (6, 16)}
    with terminal.progress(what) as bar:
        if what == "fig4":
            errors = sweeps.rbfn_sweep(recipe, pool, points, seed, bar)
            draw = draw_rbfn_sweep
        elif what == "fig5":
            errors = sweeps.fnn_sweep(recipe, pool, points, seed, bar)
            draw = partial(draw_fnn_sweep, printed=of_paper)
        else:
            errors = sweeps.kernel_sweep(recipe, pool, points, seed, bar)
            draw = draw_kernel_sweep
    terminal.say(*draw(errors, out, origin))
