"""``erclutch fit-large`` fits models to logs larger than memory."""

from __future__ import annotations

from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from erclutch.cli import terminal
from erclutch.cli.fit import model_names, require_counts
from erclutch.cli.options import DEFAULT_READING, LogOptions, expand
from erclutch.errors import SettingError

if TYPE_CHECKING:
    from erclutch.logs import ColumnMap
    from erclutch.runs.large_fit import LargeFit

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
    from functools import partial

    from erclutch.runs.large_fit import MARKER, Reading, write_large
    from erclutch.runs.large_fit import fit_large as fit_them
    from erclutch.runs.run_folder import may_write

    require_counts(workers, seed, "--batch", batch, "10000 or more", batch >= 10_000)
    if out is not None:
        may_write(out, force, MARKER)
    how = Reading(_mapped(reading), reading.map, None, reading.variable, reading.filter(), batch)
    fit_so = partial(fit_them, friction=friction, offset=offset, seed=seed, workers=workers, scratch=scratch)
    paths, tests, names = expand(logs), expand(test_log), model_names(models)
    with terminal.progress("reading") as bar:

        def show(what: str, rows: int) -> None:
            bar(0, None, f"{what}: {rows:,} rows")

        result = fit_so(paths, names, reading=how, device=reading.device, test=tests, progress=show)
    if out is not None:
        write_large(out, result, force=force)
    _print(result, json, out)


def _print(result: LargeFit, json: bool, out: Path | None) -> None:
    from erclutch.runs.large_fit import peak_memory

    memory = peak_memory()
    if json:
        seconds = {entry.name: entry.seconds for entry in result.entries}
        costs = {"cpu_seconds": {"read": result.read_seconds, **seconds}, "peak_memory_bytes": memory}
        print(dumps({**result.to_dict(), **costs}, indent=1, allow_nan=False))
        return
    made = sorted({source.origin for source in result.sources if source.origin})
    label = f"{' and '.join(made)}: " if made else ""
    for source in result.sources:
        lost = source.read - source.kept
        left = f", {lost:,} of them left out" if lost else ""
        terminal.say(f"{source.name}: {source.read:,} rows{left}")
    for finding in result.findings:
        terminal.tell(f"{finding.level}: {finding}", "yellow")
    for reason in result.left_out:
        terminal.tell(f"left out: {reason}", "dim")
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


def _mapped(reading: LogOptions) -> ColumnMap:
    """Which column is which; the filter of --resample needs whole stretches, and rows come here block by block."""
    if reading.resample is not None:
        raise SettingError("--resample needs whole stretches in memory", remedy="Use erclutch fit, or resample before")
    if reading.begin or reading.end or reading.skip:
        raise SettingError(
            "--from, --to and --skip need the whole log in memory", remedy="Use erclutch fit, or cut before"
        )
    return reading.column_map()
