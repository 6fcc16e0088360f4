"""A model as a file that runs elsewhere: `export_model` writes it, `verify_export` runs it on its test vectors.

One generated C99 file is the single source; every other target wraps it. `program` cuts a model into stages, `graph`
records a law's own NumPy function so that C and NumPy do the same operations in the same order, `emulate` is the step
in NumPy bit for bit, `targets` lists what can be written.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from erclutch.export.check import Check
from erclutch.export.folder import finish, may_write, read_export, unwritable
from erclutch.export.program import Options, Program, program_of
from erclutch.export.rounding import refuse_noise
from erclutch.export.targets import TARGETS, target
from erclutch.whole_folder import whole_folder

__all__ = ["TARGETS", "Check", "Options", "Program", "export_model", "program_of", "verify_export"]


def export_model(
    model: Any, out: str | Path, to: str = "c", options: Options | None = None, *, force: bool = False
) -> Path:
    """Write a model for a target.

    Args:
        model: a TorqueModel or NetworkModel.
        out: the folder to make; its parent must exist.
        to: name of the target.
        options: name, precision, period, inputs, limits.
        force: replace an export that is already there (never anything else).

    Returns:
        The folder.

    Raises:
        ExportError: the model, an option, the target or the folder will not do.
    """
    folder, chosen = Path(out), target(to)
    asked = options or Options()
    may_write(folder, force)
    program = program_of(model, asked)
    refuse_noise(program)
    with whole_folder(folder, unwritable) as partial:
        chosen.write(program, partial)
        finish(program, asked, to, partial)
    return folder


def verify_export(folder: str | Path) -> list[Check]:
    """Run an export on its test vectors with everything that this machine has for it.

    Raises:
        ExportError: no export, a changed file, or a tool that failed.
    """
    exported = read_export(folder)
    return list(target(exported.target).verify(exported.program, exported.folder))
