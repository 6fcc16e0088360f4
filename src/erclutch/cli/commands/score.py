"""``erclutch score`` says how good the models of a run are on another log."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import asdict
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, cast

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import LogError, shell_word
from erclutch.signals.percent import percent

if TYPE_CHECKING:
    from rich.table import Table

    from erclutch.fit.choice.scoring import BandedFigure
    from erclutch.logs.dataset import Dataset
    from erclutch.runs.new_rows import ModelScore
    from erclutch.runs.run_folder import Run
    from erclutch.signals.recording import Recording

COMMAND = {
    "help": "Score the models of a run on another log.",
    "panel": "The road of a log",
    "place": 7,
}

#: Times its error at home that a model errs on another log, bands apart, before a remedy is told.
_WORSE = 1.5
#: Share of an error that one factor leaves, at most, where the factor is told: of a sign or of a unit.
_EXPLAINED = 0.3
#: Share of the rows from which on a model guesses: where its fields or speeds were never logged, no factor tells more.
_MOSTLY_GUESSED = 0.5
#: Factors that a device may have changed by; larger and smaller ones are of a unit or a sensor.
_OF_AN_AGED_DEVICE = (0.5, 2.0)


def score(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    /,
    *,
    run: Annotated[tuple[Path, ...], Parameter(consume_multiple=True, negative=())],
    model: str | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Score the kept models of runs on logs that were not there when they were fitted, best first.

    The table gives the RMSE with its 95 % band, its share of the standard deviation, the share of rows in which the
    model guesses, and what its prediction band holds: of all rows, and of the worst second (a longer stretch where a
    second has few rows; of several logs the worst log). Lines below say where the models guess.

    Args:
        logs: One log or several of the run's device; a folder stands for the logs in it.
        run: The folder of a run, or a model's JSON file; one or several.
        model: Which model of each run, by its id (m2) or specification; final: of all rows. Default: all.
        json: Print as JSON instead of a table.
        reading: How to read the logs; by default as each run's own logs were read.
    """
    from erclutch.fit.choice.scoring import BandedFigure
    from erclutch.logs.dataset import require_units
    from erclutch.logs.log_writer import PREDICTED
    from erclutch.models.model_titles import title_of
    from erclutch.runs.new_rows import models_of, opened, score_model, unlike_training
    from erclutch.runs.run_shape import FINAL

    scores: list[_Scored] = []
    recordings: list[Recording] = []
    data_of_runs: list[Dataset] = []
    warnings: list[str] = []
    all_new = True  # whether no run was fitted to one of the logs
    for folder in run:
        # Each run reads the logs in its own way; units must be the same, or the errors could not be compared.
        kept, chosen = opened(folder, model)
        how = reading.like(kept, chosen)
        recordings = how.read(logs)
        for recording in recordings:
            if recording.origin == PREDICTED:
                problem = "its effort is predicted, not measured"
                raise LogError(problem, where=recording.name, remedy="Give the measured log")
        if kept is not None:
            trained_on = _trained_on(kept, recordings)
            warnings += trained_on
            all_new = all_new and not trained_on
        data = how.dataset(recordings)
        data_of_runs.append(data)
        require_units(data, data_of_runs[0], str(folder))
        warnings += unlike_training(kept, chosen, data)
        for name, each in models_of(kept, chosen, model):
            # A model's id in its run, and what it is called in plain words.
            if kept is None:
                title = title_of(name)
            elif name in kept.names:
                title = f"{kept.id_of(name)}, {kept.titles[name]}"
            else:
                title = f"{FINAL}, {kept.titles[kept.recommended]}, of all rows"
            recommended_at: BandedFigure | None = None
            if kept is not None and kept.recommends(name):
                recommended_at = BandedFigure(*kept.entry(name)["test"]["rmse"])
            scores.append(_Scored(folder, title, score_model(each, data, name), recommended_at))
    scores.sort(key=lambda each: each.score.figures.rmse.value)
    data = data_of_runs[0]

    if json:
        models: list[dict[str, Any]] = []
        for each in scores:
            of_logs = [asdict(log) for log in each.score.by_log]
            models.append({"title": each.title, **each.score.row(str(each.run)), "logs": of_logs})
        body = {
            "log": data.where,
            "rows": data.rows,
            "unit": data.units.effort,
            "warnings": warnings,
        }
        terminal.say_json({**body, "models": models})
        return
    terminal.tell("\n".join(terminal.recording_lines(recordings, made=data.notes)))
    terminal.tell(_table(scores, data, runs=len(run)))
    as_typed = shlex.join([*map(str, logs), *reading.words()])
    words = _words_on(scores, data, as_typed=as_typed, all_new=all_new)
    terminal.tell(*words, style="dim")
    for each in scores:
        if each.score.by_log and (each.recommended_at is not None or len(scores) == 1):
            terminal.tell(_table_by_log(each, data))
            terminal.tell(
                "gain: measured over estimated effort; 1 where the device is as it was", style="dim"
            )
    terminal.tell(*warnings, style="yellow")
    for where in dict.fromkeys(each.score.where for each in scores if each.score.where):
        alike = [each.title.partition(",")[0] for each in scores if each.score.where == where]
        more = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
        terminal.tell(f"guessed by {alike[0]}{more}: {where}")


