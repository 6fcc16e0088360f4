"""Target fmu3 writes an FMU 3.0 for co-simulation and model exchange."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from erclutch.export.exported_step import ExportedStep
from erclutch.export.target_check import Check
from erclutch.wings.exporters.fmu.fmu_archive import write_fmu

TITLE = "an FMU 3.0 for co-simulation and model exchange, with its C sources"


def write(step: ExportedStep, folder: Path) -> None:
    """NAME_fmi3.fmu."""
    write_fmu(step, folder, 3)


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """Validate and simulate it with FMPy, both ways."""
    from erclutch.wings.exporters.fmu.fmu_run import check_fmu

    yield from check_fmu(step, folder, 3, ("CoSimulation", "ModelExchange"))
