"""``erclutch experiment`` repeats the paper's online experiments with the live loop."""

from __future__ import annotations

import io
from collections.abc import Generator
from contextlib import contextmanager, nullcontext, redirect_stdout
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from erclutch.cli import terminal
from erclutch.cli.quantities import SECONDS
from erclutch.errors import SettingError
from erclutch.files import may_fill
from erclutch.files.groups import together
from erclutch.files.places import nothing, reserve
from erclutch.signals.percent import percent
from erclutch.wings.paper.published import WARMING
from erclutch.wings.rig.twin.parameters import load_rig

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from erclutch.wings.paper.hand_experiments import HandName
    from erclutch.wings.paper.online import OnlineTrace
    from erclutch.wings.paper.torque_control import ControlRun, Figures

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
        seeds: How many seeds, from 0 on, for control, impedance and wall. What is finished in --out is not run again.
        real_time: Run the loop and the twin each in its process, at 1 kHz, instead of as fast as they go. The
            experiment encoders cannot: a rig's packets carry one encoder's angle.
        rig_file: A rig file (TOML) for the twin.
        json: Print the list, or the numbers of an experiment, as JSON.
    """
    from erclutch.wings.paper.online import EXPERIMENTS, experiment_of

    if name is None:
        heads = ["name", "what", "length"]
        rows = [[each.name, each.meaning, f"{each.seconds:g} s"] for each in EXPERIMENTS.values()]
        rows.append(
            ["control", "torque control: models, observers, a device that changes", "80 s a case"]
        )
        rows.append(
            ["impedance", "stiffness and damping that a hand feels at the output", "70 s a case"]
        )
        rows.append(["wall", "a brake as a wall: step, drag, stiffness, letting go", "32 s a case"])
        if json:
            as_json = [dict(zip(heads, row, strict=True)) for row in rows]
            terminal.say_json(as_json)
        else:
            terminal.tell(terminal.table("Experiments with the live loop", heads, rows, left=2))
        return
    may_fill(out)
    if name in ("control", "impedance", "wall"):
        if run is not None or seconds is not None or seed or real_time:
            problem = f"experiment {name} takes no --run, --seconds, --seed or --real-time"
            raise SettingError(problem, remedy="Give --seeds, --out and --rig-file alone")
        with _quiet(json):
            numbers = [_over_seeds(name, seeds, rig_file, out)]
        if json:
            terminal.say_json({"data": "TWIN", "experiments": numbers})
        return
    names = list(EXPERIMENTS) if name == "all" else [experiment_of(name).name]
    if real_time and name == "all":
        left_out = [each for each in names if EXPERIMENTS[each].encoders]
        names = [each for each in names if each not in left_out]
        terminal.tell(f"left out, for it does not run in real time: {', '.join(left_out)}")
    options = {
        "seconds": seconds,
        "seed": seed,
        "real_time": real_time,
    }
    with _quiet(json):
        numbers = run_online(names, run, rig_file, out, options)
    if json:
        terminal.say_json({"data": "TWIN", "experiments": numbers})


@contextmanager
def _quiet(json: bool) -> Generator[None]:
    """Keep tables and sentences back where JSON is asked for."""
    with redirect_stdout(io.StringIO()) if json else nullcontext():
        yield


def _over_seeds(
    name: Literal["control"] | HandName,
    seeds: int,
    rig_file: Path | None,
    out: Path,
) -> dict[str, Any]:
    """Run an experiment on so many seeds; print its table, draw its figure, and give the numbers of each run."""
    from erclutch.report.plots.matplotlib_painter import save_plot
    from erclutch.wings.paper.control_figure import describe_control
    from erclutch.wings.paper.hand_experiments import (
        describe_impedance,
        describe_wall,
        hand_points,
        hand_runs,
    )
    from erclutch.wings.paper.sweep_points import make_folder
    from erclutch.wings.paper.torque_control import control_runs, kept_runs

    rig = load_rig(rig_file)
    make_folder(out)
    reserve(out / name, nothing)  # its figure, its numbers and what it resumes from
    with terminal.progress(name) as bar:
        if name == "control":
            runs = control_runs(seeds, rig, kept_runs(out, rig), bar)
        else:
            runs = hand_runs(name, seeds, rig, hand_points(out, rig, name), bar)
    if name == "control":
        table = _control_table(runs, seeds)
        plot = describe_control(runs)
    elif name == "impedance":
        table = _impedance_table(runs, seeds)
        plot = describe_impedance(runs)
    else:
        table = _wall_table(runs, seeds)
        plot = describe_wall(runs)
    terminal.tell(table)
    files = save_plot(plot, out / f"{name}.png")
    terminal.say(*files)
    cases: list[dict[str, Any]] = []
    for run in runs:
        cases.append(
            {"seed": run.seed, "inverse": run.model, "controller": run.knows, **run.figures}
        )
    return {"experiment": name, "runs": cases, "files": list(map(str, files))}


def _control_table(runs: list[ControlRun], seeds: int) -> Table:
    """Means over the seeds, and of how many seeds a promise holds."""
    from erclutch.wings.paper.torque_control import INVERSES, KNOWS, WITHHELD

    # The plainest controller is what the others are compared with.
    plainest = _figures_of(runs, next(iter(INVERSES)), next(iter(KNOWS)))
    rows: list[list[str]] = []
    for model, knows in product(INVERSES, KNOWS):
        of_seeds = _figures_of(runs, model, knows)
        count = len(of_seeds)
        thrice_below = 0  # seeds
        still = 0  # seeds
        for figures, plain in zip(of_seeds, plainest, strict=True):
            thrice_below += 3.0 * figures["chirp"] <= float(plain["chirp"])
            still += bool(figures["locked"])
        means: dict[str, float] = {}
        for name in ("chirp", "steps", "random", "bandwidth", "within 10 %", *WITHHELD):
            means[name] = sum(float(figures[name]) for figures in of_seeds) / count
        row = [
            model,
            knows,
            f"{100.0 * means['chirp']:.2f}",
            f"{100.0 * means['steps']:.2f}",
            f"{100.0 * means['random']:.2f}",
            f"{thrice_below}/{count}",
            f"{means['bandwidth']:.0f}",
            f"{means['within 10 %']:.0f}",
            f"{still}/{count}",
        ]
        row += [f"{100.0 * means[name]:.2f}" for name in WITHHELD]
        rows.append(row)
    heads = [
        "inverse of",
        "controller",
        "chirp",
        "steps",
        "random",
        "3 x below",
        "-3 dB",
        "10 %",
        "locked",
        *WITHHELD,
    ]
    title = f"TWIN, torque control, means of {seeds} seeds: RMS in % of the range, Hz, and chirps on a changed device"
    return terminal.table(title, heads, rows, left=2)


def _figures_of(runs: list[ControlRun], model: str, knows: str) -> list[Figures]:
    """The figures of a model with a controller, a value a seed."""
    return [run.figures for run in runs if run.model == model and run.knows == knows]


def _impedance_table(runs: list[ControlRun], seeds: int) -> Table:
    """Means over the seeds, and of how many seeds no damping is negative."""
    import numpy as np

    from erclutch.wings.paper.hand_experiments import DAMPING, FREQUENCIES, KNOWN, STIFFNESS
    from erclutch.wings.paper.torque_control import INVERSES

    rows: list[list[str]] = []
    for model, knows in product(INVERSES, KNOWN):
        of_seeds = _figures_of(runs, model, knows)
        # Shape (seeds, frequencies).
        stiffness = np.array([figures["stiffness"] for figures in of_seeds], np.float64)
        damping = np.array([figures["damping"] for figures in of_seeds], np.float64)
        stiffness_shares = (stiffness[:, :5] / STIFFNESS).mean(axis=0)
        damping_shares = (damping / DAMPING).mean(axis=0)
        passive = np.count_nonzero(damping.min(axis=1) > 0.0)  # seeds
        row = [model, knows]
        row += [f"{share:.2f}" for share in [*stiffness_shares, *damping_shares]]
        row.append(f"{passive}/{len(of_seeds)}")
        rows.append(row)
    heads = ["inverse of", "controller"]
    heads += [f"K {frequency:g} Hz" for frequency in FREQUENCIES[:5]]
    heads += [f"D {frequency:g}" for frequency in FREQUENCIES]
    heads.append("passive")
    title = f"TWIN, means of {seeds} seeds: stiffness and damping that a hand feels, over what was asked"
    return terminal.table(title, heads, rows, left=2)


def _wall_table(runs: list[ControlRun], seeds: int) -> Table:
    """Means over the seeds, and the stiffest wall that is calm in all of them."""
    import numpy as np

    from erclutch.wings.paper.hand_experiments import CALM, KNOWN, WALLS
    from erclutch.wings.paper.torque_control import INVERSES

    rows: list[list[str]] = []
    for model, knows in product(INVERSES, KNOWN):
        of_seeds = _figures_of(runs, model, knows)
        means: dict[str, float] = {}
        for name in ("rise", "overshoot", "drag", "pull"):
            of_name = np.array([figures[name] for figures in of_seeds], np.float64)
            means[name] = of_name.mean()
        swings = np.array([figures["swing"] for figures in of_seeds], np.float64)  # (seeds, walls)
        calm: list[float] = []  # stiffnesses
        for stiffness, swing in zip(WALLS, swings.max(axis=0), strict=True):
            if swing < CALM:
                calm.append(stiffness)
        row = [
            model,
            knows,
            f"{1e3 * means['rise']:.1f}",
            f"{100 * means['overshoot']:.0f}",
            f"{1e3 * means['drag']:.1f}",
            f"{max(calm):g}" if calm else "none",
            f"{1e3 * means['pull']:.0f}",
        ]
        rows.append(row)
    heads = [
        "inverse of",
        "controller",
        "rise [ms]",
        "overshoot [%]",
        "drag [mN m]",
        "calm to [N m/rad]",
        "pull [mN m]",
    ]
    return terminal.table(
        f"TWIN brake, means of {seeds} seeds; calm in all of them", heads, rows, left=2
    )


def run_online(
    names: Sequence[str],
    of_run: Path | None,
    rig_file: Path | None,
    out: Path,
    options: dict[str, Any],
    only: int | None = None,
) -> list[dict[str, Any]]:
    """Run experiments, print their figures and draw those of the paper, or only one of them; give their numbers."""
    from erclutch.models.load import load_model
    from erclutch.wings.live.command_line.chosen_rig import file_of
    from erclutch.wings.live.live_model import live_model
    from erclutch.wings.paper.online import EXPERIMENTS, run
    from erclutch.wings.paper.online_figures import FIGURE_OF
    from erclutch.wings.rig.twin_model import twin_models

    rig = load_rig(rig_file)
    online = file_of(of_run, None) or twin_models(rig, ("fnn-16",), terminal.console())[0]
    chosen = live_model(online, "coaxial")
    options["rig_file"] = "" if rig_file is None else str(rig_file.resolve())
    numbers: list[dict[str, Any]] = []
    for name in names:
        files = [online]
        if EXPERIMENTS[name].rivals:
            files += twin_models(rig, _RIVALS, terminal.console())
        saved = [load_model(file) for file in files]
        traces = run(name, chosen, saved, rig, **options)
        with together():
            for figure, trace in enumerate(traces, start=FIGURE_OF[name]):
                if only is None:
                    numbers.append(_show(name, trace, figure, out / f"figure-{figure}"))
                elif figure == only:
                    numbers.append(_show(name, trace, figure, out / f"fig{figure}"))
    return numbers


def _show(
    name: str,
    trace: OnlineTrace,
    figure: int,
    stem: Path,
) -> dict[str, Any]:
    """Print what a run came to, draw its figure, and give its numbers."""
    import numpy as np

    from erclutch.report.plots.matplotlib_painter import save_plot
    from erclutch.wings.paper.online import lines, tracking_error, trial
    from erclutch.wings.paper.online_figures import describe_online
    from erclutch.wings.paper.tables import printed

    errors = lines(trace)
    rows: list[list[str]] = []
    for line in errors:
        paper = printed(line.model).get(name)
        row = [
            line.model,
            f"{line.mse:.3e}",
            f"{line.rmse:.5f}",
            f"{line.largest:.4f}",
            percent(line.share, 1),
            percent(line.outside, 1),
            "-" if paper is None else f"{paper:.3e}",
        ]
        rows.append(row)
    heads = [
        "model",
        "MSE [N2m2]",
        "RMSE [N m]",
        "largest [N m]",
        "of the std",
        "outside",
        "MSE, paper's rig",
    ]
    terminal.tell(terminal.table(f"TWIN, {trace.name}: {errors[0].rows:,} samples", heads, rows))

    terminal.say(
        f"online estimate against the compiled model offline: {trace.compiled_off:.1e} N m at most; "
        f"against NumPy, where inside the training range and not limited: {trace.numpy_off:.1e} N m"
    )
    if name == "tracking":
        first = lines(trace, trial(trace, 0))[0].rmse
        last = lines(trace, trial(trace, -1))[0].rmse
        terminal.say(
            f"tracking error {tracking_error(trace):.3f} rad rms; RMSE of the first trial {first:.5f}, "
            f"of the last {last:.5f} N m; warmer by {trace.warming:.2f} K (paper, after both: {WARMING} K)"
        )
    if trace.other_alpha is not None:
        alpha, with_other = trace.other_alpha
        online = next(iter(trace.estimates.values()))
        angle_apart = 1e3 * np.std(alpha - trace.frames["alpha"])  # [mrad]
        settled = (with_other - online)[100:]  # [N m]
        torque_apart = np.sqrt(np.mean(settled**2))
        terminal.say(
            f"linear less rotary encoder: {angle_apart:.2f} mrad rms; estimates apart by {torque_apart:.5f} N m rms"
        )

    pdf = stem.with_name(f"{stem.name}.pdf")
    png = stem.with_name(f"{stem.name}.png")
    drawn = save_plot(describe_online(trace, figure), pdf, png)
    terminal.say(*drawn)
    return {
        "experiment": name,
        "figure": figure,
        "rows": [asdict(line) for line in errors],
        "files": list(map(str, drawn)),
    }