class _Scored(NamedTuple):
    """A model with its figures, the folder of its run, and its title there.

    Attributes:
        run: the folder.
        title: its id and name there.
        score: the figures.
        recommended_at: RMSE on the rows held out there, with its band, of a recommended model; None of others.
    """

    run: Path
    title: str
    score: ModelScore
    recommended_at: BandedFigure | None


def _table_by_log(each: _Scored, data: Dataset) -> Table:
    """How good a model is on each log: a device that changes shows from log to log."""
    rows = [
        [
            log.log,
            terminal.number(log.rmse, zeros=True),
            f"{log.gain:.3f}",
            "no band" if log.inside is None else percent(log.inside, 1),
        ]
        for log in each.score.by_log
    ]
    headings = ["log", terminal.with_unit("RMSE", data.units.effort), "gain", "inside"]
    return terminal.table(f"{each.title}, by log", headings, rows)


def _table(scores: Sequence[_Scored], data: Dataset, runs: int) -> Table:
    """The figures of all models; what is needed less goes where the screen is narrow."""
    number = terminal.number
    rmse = terminal.with_unit("RMSE", data.units.effort)
    worst = _heading_of_worst(data)
    marks = ["  " if each.recommended_at is None else "* " for each in scores]
    titles = [f"{mark}{each.title}" for mark, each in zip(marks, scores, strict=True)]
    columns: dict[str, list[str]] = {"model": titles}
    if runs > 1:
        columns["run"] = [str(each.run) for each in scores]
    for heading in filter(None, (rmse, "95 % band", "of std", "guessed", "inside", worst)):
        columns[heading] = []
    for each in scores:
        score = each.score
        error = score.figures.rmse
        columns[rmse].append(number(error.value, zeros=True))
        columns["95 % band"].append(f"{number(error.low, 3)} - {number(error.high, 3)}")
        columns["of std"].append(percent(score.figures.share.value, 1))
        columns["guessed"].append(percent(score.guessed, 1))
        columns["inside"].append("no band" if score.held is None else percent(score.held.share, 1))
        if worst:
            columns[worst].append("" if score.held is None else percent(score.held.worst, 1))

    whose = str(scores[0].run) if runs == 1 else f"{runs} runs"
    title = f"Models of {whose} on {data.rows:,} rows of {data.where}"
    if "* " in marks:
        title += " (* recommended)"
    less_needed = [name for name in ("95 % band", worst, "of std", "guessed") if name]
    return terminal.narrowed(title, columns, less_needed, terminal.console().width)


def _heading_of_worst(data: Dataset) -> str:
    """The heading of what a band holds of its worst piece; "": points of a table have none."""
    from erclutch.fit.bands.band_pieces import kind_of_pieces

    kind = kind_of_pieces(data)
    return f"worst {kind}" if kind else ""


