"""``erclutch recalibrate`` adapts a kept model to a new log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.cli.quantities import SHARE

COMMAND = {
    "help": "Adapt a kept model to a new log of the same or a sister device, from few rows.",
    "panel": "The road of a log",
    "place": 8,
}


def recalibrate(
    run: Annotated[Path, Parameter(name="RUN")],
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    /,
    *,
    model: str | None = None,
    share: Annotated[float, SHARE] = 0.7,
    stretches: int = 1,
    out: Path | None = None,
    force: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Adapt a kept model to a new log of the same or a sister device; blocks that it has not seen decide what moves.

    Args:
        run: Folder that erclutch fit --out wrote; its options say how to read the log, unless given anew.
        logs: New log, or several; a folder stands for the logs in it.
        model: Which model of the run, by its id (m2) or specification; final: of all rows. Default: the recommended.
        share: Share of each log's rows that the adaptation sees; the rest judges.
        stretches: Stretches into which the share is divided, spread over each log; 1 takes the first rows.
        out: Folder to keep the result in; it is a run as of erclutch fit.
        force: Replace a run that is already there.
        json: Print everything as JSON instead of tables.
        reading: How to read the log.
    """
    from erclutch.cli import ranking_table, terminal
    from erclutch.runs.recalibrated_run import recalibrated
    from erclutch.runs.run_folder import read_run
    from erclutch.runs.written_run import may_write, run_to_dict, write_run

    if out is not None:
        may_write(out, force)
    base = read_run(run)
    reading = reading.like(base, base.model(model))
    recordings = reading.read(logs)
    data = reading.dataset(recordings)
    adapted = recalibrated(base, data, model=model, share=share, stretches=stretches)
    if not json:
        terminal.tell("\n".join(terminal.recording_lines(recordings, made=data.notes)))
        about = adapted.recalibration or {}
        judged = int(adapted.test.sum())
        terminal.tell(f"adapted on {adapted.data.rows - judged:,} rows, judged on {judged:,}")
        # Errors of the blocks, by the way of adapting.
        rmse_of_blocks: dict[str, list[float]] = about["unseen_blocks_rmse"]
        rows: list[list[str]] = []
        for way, errors in rmse_of_blocks.items():
            overall = sum(rmse**2 for rmse in errors) ** 0.5 / len(errors) ** 0.5
            rows.append([way, terminal.number(overall, zeros=True)])
        blocks = len(rmse_of_blocks[about["way"]])
        title = f"What moves, on {blocks} unseen blocks of these rows"
        unit = terminal.with_unit("RMSE", adapted.data.units.effort)
        terminal.tell(terminal.table(title, ["", unit], rows, left=1))
        terminal.tell(ranking_table.ranking(adapted, terminal.console().width))
        terminal.tell(about["verdict"], style="bold")
        terminal.tell(*ranking_table.parameters(adapted))
    if out is not None:
        write_run(out, adapted, recordings, reading=reading.to_dict(), force=force)
    if json:
        body = run_to_dict(adapted, recordings, reading.to_dict())
        terminal.say_json(body)
        return
    terminal.say(*terminal.kept_lines(out))
