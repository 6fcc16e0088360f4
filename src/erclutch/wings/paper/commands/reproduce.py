"""``erclutch reproduce`` makes the paper's tables and sweeps, on the twin or on a user's log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.cli.quantities import SECONDS
from erclutch.errors import RunError, SettingError, require
from erclutch.files.places import nothing, reserve
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.rig.twin.parameters import RigParameters, load_rig

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset
    from erclutch.runs.cluster import TaskPool
    from erclutch.wings.paper.sweep_points import Points
    from erclutch.wings.paper.sweeps import RunsRecipe
    from erclutch.wings.paper.tables import Row

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
_Figure = Literal["fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9", "fig10", "fig11", "fig12", "fig13", "kernels"]
What = Literal[_Table, _Figure]


def reproduce(
    what: Annotated[What, Parameter(name="WHAT")],
    /,
    *,
    log: tuple[Path, ...] = (),
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
    from erclutch.wings.paper.section_figures import COMPARED, draw_estimates, draw_training_section
    from erclutch.wings.paper.sweeps import RunsRecipe
    from erclutch.wings.paper.tables import table
    from erclutch.wings.rig.twin.scenarios import prepare

    require(5, 86400, " s", seconds=_TRAINING if seconds is None else seconds)
    require(0, seed=seed)
    if what in _ONLINE and log:
        problem = f"{what} shows the live loop on the TWIN, and a log is no rig"
        raise SettingError(problem, remedy="Leave out --log, or run erclutch live on your rig")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"cannot be made: {error.strerror}", where=str(out), remedy="Give another --out") from error
    reserve(out / what, nothing)  # its figures, its numbers and the points that it resumes from

    if what in _ONLINE:
        from erclutch.wings.paper.commands.experiment import run_online

        run_online([_ONLINE[what]], None, rig_file, out, {"seconds": seconds, "seed": seed}, int(what[3:]))
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

    # How the runs are made, as a value: each process that a sweep starts makes them anew.
    if log:
        others = {"zero-field": zero_field, "zero-motion": zero_motion} if what == "table3" else {"test": test_log}
        given = tuple((name, path.resolve()) for name, path in others.items() if path)
        logs = tuple(each.resolve() for each in log)
        own = (("log", logs), ("others", given), ("what", what), ("reading", reading))
        recipe = RunsRecipe(_own_runs, own)
    else:
        twin = (("what", what), ("rig", rig_file), ("seed", seed), ("seconds", seconds))
        recipe = RunsRecipe(_twin_runs, twin)

    if what in ("fig4", "fig5", "kernels"):
        with task_pool(cluster, workers) as pool:
            _sweep(what, recipe, pool, out, seed)
        return
    runs, origin = _runs_of(recipe)
    if what == "memory":
        _memory(runs, origin, out, seed, polish, None if log else load_rig(rig_file), json)
    elif what == "fig6":
        train, test = runs.values()
        models = COMPARED if train.device == "coaxial" else [name.removesuffix("/forward") for name in COMPARED]
        with terminal.progress("fitting") as bar:
            rows = table({"training": train}, models=models, seed=seed, polish=polish, progress=bar)
        terminal.say(*draw_estimates(test, rows, out, origin))
    else:
        _table(what, runs, origin, out, seed, polish, json)


def _runs_of(recipe: RunsRecipe) -> tuple[dict[str, Dataset], str]:
    """The runs by name, and where they are from."""
    runs = recipe.make(**dict(recipe.options))
    return dict(runs), next(iter(runs.values())).origins[0] or "your log"


def _twin_runs(what: What, rig: Path | None, seed: int, seconds: float) -> dict[str, Dataset]:
    from erclutch.wings.paper.tables import twin_runs

    names = ("training", "zero-field", "zero-motion") if what == "table3" else ("training", "test")
    return twin_runs(names, rig=load_rig(rig), seed=seed, seconds=seconds)


def _own_runs(
    log: tuple[Path, ...], others: tuple[tuple[str, Path], ...], what: What, reading: LogOptions
) -> dict[str, Dataset]:
    """Rows of the training log and of the other logs; where there are none, the end of the first is the test."""
    from erclutch.logs.dataset import hold_out

    data = reading.dataset(reading.read(log))
    given = {name: reading.dataset(reading.read([path])) for name, path in others}
    if given:
        return {"training": data, **given}
    if what == "table3":
        problem = "table3 needs runs without field or with the output held"
        raise SettingError(problem, remedy="Give --zero-field or --zero-motion")
    held = hold_out(data, 0.3)
    return {"training": data.take(~held), "test": data.take(held)}


def _table(what: What, runs: dict[str, Dataset], origin: str, out: Path, seed: int, polish: bool, json: bool) -> None:
    from erclutch.report.plots.paper_style import placed, save_numbers
    from erclutch.wings.paper.tables import table

    # Table III has figures of some approaches alone.
    names: list[str] = []
    for name, approach in APPROACHES.items():
        if what == "table2" or approach.zero_field is not None:
            names.append(name)
    device = next(iter(runs.values())).device
    if device == "single":  # the slip turns, so no law keeps the sign in which the device drives
        names = [name.removesuffix("/forward") for name in names]
    with terminal.progress("fitting") as bar:
        rows = table(runs, models=names, seed=seed, polish=polish, progress=bar)
    header, lines = _numbers(rows, list(runs))
    files = [save_numbers(out / f"{what}.csv", header, lines), out / f"{what}.tex"]
    shown = list(runs) if what == "table2" else list(runs)[1:]
    with placed(out / f"{what}.tex") as partial:
        partial.write_text(_latex(rows, shown, origin), encoding="utf-8")
    if json:
        _say_json(origin, header, lines, files)
        return
    screen = terminal.console()
    lengths = ", ".join(f"{name} {data.rows:,} rows" for name, data in runs.items())
    terminal.tell(f"{origin}: {lengths}. Mean squared errors; paper: as Huang and Ishikawa print them.")
    screen.print(_printed(what, rows, list(runs), origin, screen.width))
    seconds = sum(row.seconds for row in rows)
    terminal.tell(f"{len(rows)} models in {seconds:.1f} CPU s")
    terminal.say(*files)


def _say_json(origin: str, header: Sequence[str], lines: Sequence[Sequence[object]], files: Sequence[object]) -> None:
    """The numbers of a table, an entry a model; null where there is none."""
    rows = [{key: None if cell == "" else cell for key, cell in zip(header, line, strict=True)} for line in lines]
    terminal.say_json({"data": origin, "rows": rows, "files": [str(file) for file in files]})


def _printed(what: What, rows: list[Row], runs: list[str], origin: str, width: int) -> Any:
    """The table; on a narrow screen bands, seconds and ratios are left out, in this order."""
    from erclutch.wings.paper.tables import printed

    paper = [printed(row.name) for row in rows]
    names = [APPROACHES[row.name].title if row.name in APPROACHES else row.title for row in rows]
    cells: dict[str, list[str]] = {"model": names}
    shown = runs if what == "table2" else runs[1:]
    for run in shown:
        cells[f"{run}\n{origin}"] = [f"{row.errors[run]:.3e}" for row in rows]
        cells[f"{run}\n95 % band"] = [f"{row.bands[run][0]:.1e} - {row.bands[run][1]:.1e}" for row in rows]
        cells[f"{run}\npaper"] = [_or_dash(figures.get(run), "{:.3e}") for figures in paper]
    to_bingham: list[str] = []
    for run in runs[:1] if what == "table2" else shown:
        ours, theirs = _to_bingham(rows, run)
        heading = "to Bingham" if what == "table2" else f"{run}\nto Bingham"
        cells[f"{heading}\n{origin}"] = [f"{ratio:.3f}" for ratio in ours]
        cells[f"{heading}\npaper"] = [_or_dash(ratio, "{:.3f}") for ratio in theirs]
        to_bingham = [f"{heading}\npaper", f"{heading}\n{origin}", *to_bingham]
    cells["CPU s"] = [f"{row.seconds:.2f}" for row in rows]
    less_needed = [f"{run}\n95 % band" for run in shown] + ["CPU s", *to_bingham]
    number = {"table2": "II", "table3": "III"}[what]
    return terminal.narrowed(f"Table {number}: {origin} beside the paper", cells, less_needed, width)


def _to_bingham(rows: list[Row], run: str) -> tuple[list[float], list[float | None]]:
    """Errors on a run over that of the first model, which is Bingham's: ours, and the paper's."""
    from erclutch.wings.paper.tables import printed

    bingham = rows[0]
    bingham_of_paper = printed(bingham.name).get(run)
    ours: list[float] = []
    theirs: list[float | None] = []
    for row in rows:
        ours.append(row.errors[run] / bingham.errors[run])
        error = printed(row.name).get(run)
        ratio = None
        if error is not None and bingham_of_paper:
            ratio = error / bingham_of_paper
        theirs.append(ratio)
    return ours, theirs


def _latex(rows: list[Row], runs: list[str], origin: str) -> str:
    """The table for a paper: errors with 95 % bands, the paper's own, and their ratios to Bingham."""
    from erclutch.report.printed_table import PRINTERS, Interval, PaperTable
    from erclutch.wings.paper.tables import printed

    names = [APPROACHES[row.name].title if row.name in APPROACHES else row.title for row in rows]
    lines: list[list[str | int | Interval]] = [[name] for name in names]
    header = ["Model"]
    for run in runs:
        header += [f"{run}, {origin}", f"{run}, low", f"{run}, high", f"{run}, paper", "to Bingham", "paper"]
        for line, row, ours, theirs in zip(lines, rows, *_to_bingham(rows, run), strict=True):
            known = printed(row.name).get(run)
            line += [(row.errors[run], *row.bands[run]), "" if known is None else f"{known:.4e}".replace("e-0", "e-")]
            line += [f"{ours:.3f}", "" if theirs is None else f"{theirs:.3f}"]
    caption = f"Mean squared errors with 95 % bands on {origin} data, beside those that Huang and Ishikawa print."
    return PRINTERS["latex"](PaperTable(header, lines, caption))