def _words_on(
    scores: Sequence[_Scored], data: Dataset, *, as_typed: str, all_new: bool
) -> list[str]:
    """The recommended model of each run, here and where it was judged, and what the shares are of.

    Args:
        scores: of all models.
        data: the rows scored.
        as_typed: the logs and how they are read, for a further command.
        all_new: whether no run was fitted to one of the logs.
    """
    from erclutch.signals.units import amount

    unit = data.units.effort
    lines: list[str] = []
    for each in scores:
        if each.recommended_at is not None:
            here = amount(terminal.number(each.score.figures.rmse.value, zeros=True), unit)
            there = amount(terminal.number(each.recommended_at.value), unit)
            lines.append(
                f"{each.title}, is recommended by {each.run.name}: it errs by {here} here, "
                f"by {there} on the rows that its fit held out."
            )
            error = each.score.figures.rmse
            at_home = each.recommended_at
            is_far_more = error.low > at_home.high and error.value > _WORSE * at_home.value
            adapt = f"erclutch recalibrate {shell_word(str(each.run))} {as_typed} --out NEW"
            if is_far_more and each.score.guessed >= _MOSTLY_GUESSED:
                lines.append(
                    "Most of these rows are unlike those that it was fitted to, as the lines below say: fit both logs "
                    "together"
                )
            elif is_far_more and each.score.left_by_gain < _EXPLAINED:
                lines.append(_of_one_factor(each.score.gain, adapt))
            elif all_new and is_far_more:
                lines.append(
                    "That is far more than on those rows. Lines below say where it guesses; if the device itself has "
                    f"changed, adapt the model: {adapt}"
                )
    meanings = [
        "guessed: rows unlike those that the model was fitted to",
        "inside: rows in its band, which is made for 95 % of them",
    ]
    if worst := _heading_of_worst(data):
        piece = worst.removeprefix("worst ")
        meanings.append(f"{worst}: the same of the {piece} that the band fits least")
    lines.append("; ".join(meanings) + ".")
    return lines


def _of_one_factor(gain: float, adapt: str) -> str:
    """What to do where measured and estimated effort differ by a factor: of a sign, of a unit, or of an aged device."""
    factor = terminal.number(gain, 3)
    line = f"The effort measured here is {factor} times the estimated: this factor alone makes most of the error."
    if gain < 0.0:
        turns = "--scale effort=-1 or --scale slip=-1"
        return f"{line} If a signal has another sign here than in the run's logs, turn it: {turns}"
    least, most = _OF_AN_AGED_DEVICE
    if least <= gain <= most:
        return f"{line} If it is a unit, say the right one; if the device itself has changed, adapt the model: {adapt}"
    return (
        f"{line} No device changes so much: check the unit of the effort and what its sensor means"
    )


def _trained_on(run: Run, recordings: Sequence[Recording]) -> list[str]:
    """A warning where logs are some that the run was fitted to, known by their digests."""
    # A fit that was given patterns of names kept whole logs apart: these are new to it.
    test: Any = run.body["settings"]["test"]
    patterns: list[str] = []
    if isinstance(test, list):
        patterns = [str(pattern) for pattern in cast(list[Any], test)]
    known: set[str] = set()
    for log in run.body["logs"]:
        if not any(fnmatchcase(str(log["name"]), pattern) for pattern in patterns):
            known.add(str(log["sha256"]))
    seen = [recording.name for recording in recordings if recording.digest in known]
    if not seen:
        return []
    share = run.body["train_rows"] / (run.body["train_rows"] + run.body["test_rows"])
    more = f" and {len(seen) - 1} more are among them" if len(seen) > 1 else " is one of them"
    return [
        f"{run.folder.name} was trained on {percent(share)} of the rows of its logs, and {seen[0]}{more}: these "
        "figures are no test of its models. Score logs that the fit has not seen, or read the report."
    ]
