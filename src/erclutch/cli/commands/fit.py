"""``erclutch fit`` does the main job: a log in, ranked models out."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from erclutch.cli import scored_rows, terminal
from erclutch.cli.folded_help import folded
from erclutch.cli.options import DEFAULT_READING, LogOptions, expand
from erclutch.cli.quantities import MEMORY
from erclutch.errors import SettingError, require

if TYPE_CHECKING:
    from erclutch.fit.comparison import Comparison, FitStep, Settings
    from erclutch.logs.any_size import RowsOfLogs
    from erclutch.logs.dataset import Dataset
    from erclutch.logs.reading import Reading
    from erclutch.runs.every_row import EveryRow
    from erclutch.signals.device import DeviceName

COMMAND = {
    "help": "Fit all models to a log, rank them on rows held out, recommend one.",
    "panel": "The road of a log",
    "place": 4,
}

MODELS = Group("Models and figures", sort_key=1)
LONG_LOGS = folded("Logs beyond memory", 5)
ModelNames = Annotated[
    tuple[str, ...], Parameter(group=MODELS, consume_multiple=True, negative=(), show_default=False)
]
# Types of options, and where they stand in the help; a flag has no --no-flag.
_OF_MODELS = Parameter(group=MODELS)
_Flag = Annotated[bool, Parameter(group=MODELS, negative=())]
_Times = Annotated[tuple[str, ...], Parameter(group=MODELS, consume_multiple=True, negative=())]


def fit(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    /,
    *,
    models: ModelNames = ("all",),
    lag: Annotated[str, Parameter(name=("--lag", "--stages"), group=MODELS)] = "auto",
    test: ModelNames = ("auto",),
    blocks: Annotated[int, _OF_MODELS] = 0,
    friction: Annotated[bool | None, _OF_MODELS] = None,
    offset: Annotated[bool | None, _OF_MODELS] = None,
    seed: Annotated[int, _OF_MODELS] = 0,
    past: _Times = (),
    polish: _Flag = False,
    workers: Annotated[int, _OF_MODELS] = 1,
    memory: Annotated[float, MEMORY, Parameter(group=LONG_LOGS)] = 1.5,
    cluster: Annotated[str | None, Parameter(group=LONG_LOGS)] = None,
    resume: Annotated[bool, Parameter(group=LONG_LOGS, negative=())] = False,
    out: Annotated[Path | None, _OF_MODELS] = None,
    force: _Flag = False,
    final: _Flag = False,
    all_: Annotated[_Flag, Parameter(name="--all")] = False,
    json: _Flag = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Fit all models to a log, score them on rows held out, rank them, and recommend one.

    Args:
        logs: One log or several of the same device; a folder stands for the logs in it.
        models: Laws of `erclutch laws`, networks, both joined by + (a network on the law's residual), each with its own
            stages if wanted: bingham hem/square fnn-16+lag+dahl-2 bingham+fnn-16. 'paper': those of its tables.
            Default: 'all'.
        lag: 'none'; 'auto': without and with a lag, and memory of the slip as far as the data ask for it; or stages
            out of `erclutch laws`, joined by +, such as lag, rise-fall, dahl/field, effort-lag.
        test: Held out: a share (the end of each log, or of each constant field), 'stretches' (30 % all over each log,
            like it in field, slip and motion), or patterns of names. Default: 0.3; stretches if an end goes beyond all.
        blocks: Also cross-validate over this many blocks in time of the training rows.
        friction: Fit a friction effort at zero field. Default: yes for single, no for coaxial (the paper's form).
        offset: Fit a constant effort. Default: as for friction.
        seed: Seed of the bootstrap that gives the bands, and of the networks' starts.
        past: Networks also take signals of so long ago as inputs, such as --past 1ms 2ms; a plain number counts rows.
        polish: Train networks longer, and on all rows at the end, not only on centroids.
        workers: How many models are fitted side by side, and parts of long logs scored; changes no figure. Two pay from
            some 300,000 rows on.
        memory: GB that the fit may take. Of logs that need more, whole stretches are fitted, and every row is scored.
        cluster: Where every row is scored: threads (default), processes, local (Dask here), or tcp://HOST:PORT of Dask.
        resume: Go on where the scoring of every row of --out was interrupted; the models are there.
        out: Folder to keep the run in.
        force: Replace a run that is already there.
        final: After the choice, also fit the recommended model to all rows. It is kept in --out beside the judged one;
            take it with --model final.
        all_: Print every model with its specification and its notes, not the first 8 alone.
        json: Print everything as JSON instead of tables.
        reading: How to read the log.
    """
    from erclutch.fit.comparison import Settings
    from erclutch.logs.held_out import held_out_as_told
    from erclutch.runs.tasks import tasks_on
    from erclutch.runs.written_run import may_write, run_to_dict, write_run

    began = time.perf_counter()
    require_counts(workers, seed, blocks)
    if resume:
        return _resumed(out, reading, cluster, workers, json)
    if out is not None:
        may_write(out, force)
    elif final or force:
        where = "--final" if final else "--force"
        raise SettingError("no run is kept", where=where, remedy="Give --out RUN too")
    settings = Settings(
        models=model_names(models),
        lag=lag,
        test=held_out_as_told(test),
        blocks=blocks,
        friction=friction,
        offset=offset,
        seed=seed,
        workers=workers,
        # Counts of rows are numbers; times stay as they were written.
        past=tuple(int(ago) if ago.isdecimal() else ago for ago in past),
        polish=polish,
    )
    how = reading.how()
    # A cluster that does not answer is told before the fit.
    with tasks_on(cluster, workers) as tasks:
        rows = _read(logs, how, reading.device, 1e9 * memory)
        comparison = _compared(rows.data, settings, final=final)
        if not json:
            _print_all(rows, comparison, time.perf_counter() - began, whole=all_, final=final)
        if out is not None:
            write_run(out, comparison, rows.logs, reading=reading.to_dict(), force=force)
        figures = scored_rows.score_left_out(rows, comparison, how, tasks, out)
    if json:
        body = dict(run_to_dict(comparison, rows.logs, reading.to_dict()))
        if figures is not None:
            body["every_row"] = figures.to_dict()
        terminal.say_json(body)
        return
    if figures is not None:
        _print_every_row(figures, comparison.recommended, comparison.data.units.effort)
    terminal.say(*terminal.kept_lines(out))


