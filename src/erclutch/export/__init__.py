"""A model becomes files that run elsewhere: `export_model` writes them, `verify_export` runs them on test vectors.

The step of a model is recorded once (`step_record`). Every target is made from that record. One generated C99 file is
the source of those targets that compile C.
"""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from erclutch.errors import ExportError, require_known
from erclutch.export.export_folder import finish, may_write, read_export, unwritable
from erclutch.export.exported_step import ExportedStep, ExportOptions
from erclutch.export.rounding import refuse_noise
from erclutch.export.step_record import step_of
from erclutch.export.target_check import Check
from erclutch.export.targets import target
from erclutch.files import whole_folder
from erclutch.files.places import release

__all__ = ["Check", "ExportOptions", "ExportedStep", "export_model", "step_of", "verify_export"]


def export_model(
    model: Any,
    out: str | Path,
    to: str = "c",
    options: ExportOptions | None = None,
    *,
    force: bool = False,
    **more: Any,
) -> Path:
    """Write a model for a target.

    Args:
        model: a TorqueModel or NetworkModel.
        out: the folder to make; its parent must exist.
        to: name of the target.
        options: name, precision, period, inputs, limits.
        force: replace an export that is already there (never anything else).
        more: fields of the options, such as ``precision="float32"``; they go before those of `options`.

    Returns:
        The folder.

    Raises:
        ExportError: the model, an option, the target or the folder will not do.
        SettingError: a keyword that no export knows.
    """
    folder = Path(out)
    chosen = target(to)
    known = [each.name for each in fields(ExportOptions)]
    require_known(more, [*known, "to", "options", "force"], "export_model")
    asked = replace(options or ExportOptions(), **more)
    for name, wanted in (("alarms", asked.alarms), ("adaptation", asked.adapt)):
        if wanted and not getattr(chosen.value, "ALARMS", False):
            raise ExportError(
                f"target {to} has no {name}",
                remedy=f"Export to c, cpp or python, or without {name}",
            )
    may_write(folder, force)
    try:
        step = step_of(model, asked)
        refuse_noise(step)
        with whole_folder(folder, unwritable) as partial:
            with chosen.working("failed to write"):
                chosen.value.write(step, partial)
            finish(step, asked, chosen, partial)
    finally:
        release(folder)
    return folder


def verify_export(folder: str | Path) -> list[Check]:
    """Run an export on its test vectors with everything that this machine has for it.

    Raises:
        ExportError: no export, a changed file, or a tool that failed.
    """
    exported = read_export(folder)
    chosen = target(exported.target)
    with chosen.working(f"failed on {folder}"):
        return list(chosen.value.verify(exported.step, exported.folder))
