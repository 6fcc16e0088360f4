"""``erclutch experiment`` repeats the paper's online experiments with the live loop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import SECONDS
from erclutch.errors import SettingError
from erclutch.files.places import nothing, reserve
from erclutch.wings.paper.published import WARMING
from erclutch.wings.rig.twin.parameters import load_rig

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from erclutch.wings.paper.hand_experiments import HandName
    from erclutch.wings.paper.online import ErrorLine, OnlineTrace
    from erclutch.wings.paper.torque_control import ControlRun

COMMAND = {
    "help": "Run the paper's online experiments with the live loop: figures 7 to 13.",
    "panel": "The digital TWIN and the paper",
    "place": 4,
}

#: Models beside the online one where the paper compares them (figures 11 and 12, table III).
_RIVALS = ("rbfn-50", "rbfm-10/forward", "hem/forward", "seo-seo/forward", "bingham/forward")


def experiment(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    /,
    *,
    run: Path | None = None,
    out: Path = Path("experiments"),
    seconds: Annotated[float | None, SECONDS] = None,
    seed: int = 0,
    seeds: int = 20,
    real_time: Annotated[bool, Parameter(negative=())] = False,
    rig_file: Path | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Run an experiment with the live loop on the TWIN: of sections IV-B to V, or torque control. Without NAME: list.

    Args:
        name: Which experiment; "all" runs those of the paper one after another; "control", "impedance" and "wall"
            judge torque control, the pair as a spring and a damper, and the wall of a brake.
        run: A run, for its recommended model, or a model's JSON file; default: fnn-16, fitted to the twin once. It must
            be memoryless or have a lag.
        out: Folder for the figures and their numbers.
        seconds: Length in place of the experiment's own.
        seed: Seed of the commands and the noise.
        seeds: Of control, impedance and wall: how many, from 0 on. What is finished in --out is not run again.
        real_time: Run the loop and the twin each in its process, at 1 kHz, instead of as fast as they go. The
            experiment encoders cannot: a rig's packets carry one encoder's angle.
        rig_file: A rig file (TOML) for the twin.
        json: Print the list as JSON; an experiment keeps its numbers in --out.
    """
    from erclutch.wings.paper.online import EXPERIMENTS, experiment_of

    if name is None:
        rows = [[e.name, e.meaning, f"{e.seconds:g} s"] for e in EXPERIMENTS.values()]
        rows.append(["control", "torque control: models, observers, a device that changes", "80 s a case"])
        rows.append(["impedance", "stiffness and damping that a hand feels at the output", "70 s a case"])
        rows.append(["wall", "a brake as a wall: step, drag, stiffness, letting go", "32 s a case"])
        if json:
            terminal.say_json([dict(zip(("name", "what", "length"), row, strict=True)) for row in rows])
            return
        terminal.tell(terminal.table("Experiments with the live loop", ["name", "what", "length"], rows, left=2))
        return
    if json:
        remedy = "Leave --json out, or leave NAME out for the list"
        raise SettingError(f"experiment {name} writes its numbers as CSV into --out", remedy=remedy)
    if name in ("control", "impedance", "wall"):
        if run is not None or seconds is not None or seed or real_time:
            problem = f"experiment {name} takes no --run, --seconds, --seed or --real-time"
            raise SettingError(problem, remedy="Give --seeds, --out and --rig-file alone")
        _over_seeds(name, seeds, rig_file, out)
        return
    names = list(EXPERIMENTS) if name == "all" else [experiment_of(name).name]
    if real_time and name == "all":
        left_out = [n for n in names if EXPERIMENTS[n].encoders]
        names = [n for n in names if n not in left_out]
        terminal.tell(f"left out, for it does not run in real time: {', '.join(left_out)}")
    run_online(names, run, rig_file, out, {"seconds": seconds, "seed": seed, "real_time": real_time})


