"""``erclutch reproduce``: the paper's tables and sweeps, on the twin or on a user's log."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import SettingError

if TYPE_CHECKING:
    from erclutch.dataset import Dataset
    from erclutch.experiments.tables import Row

What = Literal["table2", "table3", "fig4", "fig5", "kernels"]


def reproduce(
    what: What,
    *,
    log: tuple[Path, ...] = (),
    test: Path | None = None,
    zero_field: Path | None = None,
    zero_motion: Path | None = None,
    out: Path = Path("reproduced"),
    seconds: float = 290.0,
    seed: int = 0,
    rig: Path | None = None,
    polish: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Print a table of the paper, or draw one of its sweeps: on the digital TWIN, or on your own log.

    Args:
        what: table2, table3, fig4 (RBFN: spread and neurons), fig5 (FNN: neurons), kernels (RBFM).
        log: Your training log, in place of the twin.
        test: Your test log; default: the last 30 % of the training log.
        zero_field: Your log without field, for table3.
        zero_motion: Your log with the output held, for table3.
        out: Folder for figures, numbers and models; a sweep resumes from what is there.
        seconds: Rig time of the twin's training run.
        seed: Of the twin's runs and of the networks' starts.
        rig: A rig file (TOML) for the twin.
        polish: Train networks on all rows at last, not only on centroids.
        reading: How to read your logs.
    """
    from erclutch.errors import RunError

    if not 5.0 <= seconds <= 86400.0 or seed < 0:
        raise SettingError(f"--seconds {seconds:g} --seed {seed}", remedy="Give 5 to 86400 s and a seed of 0 or more")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"cannot be made: {error.strerror}", where=str(out), remedy="Give another --out") from error
    if log:
        runs, origin = _own_runs(what, log, test, zero_field, zero_motion, reading)
    else:
        runs, origin = _twin_runs(what, seconds, seed, rig), "TWIN"
    if what in ("table2", "table3"):
        _table(what, runs, origin, out, seed, polish)
    else:
        _sweep(what, runs, origin, out, seed)


def _twin_runs(what: What, seconds: float, seed: int, rig: Path | None) -> dict[str, Dataset]:
    from erclutch.experiments.tables import twin_runs
    from erclutch.rig.parameters import load_rig

    names = ("training", "zero-field", "zero-motion") if what == "table3" else ("training", "test")
    return twin_runs(names, rig=None if rig is None else load_rig(rig), seed=seed, seconds=seconds)


def _own_runs(
    what: What,
    log: tuple[Path, ...],
    test: Path | None,
    zero_field: Path | None,
    zero_motion: Path | None,
    reading: LogOptions,
) -> tuple[dict[str, Dataset], str]:
    from erclutch.dataset import hold_out

    recordings = reading.read(log)
    data = reading.dataset(recordings)
    origin = recordings[0].origin or "your log"
    if what == "table3":
        others = {"zero-field": zero_field, "zero-motion": zero_motion}
        given = {name: reading.dataset(reading.read([path])) for name, path in others.items() if path is not None}
        if not given:
            raise SettingError(
                "table3 needs runs without field or with the output held", remedy="Give --zero-field or --zero-motion"
            )
        return {"training": data, **given}, origin
    if test is not None:
        return {"training": data, "test": reading.dataset(reading.read([test]))}, origin
    held = hold_out(data, 0.3)
    return {"training": data.take(~held), "test": data.take(held)}, origin


def _table(what: What, runs: dict[str, Dataset], origin: str, out: Path, seed: int, polish: bool) -> None:
    from erclutch.cli import show
    from erclutch.experiments.tables import table
    from erclutch.figures.style import save_numbers
    from erclutch.paper import APPROACHES

    names = [n for n, a in APPROACHES.items() if what == "table2" or a.zero_field is not None]
    device = next(iter(runs.values())).device
    if device == "single":
        names = [n.removesuffix("/forward") for n in names]
    rows = _with_progress(
        "fitting", lambda report: table(runs, models=names, seed=seed, polish=polish, progress=report)
    )
    screen = show.console()
    lengths = ", ".join(f"{name} {data.rows:,} rows" for name, data in runs.items())
    screen.print(f"{origin}: {lengths}. Mean squared errors; paper: as Huang and Ishikawa print them.", markup=False)
    screen.print(_printed(what, rows, list(runs), origin, screen.width))
    seconds = sum(row.seconds for row in rows)
    screen.print(f"{len(rows)} models in {seconds:.1f} CPU s", markup=False)
    header, lines = _numbers(rows, list(runs))
    screen.print(f"{save_numbers(out / f'{what}.csv', header, lines)}", markup=False, soft_wrap=True)


