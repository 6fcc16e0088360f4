"""``erclutch export`` writes a model as C or for another target."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from erclutch.cli.quantities import HERTZ, SECONDS
from erclutch.registry import names

COMMAND = {
    "help": "Write a model for a controller: C99, C++, Python, ONNX, FMU, Simulink, MuJoCo.",
    "panel": "The road of a log",
    "place": 9,
}

_Precision = Literal["float32", "float64"]
_Causal = Literal["difference", "lowpass", "kalman"]


def export(
    model: Path,
    /,
    *,
    to: Annotated[
        str, Parameter(help=f"What to write: {', '.join(names('erclutch.targets'))}.")
    ] = "c",
    out: Path | None = None,
    run_model: Annotated[str | None, Parameter(name="--model")] = None,
    name: str | None = None,
    precision: _Precision = "float64",
    period: Annotated[float | None, SECONDS] = None,
    inputs: Literal["speeds", "angles"] = "speeds",
    derivative: _Causal | None = None,
    cutoff: Annotated[float | None, HERTZ] = None,
    limits: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    alarms: Annotated[bool, Parameter(negative=())] = False,
    adapt: Annotated[bool, Parameter(negative=())] = False,
    force: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """Write a model for a controller: one C99 file and what wraps it.

    Args:
        model: A model's JSON file, or the folder of a run.
        to: What to write: the name of a target.
        out: The folder to make. Default: NAME_TARGET.
        run_model: Which model of the run, by its id (m2) or specification; final: of all rows. Default: the
            recommended.
        name: Prefix of all C names, at most 20 characters. Default: after the run's log, or the model.
        precision: Number format of all arithmetic; float32 is for processors without double (Cortex-M4F).
        period: Sampling period at which the step will be called, in s or as 1ms. Default: that of the training data.
        inputs: The step takes speeds, or angles (encoder positions) that it differentiates.
        derivative: Filter that differentiates angles. Default: kalman.
        cutoff: Bandwidth of this filter in Hz (lowpass, kalman). Default: 150 Hz, at most 0.4 of the sampling rate.
        limits: Smallest and largest effort, for example -2,2 or '-500,500 mN*m'. Default: the training range and half
            its width a side.
        alarms: Keep the effort's band, and warn of a wide band and of a residual that drifts (c, cpp, python).
        adapt: Let a gain and an offset follow a measured effort; at most 2 % worse in RMSE (c, cpp, python).
        force: Replace an export that is there.
    """
    from erclutch.cli import terminal
    from erclutch.errors import ExportError
    from erclutch.export import ExportOptions, export_model, step_of
    from erclutch.export.export_folder import may_write
    from erclutch.models.load import load_model
    from erclutch.models.model_titles import title_of
    from erclutch.runs.run_folder import read_run
    from erclutch.signals.speed import Derivative, usual_cutoff

    if inputs == "speeds" and (derivative, cutoff) != (None, None):
        option = "--derivative" if derivative else "--cutoff"
        raise ExportError(
            f"{option} is of a step that takes angles, and this step takes speeds",
            remedy=f"Add --inputs angles, or leave {option} out",
        )
    if out is not None:
        may_write(out, force)
    if run_model is not None and not model.is_dir():
        raise ExportError(
            "--model needs the folder of a run",
            where=str(model),
            remedy="Give the run, or leave it out",
        )
    if model.is_dir():
        run = read_run(model)
        chosen = run.model(run_model)
        name = name or run.c_name
    else:
        chosen = load_model(model)
    if cutoff is None:
        cutoff = usual_cutoff(period or chosen.period or 1e-3)
    options = ExportOptions(
        name=name,
        precision=precision,
        period=period,
        inputs=inputs,
        derivative=Derivative(derivative or "kalman", cutoff),
        limits=_limits(limits, chosen.units.effort),
        alarms=alarms,
        adapt=adapt,
    )
    step = step_of(chosen, options)
    folder = export_model(chosen, out or Path(f"{step.name}_{to}"), to, options, force=force)

    screen = terminal.console()
    title = title_of(step.model.name)
    screen.print(
        f"{title} as {precision}, inputs {', '.join(step.inputs)}, to {folder}:", markup=False
    )
    files = sorted(path.name for path in folder.iterdir())
    screen.print(f"  {', '.join(files)}", markup=False)
    binaries = folder / "binaries.txt"
    if binaries.is_file():
        for line in binaries.read_text(encoding="utf-8").splitlines():
            screen.print(f"  binary {line}", markup=False)
    for note in step.notes:
        screen.print(f"note: {note}.", markup=False)
    screen.print(f"Check it here: erclutch verify {shlex.quote(str(folder))}", markup=False)


def _limits(text: str | None, unit: str) -> tuple[float, float] | None:
    """Two efforts in the model's unit; a unit behind the second is that of both."""
    from erclutch.errors import ExportError, UnitError
    from erclutch.signals import units

    if text is None:
        return None
    low, comma, high = text.partition(",")
    try:
        unit_of_high = units.quantity(high)[1] if comma else None
        if unit_of_high is not None and not units.quantity(low)[1]:
            low = f"{low} {unit_of_high}"
        return units.in_unit(low, unit), units.in_unit(high, unit)
    except UnitError as error:
        remedy = f"Write the limits like --limits -2,2, or --limits '-2,2 {unit.replace('?', 'N')}'"
        raise ExportError(
            f"{text!r} are no two efforts", where="--limits", remedy=remedy
        ) from error
