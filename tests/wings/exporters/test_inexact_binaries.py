"""A compiler changed the arithmetic of an FMU's binary or a C++ class: nothing is instantiated, nothing comes out."""

from __future__ import annotations

import ctypes
import re
import subprocess
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from erclutch.export import ExportOptions, step_of
from erclutch.export.c import c_source
from erclutch.export.c.compilers import Compiler
from erclutch.models.law_model import TorqueModel
from erclutch.wings.exporters.fmu import fmu_archive, fmu_binaries
from erclutch.wings.exporters.targets import cpp


@pytest.fixture
def fast_math(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, need: Callable[..., None]
) -> Iterator[Compiler]:
    """gcc with parts of -ffast-math behind its other options, and C that is compiled without a check."""
    need("gcc")
    wrapper = tmp_path / "cc"
    wrapper.write_text('#!/bin/sh\nexec gcc "$@" -ffast-math -fno-finite-math-only\n')
    wrapper.chmod(0o755)
    monkeypatch.setattr(c_source, "COMPILE_TIME", "")
    c_source.source.cache_clear()
    yield Compiler("cc", (str(wrapper),))
    c_source.source.cache_clear()


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_no_fmu_is_instantiated(
    law: Callable[..., TorqueModel],
    fast_math: Compiler,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    version: int,
) -> None:
    monkeypatch.setattr(fmu_binaries, "native", lambda: fast_math)
    monkeypatch.setattr(fmu_binaries, "PLATFORMS", fmu_binaries.PLATFORMS[:1])
    step = step_of(law("bingham", "single"), ExportOptions(name="m", period=1e-3))
    fmu_archive.write_fmu(step, tmp_path, version)
    folder = "linux64" if version == 2 else "x86_64-linux"
    binary = f"binaries/{folder}/{fmu_archive.identifier(step, version)}.so"
    with zipfile.ZipFile(tmp_path / f"m_fmi{version}.fmu") as archive:
        library = ctypes.CDLL(archive.extract(binary, tmp_path))
        said = archive.read("modelDescription.xml").decode()
    token = re.findall(r"(?:guid|instantiationToken)=\"([^\"]+)\"", said)[0].encode()
    heard: list[bytes] = []
    if version == 3:
        log = ctypes.CFUNCTYPE(
            None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p
        )(lambda _environment, _status, _category, message: heard.append(message))
        make = library.fmi3InstantiateModelExchange
        make.restype = ctypes.c_void_p
        made = make(b"one", token, b"", ctypes.c_bool(False), ctypes.c_bool(False), None, log)
    else:
        logger = ctypes.CFUNCTYPE(
            None,
            ctypes.c_void_p,
            ctypes.c_char_p,
            ctypes.c_int,
            ctypes.c_char_p,
            ctypes.c_char_p,
            ctypes.c_char_p,
        )(lambda _environment, _name, _status, _category, _form, message: heard.append(message))
        callbacks = (ctypes.c_void_p * 5)(ctypes.cast(logger, ctypes.c_void_p).value)
        make = library.fmi2Instantiate
        make.restype = ctypes.c_void_p
        made = make(b"one", 1, token, b"", ctypes.byref(callbacks), 0, 0)
    assert made is None
    assert heard == [b"the options of this binary's compiler changed the model's arithmetic"]


@pytest.mark.slow
def test_a_class_says_so(
    law: Callable[..., TorqueModel], fast_math: Compiler, tmp_path: Path, need: Callable[..., None]
) -> None:
    need("g++")
    folder = tmp_path / "cpp"
    cpp.write(step_of(law("bingham", "single"), ExportOptions(name="m")), folder)
    (folder / "main.cpp").write_text(
        """#include <cstdio>
#include "m/m.hpp"
int main() {
    m_model::M device;
    m_model::Input in;
    in.field = 100.0;
    in.slip = 1.0;
    const m_model::Output out = device.step(in);
    std::printf("%d %g %u", device.exact(), out.effort, static_cast<unsigned>(out.flags));
}
"""
    )
    for compiler, said in ((Compiler("gcc", ("gcc",)), "1 "), (fast_math, "0 0 2")):
        compiler.build(
            [folder / "src" / "m.c"], folder / "m.o", "-O2", "-c", f"-I{folder}/include/m"
        )
        subprocess.run(
            ["g++", "-std=c++11", "-Iinclude", "main.cpp", "m.o", "-o", "main"],
            cwd=folder,
            check=True,
        )
        printed = subprocess.run(
            [folder / "main"], capture_output=True, text=True, check=True
        ).stdout
        assert printed.startswith(said), printed
