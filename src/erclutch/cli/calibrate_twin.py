"""``erclutch calibrate-twin``: the twin's parameters from a log, or from the paper's summary figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import SettingError

if TYPE_CHECKING:
    from erclutch.calibrate import Calibration, Target


def calibrate_twin(
    log: Annotated[Path | None, Parameter(name="LOG")] = None,
    *,
    out: Path = Path("rig.toml"),
    parameters: Annotated[tuple[str, ...], Parameter(consume_multiple=True, negative=(), show_default=False)] = (),
    rig: Path | None = None,
    seed: int = 1,
    seconds: float = 60.0,
    evaluations: int = 480,
    workers: int = 2,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Calibrate chosen parameters of the digital TWIN within their ranges, with 95 % intervals, and write the rig.

    To a LOG of your own pair (E1, E2, theta, alpha, T and the commanded motor torque), sample by sample; without one,
    to the summary figures that the paper prints. The search keeps a journal beside the rig file and resumes from it.

    Args:
        log: A log of the pair.
        out: Rig file to write.
        parameters: Which, as section.name. Default: what the paper leaves open (those marked assumed are kept).
        rig: A rig file (TOML) to start from.
        seed: Of the search and, without a log, of the twin's runs.
        seconds: Rig time of the training run in each evaluation, without a log.
        evaluations: Rigs tried by the wide search (CMA-ES).
        workers: Rigs simulated side by side; changes no figure.
        reading: How to read the log.
    """
    from dataclasses import replace

    from erclutch.cli import show
    from erclutch.rig.parameters import default_rig, load_rig
    from erclutch.rig.rig_file import write_rig

    if not (5.0 <= seconds <= 3600.0 and evaluations >= 16 and seed >= 0 and workers >= 1):
        raise SettingError(
            f"--seconds {seconds:g} --evaluations {evaluations} --seed {seed} --workers {workers}",
            remedy="Give 5 to 3600 s, 16 evaluations or more, a seed of 0 or more and a worker",
        )
    start = default_rig() if rig is None else load_rig(rig)
    target = _target(log, seed, seconds, replace(reading, device="coaxial"))
    names = parameters or _open(start, log is not None)
    found = _with_progress(
        evaluations,
        start,
        names,
        target,
        seed=seed,
        evaluations=evaluations,
        workers=workers,
        journal=out.with_suffix(".journal"),
    )
    about = _about(found, target, seed, log is None)
    write_rig(out, found.rig, about)
    out.with_suffix(".journal").unlink(missing_ok=True)
    _print(found, show.console())
    show.console().print(f"{out}: use it with --rig {out}", markup=False, soft_wrap=True)


def _with_progress(total: int, *given: Any, **settings: Any) -> Calibration:
    """`calibrate` with a progress bar on a terminal's standard error."""
    from rich.console import Console
    from rich.progress import Progress

    from erclutch.calibrate import calibrate

    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("TWIN: calibrating", total=total)

        def told(done: int, cost: float) -> None:
            bar.update(task, completed=done, description=f"TWIN: calibrating, {done} rigs tried, best {cost:.4g}")

        return calibrate(*given, **settings, progress=told)


def _target(log: Path | None, seed: int, seconds: float, reading: LogOptions) -> Target:
    if log is None:
        from erclutch.calibrate.summary import PaperSummary

        return PaperSummary(seed, seconds)
    from erclutch.calibrate.trace import Trace

    return Trace(reading.read([log])[0])


def _open(rig: Any, with_log: bool) -> tuple[str, ...]:
    """What the paper leaves open and a run can tell: all that a calibration has made before."""
    return tuple(
        f"{section}.{key}"
        for section, names in rig.entries.items()
        for key, entry in names.items()
        if entry.source in ("calibrated", "prototype") and not (with_log and section in ("excitation", "thermal"))
    )


def _about(found: Calibration, target: Target, seed: int, paper: bool) -> dict[str, Any]:
    from datetime import UTC, datetime

    from erclutch._version import __version__

    about: dict[str, Any] = {
        "target": found.target,
        "date": datetime.now(UTC).date().isoformat(),
        "erclutch": __version__,
        "cost_before": round(found.before, 3),
        "cost_after": round(found.after, 3),
        "evaluations": found.evaluations,
    }
    if paper:
        from erclutch.calibrate.summary import PaperSummary, summarise

        assert isinstance(target, PaperSummary)
        pairs = summarise(found.rig, target.seed, target.seconds, target.thin).against_paper()
        about["seed"] = seed
        about["figures"] = {k: [float(f"{a:.4g}"), float(f"{b:.4g}")] for k, (a, b, _) in pairs.items()}
    return about


def _print(found: Calibration, screen: Any) -> None:
    from erclutch.cli import show

    rows = [
        [
            c.path,
            show.number(c.start),
            show.number(c.value) + (f" (at its {c.at_bound} limit)" if c.at_bound else ""),
            f"{show.number(c.low, 3)} - {show.number(c.high, 3)}",
            found.rig.entry(c.path).unit,
            f"{c.learnt:.0%}",
        ]
        for c in found.parameters
    ]
    title = f"TWIN calibrated to {found.target}"
    screen.print(show.table(title, ["parameter", "start", "value", "95 % interval", "unit", "learnt"], rows, left=1))
    screen.print(
        f"sum of squares {found.before:.4g} -> {found.after:.4g} in {found.evaluations} rigs; learnt: how much "
        "narrower the interval is than what its range alone says",
        markup=False,
    )
