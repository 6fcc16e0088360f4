"""``erclutch fit-large``: logs larger than memory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions, expand
from erclutch.errors import SettingError

if TYPE_CHECKING:
    from erclutch.large import LargeFit, Reading

_MODELS = Group("Models and figures", sort_key=1)


def fit_large(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    *,
    models: Annotated[
        tuple[str, ...], Parameter(group=_MODELS, consume_multiple=True, negative=(), show_default=False)
    ] = ("all",),
    test_log: Annotated[tuple[Path, ...], Parameter(group=_MODELS, negative=())] = (),
    friction: Annotated[bool | None, Parameter(group=_MODELS)] = None,
    offset: Annotated[bool | None, Parameter(group=_MODELS)] = None,
    seed: Annotated[int, Parameter(group=_MODELS)] = 0,
    workers: Annotated[int, Parameter(group=_MODELS)] = 2,
    batch: Annotated[int, Parameter(group=_MODELS)] = 65_536,
    scratch: Annotated[Path | None, Parameter(group=_MODELS)] = None,
    out: Annotated[Path | None, Parameter(group=_MODELS)] = None,
    force: Annotated[bool, Parameter(group=_MODELS, negative=())] = False,
    json: Annotated[bool, Parameter(group=_MODELS, negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Fit models without memory to logs larger than memory; all figures are of all rows.

    Parquet is read in batches, other formats one file at a time. Rows go to a temporary file of 24 to 40 bytes a row.

    Args:
        logs: One log or several of the same device; a folder stands for the logs in it.
        models: Laws and networks, for example --models rbfm-10 hem/square fnn-16; 'all' (default) and 'paper' stand for
            those of their sets that can be fitted this way. No dynamics, no past samples, no laws with a stimulus.
        test_log: Log to score the models on; more than once for several.
        friction: A friction effort at zero field. Default: yes for single, no for coaxial (the paper's form).
        offset: A constant effort. Default: as for friction.
        seed: Seed of the networks' starts.
        workers: Starts of a network side by side; changes no figure.
        batch: Rows that are read at a time.
        scratch: Folder for the temporary file. Default: the system's.
        out: Folder to keep the models in.
        force: Replace such a folder that is already there.
        json: Print everything as JSON instead of a table.
        reading: How to read the log.
    """
    from erclutch.large import MARKER, write_large
    from erclutch.runs import may_write

    _require(workers, seed, batch)
    if out is not None:
        may_write(out, force, MARKER)
    names = tuple(name for word in models for name in word.replace(",", " ").split())
    result = _with_progress(
        expand(logs),
        names,
        how=_how(reading, batch),
        device=reading.device,
        test=expand(test_log),
        friction=friction,
        offset=offset,
        seed=seed,
        workers=workers,
        scratch=scratch,
    )
    if out is not None:
        write_large(out, result, force=force)
    _print(result, json, out)


def _require(workers: int, seed: int, batch: int) -> None:
    if workers < 1 or seed < 0 or batch < 10_000:
        raise SettingError(
            f"--workers {workers} --seed {seed} --batch {batch}",
            remedy="Give --workers 1 or more, --seed 0 or more, --batch 10000 or more",
        )


def _how(reading: LogOptions, batch: int) -> Reading:
    from erclutch.large import Reading

    return Reading(
        reading.column_map(), reading.map, derivative=reading.filter(), variable=reading.variable, rows=batch
    )


def _with_progress(paths: list[Path], names: tuple[str, ...], *, how: Reading, **asked: object) -> LargeFit:
    """Fit, with what is being done on a terminal's standard error."""
    from typing import Any, cast

    from rich.console import Console

    from erclutch.large import fit_large as fit

    screen = Console(stderr=True)
    if not screen.is_terminal:
        return fit(paths, names, reading=how, **cast("dict[str, Any]", asked))
    with screen.status("reading") as status:

        def show(what: str, rows: int) -> None:
            status.update(f"{what}: {rows:,} rows")

        return fit(paths, names, reading=how, progress=show, **cast("dict[str, Any]", asked))


def _print(result: LargeFit, json: bool, out: Path | None) -> None:
    from erclutch.cli import show
    from erclutch.large import peak_memory

    memory = peak_memory()
    if json:
        from json import dumps

        seconds = {entry.name: entry.seconds for entry in result.entries}
        costs = {"cpu_seconds": {"read": result.read_seconds, **seconds}, "peak_memory_bytes": memory}
        print(dumps({**result.to_dict(), **costs}, indent=1, allow_nan=False))
        return
    screen = show.console()
    made = sorted({source.origin for source in result.sources if source.origin})
    label = f"{' and '.join(made)}: " if made else ""
    for source in result.sources:
        lost = source.read - source.kept
        left = f", {lost:,} of them left out" if lost else ""
        screen.print(f"{source.name}: {source.read:,} rows{left}", markup=False, soft_wrap=True)
    for finding in result.findings:
        screen.print(f"{finding.level}: {finding}", style="yellow", markup=False)
    for reason in result.left_out:
        screen.print(f"left out: {reason}", style="dim", markup=False)
    unit = f"({result.units.effort})^2" if result.units.effort not in ("", "?") else ""
    heads = ["model", "par.", show.with_unit("train MSE", unit)]
    heads += [show.with_unit("test MSE", unit)] if result.test_rows else []
    rows = [
        [e.name, str(e.outcome.parameters), show.number(e.train_mse)]
        + ([show.number(e.test_mse)] if e.test_mse is not None else [])
        + [f"{e.seconds:.1f}"]
        for e in result.entries
    ]
    tested = f", tested on {result.test_rows:,}" if result.test_rows else ""
    title = f"{label}models fitted to {result.rows:,} rows{tested}; errors are of all rows"
    screen.print(show.table(title, [*heads, "CPU s"], rows, left=1))
    peak = f", peak memory {memory / 1e6:.0f} MB" if memory else ""
    screen.print(f"reading took {result.read_seconds:.1f} CPU s{peak}", markup=False)
    kept = f"Models kept in {out / 'models'}" if out else "Nothing was kept; --out FOLDER keeps the models."
    screen.print(kept, markup=False, soft_wrap=True)
