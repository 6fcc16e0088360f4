"""Target fmu2 writes an FMU 2.0 for co-simulation."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from erclutch.export.exported_step import ExportedStep
from erclutch.export.target_check import Check
from erclutch.wings.exporters.fmu.fmu_archive import write_fmu

TITLE = "an FMU 2.0 for co-simulation, with its C sources"


def write(step: ExportedStep, folder: Path) -> None:
    """NAME_fmi2.fmu."""
    write_fmu(step, folder, 2)


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """Validate and simulate it with FMPy."""
    from erclutch.wings.exporters.fmu.fmu_run import check_fmu

    yield from check_fmu(step, folder, 2, ("CoSimulation",))
