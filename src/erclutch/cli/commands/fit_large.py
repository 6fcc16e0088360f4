"""``erclutch fit-large`` fits models to logs larger than memory."""

from __future__ import annotations

from collections.abc import Callable
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.commands.fit import MODELS, ModelNames, model_names, require_counts
from erclutch.cli.options import DEFAULT_READING, LogOptions, expand
from erclutch.errors import require

if TYPE_CHECKING:
    from erclutch.runs.large_fit import LargeFit

COMMAND = {
    "help": "Fit models to logs larger than memory, block by block.",
    "panel": "More logs",
    "place": 4,
}


def fit_large(
    logs: Annotated[tuple[str, ...], Parameter(name="LOG", negative=())],
    *,
    models: ModelNames = ("all",),
    test_log: Annotated[tuple[str, ...], Parameter(group=MODELS, negative=())] = (),
    friction: Annotated[bool | None, Parameter(group=MODELS)] = None,
    offset: Annotated[bool | None, Parameter(group=MODELS)] = None,
    seed: Annotated[int, Parameter(group=MODELS)] = 0,
    workers: Annotated[int, Parameter(group=MODELS)] = 2,
    batch: Annotated[int, Parameter(group=MODELS)] = 65_536,
    cluster: Annotated[str | None, Parameter(group=MODELS)] = None,
    scratch: Annotated[Path | None, Parameter(group=MODELS)] = None,
    out: Annotated[Path | None, Parameter(group=MODELS)] = None,
    force: Annotated[bool, Parameter(group=MODELS, negative=())] = False,
    json: Annotated[bool, Parameter(group=MODELS, negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Fit models to logs larger than memory, here or on a cluster; all figures are of all rows.

    Parquet is read in batches, other formats one file at a time. Rows go to temporary files of 32 to 48 bytes a row.

    Args:
        logs: Logs of one device; a folder stands for the logs in it. With fsspec also addresses (s3://B/a.parquet).
        models: Laws and networks, for example --models rbfm-10 hem/square fnn-16; 'all' (default) and 'paper' stand for
            those of their sets that can be. Laws may have stages (hem/square+lag), networks not; no past, no stimulus.
        test_log: Log to score the models on; more than once for several.
        friction: A friction effort at zero field. Default: yes for single, no for coaxial (the paper's form).
        offset: A constant effort. Default: as for friction.
        seed: Seed of the networks' starts.
        workers: Tasks side by side; changes no figure.
        cluster: Where tasks run: threads (default), processes, local (Dask here), or tcp://HOST:PORT of Dask.
        batch: Rows that are read at a time.
        scratch: Folder for the temporary files, which all workers must see. Default: the system's.
        out: Folder to keep the models in.
        force: Replace such a folder that is already there.
        json: Print everything as JSON instead of a table.
        reading: How to read the log.
    """
    from dataclasses import replace
    from functools import partial

    from erclutch.files import may_write
    from erclutch.runs.large_fit import MARKER, write_large
    from erclutch.runs.large_fit import fit_large as fit_them

    require_counts(workers, seed)
    require(10_000, batch=batch)
    if out is not None:
        may_write(out, force, MARKER)
    how = replace(reading.how(), rows=batch)
    fit_so = partial(fit_them, friction=friction, offset=offset, seed=seed, workers=workers, cluster=cluster)
    paths, tests, names = _places(logs), _places(test_log), model_names(models)
    with terminal.progress("reading") as bar:
        show = partial(_shown, bar)
        result = fit_so(
            paths, names, reading=how, device=reading.device or "single", test=tests, scratch=scratch, progress=show
        )
    if out is not None:
        write_large(out, result, force=force)
    _print(result, json, out)


def _shown(bar: Callable[[int, int | None, str], None], what: str, rows: int) -> None:
    bar(0, None, f"{what}: {rows:,} rows")


def _print(result: LargeFit, json: bool, out: Path | None) -> None:
    from erclutch.runs.tasks import peak_memory

    memory = peak_memory()
    if json:
        seconds = {entry.name: entry.seconds for entry in result.entries}
        costs = {"cpu_seconds": {"read": result.read_seconds, **seconds}, "peak_memory_bytes": memory}
        costs["worker_memory_bytes"] = result.worker_memory
        print(dumps({**result.to_dict(), **costs}, indent=1, allow_nan=False))
        return
    made = sorted({source.origin for source in result.sources if source.origin})
    label = f"{' and '.join(made)}: " if made else ""
    for source in result.sources:
        lost = source.read - source.kept
        left = f", {lost:,} of them left out" if lost else ""
        terminal.say(f"{source.name}: {source.read:,} rows{left}")
    terminal.tell(*(f"{finding.level}: {finding}" for finding in result.findings), style="yellow")
    terminal.tell(*(f"left out: {reason}" for reason in result.left_out), style="dim")
    unit = f"({result.units.effort})^2" if result.units.effort not in ("", "?") else ""
    heads = ["model", "par.", terminal.with_unit("train MSE", unit)]
    heads += [terminal.with_unit("test MSE", unit)] if result.test_rows else []
    rows = [
        [e.name, str(e.outcome.parameters), terminal.number(e.train_mse)]
        + ([terminal.number(e.test_mse)] if e.test_mse is not None else [])
        + [f"{e.seconds:.1f}"]
        for e in result.entries
    ]
    tested = f", tested on {result.test_rows:,}" if result.test_rows else ""
    title = f"{label}models fitted to {result.rows:,} rows{tested}; errors are of all rows"
    terminal.tell(terminal.table(title, [*heads, "CPU s"], rows, left=1))
    peak = f", peak memory {memory / 1e6:.0f} MB" if memory else ""
    terminal.tell(f"reading took {result.read_seconds:.1f} CPU s{peak}")
    terminal.say(f"Models kept in {out / 'models'}" if out else "Nothing was kept; --out FOLDER keeps the models.")


def _places(logs: tuple[str, ...]) -> list[str | Path]:
    """Paths of logs, folders opened; addresses as they are."""
    return [place for log in logs for place in ([log] if "://" in log else expand((Path(log),)))]
