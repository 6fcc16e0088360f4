"""``erclutch calibrate-twin`` finds the twin's parameters from a log, or from the paper's summary figures."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.cli.quantities import SECONDS
from erclutch.errors import require
from erclutch.files import may_write_file, spare_logs
from erclutch.signals.percent import percent
from erclutch.wings.rig.twin.parameters import RigParameters, load_rig

if TYPE_CHECKING:
    from erclutch.wings.paper.calibration.calibrate import Calibration, CalibrationTarget

COMMAND = {
    "help": "Calibrate the digital TWIN to a log, or to the paper's summary figures.",
    "panel": "The digital TWIN and the paper",
    "place": 5,
}

#: Assumed before, and not printed by the paper: they take part in a calibration to its figures.
ALSO_OPEN = (
    "fluid.thinning_rate",
    "clutch.seal_slip",
    "clutch.gap",
    "clutch.faces",
    "screw.breakaway",
    "screw.presliding",
    "drive.torque_time",
)


def calibrate_twin(
    log: Annotated[Path | None, Parameter(name="LOG")] = None,
    /,
    *,
    out: Path = Path("rig.toml"),
    vary: Annotated[
        tuple[str, ...], Parameter(consume_multiple=True, negative=(), show_default=False)
    ] = (),
    rig_file: Path | None = None,
    go_on: Annotated[bool, Parameter(negative=())] = False,
    seed: int = 1,
    runs: int = 2,
    held: float = 1.0,
    seconds: Annotated[float, SECONDS] = 20.0,
    evaluations: int = 480,
    rounds: int = 6,
    workers: int = 2,
    force: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
    reading: LogOptions = DEFAULT_READING,
) -> None:
    """Calibrate chosen parameters of the digital TWIN within their ranges, with 95 % intervals, and write the rig.

    With a LOG of your own pair (E1, E2, theta, alpha, T and the commanded motor torque) the twin follows it sample by
    sample. Without a LOG the paper's summary figures are the target. The search resumes from a journal beside OUT.

    Args:
        log: A log of the pair. Default: none; the paper's summary figures stand for it.
        out: Rig file to write.
        vary: Parameters to vary, as section.name. Default: the paper's open ones, without those marked assumed.
        rig_file: A rig file (TOML) to start from.
        go_on: Start from the rig's values, and not from where its last calibration started.
        seed: Seed of the search and, without a log, of the twin's first training run; the others follow.
        runs: How many training runs each evaluation takes, without a log; figures are means over them.
        held: Weight of the laws' ratios with the output held, without a log; 0 leaves them out.
        seconds: Rig time of each training run, without a log.
        evaluations: How many rigs the wide search tries (CMA-ES).
        rounds: How many rounds the local search takes after it, without a log; each tries a rig a parameter.
        workers: How many rigs are simulated side by side; changes no figure.
        force: Replace a rig file that is there.
        json: Print as JSON what was found.
        reading: How to read the log.
    """
    from dataclasses import replace

    from erclutch.wings.paper.calibration.calibrate import calibrate
    from erclutch.wings.paper.calibration.log_trace import LogTrace
    from erclutch.wings.paper.calibration.paper_summary import PaperSummary
    from erclutch.wings.rig.twin.parameters_file import write_rig

    require(5, 3600, " s", seconds=seconds)
    require(0, seed=seed, evaluations=evaluations, rounds=rounds)
    require(1, workers=workers, runs=runs)
    require(0.0, held=held)
    spare_logs([] if log is None else [log], [out])
    may_write_file(out, force)
    start = load_rig(rig_file)
    if go_on:
        start = start.begun_here()
    target: CalibrationTarget
    if log is None:
        seeds = tuple(range(seed, seed + runs))
        target = PaperSummary(seeds, seconds, held)
    else:
        recordings = replace(reading, device="coaxial").read([log])
        target = LogTrace(recordings[0])
    names = vary or open_parameters(start, log is not None)
    journal = out.with_suffix(".journal")
    of_rounds = rounds * (len(names) + 4)  # rigs: a slope a parameter, and four steps
    total = evaluations + of_rounds
    if not json:
        terminal.tell(
            f"TWIN: {evaluations} rigs are simulated, then some {of_rounds} more. "
            f"After Ctrl-C the same command goes on from {journal}."
        )
    with terminal.progress("TWIN: calibrating") as bar:

        def told(done: int, cost: float) -> None:
            bar(min(done, total), total, f"TWIN: calibrating, {done} rigs tried, best {cost:.4g}")

        calibration = calibrate(
            start,
            names,
            target,
            seed=seed,
            evaluations=evaluations,
            rounds=rounds,
            workers=workers,
            journal=journal,
            progress=told,
        )
    write_rig(out, calibration.rig, _about(calibration, target))
    journal.unlink(missing_ok=True)
    if json:
        terminal.say_json(_as_json(calibration, out))
        return
    _print(calibration)
    terminal.say(f"{out}: use it with --rig-file {out}")


def _as_json(calibration: Calibration, rig_file: Path) -> dict[str, Any]:
    """What was found, as JSON values."""
    parameters: list[dict[str, Any]] = []
    for parameter in calibration.parameters:
        unit = calibration.rig.entry(parameter.path).unit
        parameters.append({**asdict(parameter), "unit": unit})
    return {
        "target": calibration.target,
        "before": calibration.before,
        "after": calibration.after,
        "evaluations": calibration.evaluations,
        "parameters": parameters,
        "rig_file": str(rig_file),
    }


def open_parameters(rig: RigParameters, with_log: bool) -> tuple[str, ...]:
    """What the paper leaves open and a run can tell: all that a calibration has made before.

    Without a log also how commands are drawn, and ALSO_OPEN.
    """
    # A log holds its own commands, and its heat is too slow to show.
    of_log = ("excitation.", "thermal.")
    paths: list[str] = []
    for section, entries in rig.entries.items():
        for key, entry in entries.items():
            path = f"{section}.{key}"
            made_before = entry.source in ("calibrated", "prototype")
            if with_log:
                is_open = made_before and not path.startswith(of_log)
            else:
                drawn = path.startswith("excitation.") and entry.source == "assumed"
                is_open = made_before or path in ALSO_OPEN or drawn
            if is_open:
                paths.append(path)
    return tuple(paths)


def _about(calibration: Calibration, target: CalibrationTarget) -> dict[str, Any]:
    from datetime import UTC, datetime

    from erclutch._version import __version__
    from erclutch.wings.paper.calibration.paper_summary import PaperSummary, summarise

    about: dict[str, Any] = {
        "target": calibration.target,
        "date": datetime.now(UTC).date().isoformat(),
        "erclutch": __version__,
        "cost_before": round(calibration.before, 3),
        "cost_after": round(calibration.after, 3),
        "evaluations": calibration.evaluations,
    }
    if isinstance(target, PaperSummary):
        summary = summarise(calibration.rig, target.seeds, target.seconds, target.thin)
        pairs = summary.against_paper()
        figures: dict[str, list[float]] = {}
        for name, (ours, papers, _) in pairs.items():
            figures[name] = [float(f"{ours:.4g}"), float(f"{papers:.4g}")]
        about["seeds"] = list(target.seeds)
        about["figures"] = figures
    return about


def _print(calibration: Calibration) -> None:
    number = terminal.number
    rows: list[list[str]] = []
    for parameter in calibration.parameters:
        limit = f" (at its {parameter.at_bound} limit)" if parameter.at_bound else ""
        row = [
            parameter.path,
            number(parameter.start),
            number(parameter.value) + limit,
            f"{number(parameter.low, 3)} - {number(parameter.high, 3)}",
            calibration.rig.entry(parameter.path).unit,
            percent(parameter.learnt),
        ]
        rows.append(row)
    heads = ["parameter", "start", "value", "95 % interval", "unit", "learnt"]
    terminal.tell(terminal.table(f"TWIN calibrated to {calibration.target}", heads, rows, left=1))
    terminal.tell(
        f"sum of squares {calibration.before:.4g} -> {calibration.after:.4g} in {calibration.evaluations} rigs; "
        "learnt: how much narrower the interval is than what its range alone says"
    )
