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


def check_fmu(
    step: ExportedStep,
    folder: Path,
    version: int,
    kinds: Sequence[str],
) -> Iterator[Check]:
    """Every kind of simulation of a model over its test vectors."""
    vectors = vectors_of(step)
    for where, outputs, flags in simulated(
        step, interface(step), folder, version, kinds, vectors.rows
    ):
        yield to_the_bit(step, vectors, where, outputs[:, 0], flags)


def simulated(
    step: ExportedStep,
    face: Interface,
    folder: Path,
    version: int,
    kinds: Sequence[str],
    rows: NDArray[Any],
) -> Iterator[tuple[str, NDArray[Any], NDArray[Any]]]:
    """Each kind of simulation, step by step through the interface: its name, the outputs of all rows, their flags.

    Raises:
        ExportError: FMPy is not installed, or finds a fault in the FMU.
    """
    try:
        import fmpy
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Model, FMU3Slave
        from fmpy.validation import validate_fmu
    except ImportError as error:
        raise ExportError("fmpy is not installed", remedy="Run: pip install fmpy") from error
    path = archive_path(step, version, folder)
    check_binary(version, path)
    problems = validate_fmu(str(path))
    if problems:
        raise ExportError(
            f"FMPy finds: {'; '.join(problems)}", where=str(path), remedy="Export the model again"
        )
    description = fmpy.read_model_description(str(path))
    unpacked = fmpy.extract(str(path))
    try:
        for kind in kinds:
            instance: Any
            if version == 2:
                instance = FMU2Slave
            elif kind == "ModelExchange":
                instance = FMU3Model
            else:
                instance = FMU3Slave
            fmu = instance(
                guid=description.guid,
                unzipDirectory=unpacked,
                modelIdentifier=identifier(step, version),
                instanceName=step.name,
            )
            fmu.instantiate()
            if version == 2:
                fmu.setupExperiment(startTime=0.0)
                fmu.enterInitializationMode()
            else:
                fmu.enterInitializationMode(startTime=0.0)
            fmu.exitInitializationMode()
            outputs, flags = _stepped(step, face, fmu, rows, kind)
            yield f"FMI {version}.0 {kind}, FMPy {fmpy.__version__}", outputs, flags
    finally:
        shutil.rmtree(unpacked, ignore_errors=True)


def _stepped(
    step: ExportedStep,
    face: Interface,
    fmu: Any,
    rows: NDArray[Any],
    kind: str,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Outputs and flags of each row: after a communication step, or at an event of model exchange."""
    exchange = kind == "ModelExchange"
    period = step.period or 1e-3  # s
    if hasattr(fmu, "setReal"):  # FMI 2.0
        write = fmu.setReal
        read = fmu.getReal
        read_whole = fmu.getInteger
    else:
        write = fmu.setFloat64
        read = fmu.getFloat64
        read_whole = fmu.getUInt32
    # Value references in the order of the interface: inputs from 1 on, outputs, flags.
    count = len(face.inputs)
    inputs = list(range(1, count + 1))
    results = [count + 1 + i for i in range(len(face.outputs))]
    flags_reference = results[-1] + 1

    outputs = np.zeros((len(rows), len(results)))
    flags = np.zeros(len(rows), np.uint32)
    for k, row in enumerate(rows):
        now = k * period
        if exchange and k:
            fmu.setTime(now)
            fmu.enterEventMode()
        write(inputs, [float(x) for x in row])
        if exchange:
            next_event, event_time = fmu.updateDiscreteStates()[-2:]
            is_near = abs(event_time - (k + 1) * period) < 1e-9 * max(1.0, now)
            if has_memory(step) and not (next_event and is_near):
                raise ExportError(
                    "the next event is not a period away", remedy="Export the model again"
                )
        else:
            fmu.doStep(currentCommunicationPoint=now, communicationStepSize=period)
        outputs[k] = read(results)
        flags[k] = read_whole([flags_reference])[0]
        if exchange:
            fmu.enterContinuousTimeMode()
    fmu.terminate()
    fmu.freeInstance()
    return outputs, flags