def _or_dash(value: float | None, form: str) -> str:
    """A number in a form such as ``{:.3f}``; a dash where there is none."""
    return "-" if value is None else form.format(value)


def _numbers(rows: list[Row], runs: list[str]) -> tuple[list[str], list[tuple[object, ...]]]:
    """Header and lines of the table's CSV."""
    from erclutch.wings.paper.tables import printed

    header = ["model", "parameters", "cpu_s"]
    for run in runs:
        header += [f"{run}_{figure}" for figure in _FIGURES]
    lines: list[tuple[object, ...]] = []
    for row in rows:
        line: list[object] = [row.name, row.parameters, row.seconds]
        for run in runs:
            paper = printed(row.name).get(run)
            line += [row.errors[run], *row.bands[run], "" if paper is None else paper]
        lines.append(tuple(line))
    return header, lines


def _memory(
    runs: dict[str, Dataset], origin: str, out: Path, seed: int, polish: bool, rig: RigParameters | None, json: bool
) -> None:
    from erclutch.report.plots.paper_style import save_numbers
    from erclutch.wings.paper.memory_table import PAST, memory_table, noise_floor

    points = _points("memory", runs, out, {"seed": seed, "polish": polish})
    with terminal.progress("fitting") as bar:
        stages, variants = memory_table(runs, points, seed, polish, bar)
    header = ["variant", "model", "parameters"]
    for run in runs:
        header += [f"{run}_{figure}" for figure in _FIGURES[:3]]
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
    terminal.tell(f"{origin}: mean squared errors. Memory: {stages}, as the ladder chose. Past: {', '.join(PAST)}.")
    titles = {name.removesuffix("/forward"): approach.title for name, approach in APPROACHES.items()}
    for run in runs:
        cells = {"model": [*titles.values()]}
        for variant, models in variants.items():
            errors = [models[name][run][0] if name in models else None for name in titles]
            cells[variant.replace(" ", "\n", 1)] = [_or_dash(error, "{:.2e}") for error in errors]
        screen.print(terminal.narrowed(f"{origin}, {run}", cells, (), screen.width))
    if rig is not None:
        terminal.tell(f"Noise of the TWIN's torque meter: {noise_floor(rig):.1e}. No model can come below.")
    terminal.say(file)