def _resumed(
    out: Path | None,
    reading: LogOptions,
    cluster: str | None,
    workers: int,
    json: bool,
) -> None:
    """Score the rows of a run that an interruption left unscored."""
    figures, run = scored_rows.score_the_rest(out, reading.how(), cluster, workers)
    if json:
        terminal.say_json(figures.to_dict())
        return
    recommended = str(run.body["recommended"])
    unit = str(run.body["units"]["effort"])
    _print_every_row(figures, recommended, unit)
    terminal.say(*terminal.kept_lines(out))


def _print_every_row(figures: EveryRow, recommended: str, unit: str) -> None:
    """The figures of models on every row, and why others have none."""
    terminal.console().print(scored_rows.table(figures, recommended, unit))
    for name, why in figures.not_scored.items():
        terminal.tell(f"not scored on every row: {name}: {why}")


def _print_all(
    rows: RowsOfLogs,
    comparison: Comparison,
    seconds: float,
    *,
    whole: bool,
    final: bool,
) -> None:
    """What was read, what came out, and how long it took; whether the final model is there that was asked for."""
    made = rows.data.notes[: -1 if rows.left_out else None]
    lines = terminal.recording_lines(rows.logs, made=made)
    terminal.tell(*(line for line in lines if not line.startswith(" ")))
    if rows.left_out:
        terminal.tell(rows.data.notes[-1])
    print_comparison(comparison, [line for line in lines if line.startswith(" ")], whole=whole)
    if comparison.final is not None:
        terminal.tell(
            f"Also fitted to all {comparison.final.train_rows:,} rows: --model final. The figures above are of the "
            "model that was judged; no row is left to judge this one."
        )
    count = len(comparison.entries)
    models = f"{count} models" if count > 1 else "1 model"
    terminal.tell(f"{models} in {seconds:.1f} s")
    if final and comparison.final is None:
        terminal.tell("No model is recommended, so none is fitted to all rows, as --final asks.")


