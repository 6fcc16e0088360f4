"""``erclutch fit-many`` fits the same models to each of many logs."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from erclutch.cli import terminal
from erclutch.cli.commands.fit import MODELS, ModelNames, model_names, require_counts
from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.cli.quantities import SHARE
from erclutch.errors import CheckError, ErclutchError, LogError, require
from erclutch.signals.origins import MEASURED

if TYPE_CHECKING:
    from erclutch.signals.recording import Recording
    from erclutch.wings.fleet.fitted_fleet import Fleet

COMMAND = {
    "help": "Fit the same models to each of many logs or devices; one table, one report, outliers and trends.",
    "panel": "More logs",
    "place": 3,
}

#: Beyond, logs are not compared: all of them would stand in memory at once.
_MOST_LOGS, _MOST_ROWS = 200, 1_000_000
_WHERE = Group("Where it runs", sort_key=2)


def fit_many(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    /,
    *,
    out: Annotated[Path, Parameter(group=MODELS)],
    models: ModelNames = ("all",),
    lag: Annotated[str, Parameter(name=("--lag", "--stages"), group=MODELS)] = "auto",
    test: Annotated[float, SHARE, Parameter(group=MODELS)] = 0.3,
    friction: Annotated[bool | None, Parameter(group=MODELS)] = None,
    offset: Annotated[bool | None, Parameter(group=MODELS)] = None,
    seed: Annotated[int, Parameter(group=MODELS)] = 0,
    by: Annotated[str, Parameter(group=MODELS)] = "log",
    over: Annotated[str, Parameter(group=MODELS)] = "name",
    baseline: Annotated[int, Parameter(group=MODELS)] = 0,
    force: Annotated[bool, Parameter(group=MODELS, negative=())] = False,
    json: Annotated[bool, Parameter(group=MODELS, negative=())] = False,
    cluster: Annotated[str | None, Parameter(group=_WHERE)] = None,
    workers: Annotated[int, Parameter(group=_WHERE)] = 2,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Fit the same models to each of many logs or devices: one table of parameters, what stands out, what drifts.

    A log that fails is a row with its reason. The same command again takes what is done and fits the rest.

    Args:
        logs: Logs; a folder stands for the logs in it and in the folders below.
        out: Folder for parameters.parquet, fits.parquet, report.html and the finished fit of each device.
        models: Models as for `erclutch fit`.
        lag: Stages as for `erclutch fit`.
        test: Share of each log that is held out, at its end.
        friction: Fit a friction effort at zero field. Default: as for `erclutch fit`.
        offset: Fit a constant effort. Default: as for friction.
        seed: Seed of the bootstrap that gives the bands, and of the networks' starts.
        by: What is one device: 'log'; 'folder', all logs of a folder together; 'joint', each joint of a robot in all
            logs; or a field of --name-pattern.
        over: Order for trends and charts: 'name', 'mtime' (time of the file), or a field of --name-pattern.
        baseline: How many of the first devices give the limits of the control charts; 0 for all.
        force: Begin anew where the folder holds a fleet of other settings.
        json: Print as JSON instead of a table.
        cluster: 'threads' (the default), 'processes', 'local' (Dask here), or tcp://HOST:PORT of a Dask scheduler.
        workers: How many threads or processes; changes no figure.
        reading: How to read the logs.
    """
    from erclutch.fit.comparison import Settings
    from erclutch.wings.fleet.fleet import REPORT
    from erclutch.wings.fleet.fleet import fit_many as fit_fleet

    require_counts(workers, seed)
    require(5 if baseline else 0, baseline=baseline)
    settings = Settings(model_names(models), lag, test, 0, friction, offset, seed)
    with terminal.progress("fitting") as bar:

        def show(done: int, total: int, name: str) -> None:
            bar(done, total, f"fitted {name}")

        fleet = fit_fleet(
            logs,
            settings.models,
            out=out,
            device=reading.device or "single",
            reading=reading.how(),
            settings=settings,
            by=by,
            over=over,
            baseline=baseline,
            cluster=cluster,
            workers=workers,
            force=force,
            progress=show,
        )
    advice = advice_of_logs(logs, reading)
    if json:
        terminal.say_json(_as_json(fleet) | {"advice": advice})
    else:
        _print(fleet)
        terminal.tell(*advice)
        terminal.say(f"Kept in {out}; read {out / REPORT}")
    if fleet.model is None and not fleet.failed:
        terminal.say(
            "Of no log or device a model is recommended: erclutch fit says why, log by log."
        )
    elif fleet.model is None:
        first, why = next(iter(fleet.failed.items()))
        problem = f"none of {fleet.devices} could be fitted; the first: {why.rstrip('.')}"
        raise CheckError(problem, where=first, remedy="Try erclutch inspect on this log")