def _printed(what: What, rows: list[Row], runs: list[str], origin: str, width: int) -> Any:
    """The table; on a narrow screen bands, seconds and ratios are left out, in this order."""
    from erclutch.cli import show
    from erclutch.experiments.tables import printed
    from erclutch.paper import APPROACHES

    paper = [printed(row.name) for row in rows]
    cells: dict[str, list[str]] = {
        "model": [APPROACHES[row.name].title if row.name in APPROACHES else row.title for row in rows]
    }
    shown = runs if what == "table2" else runs[1:]
    for run in shown:
        cells[f"{run}\n{origin}"] = [f"{row.errors[run]:.3e}" for row in rows]
        cells[f"{run}\n95 % band"] = [f"{row.bands[run][0]:.1e} - {row.bands[run][1]:.1e}" for row in rows]
        cells[f"{run}\npaper"] = [_or_dash(figures.get(run), "{:.3e}") for figures in paper]
    base = rows[0].errors["training"]
    cells[f"to Bingham\n{origin}"] = [f"{row.errors['training'] / base:.3f}" for row in rows]
    cells["to Bingham\npaper"] = [_or_dash(_ratio(figures, paper[0]), "{:.3f}") for figures in paper]
    cells["CPU s"] = [f"{row.seconds:.2f}" for row in rows]
    less_needed = [f"{run}\n95 % band" for run in shown] + ["CPU s", "to Bingham\npaper", f"to Bingham\n{origin}"]
    number = {"table2": "II", "table3": "III"}[what]
    return show.narrowed(f"Table {number}: {origin} beside the paper", cells, less_needed, width)


def _ratio(figures: Mapping[str, float | None], base: Mapping[str, float | None]) -> float | None:
    """Of a training error as the paper prints it to that of the Bingham model; None where it prints none."""
    error, against = figures.get("training"), base.get("training")
    return error / against if error and against else None


def _or_dash(value: float | None, form: str) -> str:
    return "-" if value is None else form.format(value)


def _numbers(rows: list[Row], runs: list[str]) -> tuple[list[str], list[tuple[object, ...]]]:
    from erclutch.experiments.tables import printed

    header = ["model", "parameters", "cpu_s"]
    for run in runs:
        header += [f"{run}_mse", f"{run}_low", f"{run}_high", f"{run}_paper"]
    lines: list[tuple[object, ...]] = []
    for row in rows:
        line: list[object] = [row.name, row.parameters, row.seconds]
        for run in runs:
            paper = printed(row.name).get(run)
            line += [row.errors[run], *row.bands[run], "" if paper is None else paper]
        lines.append(tuple(line))
    return header, lines


def _sweep(what: What, runs: dict[str, Dataset], origin: str, out: Path, seed: int) -> None:
    from erclutch.cli import show
    from erclutch.experiments import sweeps
    from erclutch.experiments.points import Points
    from erclutch.figures.sweeps import draw_fnn_sweep, draw_kernel_sweep, draw_rbfn_sweep
    from erclutch.paper import APPROACHES

    train, test = runs.values()
    digest = [float(train.effort.sum()), float(test.effort.sum()), train.rows, test.rows]
    points = Points(out / f"{what}.points.jsonl", {"what": what, "seed": seed, "rows": digest})
    run = {"fig4": sweeps.rbfn_sweep, "fig5": sweeps.fnn_sweep, "kernels": sweeps.kernel_sweep}[what]
    found = _with_progress(what, lambda report: run(train, test, points, seed, report))
    if what == "fig4":
        paths = draw_rbfn_sweep(found, out, origin)
    elif what == "fig5":
        twin = origin == "TWIN"
        printed = {int(n[4:]): a.train for n, a in APPROACHES.items() if n in ("fnn-6", "fnn-16") and twin}
        paths = draw_fnn_sweep(found, out, origin, printed)
    else:
        paths = draw_kernel_sweep(found, out, origin)
    for path in paths:
        show.console().print(str(path), markup=False, soft_wrap=True)


def _with_progress(title: str, work: Callable[[Callable[[int, int, str], None]], Any]) -> Any:
    from rich.console import Console
    from rich.progress import Progress

    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task(title, total=None)
        return work(lambda done, total, what: bar.update(task, completed=done, total=total, description=what))
