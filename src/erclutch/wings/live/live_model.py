"""A saved model is exported to C, compiled for this machine and kept in the cache, so that the loop can run it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from erclutch.errors import SettingError
from erclutch.files import cache_folder
from erclutch.models.load import load_model
from erclutch.signals.array import largest_size
from erclutch.signals.device import DeviceName, Units
from erclutch.signals.units import UNKNOWN
from erclutch.wings.live.c_build import cached, find_compiler
from erclutch.wings.live.session import LiveModel

_INPUTS = {"coaxial": 4, "single": 2}


def live_model(
    path: str | Path,
    device: DeviceName,
    *,
    adapt: bool = False,
    units: Units | None = None,
    period: float = 1e-3,
) -> LiveModel:
    """A saved model, ready for the loop.

    Args:
        path: its JSON file.
        device: of the rig.
        adapt: a gain and an offset follow the torque sensor; the name says so.
        units: of the rig's effort, field and slip; "?" where that is not known.
        period: of the loop in s.

    Raises:
        RunError: no model, or a damaged one.
        SettingError: of another device or unit, or with further inputs.
        ExportError: it cannot be exported or compiled.
        CompilerError: there is no C compiler.
    """
    model = load_model(path)
    if model.structure.device != device:
        raise SettingError(
            f"a model of a {model.structure.device} device on a {device} rig",
            where=str(path),
            remedy="Give a model of the rig's device",
        )
    for name in ("effort", "field", "slip"):
        own, of_rig = (getattr(each, name) for each in (model.units, units or model.units))
        if own != of_rig and UNKNOWN not in (own, of_rig):
            problem = (
                f"the model's {name} is in {own or '1'}, and that of the rig in {of_rig or '1'}"
            )
            remedy = (
                "Give a model of the rig's device, or play the model's log: --rig replay --log LOG"
            )
            raise SettingError(problem, where=str(path), remedy=remedy)
    from erclutch.export import ExportOptions, step_of
    from erclutch.export.monotone import releases
    from erclutch.export.targets.python import build, library_name

    alarms = model.band is not None
    options = ExportOptions(
        name="live",
        precision="float64",
        period=period,
        alarms=alarms,
        adapt=adapt,
    )
    step = step_of(model, options)
    if step.model_inputs != _INPUTS[device]:
        needed = ", ".join(step.inputs[: step.model_inputs])
        raise SettingError(
            f"{model.name} has the inputs {needed}; the loop has {_INPUTS[device]}",
            where=str(path),
            remedy="Give a model without further inputs",
        )
    library = library_name(step)
    digest = hashlib.sha256(library.encode()).hexdigest()[:24]
    target = cache_folder() / f"model-{digest}" / library
    name = f"{model.name}, adapting" if adapt else model.name
    notes = list(step.notes)
    if step.field.range == (0.0, 0.0):
        notes.append("It was fitted without a field: it estimates, and no field gives a torque")
    elif releases(model):
        notes.append(
            "Its effort falls as the field grows: where the loop takes the field away, the device holds"
        )
    return LiveModel(
        library=cached(target, lambda folder: build(step, folder, find_compiler())),
        name=name,
        digest=step.digest,
        units=model.units,
        period=period,
        note=". ".join(notes),
        adapts=adapt,
        effort=step.scale,
        slip=largest_size(step.slip.range),
        band=0.0 if model.band is None else model.band.settled,
    )
