"""``erclutch fit``: the main job."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Group, Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import SettingError

if TYPE_CHECKING:
    from erclutch.comparison import Comparison, Settings
    from erclutch.dataset import Dataset
    from erclutch.signals import Recording

_MODELS = Group("Models and figures", sort_key=1)


def fit(
    logs: Annotated[tuple[Path, ...], Parameter(name="LOG", negative=())],
    *,
    models: Annotated[
        tuple[str, ...], Parameter(group=_MODELS, consume_multiple=True, negative=(), show_default=False)
    ] = ("all",),
    lag: Annotated[Literal["auto", "none", "lag", "rise-fall"], Parameter(group=_MODELS)] = "auto",
    test: Annotated[tuple[str, ...], Parameter(group=_MODELS, negative=(), show_default=False)] = ("0.3",),
    blocks: Annotated[int, Parameter(group=_MODELS)] = 0,
    friction: Annotated[bool | None, Parameter(group=_MODELS)] = None,
    offset: Annotated[bool | None, Parameter(group=_MODELS)] = None,
    seed: Annotated[int, Parameter(group=_MODELS)] = 0,
    past: Annotated[tuple[int, ...], Parameter(group=_MODELS, consume_multiple=True, negative=())] = (),
    polish: Annotated[bool, Parameter(group=_MODELS, negative=())] = False,
    workers: Annotated[int, Parameter(group=_MODELS)] = 2,
    out: Annotated[Path | None, Parameter(group=_MODELS)] = None,
    force: Annotated[bool, Parameter(group=_MODELS, negative=())] = False,
    json: Annotated[bool, Parameter(group=_MODELS, negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Fit all models to a log, score them on rows held out, rank them, and recommend one.

    Args:
        logs: One log or several of the same device; a folder stands for the logs in it.
        models: Names from `erclutch laws` and networks, for example --models bingham hem/square fnn-16 rbfn-50; 'paper'
            stands for those of its tables, 'all' (default) for all laws, fnn-16 and rbfn-10.
        lag: 'none', 'lag' (delay, one time constant), 'rise-fall' (two), or 'auto': without, with, and two if need be.
        test: Held out: a share (the end of each log, or of each stretch where each has one field of its own), or
            a pattern of logs' names, more than once. Default: 0.3.
        blocks: Also cross-validate over this many blocks in time of the training rows.
        friction: A friction effort at zero field. Default: yes for single, no for coaxial (the paper's form).
        offset: A constant effort. Default: as for friction.
        seed: Seed of the bootstrap that gives the bands, and of the networks' starts.
        past: Rows back that networks take as inputs too, for example --past 1 2 4.
        polish: Train networks on all rows at last, not only on centroids.
        workers: Models fitted side by side; changes no figure.
        out: Folder to keep the run in.
        force: Replace a run that is already there.
        json: Print everything as JSON instead of tables.
        reading: How to read the log.
    """
    from dataclasses import replace

    from erclutch.runs import may_write, write_run

    began = time.perf_counter()
    if out is not None:
        may_write(out, force)
    settings = replace(_settings(models, lag, test, blocks, friction, offset, seed, workers), past=past, polish=polish)
    recordings = reading.read(logs)
    data = reading.dataset(recordings)
    comparison = compare_with_progress(data, settings)
    if json:
        _print_json(comparison, recordings, reading)
    else:
        _print_all(recordings, comparison, time.perf_counter() - began)
    if out is not None:
        write_run(out, comparison, recordings, reading=reading.to_dict(), force=force)
    if not json:
        _print_kept(out)


def _print_json(comparison: Comparison, recordings: Sequence[Recording], reading: LogOptions) -> None:
    from json import dumps

    from erclutch.runs import run_to_dict

    print(dumps(run_to_dict(comparison, recordings, reading.to_dict()), indent=1, allow_nan=False))


def _print_kept(out: Path | None) -> None:
    from erclutch.cli import show

    kept = f"Kept in {out}" if out else "Nothing was kept; --out RUN keeps it."
    show.console().print(kept, markup=False, soft_wrap=True)


def _print_all(recordings: Sequence[Recording], comparison: Comparison, seconds: float) -> None:
    from erclutch.cli import show

    screen = show.console()
    screen.print("\n".join(show.recording_lines(recordings)), markup=False)
    print_comparison(comparison)
    count = len(comparison.entries)
    screen.print(f"{count} model{'s' if count > 1 else ''} in {seconds:.1f} s", markup=False)


def _settings(
    models: tuple[str, ...],
    lag: Literal["auto", "none", "lag", "rise-fall"],
    test: tuple[str, ...],
    blocks: int,
    friction: bool | None,
    offset: bool | None,
    seed: int,
    workers: int,
) -> Settings:
    from erclutch.comparison import Settings

    names = tuple(name for word in models for name in word.replace(",", " ").split())
    if workers < 1 or seed < 0 or not (blocks == 0 or 2 <= blocks <= 50):
        raise SettingError(
            f"--workers {workers} --seed {seed} --blocks {blocks}",
            remedy="Give --workers 1 or more, --seed 0 or more, --blocks 0 or 2 to 50",
        )
    return Settings(names, lag, _held_out(test), blocks, friction, offset, seed, workers)


def _held_out(test: tuple[str, ...]) -> float | tuple[str, ...]:
    if len(test) == 1:
        try:
            return float(test[0].removesuffix("%")) / (100.0 if test[0].endswith("%") else 1.0)
        except ValueError:
            return test
    return test


def compare_with_progress(data: Dataset, settings: Settings) -> Comparison:
    """Compare, with a progress bar on a terminal's standard error."""
    from rich.console import Console
    from rich.progress import Progress

    from erclutch.comparison import compare

    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("fitting", total=None)

        def show(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=f"fitted {what}")

        return compare(data, settings, show)


def print_comparison(comparison: Comparison) -> None:
    """Findings, ranking, recommendation and the recommended model's parameters."""
    from erclutch.cli import ranked, show

    screen = show.console()
    held = int(comparison.test.sum())
    screen.print(f"fitted on {comparison.data.rows - held:,} rows, scored on {held:,} rows held out", markup=False)
    if which := ranked.held_out(comparison):
        screen.print(which, markup=False)
    for finding in comparison.findings:
        screen.print(f"{finding.level}: {finding}", style="yellow", markup=False)
    screen.print()
    screen.print(ranked.ranking(comparison, screen.width))
    for line in ranked.model_notes(comparison.entries):
        screen.print(line, style="dim", markup=False)
    screen.print()
    screen.print(ranked.verdict(comparison), style="bold", markup=False)
    if moving := ranked.at_rest(comparison):
        screen.print(moving, markup=False)
    screen.print()
    screen.print(ranked.parameters(comparison.entry(comparison.recommended).outcome))
