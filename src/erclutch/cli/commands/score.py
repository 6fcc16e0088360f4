"""``erclutch score`` says how good the models of a run are on another log."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import LogError

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset
    from erclutch.runs.new_rows import ModelScore
    from erclutch.runs.run_folder import Run
    from erclutch.signals.recording import Recording

COMMAND = {
    "help": "Score the models of a run on another log.",
    "panel": "The road of a log",
    "place": 7,
}


def score(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    *,
    run: Annotated[tuple[Path, ...], Parameter(consume_multiple=True, negative=())],
    model: str | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Score the kept models of runs on logs that were not there when they were fitted, best first.

    The table gives the RMSE with its 95 % band, its share of the standard deviation, the share of rows in which the
    model guesses, and what its prediction band holds: of all rows, and of the worst second (of several logs: the worst
    log). Lines below say where the models guess.

    Args:
        logs: One log or several of the run's device; a folder stands for the logs in it.
        run: The folder of a run, or a model's JSON file; one or several.
        model: Score this model of each run alone, by its id (m2) or specification; "final": that of all rows.
        json: Print as JSON instead of a table.
        reading: How to read the logs; by default as each run's own logs were read.
    """
    from erclutch.logs.dataset import require_units
    from erclutch.runs.new_rows import models_of, opened, score_model

    found: list[tuple[Path, str, ModelScore]] = []
    recordings: list[Recording] = []
    read: list[Dataset] = []
    seen: list[str] = []
    for place in run:
        kept, chosen = opened(place, model)
        how = reading.like(kept, chosen)
        recordings = how.read(logs)
        _require_measured(recordings)
        seen += [] if kept is None else _trained_on(kept, recordings)
        data = how.dataset(recordings)
        read.append(data)
        require_units(data, read[0], str(place))
        models = models_of(kept, chosen, model)
        found += [(place, _title(kept, called), score_model(each, data, called)) for called, each in models]
    found.sort(key=lambda each: each[2].figures.rmse.value)
    data = read[0]
    if json:
        body = {"log": data.where, "rows": data.rows, "unit": data.units.effort, "warnings": seen}
        terminal.say_json(
            {**body, "models": [{"title": title, **each.row(str(place))} for place, title, each in found]}
        )
        return
    terminal.tell("\n".join(terminal.recording_lines(recordings)))
    columns = ["model", *(["run"] if len(run) > 1 else []), terminal.with_unit("RMSE", data.units.effort)]
    columns += ["95 % band", "of std", "guessed", "inside", "worst second" if len(data.sources) == 1 else "worst log"]
    rows = [_row(each, title, place if len(run) > 1 else None) for place, title, each in found]
    shown = str(run[0]) if len(run) == 1 else f"{len(run)} runs"
    title = f"Models of {shown} on {data.rows:,} rows of {data.where}"
    cells = dict(zip(columns, zip(*rows, strict=True), strict=True))
    less_needed = ("95 % band", columns[-1], "of std", "guessed")
    terminal.tell(terminal.narrowed(title, cells, less_needed, terminal.console().width))
    terminal.tell(*seen, style="yellow")
    for where in dict.fromkeys(each.where for _, _, each in found if each.where):
        alike = [title.partition(",")[0] for _, title, each in found if each.where == where]
        more = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
        terminal.tell(f"guessed by {alike[0]}{more}: {where}")


def _title(run: Run | None, name: str) -> str:
    """A model's id in its run, and what it is called in plain words."""
    from erclutch.models.model_titles import title_of

    return title_of(name) if run is None else f"{run.id_of(name)}, {run.titles[name]}"


def _require_measured(recordings: Sequence[Recording]) -> None:
    """LogError for a log that `predict` wrote: its effort is a model's."""
    from erclutch.logs.log_writer import PREDICTED

    for each in recordings:
        if each.origin == PREDICTED:
            raise LogError("its effort is predicted, not measured", where=each.name, remedy="Give the measured log")


def _trained_on(run: Run, recordings: Sequence[Recording]) -> list[str]:
    """A warning for each log that the run was fitted to, known by its digest."""
    known = {str(log["sha256"]) for log in run.body["logs"] if not _held_out(str(log["name"]), run)}
    share = run.body["train_rows"] / (run.body["train_rows"] + run.body["test_rows"])
    seen = [log.name for log in recordings if log.digest in known]
    if not seen:
        return []
    more = f" and {len(seen) - 1} more are among them" if len(seen) > 1 else " is one of them"
    return [
        f"{run.folder.name} was trained on {share:.0%} of the rows of its logs, and {seen[0]}{more}: these figures are "
        "no test of its models. Score logs that the fit has not seen, or read the report."
    ]


def _held_out(log: str, run: Run) -> bool:
    """Whether a fit kept a whole log apart, by the patterns of names that it was given."""
    test = run.body["settings"]["test"]
    return isinstance(test, list) and any(fnmatchcase(log, str(pattern)) for pattern in cast(list[Any], test))


def _row(found: ModelScore, title: str, run: Path | None) -> list[str]:
    """A model's row of the table."""
    rmse, number = found.figures.rmse, terminal.number
    cells = [title, *([] if run is None else [str(run)])]
    cells += [number(rmse.value, zeros=True), f"{number(rmse.low, 3)} - {number(rmse.high, 3)}"]
    cells += [f"{found.figures.share.value:.1%}", f"{found.guessed:.1%}"]
    return (
        [*cells, "no band", ""]
        if found.held is None
        else [*cells, f"{found.held.share:.1%}", f"{found.held.worst:.1%}"]
    )