def _read(
    logs: Sequence[Path],
    how: Reading,
    device: DeviceName | None,
    memory: float,
) -> RowsOfLogs:
    """Read all logs, or of those beyond the memory (in bytes) whole stretches, behind a bar on a terminal."""
    from erclutch.logs.any_size import read_rows

    with terminal.progress("reading the log") as bar:

        def show(what: str, done: int, total: int) -> None:
            bar(done, total, what)

        return read_rows(expand(logs), how, device, memory=memory, progress=show)


def _compared(data: Dataset, settings: Settings, *, final: bool) -> Comparison:
    """Fit all models, behind a bar on a terminal; the recommended model to all rows too, where that is asked for."""
    from erclutch.fit.comparison import compare
    from erclutch.fit.final_fit import with_final_fit

    with terminal.progress("looking at the rows, before the first fit") as bar:

        def show(step: FitStep) -> None:
            bar(step.done, 1.0, step.doing, fitted=step.fitted, train_share=step.train_share)

        comparison = compare(data, settings, show)
    if final and not comparison.standing.why_none:
        return with_final_fit(comparison)
    return comparison


def require_counts(workers: int, seed: int, blocks: int = 0) -> None:
    """Refuse no workers, a seed below zero, and one block or more than 50.

    Raises:
        SettingError: one of them cannot be.
    """
    require(1, workers=workers)
    require(0, seed=seed)
    require(2 if blocks else 0, 50, blocks=blocks)


def model_names(words: Sequence[str]) -> tuple[str, ...]:
    """Names of models as they are given: apart, or with commas between them."""
    names: list[str] = []
    for word in words:
        names += word.replace(",", " ").split()
    return tuple(names)


def print_comparison(
    comparison: Comparison,
    reading: Sequence[str],
    *,
    whole: bool = False,
) -> None:
    """The verdict, findings, ranking, why, how the log was read, and the recommended model's parameters.

    Args:
        comparison: what came out.
        reading: how the log was read, a line a decision.
        whole: every model with its notes, or the first ones and the notes of the recommended one.
    """
    from erclutch.cli import ranking_table

    screen = terminal.console()
    chosen = comparison.entry(comparison.recommended)
    held = int(comparison.test.sum())
    headline = ranking_table.headline(comparison)
    terminal.tell(headline, style="bold")
    terminal.tell(
        f"fitted on {comparison.data.rows - held:,} rows, scored on {held:,} rows held out"
    )
    which_rows = ranking_table.held_out(comparison)
    if which_rows:
        terminal.tell(which_rows)
    terminal.tell(
        *(f"{finding.level}: {finding}" for finding in comparison.findings), style="yellow"
    )
    screen.print()
    screen.print(ranking_table.ranking(comparison, screen.width, whole=whole))
    not_shown = ranking_table.left_out(comparison)
    if not_shown and not whole:
        terminal.tell(not_shown)
    terminal.tell(*ranking_table.notes(comparison, whole=whole), style="dim")
    screen.print()
    why = ranking_table.verdict(comparison)
    if why != headline:
        terminal.tell(why)
    over_motion = ranking_table.at_rest(comparison)
    if over_motion:
        terminal.tell(over_motion)
    terminal.tell(*ranking_table.prediction(chosen, comparison.data.units.effort))
    specification = chosen.outcome.model.name
    inputs = chosen.outcome.chosen_inputs
    also = f", with the input {' and '.join(inputs)}" if inputs else ""
    terminal.tell(f"Its specification: {specification}{also}")
    screen.print()
    if reading:
        terminal.tell("How the log was read:", *reading)
        screen.print()
    terminal.tell(*ranking_table.parameters(comparison))
