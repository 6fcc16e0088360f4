"""`erclutch fit` scores every row of logs of which it fitted stretches, and goes on where that was interrupted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.cli import terminal
from erclutch.errors import SettingError
from erclutch.signals.percent import percent

if TYPE_CHECKING:
    from rich.table import Table

    from erclutch.fit.comparison import Comparison
    from erclutch.logs.any_size import RowsOfLogs
    from erclutch.logs.reading import Reading
    from erclutch.models.model import Model
    from erclutch.runs.every_row import EveryRow
    from erclutch.runs.run_folder import Run
    from erclutch.runs.scoring_plan import ScoringPlan
    from erclutch.runs.tasks import Tasks


def score_left_out(
    rows: RowsOfLogs,
    comparison: Comparison,
    how: Reading,
    tasks: Tasks,
    folder: Path | None,
) -> EveryRow | None:
    """Score the models of a comparison of stretches on every row; with the folder of the run, in which all is kept.

    Returns:
        The figures; None where the comparison has every row already.

    Raises:
        LogError, MappingError: a log changed meanwhile.
        RunError: the folder cannot be written.
    """
    from erclutch.runs.run_folder import read_run
    from erclutch.runs.scoring_plan import plan_of

    if not rows.left_out:
        return None
    run = "" if folder is None else str(read_run(folder).body["digest"])
    models = {entry.name: entry.outcome.model for entry in comparison.entries}
    return _scored(plan_of(rows, comparison, run), models, how, tasks, folder)


def score_the_rest(
    folder: Path | None,
    how: Reading,
    cluster: str | None,
    workers: int,
) -> tuple[EveryRow, Run]:
    """Go on with the scoring of a run that was interrupted; the figures, and the run.

    Raises:
        SettingError: no folder. RunError: no such run, or nothing is left to score. LogError: a log cannot be read.
    """
    from erclutch.runs.every_row_folder import unfinished_plan
    from erclutch.runs.run_folder import read_run
    from erclutch.runs.tasks import tasks_on

    if folder is None:
        raise SettingError(
            "--resume without a run", remedy="Give --out RUN, the run that was interrupted"
        )
    run = read_run(folder)
    plan = unfinished_plan(run)
    models = {name: run.model(name) for name in run.names}
    with tasks_on(cluster, workers) as tasks:
        return _scored(plan, models, how, tasks, folder), run


def _scored(
    plan: ScoringPlan,
    models: Mapping[str, Model],
    how: Reading,
    tasks: Tasks,
    folder: Path | None,
) -> EveryRow:
    from erclutch.runs.every_row import score_every_row
    from erclutch.runs.every_row_folder import KeptParts, write_every_row

    kept = None if folder is None else KeptParts(folder, plan)
    try:
        with terminal.progress("scoring") as bar:

            def show(done: int, total: int) -> None:
                bar(done, total, "scoring every row")

            figures = score_every_row(plan, models, how, tasks, kept=kept, progress=show)
            if folder is not None:
                write_every_row(folder, figures)
    except BaseException:  # whatever ends the scoring, the run is there and the scoring can go on
        if folder is not None:
            terminal.say(
                f"The run is kept in {folder}; the same command with --resume scores the rest."
            )
        raise
    return figures


def table(figures: EveryRow, recommended: str, unit: str) -> Table:
    """The figures of every row, best first."""
    scores = figures.test or figures.train
    ranked = sorted(scores, key=lambda name: scores[name].rmse.value)
    lines: list[list[str]] = []
    for name in ranked:
        score = scores[name]
        rmse = score.rmse
        trained = figures.train.get(name)
        lines.append(
            [
                "*" if name == recommended else "",
                name,
                terminal.number(rmse.value, zeros=True),
                f"{terminal.number(rmse.low, 3)} - {terminal.number(rmse.high, 3)}",
                percent(score.share.value, 1),
                terminal.number(score.largest.value, 3),
                "" if trained is None else terminal.number(trained.rmse.value, zeros=True),
            ]
        )
    held_out = 0
    if figures.test:
        held_out = next(iter(figures.test.values())).rows
    title = f"Every row: {figures.plan.rows:,}, of which {held_out:,} are held out (* recommended)"
    headings = [
        "",
        "model",
        terminal.with_unit("test RMSE", unit),
        "95 % band",
        "of std",
        "max error",
        "train RMSE",
    ]
    return terminal.table(title, headings, lines, left=2)
