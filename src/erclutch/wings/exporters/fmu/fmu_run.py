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
from erclutch.export.step_record import has_memory
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, to_the_bit
from erclutch.wings.exporters.fmu.fmu_archive import archive_path, identifier
from erclutch.wings.exporters.fmu.fmu_binaries import check_binary
from erclutch.wings.exporters.fmu.fmu_description import Interface, interface


def check_fmu(step: ExportedStep, folder: Path, version: int, kinds: Sequence[str]) -> Iterator[Check]:
    """Every kind of simulation of a model over its test vectors."""
    vectors = vectors_of(step)
    for where, outputs, flags in simulated(step, interface(step), folder, version, kinds, vectors.rows):
        yield to_the_bit(step, vectors, where, outputs[:, 0], flags)


def simulated(
    step: ExportedStep, face: Interface, folder: Path, version: int, kinds: Sequence[str], rows: NDArray[Any]
) -> Iterator[tuple[str, NDArray[Any], NDArray[Any]]]:
    """Each kind of simulation, step by step through the interface: its name, the outputs of all rows, their flags.

    Raises:
        ExportError: FMPy is not installed, or finds a fault in the FMU.
    """
    try:
        import fmpy
        from fmpy.validation import validate_fmu
    except ImportError as error:
        raise ExportError("fmpy is not installed", remedy="Run: pip install fmpy") from error
    path = archive_path(step, version, folder)
    check_binary(version, path)
    problems = validate_fmu(str(path))
    if problems:
        raise ExportError(f"FMPy finds: {'; '.join(problems)}", where=str(path), remedy="Export the model again")
    description, place = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    try:
        for kind in kinds:
            where = f"FMI {version}.0 {kind}, FMPy {fmpy.__version__}"
            yield where, *_stepped(step, face, _begun(step, description, place, version, kind), rows, kind)
    finally:
        shutil.rmtree(place, ignore_errors=True)


def _stepped(
    step: ExportedStep, face: Interface, fmu: Any, rows: NDArray[Any], kind: str
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Outputs and flags of each row: after a communication step, or at an event of model exchange."""
    exchange, old = kind == "ModelExchange", hasattr(fmu, "setReal")
    period, count = step.period or 1e-3, len(face.inputs)
    write, read = (fmu.setReal, fmu.getReal) if old else (fmu.setFloat64, fmu.getFloat64)
    whole = fmu.getInteger if old else fmu.getUInt32
    references = [count + 1 + i for i in range(len(face.outputs))]
    outputs, flags = np.zeros((len(rows), len(references))), np.zeros(len(rows), np.uint32)
    for k, row in enumerate(rows):
        if exchange and k:
            fmu.setTime(k * period)
            fmu.enterEventMode()
        write(list(range(1, count + 1)), [float(x) for x in row])
        if exchange:
            _event(step, fmu, k, period)
        else:
            fmu.doStep(currentCommunicationPoint=k * period, communicationStepSize=period)
        outputs[k], flags[k] = read(references), whole([references[-1] + 1])[0]
        if exchange:
            fmu.enterContinuousTimeMode()
    fmu.terminate()
    fmu.freeInstance()
    return outputs, flags


def _begun(step: ExportedStep, description: Any, place: str, version: int, kind: str) -> Any:
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Model, FMU3Slave

    made: Any = FMU2Slave if version == 2 else FMU3Model if kind == "ModelExchange" else FMU3Slave
    name = identifier(step, version)
    fmu = made(guid=description.guid, unzipDirectory=place, modelIdentifier=name, instanceName=step.name)
    fmu.instantiate()
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    return fmu


def _event(step: ExportedStep, fmu: Any, k: int, period: float) -> None:
    found = fmu.updateDiscreteStates()
    if has_memory(step) and not (found[-2] and abs(found[-1] - (k + 1) * period) < 1e-9 * max(1.0, k * period)):
        raise ExportError("the next event is not a period away", remedy="Export the model again")
