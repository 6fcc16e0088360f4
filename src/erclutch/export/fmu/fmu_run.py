"""FMPy validates an FMU and simulates it over the test vectors, in the way of each of its kinds."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.exported_step import ExportedStep
from erclutch.export.fmu.fmu_archive import archive_path, identifier
from erclutch.export.fmu.fmu_binaries import check_binary
from erclutch.export.step_record import has_memory
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, to_the_bit


def check_fmu(program: ExportedStep, folder: Path, version: int, kinds: Sequence[str]) -> Iterator[Check]:
    """Every kind of simulation, step by step through the interface.

    Raises:
        ExportError: FMPy is not installed, or finds a fault in the FMU.
    """
    try:
        import fmpy
        from fmpy.validation import validate_fmu
    except ImportError as error:
        raise ExportError("fmpy is not installed", remedy="pip install fmpy") from error
    path = archive_path(program, version, folder)
    check_binary(version, path)
    problems = validate_fmu(str(path))
    if problems:
        raise ExportError(f"FMPy finds: {'; '.join(problems)}", where=str(path), remedy="Export the model again")
    vectors = vectors_of(program)
    description, place = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    try:
        for kind in kinds:
            effort, flags = _simulated(program, description, place, vectors.rows, version, kind)
            where = f"FMI {version}.0 {kind}, FMPy {fmpy.__version__}"
            yield to_the_bit(program, vectors, where, effort, flags)
    finally:
        shutil.rmtree(place, ignore_errors=True)


def _simulated(
    program: ExportedStep, description: Any, place: str, rows: NDArray[Any], version: int, kind: str
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Effort and flags of each row: after a communication step, or at an event of model exchange."""
    fmu, exchange = _begun(program, description, place, version, kind), kind == "ModelExchange"
    step, count = program.period or 1e-3, len(program.inputs)
    write = fmu.setReal if version == 2 else fmu.setFloat64
    read = fmu.getReal if version == 2 else fmu.getFloat64
    whole = fmu.getInteger if version == 2 else fmu.getUInt32
    effort, flags = np.zeros(len(rows)), np.zeros(len(rows), np.uint32)
    for k, row in enumerate(rows):
        if exchange and k:
            fmu.setTime(k * step)
            fmu.enterEventMode()
        write(list(range(1, count + 1)), [float(x) for x in row])
        if exchange:
            _event(program, fmu, k, step)
        else:
            fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
        effort[k], flags[k] = read([count + 1])[0], whole([count + 2])[0]
        if exchange:
            fmu.enterContinuousTimeMode()
    fmu.terminate()
    fmu.freeInstance()
    return effort, flags


def _begun(program: ExportedStep, description: Any, place: str, version: int, kind: str) -> Any:
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Model, FMU3Slave

    made: Any = FMU2Slave if version == 2 else FMU3Model if kind == "ModelExchange" else FMU3Slave
    name = identifier(program, version)
    fmu = made(guid=description.guid, unzipDirectory=place, modelIdentifier=name, instanceName=program.name)
    fmu.instantiate()
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    return fmu


def _event(program: ExportedStep, fmu: Any, k: int, step: float) -> None:
    found = fmu.updateDiscreteStates()
    if has_memory(program) and not (found[-2] and abs(found[-1] - (k + 1) * step) < 1e-9 * max(1.0, k * step)):
        raise ExportError("the next event is not a period away", remedy="Export the model again")
