"""From a saved model to what the loop runs: exported to C, compiled for this machine, kept in the cache."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from pathlib import Path

from erclutch.device import DeviceName
from erclutch.errors import SettingError
from erclutch.live.build import cache_folder, find_compiler, note_whole, whole
from erclutch.live.session import LiveModel
from erclutch.live.soft_model import refuse_memory
from erclutch.saved import load_model

_INPUTS = {"coaxial": 4, "single": 2}


def live_model(path: str | Path, device: DeviceName, *, period: float = 1e-3, python: bool = False) -> LiveModel:
    """A saved model, ready for the loop.

    Args:
        path: its JSON file.
        device: of the rig.
        period: of the loop in s.
        python: for the loop in Python, even if there is a compiler.

    Raises:
        RunError: no model, a damaged one, or one that the loop in Python does not run.
        SettingError: of another device, or with further inputs.
        ExportError: it cannot be exported or compiled.
    """
    model = load_model(path)
    if model.structure.device != device:
        raise SettingError(
            f"a model of a {model.structure.device} device on a {device} rig",
            where=str(path),
            remedy="Give a model of the rig's device",
        )
    saved = Path(path).resolve()
    if python or find_compiler() is None:  # the loop in Python takes the file itself
        refuse_memory(model)
        return LiveModel(None, model.name, str(model.to_dict()["digest"]), saved)
    from erclutch.export import Options, program_of

    program = program_of(model, Options(name="live", precision="float64", period=period))
    if len(program.inputs) != _INPUTS[device]:
        raise SettingError(
            f"{model.name} has the inputs {', '.join(program.inputs)}; the loop has {_INPUTS[device]}",
            where=str(path),
            remedy="Give a model without further inputs",
        )
    return LiveModel(_compiled(program), model.name, program.digest, saved)


def _compiled(program: object) -> Path:
    from erclutch.export.program import Program
    from erclutch.export.python import build, library_name

    assert isinstance(program, Program)
    name = library_name(program)
    target = cache_folder() / f"model-{hashlib.sha256(name.encode()).hexdigest()[:24]}" / name
    if whole(target):
        return target
    target.parent.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix=".building-", dir=target.parent.parent))
    try:
        made = build(program, folder)
        note = note_whole(made)
        os.replace(made, target)
        os.replace(note, target.with_name(note.name))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return target