def _over_seeds(name: Literal["control"] | HandName, seeds: int, rig_file: Path | None, out: Path) -> None:
    from erclutch.report.plots.matplotlib_painter import save_plot
    from erclutch.wings.paper.control_figure import describe_control
    from erclutch.wings.paper.hand_experiments import describe_impedance, describe_wall, hand_points, hand_runs
    from erclutch.wings.paper.torque_control import control_runs, kept_runs

    rig = load_rig(rig_file)
    out.mkdir(parents=True, exist_ok=True)
    reserve(out / name, nothing)  # its figure, its numbers and what it resumes from
    with terminal.progress(name) as bar:
        if name == "control":
            runs = control_runs(seeds, rig, kept_runs(out, rig), bar)
        else:
            runs = hand_runs(name, seeds, rig, hand_points(out, rig, name), bar)
    terminal.tell(_control_table(runs, seeds) if name == "control" else _hand_table(name, runs, seeds))
    describe = {"control": describe_control, "impedance": describe_impedance, "wall": describe_wall}[name]
    terminal.say(*save_plot(describe(runs), out / f"{name}.png"))


def _control_table(runs: list[ControlRun], seeds: int) -> Table:
    """Means over the seeds, and the worst seed of what the models do not know."""
    from erclutch.wings.paper.torque_control import INVERSES, KNOWS, WITHHELD

    first = (next(iter(INVERSES)), next(iter(KNOWS)))
    plain = [float(run.figures["chirp"]) for run in runs if (run.model, run.knows) == first]

    def row(model: str, knows: str) -> list[str]:
        own = [run.figures for run in runs if (run.model, run.knows) == (model, knows)]

        def mean(name: str) -> float:
            return sum(float(figures[name]) for figures in own) / len(own)

        shares = [f"{100.0 * mean(name):.2f}" for name in ("chirp", "steps", "random")]
        reach = [f"{mean(name):.0f}" for name in ("bandwidth", "within 10 %")]
        still = f"{sum(bool(figures['locked']) for figures in own)}/{len(own)}"
        shares.append(f"{sum(3.0 * f['chirp'] <= base for f, base in zip(own, plain, strict=True))}/{len(own)}")
        return [model, knows, *shares, *reach, still, *(f"{100.0 * mean(name):.2f}" for name in WITHHELD)]

    heads = ["inverse of", "controller", "chirp", "steps", "random", "3 x below", "-3 dB", "10 %", "locked", *WITHHELD]
    title = f"TWIN, torque control, means of {seeds} seeds: RMS in % of the range, Hz, and chirps on a changed device"
    return terminal.table(title, heads, [row(m, k) for m in INVERSES for k in KNOWS], left=2)


def _hand_table(name: HandName, runs: list[ControlRun], seeds: int) -> Table:
    """Means over the seeds, and how many seeds keep their promise."""
    import numpy as np

    from erclutch.wings.paper.hand_experiments import CALM, DAMPING, FREQUENCIES, KNOWN, STIFFNESS, WALLS
    from erclutch.wings.paper.torque_control import INVERSES

    def row(model: str, knows: str) -> list[str]:
        own = [run.figures for run in runs if (run.model, run.knows) == (model, knows)]
        of = {key: np.array([figures[key] for figures in own], np.float64) for key in own[0]}
        if name == "impedance":
            shares = [*(of["stiffness"][:, :5] / STIFFNESS).mean(axis=0), *(of["damping"] / DAMPING).mean(axis=0)]
            passive = int(np.count_nonzero(of["damping"].min(axis=1) > 0.0))
            return [model, knows, *(f"{share:.2f}" for share in shares), f"{passive}/{len(own)}"]
        step = [
            f"{1e3 * of['rise'].mean():.1f}",
            f"{100 * of['overshoot'].mean():.0f}",
            f"{1e3 * of['drag'].mean():.1f}",
        ]
        calm = [wall for wall, swing in zip(WALLS, of["swing"].max(axis=0), strict=True) if swing < CALM]
        stiffest = f"{max(calm):g}" if calm else "none"
        return [model, knows, *step, stiffest, f"{1e3 * of['pull'].mean():.0f}"]

    heads = [*(f"K {f:g} Hz" for f in FREQUENCIES[:5]), *(f"D {f:g}" for f in FREQUENCIES), "passive"]
    title = f"TWIN, means of {seeds} seeds: stiffness and damping that a hand feels, over what was asked"
    if name == "wall":
        heads = ["rise [ms]", "overshoot [%]", "drag [mN m]", "calm to [N m/rad]", "pull [mN m]"]
        title = f"TWIN brake, means of {seeds} seeds; calm in all of them"
    rows = [row(model, knows) for model in INVERSES for knows in KNOWN]
    return terminal.table(title, ["inverse of", "controller", *heads], rows, left=2)


