"""Each law and stage of another package is recorded as an export would, so that its user need not wait for a fit.

Somebody else's code may raise, hang, end the program or answer anything: a plug-in is checked in a process of its own,
``python -m erclutch.cli.plugin_check GROUP NAME``, which prints what is wrong with it and nothing else.
"""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from erclutch.registry import Plugin

#: By the clock: what is recorded in seconds here may take long on a busy machine.
SECONDS = 120.0
_LARGEST = 2000.0  # of a field
_SLIP = 30.0  # rad/s
_END = "checked: "


def fault_of(plugin: Plugin, seconds: float = SECONDS) -> str:
    """What is wrong with a plug-in, as a process of its own finds out; "" where nothing is."""
    paths = os.pathsep.join(entry for entry in sys.path if entry)
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", "erclutch.cli.plugin_check", plugin.group, plugin.name],
            env={**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=seconds,
        )
    except subprocess.TimeoutExpired:
        return f"it does not come to an end within {seconds:g} s"
    ends = [line for line in done.stdout.splitlines() if line.startswith(_END)]
    if not ends:
        return f"it ends the program (code {done.returncode})"
    return ends[-1].removeprefix(_END)


def recorded_fault(group: str, name: str) -> str:
    """What is wrong with a plug-in of this process: whether it loads, and whether a law or stage can be exported."""
    from erclutch import registry
    from erclutch.errors import ErclutchError

    try:
        plugin = registry.find(group, name)
        if group == "erclutch.laws":
            return _not_exported(name, "none")
        if group == "erclutch.stages":
            return _not_exported("bingham", name)
        plugin.value  # noqa: B018
    except ErclutchError as error:
        return error.problem
    except Exception as error:  # not our code
        return f"it cannot be exported: {type(error).__name__}: {str(error)[:200]}"
    return ""


def _not_exported(law: str, stage: str) -> str:
    """Why a law with a stage gives no C; "" where it does."""
    import numpy as np

    from erclutch.export import ExportOptions, step_of
    from erclutch.export.c.c_source import source
    from erclutch.models.law_model import TorqueModel
    from erclutch.models.laws import law_from_name
    from erclutch.models.model import Range
    from erclutch.models.structure import Reference, Structure
    from erclutch.signals.device import Units

    # Numbers in the middle of their ranges need no fit.
    structure = Structure("single", law, law_from_name(law, "single"), stage, True, True)
    shapes: dict[str, float] = {}
    for shape in structure.shapes(1e-3):
        low = float(shape.lower)
        high = float(shape.upper)
        shapes[shape.name] = low + 0.4 * (high - low)
        if shape.scale == "log":
            shapes[shape.name] = low * (high / low) ** 0.4
    gains = {gain.name: 0.1 for gain in structure.gains()}
    ranges = Range((0.0, _LARGEST), (-_SLIP, _SLIP), (-1.0, 1.0))
    reference = Reference(_LARGEST, 17.0, 1e-3)
    units = Units("N*m", "V", "rad/s")
    model = TorqueModel(structure, reference, shapes, gains, units, ranges)

    rng = np.random.default_rng(0)
    rows = 200
    fields = rng.uniform(0.0, _LARGEST, rows)
    slips = rng.uniform(-_SLIP, _SLIP, rows)
    extras = [np.ones(rows) for _ in model.extras]
    effort = np.asarray(model.steady([fields], [slips], extras))
    if effort.shape != (rows,):
        return f"it answers {rows} rows by an array of shape {effort.shape}"
    infinite = np.count_nonzero(~np.isfinite(effort))
    if infinite:
        return f"its effort is not finite in {infinite} of {rows} rows within its range"
    for row in range(3):  # the export computes one row at a time
        field = fields[row : row + 1]
        slip = slips[row : row + 1]
        extras_of_row = [np.ones(1) for _ in model.extras]
        alone = float(model.steady([field], [slip], extras_of_row)[0])
        if not np.isclose(alone, effort[row], rtol=1e-9, atol=0.0):
            return f"its effort of a row depends on other rows: {alone:g} alone, {effort[row]:g} among {rows}"
    source(step_of(model, ExportOptions("checked", "float64", 1e-3)))
    return ""


if __name__ == "__main__":
    fault = recorded_fault(*sys.argv[1:3])
    one_line = " ".join(fault.split())
    print(f"{_END}{one_line}", flush=True)