def advice_of_logs(logs: tuple[Path, ...], reading: LogOptions) -> list[str]:
    """Which logs teach nothing new, and what no log has; nothing where the logs are not of one kind."""
    from erclutch.cli.log_advice import advice_on
    from erclutch.cli.options import expand

    recordings: list[Recording] = []
    paths: list[Path] = []
    # A folder of folders holds no log itself, and its devices are told apart.
    with suppress(LogError):
        paths = expand(logs)
    for path in paths if len(paths) <= _MOST_LOGS else ():
        with suppress(ErclutchError):  # the table has the reason
            recordings += reading.read([path])
        if sum(recording.time.size for recording in recordings) > _MOST_ROWS:
            return []
    rows = None
    with suppress(ErclutchError):  # such as logs in different units
        rows = reading.dataset(recordings) if len(recordings) > 1 else None
    return [] if rows is None else advice_on(rows)


def _as_json(fleet: Fleet) -> dict[str, Any]:
    from erclutch.wings.fleet.fleet_page import beyond

    parameters = [
        {
            "parameter": s.parameter,
            "unit": s.unit,
            "median": median(s.value.tolist()),
            "stands_out": list(s.outliers),
            "outside_control_limits": list(beyond(s)),
            "trend": None if s.trend is None else [s.trend.slope, s.trend.low, s.trend.high],
            "chance": None if s.trend is None else s.trend.chance,
        }
        for s in fleet.stands_for
    ]
    return {
        "devices": fleet.devices,
        "failed": dict(fleet.failed),
        "model": fleet.model,
        "digest": fleet.digest,
        "folder": str(fleet.folder),
        "parameters": parameters,
    }


def _print(fleet: Fleet) -> None:
    from erclutch.wings.fleet.fleet_charts import named
    from erclutch.wings.fleet.fleet_page import beyond, mixed, not_compared, too_few, trend_of

    if artificial := sorted({*fleet.origins} - MEASURED):
        terminal.tell(f"{' and '.join(artificial)} data: made by a computer, not a measurement")
    done = f", {fleet.taken} of them by an earlier start" if fleet.taken else ""
    terminal.tell(f"{fleet.devices} logs or devices{done}; {len(fleet.failed)} failed")
    for device, reason in list(fleet.failed.items())[:5]:
        terminal.tell(f"failed: {device}: {reason}", style="yellow")
    for device, message in list(fleet.warned.items())[:5]:
        terminal.tell(f"warning: {device}: {message}", style="yellow")
    if fleet.model is not None:
        rows = [
            [
                terminal.with_unit(s.parameter, s.unit),
                named(s.outliers),
                named(beyond(s)),
                terminal.number(median(s.value.tolist())),
                trend_of(s),
            ]
            for s in fleet.stands_for
        ]
        heads = [
            "parameter",
            "stands out",
            "outside control limits",
            "median",
            "trend (95 % interval), p",
        ]
        terminal.tell(terminal.table(f"{fleet.model}, recommended most often", heads, rows, left=3))
        series = fleet.stands_for
        for note in (too_few(series), not_compared(series), mixed(series, fleet.over)):
            if note:
                terminal.tell(note)
    terminal.say(f"table digest {fleet.digest}")