def run_online(
    names: Sequence[str],
    of_run: Path | None,
    rig_file: Path | None,
    out: Path,
    options: dict[str, Any],
    only: int | None = None,
) -> None:
    """Run experiments, print their figures and draw those of the paper, or only one of them."""
    from erclutch.models.load import load_model
    from erclutch.wings.live.command_line.chosen_rig import file_of
    from erclutch.wings.live.live_model import live_model
    from erclutch.wings.paper.online import EXPERIMENTS, run
    from erclutch.wings.paper.online_figures import FIGURE_OF
    from erclutch.wings.rig.twin_model import twin_models

    rig = load_rig(rig_file)
    first = file_of(of_run, None) or twin_models(rig, ("fnn-16",), terminal.console())[0]
    options["rig_file"] = "" if rig_file is None else str(rig_file.resolve())
    chosen = live_model(first, "coaxial")
    for name in names:
        rivals = twin_models(rig, _RIVALS, terminal.console()) if EXPERIMENTS[name].rivals else []
        saved = [load_model(path) for path in (first, *rivals)]
        for figure, trace in enumerate(run(name, chosen, saved, rig, **options), start=FIGURE_OF[name]):
            if only in (None, figure):
                _show(name, trace, figure, out / (f"figure-{figure}" if only is None else f"fig{figure}"))


def _show(name: str, trace: OnlineTrace, figure: int, stem: Path) -> None:
    from erclutch.report.plots.matplotlib_painter import save_plot
    from erclutch.wings.paper.online import lines
    from erclutch.wings.paper.online_figures import describe_online

    terminal.tell(_table(name, trace, lines(trace)))
    pictures = (stem.with_name(f"{stem.name}.{kind}") for kind in ("pdf", "png"))
    terminal.say(*_sentences(name, trace))
    terminal.say(*save_plot(describe_online(trace, figure), *pictures))


def _table(name: str, trace: OnlineTrace, shown: list[ErrorLine]) -> Table:
    from erclutch.wings.paper.tables import printed

    rows: list[list[str]] = []
    for line in shown:
        paper = printed(line.model).get(name)
        figures = (f"{line.mse:.3e}", f"{line.rmse:.5f}", f"{line.largest:.4f}", f"{line.share:.1%}")
        rows.append([line.model, *figures, f"{line.outside:.1%}", "-" if paper is None else f"{paper:.3e}"])
    heads = ["model", "MSE [N2m2]", "RMSE [N m]", "largest [N m]", "of the std", "outside", "MSE, paper's rig"]
    return terminal.table(f"TWIN, {trace.name}: {shown[0].rows:,} samples", heads, rows)


def _sentences(name: str, trace: OnlineTrace) -> list[str]:
    import numpy as np

    said = [
        f"online estimate against the compiled model offline: {trace.compiled_off:.1e} N m at most; "
        f"against NumPy, where inside the training range and not limited: {trace.numpy_off:.1e} N m"
    ]
    if name == "tracking":
        from erclutch.wings.paper.online import lines, tracking_error, trial

        first, last = (lines(trace, trial(trace, n))[0].rmse for n in (0, -1))
        said.append(
            f"tracking error {tracking_error(trace):.3f} rad rms; RMSE of the first trial {first:.5f}, "
            f"of the last {last:.5f} N m; warmer by {trace.warming:.2f} K (paper, after both: {WARMING} K)"
        )
    if trace.other_alpha is not None:
        alpha, estimate = trace.other_alpha
        off = alpha - trace.frames["alpha"]
        apart = estimate - trace.estimates[next(iter(trace.estimates))]
        said.append(
            f"linear less rotary encoder: {1e3 * np.std(off):.2f} mrad rms; estimates apart by "
            f"{np.sqrt(np.mean(apart[100:] ** 2)):.5f} N m rms"
        )
    return said