def _points(what: str, runs: Mapping[str, Dataset], out: Path, settings: Mapping[str, Any]) -> Points:
    """What is known already of these rows and settings."""
    from erclutch.wings.paper.sweep_points import Points

    digest: list[list[float]] = []
    for run in runs.values():
        signals = [run.effort, *(element.slip for element in run.elements)]
        digest.append([run.rows, *(float(abs(signal).sum()) for signal in signals)])
    return Points(out / f"{what}.points.jsonl", {"what": what, "rows": digest, **settings})


def _sweep(what: What, recipe: RunsRecipe, pool: TaskPool, out: Path, seed: int) -> None:
    from erclutch.wings.paper import sweeps
    from erclutch.wings.paper.sweep_figures import draw_fnn_sweep, draw_kernel_sweep, draw_rbfn_sweep

    runs, origin = _runs_of(recipe)
    points = _points(what, runs, out, {"seed": seed})
    sweep = {"fig4": sweeps.rbfn_sweep, "fig5": sweeps.fnn_sweep, "kernels": sweeps.kernel_sweep}[what]
    with terminal.progress(what) as bar:
        errors = sweep(recipe, pool, points, seed, bar)
    if what == "fig5":
        # The paper's own errors stand beside those of its device alone.
        of_paper: dict[int, float] = {}
        if origin == "TWIN":
            of_paper = {neurons: APPROACHES[f"fnn-{neurons}"].train for neurons in (6, 16)}
        paths = draw_fnn_sweep(errors, out, origin, of_paper)
    else:
        paths = {"fig4": draw_rbfn_sweep, "kernels": draw_kernel_sweep}[what](errors, out, origin)
    terminal.say(*paths)
