"""Target onnx writes the step as an ONNX model and checks it with ONNX Runtime."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.exported_step import NON_FINITE, ExportedStep
from erclutch.export.step_record import has_memory, step_record
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, near
from erclutch.wings.exporters.onnx_graph import OPSET, onnx_model

TITLE = f"an ONNX model of one step (opset {OPSET}), state in and out as a tensor"


def write(step: ExportedStep, folder: Path) -> None:
    """NAME.onnx.

    Raises:
        ExportError: the package onnx is not installed.
    """
    try:
        import onnx
    except ImportError as error:
        raise ExportError(
            "onnx is not installed", remedy='Run: pip install "erclutch[export]"'
        ) from error
    model = onnx_model(step, step_record(step, remember=False))
    onnx.checker.check_model(model, full_check=True)  # pyright: ignore[reportUnknownMemberType]
    onnx.save_model(model, str(folder / f"{step.name}.onnx"))  # pyright: ignore[reportUnknownMemberType]


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The steps one by one in ONNX Runtime on the CPU.

    Raises:
        ExportError: ONNX Runtime is not installed, or does not take the file.
    """
    try:
        import onnxruntime as runtime
    except ImportError as error:
        raise ExportError(
            "onnxruntime is not installed", remedy="Run: pip install onnxruntime"
        ) from error
    path = folder / f"{step.name}.onnx"
    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    try:
        session = runtime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # its exceptions have no common base but this
        raise ExportError(
            f"ONNX Runtime refuses the model: {error}",
            where=str(path),
            remedy="Update ONNX Runtime",
        ) from error
    vectors = vectors_of(step)
    effort, flags = run(session, step, vectors.rows)
    if not has_memory(step):
        # Without a state the effort of a bad row is 0, and the caller keeps the effort before: so does this check.
        bad = flags == NON_FINITE
        if np.any(effort[bad] != 0.0):
            raise ExportError("the effort of a bad row is not 0", remedy="Export the model again")
        good_rows = np.where(bad, -1, np.arange(len(flags)))
        last_good = np.maximum.accumulate(good_rows)
        any_good = last_good >= 0
        effort = np.where(any_good, effort[last_good], 0.0).astype(effort.dtype)
        flags_before = np.where(any_good, flags[last_good], 0)
        flags = np.where(bad, flags_before | NON_FINITE, flags).astype(np.uint32)
    yield near(step, vectors, f"ONNX Runtime {runtime.__version__}", effort, flags)


def run(
    session: Any,
    step: ExportedStep,
    rows: NDArray[Any],
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Effort and flags of successive steps from a reset."""
    given: dict[str, NDArray[Any]] = {}
    for tensor in session.get_inputs():
        given[tensor.name] = np.zeros(tensor.shape, step.precision.dtype)
    effort = np.zeros(len(rows), step.precision.dtype)
    flags = np.zeros(len(rows), np.uint32)
    for k, row in enumerate(rows):
        given["input"] = row[None, :]
        effort_out, flags_out, *state_out = session.run(None, given)
        effort[k] = effort_out[0, 0]
        flags[k] = flags_out[0]
        if "state" in given:
            (given["state"],) = state_out
    return effort, flags
