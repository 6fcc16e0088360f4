"""``erclutch experiment``: the paper's online experiments, with the live loop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from erclutch.errors import SettingError

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.experiments.online import Line, Trace
    from erclutch.saved import Model

#: Models beside the online one where the paper compares them (figures 11 and 12, table III).
_RIVALS = ("rbfn-50", "rbfm-10/forward", "hem/forward", "seo-seo/forward", "bingham/forward")


def experiment(
    name: Annotated[str | None, Parameter(name="NAME")] = None,
    *,
    model: Path | None = None,
    out: Path = Path("experiments"),
    seconds: float | None = None,
    seed: int = 0,
    real_time: Annotated[bool, Parameter(negative=())] = False,
    rig_file: Path | None = None,
) -> None:
    """Run an experiment of sections IV-B to IV-E and V with the live loop, on the TWIN. Without NAME: list them.

    Args:
        name: Which; "all" runs them one after another.
        model: A model's file; default: fnn-16, fitted to the twin once. It must be memoryless or have a lag.
        out: Folder for the figures and their numbers.
        seconds: Length in place of the experiment's own.
        seed: Of the commands and the noise.
        real_time: The loop and the twin each in its process, at 1 kHz, instead of as fast as they go. All but encoders:
            a rig's packets carry one encoder's angle.
        rig_file: A rig file (TOML) for the twin.
    """
    from erclutch.cli import show
    from erclutch.experiments.online import EXPERIMENTS

    output = show.console()
    if name is None:
        rows = [[e.name, e.meaning, f"{e.seconds:g} s"] for e in EXPERIMENTS.values()]
        output.print(show.table("Experiments with the live loop", ["name", "what", "length"], rows, left=2))
        return
    names = list(EXPERIMENTS) if name == "all" else [name]
    unknown = [n for n in names if n not in EXPERIMENTS]
    if unknown:
        raise SettingError(f"there is no experiment {unknown[0]!r}", remedy=f"Choose one of {', '.join(EXPERIMENTS)}")
    if real_time and name == "all":
        left_out = [n for n in names if EXPERIMENTS[n].encoders]
        names = [n for n in names if n not in left_out]
        output.print(f"left out, for it does not run in real time: {', '.join(left_out)}", markup=False)
    _run(names, model, out, seconds, seed, real_time, rig_file, output)


def _run(
    names: list[str],
    model: Path | None,
    out: Path,
    seconds: float | None,
    seed: int,
    real_time: bool,
    rig_file: Path | None,
    output: Console,
) -> None:
    from erclutch.cli.twin_model import twin_models
    from erclutch.experiments.online import EXPERIMENTS, run
    from erclutch.live.model import live_model
    from erclutch.rig.parameters import default_rig, load_rig
    from erclutch.saved import load_model

    rig = default_rig() if rig_file is None else load_rig(rig_file)
    first = twin_models(rig, ("fnn-16",), output)[0] if model is None else model
    chosen = live_model(first, "coaxial")
    for name in names:
        saved: list[Model] = [load_model(first)]
        if EXPERIMENTS[name].rivals:
            saved += [load_model(path) for path in twin_models(rig, _RIVALS, output)]
        traces = run(
            name,
            chosen,
            saved,
            rig,
            seconds=seconds,
            seed=seed,
            real_time=real_time,
            rig_file="" if rig_file is None else str(rig_file.resolve()),
        )
        _shown(name, traces, out, output)


def _shown(name: str, traces: list[Trace], out: Path, output: Console) -> None:
    from erclutch.experiments.online import lines, trial
    from erclutch.figures.online import draw_online

    for number, trace in enumerate(traces):
        figure, stretch = _figure(name, number), slice(0, len(trace.frames))
        if name == "tracking":
            stretch = trial(trace, 0 if number == 0 else -1)
        shown = lines(trace)
        output.print(_table(name, trace, shown))
        for sentence in _sentences(name, trace):
            output.print(sentence, markup=False, soft_wrap=True)
        rows = 5000 if trace.name.startswith("tracking at 0.4") or name == "encoders" else 2000
        start = stretch.start + (0 if name in ("tracking", "encoders") else min(5000, len(trace.frames) // 2))
        path = out / f"{figure}.png"
        for file in draw_online(
            trace, path, f"TWIN, {trace.name}: {figure.replace('-', ' ')} of the paper", start=start, rows=rows
        ):
            output.print(str(file), markup=False, soft_wrap=True)


def _figure(name: str, number: int) -> str:
    known = {"sine": 7, "square": 8, "tracking": 9, "zero-field": 11, "zero-motion": 12, "encoders": 13}
    return f"figure-{known[name] + number}"


def _table(name: str, trace: Trace, shown: list[Line]) -> object:
    from erclutch.cli import show
    from erclutch.paper import APPROACHES

    rows: list[list[str]] = []
    for line in shown:
        printed = APPROACHES.get(line.model)
        paper = {"zero-field": printed.zero_field, "zero-motion": printed.zero_motion}.get(name) if printed else None
        figures = (f"{line.mse:.3e}", f"{line.rmse:.5f}", f"{line.largest:.4f}", f"{line.share:.1%}")
        rows.append([line.model, *figures, f"{line.outside:.1%}", "-" if paper is None else f"{paper:.3e}"])
    heads = ["model", "MSE [N2m2]", "RMSE [N m]", "largest [N m]", "of the std", "outside", "MSE, paper's rig"]
    return show.table(f"TWIN, {trace.name}: {shown[0].rows:,} samples", heads, rows)


def _sentences(name: str, trace: Trace) -> list[str]:
    import numpy as np

    said = [
        f"online estimate against the compiled model offline: {trace.compiled_off:.1e} N m at most; "
        f"against NumPy, where inside the training range and not limited: {trace.numpy_off:.1e} N m"
    ]
    if name == "tracking":
        from erclutch.experiments.online import lines, tracking_error, trial
        from erclutch.paper import WARMING

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
