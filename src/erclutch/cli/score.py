"""``erclutch score`` says how good the models of a run are on another log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions, opened

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset
    from erclutch.models.model import Model


def score(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    *,
    model: Path,
    name: str | None = None,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Score the kept models of a run on logs that were not there when they were fitted, best first.

    The table gives the RMSE with its 95 % band, its share of the standard deviation, the share of rows in which the
    model guesses, and what its prediction band holds: of all rows, and of the worst second (of several logs: the worst
    log).

    Args:
        logs: One log or several of the run's device; a folder stands for the logs in it.
        model: The folder of a run, or a model's JSON file.
        name: Score this model of the run alone.
        reading: How to read the logs; by default as the run's own logs were read.
    """
    run, chosen = opened(model, name)
    how = reading.like(run, chosen)
    data = how.dataset(how.read(logs))
    kept = [chosen] if run is None or name is not None else [run.model(each) for each in run.names]
    rows = sorted((_row(each, data) for each in kept), key=lambda row: row[0])
    columns = ["model", terminal.with_unit("RMSE", data.units.effort), "95 % band", "of std", "guessed"]
    columns += ["inside", "worst second" if len(data.sources) == 1 else "worst log"]
    title = f"Models of {model} on {data.rows:,} rows of {data.where}"
    cells = dict(zip(columns, zip(*(row for _, row in rows), strict=True), strict=True))
    less_needed = ("95 % band", columns[-1], "of std", "guessed")
    terminal.tell(terminal.narrowed(title, cells, less_needed, terminal.console().width))


def _row(model: Model, data: Dataset) -> tuple[float, list[str]]:
    """RMSE of a model, and its row of the table."""
    import numpy as np

    from erclutch.fit.prediction_bands import coverage
    from erclutch.fit.scoring import score as scored

    effort = model.predict(data)
    figures = scored(data.effort, effort)
    rmse, number = figures.rmse, terminal.number
    cells = [model.name, number(rmse.value, zeros=True), f"{number(rmse.low, 3)} - {number(rmse.high, 3)}"]
    cells += [f"{figures.share.value:.1%}", f"{model.outside(data).mean():.1%}"]
    if model.band is None:
        return rmse.value, [*cells, "no band", ""]
    held = coverage(data, model.band.around(effort, data.elements, data.clock), np.ones(data.rows, np.bool_))
    return rmse.value, [*cells, f"{held.share:.1%}", f"{held.worst:.1%}"]
