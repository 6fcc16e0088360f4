"""Target python compiles the step for this machine and adds a module that loads it with nothing but ctypes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np

from erclutch.errors import ExportError
from erclutch.export.c import model_abi
from erclutch.export.c.c_source import source
from erclutch.export.c.compiled_model import CompiledModel
from erclutch.export.c.compilers import Compiler, native, shared_flags
from erclutch.export.encode import comment
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, to_the_bit
from erclutch.export.targets import c
from erclutch.files import scratch_folder

TITLE = "the step compiled for this machine, called from Python (ctypes; 3.11 and later)"
ALARMS = True


def write(step: ExportedStep, folder: Path) -> None:
    """C files, two shared libraries, the module."""
    build(step, folder)
    module_file = resources.files("erclutch.export").joinpath("c/compiled_model.py")
    text = module_file.read_text(encoding="utf-8")
    tail = f'''

def load() -> CompiledModel:
    """{comment(f"{step.model.name}, inputs {', '.join(step.inputs)}")}."""
    here = Path(__file__).resolve().parent
    return CompiledModel(here / "{library_name(step)}", here / "{CALL}")
'''
    (folder / f"{step.name}.py").write_text(text.rstrip() + "\n" + tail, encoding="utf-8")


CALL = "erc_call.so"


def library_name(step: ExportedStep) -> str:
    """File name of the model's shared library: a digest of its source in it, as a process loads a name only once."""
    whole = source(step) + model_abi.wrapper(step)
    digest = hashlib.sha256(whole.encode()).hexdigest()
    return f"lib{step.name}-{digest[:12]}.so"


def build(step: ExportedStep, folder: Path, compiler: Compiler | None = None) -> Path:
    """The shared library with the model ABI, and beside it the one that makes a step a function of Python.

    Returns:
        The model's library.

    Raises:
        ExportError: no compiler, or it failed.
    """
    compiler = compiler or native()
    abi = folder / f"{step.name}_abi.c"
    abi.write_text(model_abi.wrapper(step), encoding="ascii")
    sources = [*c.write_core(step, folder), abi]
    library = folder / library_name(step)
    flags = ("-O3", "-fvisibility=hidden", *shared_flags(library))
    compiler.build(sources, library, *flags)
    (folder / "erc_call.c").write_text(_call_source())
    (folder / CALL).write_bytes(_call_library(compiler, flags))
    return library


def _call_source() -> str:
    return resources.files("erclutch.export").joinpath("c/call.c").read_text(encoding="ascii")


@cache
def _call_library(compiler: Compiler, flags: tuple[str, ...]) -> bytes:
    """It is the same for all models. The interpreter's functions are found in the process that loads it."""
    with scratch_folder() as work:
        code = Path(work) / "erc_call.c"
        library = Path(work) / CALL
        code.write_text(_call_source())
        compiler.build([code], library, *flags)
        return library.read_bytes()


def compile_model(step: ExportedStep) -> CompiledModel:
    """A model compiled on the spot; its files are gone once it is loaded.

    Raises:
        ExportError: no compiler, or it failed.
    """
    with scratch_folder() as folder:
        work = Path(folder)
        library = build(step, work)
        return load(library, work / CALL)


def load(library: Path, call: Path | None = None) -> CompiledModel:
    """A compiled model from its library.

    Raises:
        ExportError: it cannot be loaded here.
    """
    try:
        return CompiledModel(library, call)
    except OSError as error:
        raise ExportError(
            f"cannot be loaded: {error}",
            where=str(library),
            remedy="Export the model again on this machine",
        ) from error


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """Steps one by one and in one call, and the inverse, through the library that lies in the folder."""
    model = load(folder / library_name(step), folder / CALL)
    if model.digest != step.digest:
        raise ExportError(
            "the library is of another model", where=str(folder), remedy="Export the model again"
        )
    vectors = vectors_of(step)
    in_one_call, flags = model.run(np.ascontiguousarray(vectors.rows, np.float64))
    together = list(zip(in_one_call, flags, strict=True))
    model.reset()
    one_by_one = [(model.step(*row), model.flags) for row in vectors.rows.tolist()]
    model.reset()

    fields: list[tuple[float, int]] = []
    for row, wanted in zip(vectors.speeds.tolist(), vectors.wanted.tolist(), strict=True):
        fields.append((model.inverse(row, wanted), model.flags))
    # The inverse of the next step, ahead of each of the first steps.
    model.reset()
    for row, wanted in zip(vectors.rows.tolist(), vectors.wanted_now.tolist(), strict=False):
        fields.append((model.inverse_now(row, wanted), model.flags))
        model.step(*row)
    model.reset()

    for name, efforts in (("step", one_by_one), ("run", together)):
        results = [*efforts, *fields]
        values = np.array([value for value, _ in results])
        raised = np.array([flag for _, flag in results], np.uint32)
        yield to_the_bit(step, vectors, f"Python, {name}", values, raised)
