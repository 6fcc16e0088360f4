"""An FMU under FMPy: validated, and simulated over the test vectors in the way of each of its kinds."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.check import Check, ulps
from erclutch.export.fmu import archive_path, identifier
from erclutch.export.fmu_binaries import check_binary
from erclutch.export.program import Program
from erclutch.export.step_record import has_memory
from erclutch.export.vectors import vectors_of


def check_fmu(program: Program, folder: Path, version: int, kinds: Sequence[str]) -> Iterator[Check]:
    """Every kind of simulation, step by step through the interface.

    Raises:
        ExportError: FMPy is not installed, or finds a fault in the FMU.
    """
    try:
        fmpy = cast(Any, import_module("fmpy"))
        validation = cast(Any, import_module("fmpy.validation"))
    except ImportError as error:
        raise ExportError("fmpy is not installed", remedy="pip install fmpy") from error
    path = archive_path(program, version, folder)
    check_binary(version, path)
    problems = validation.validate_fmu(str(path))
    if problems:
        raise ExportError(f"FMPy finds: {'; '.join(problems)}", where=str(path), remedy="Export the model again")
    vectors = vectors_of(program)
    description, place = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    try:
        for kind in kinds:
            effort, flags = _RUNS[version, kind](program, description, place, vectors.rows)
            bits = program.precision.bits
            values = effort.astype(program.precision.dtype)
            other = (values.view(bits) != vectors.effort.view(bits)) | (flags != vectors.flags)
            largest = float(np.max(np.abs(effort - vectors.numpy)))
            where = f"FMI {version}.0 {kind}, FMPy {fmpy.__version__}"
            yield Check(where, len(flags), int(np.count_nonzero(other)), ulps(program, largest))
    finally:
        shutil.rmtree(place, ignore_errors=True)


Runs = tuple[NDArray[Any], NDArray[Any]]


def _instance(module: str, name: str, program: Program, description: Any, place: str, version: int) -> Any:
    made = getattr(import_module(module), name)
    return made(
        guid=description.guid,
        unzipDirectory=place,
        modelIdentifier=identifier(program, version),
        instanceName=program.name,
    )


def _cosimulate(program: Program, description: Any, place: str, rows: NDArray[Any], version: int) -> Runs:
    """Inputs, a communication step, outputs."""
    fmu = _instance(f"fmpy.fmi{version}", f"FMU{version}Slave", program, description, place, version)
    fmu.instantiate()
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    step, count = program.period or 1e-3, len(program.inputs)
    write = fmu.setReal if version == 2 else fmu.setFloat64
    read = fmu.getReal if version == 2 else fmu.getFloat64
    whole = fmu.getInteger if version == 2 else fmu.getUInt32
    effort, flags = np.zeros(len(rows)), np.zeros(len(rows), np.uint32)
    for k, row in enumerate(rows):
        write(list(range(1, count + 1)), [float(x) for x in row])
        fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
        effort[k], flags[k] = read([count + 1])[0], whole([count + 2])[0]
    fmu.terminate()
    fmu.freeInstance()
    return effort, flags


def _exchange(program: Program, description: Any, place: str, rows: NDArray[Any]) -> Runs:
    """Inputs, an event where the model is sampled, outputs at the same time."""
    fmu = _instance("fmpy.fmi3", "FMU3Model", program, description, place, 3)
    fmu.instantiate()
    fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    step, count = program.period or 1e-3, len(program.inputs)
    effort, flags = np.zeros(len(rows)), np.zeros(len(rows), np.uint32)
    for k, row in enumerate(rows):
        if k:
            fmu.setTime(k * step)
            fmu.enterEventMode()
        fmu.setFloat64(list(range(1, count + 1)), [float(x) for x in row])
        found = fmu.updateDiscreteStates()
        if has_memory(program) and not (found[-2] and abs(found[-1] - (k + 1) * step) < 1e-9 * max(1.0, k * step)):
            raise ExportError("the next event is not a period away", remedy="Export the model again")
        effort[k], flags[k] = fmu.getFloat64([count + 1])[0], fmu.getUInt32([count + 2])[0]
        fmu.enterContinuousTimeMode()
    fmu.terminate()
    fmu.freeInstance()
    return effort, flags


_RUNS: Mapping[tuple[int, str], Callable[[Program, Any, str, NDArray[Any]], Runs]] = {
    (2, "CoSimulation"): partial(_cosimulate, version=2),
    (3, "CoSimulation"): partial(_cosimulate, version=3),
    (3, "ModelExchange"): _exchange,
}
