"""Every model on every target that wraps the C or says the same in another language."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ExportError
from erclutch.export import ExportOptions, export_model, step_of, verify_export
from erclutch.export.c.compilers import zig_command
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_numbers import run
from erclutch.export.step_vectors import vectors_of
from erclutch.export.targets import target
from erclutch.models.model import Model
from erclutch.registry import names
from tests.support.exported_models import MODELS
from tests.support.slow_params import slow_but

BOUND = {"float64": 4.0, "float32": 8.0}
PERIOD = 1e-3
#: Target -> tools that it needs here, and whether all its checks are to the bit.
WRAPPERS = {
    "onnx": ((), False),
    "fmu2": (("gcc",), True),
    "fmu3": (("gcc",), True),
    "cpp": (("g++",), True),
    "simulink": (("gcc", "octave-cli"), False),
    "mujoco": (("gcc",), True),
}
#: Of these, the ones that compile the C as Python does, which `tests/export/test_conformance.py` asks of every model.
HANDS_ON = ("fmu2", "fmu3", "mujoco")
QUICK = ("hem+rise-fall, coaxial", "fnn-3+rise-fall, single")


def exported(model: Model, to: str, folder: Path, **options: Any) -> Path:
    return export_model(
        model, folder, to, ExportOptions(**{"name": "m", "period": PERIOD, **options})
    )


def _conforms(
    model: Model, to: str, precision: str, folder: Path, need: Callable[..., None], **options: Any
) -> None:
    tools, exact = WRAPPERS[to]
    need(*tools)
    checks = verify_export(exported(model, to, folder / to, precision=precision, **options))
    assert checks
    for check in checks:
        assert check.passed, check
        # Where a network gives way to a law, a cell's share makes 16 last digits of the effort of one of the field.
        assert check.ulp <= BOUND[precision] * (1.0 if model.gives_way is None else 16.0), check
        assert check.count >= 200
        assert (check.other_bits == 0) == (exact or check.where.startswith("C Caller")), check


@pytest.mark.slow
def test_every_target_is_tested() -> None:
    assert set(names("erclutch.targets")) == {
        "c",
        "python",
        "controller",
        "controller-fmu",
        *WRAPPERS,
    }


def _pairs() -> Iterator[tuple[str, str]]:
    """Each model on each target that computes by itself, and on one of those that hand on what the same C gives."""
    for place, label in enumerate(MODELS):
        yield from ((label, to) for to in WRAPPERS if to not in HANDS_ON)
        yield label, HANDS_ON[place % len(HANDS_ON)]


@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.slow
@pytest.mark.usefixtures("own_machine")
@pytest.mark.parametrize(("label", "to"), list(_pairs()))
def test_every_model_on_every_target(
    label: str, to: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    _conforms(models[label], to, "float64", tmp_path, need)


@pytest.mark.slow
def test_every_model_in_onnx_as_float32(model: Model, tmp_path: Path) -> None:
    _conforms(model, "onnx", "float32", tmp_path, lambda *_: None)


@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.slow
@pytest.mark.usefixtures("own_machine")
@pytest.mark.parametrize("to", [to for to in WRAPPERS if to != "onnx"])
@pytest.mark.parametrize("label", [*QUICK, "rbfn-50, coaxial"])
def test_float32_on_every_target(
    to: str, label: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    _conforms(models[label], to, "float32", tmp_path, need)


@pytest.mark.slow
@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.usefixtures("own_machine")
@pytest.mark.parametrize("to", slow_but(("mujoco",), WRAPPERS))
@pytest.mark.parametrize("label", slow_but(QUICK[1:], QUICK))
def test_angles_on_every_target(
    to: str, label: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    _conforms(models[label], to, "float64", tmp_path, need, inputs="angles", period=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("to", ["onnx", pytest.param("simulink", marks=pytest.mark.slow)])
def test_numbers_of_another_model_are_found_out(
    to: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need(*WRAPPERS[to][0])
    folder = exported(models["bingham, single"], to, tmp_path / to)
    other = step_of(models["herschel-bulkley, single"], ExportOptions(name="m", period=PERIOD))
    assert not next(target(to).value.verify(other, folder)).passed


@pytest.mark.slow
def test_one_wrong_weight_is_found_out(models: dict[str, Model], tmp_path: Path) -> None:
    import onnx
    from onnx import numpy_helper

    model = models["fnn-16, coaxial"]
    folder = exported(model, "onnx", tmp_path / "o")
    made = onnx.load(folder / "m.onnx")
    at = next(i for i, t in enumerate(made.graph.initializer) if list(t.dims) == [16, 3])
    weights = numpy_helper.to_array(made.graph.initializer[at]).copy()
    weights[5, 1] *= 1.0 + 1e-6
    made.graph.initializer[at].CopyFrom(
        numpy_helper.from_array(weights, made.graph.initializer[at].name)
    )
    onnx.save_model(made, folder / "m.onnx")
    with pytest.raises(ExportError, match="was changed after the export"):
        verify_export(folder)
    checks = list(
        target("onnx").value.verify(step_of(model, ExportOptions(name="m", period=PERIOD)), folder)
    )
    assert [c.passed for c in checks] == [False]


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_onnx_says_what_it_is(precision: str, models: dict[str, Model], tmp_path: Path) -> None:
    import onnx

    folder = exported(models["fnn-7, coaxial"], "onnx", tmp_path / "o", precision=precision)
    made = onnx.load(folder / "m.onnx")
    assert [o.version for o in made.opset_import if o.domain == ""] == [17]
    kind = onnx.TensorProto.FLOAT if precision == "float32" else onnx.TensorProto.DOUBLE
    shapes = {i.name: [d.dim_value for d in i.type.tensor_type.shape.dim] for i in made.graph.input}
    assert shapes["input"] == [1, 6]
    assert len(shapes["state"]) == 1
    assert shapes["state"][0] > 6
    assert {i.type.tensor_type.elem_type for i in made.graph.input} == {kind}
    said = {p.key: p.value for p in made.metadata_props}
    assert said["digest"] == step_of(models["fnn-7, coaxial"], ExportOptions(period=PERIOD)).digest
    assert "E1 [V]" in said["inputs"]
    assert said["effort"] == "N*m"


@pytest.mark.slow
def test_a_static_model_has_no_state_in_onnx(models: dict[str, Model], tmp_path: Path) -> None:
    import onnx

    made = onnx.load(exported(models["fnn-16, coaxial"], "onnx", tmp_path / "o") / "m.onnx")
    assert [i.name for i in made.graph.input] == ["input"]
    assert [o.name for o in made.graph.output] == ["effort", "flags"]


# --- FMU -------------------------------------------------------------------------------------------------------------

_HOST = Path(__file__).with_name("fmi3_host.c")
#: Folder of a binary -> compiler of a host for it, and what runs that here; Windows is further down.
_MACHINES: dict[str, tuple[str, tuple[str, ...]]] = {
    "x86_64-linux": ("gcc", ()),
    "aarch64-linux": ("aarch64-linux-gnu-gcc", ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu")),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["model", "core", "fmi2"])
def test_a_model_called_as_a_file_of_the_fmu_is_exported(
    name: str, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    """A log whose name makes no name of C gives a model called model: no compiler took it."""
    need("gcc")
    assert exported(models["bingham, single"], "fmu2", tmp_path / "f", name=name)


@pytest.fixture(scope="module")
def fmu3(
    models: dict[str, Model], tmp_path_factory: pytest.TempPathFactory, need: Callable[..., None]
) -> Callable[[str], tuple[ExportedStep, Path]]:
    """The unpacked FMU of a model, with the binaries of all machines, compiled once for all tests."""
    need("gcc")

    @cache
    def make(label: str) -> tuple[ExportedStep, Path]:
        folder = exported(models[label], "fmu3", tmp_path_factory.mktemp("fmu3") / "f")
        with zipfile.ZipFile(folder / "m_fmi3.fmu") as archive:
            archive.extractall(folder / "x")
        return step_of(models[label], ExportOptions(name="m", period=PERIOD)), folder / "x"

    return make


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["exchange", "simulate"])
@pytest.mark.parametrize("label", ["hem+rise-fall, coaxial", "bingham, single"])
@pytest.mark.parametrize("machine", list(_MACHINES))
def test_a_plain_c_host_loads_it(
    machine: str, label: str, kind: str, fmu3: Any, tmp_path: Path, need: Callable[..., None]
) -> None:
    compiler, emulator = _MACHINES[machine]
    need(compiler, *emulator[:1])
    program, place = fmu3(label)
    library = next((place / "binaries" / machine).glob("*.so"))
    _hosted(program, place, library, kind, _by(compiler), emulator)


def _by(compiler: str) -> Callable[[Path, Path], None]:
    """Builds a host with nothing but what a host has: its own declarations of the standard's functions, and dlopen."""

    def build(source: Path, out: Path) -> None:
        subprocess.run(
            [compiler, "-std=c99", "-Wall", "-Werror", str(source), "-o", str(out), "-ldl"],
            check=True,
        )

    return build


def _hosted(
    program: ExportedStep,
    place: Path,
    library: Path,
    kind: str,
    build: Callable[[Path, Path], None],
    runner: Sequence[str],
) -> None:
    """A host in plain C gives what the emulator gives."""
    from xml.etree import ElementTree

    token = ElementTree.parse(place / "modelDescription.xml").getroot().attrib["instantiationToken"]
    host, given, result = (place / name for name in ("host.exe", "rows.bin", "result.bin"))
    build(_HOST, host)
    rows = vectors_of(program).rows[:64]
    rows = rows[np.all(np.isfinite(rows), axis=1)].astype(np.float64)
    given.write_bytes(rows.tobytes())
    words = [str(library), token, kind, str(PERIOD), str(rows.shape[1]), str(given), str(result)]
    subprocess.run([*runner, str(host), *words], check=True, capture_output=True, timeout=300)
    found = np.frombuffer(result.read_bytes()).reshape(-1, 2)
    effort, flags = run(program, rows)
    assert list(found[:, 0]) == list(effort)
    assert list(found[:, 1]) == list(flags)


@pytest.mark.slow
def test_a_broken_cross_compiler_leaves_its_binary_out(
    models: dict[str, Model],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    need: Callable[..., None],
) -> None:
    from erclutch.wings.exporters.fmu import fmu_binaries
    from erclutch.wings.exporters.fmu.fmu_binaries import Builder

    need("gcc")

    def fails(sources: Sequence[Path], out: Path) -> None:
        out.write_bytes(b"half")
        raise ExportError("broken cannot compile", remedy="Mend it")

    found = [
        next(b for b in fmu_binaries.builders(3) if b.needed),
        Builder("x86_64-windows", "dll", "broken", fails),
    ]
    monkeypatch.setattr(fmu_binaries, "builders", lambda version: iter(found))
    folder = exported(models["bingham, single"], "fmu3", tmp_path / "f")
    said = (folder / "binaries.txt").read_text(encoding="utf-8").splitlines()
    assert said[0].startswith("x86_64-linux: by ")
    assert said[1] == "x86_64-windows: left out, broken cannot compile"
    with zipfile.ZipFile(folder / "m_fmi3.fmu") as archive:
        assert {n.split("/")[1] for n in archive.namelist() if n.startswith("binaries/")} == {
            "x86_64-linux"
        }


@pytest.mark.slow
@pytest.mark.parametrize("machine", list(_MACHINES))
def test_zig_builds_libraries_for_other_machines_with_an_empty_cache(
    machine: str,
    fmu3: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    need: Callable[..., None],
) -> None:
    pytest.importorskip("ziglang", reason="pip install ziglang")
    from erclutch.export.c.cross_compiler import Cross

    compiler, emulator = _MACHINES[machine]
    need(compiler, *emulator[:1])
    monkeypatch.setenv("ZIG_GLOBAL_CACHE_DIR", str(tmp_path / "cache"))
    program, place = fmu3("hem+rise-fall, coaxial")
    library = tmp_path / "zig" / "m.so"
    library.parent.mkdir()
    Cross(f"{machine}-gnu").shared(sorted((place / "sources").glob("*.c")), library)
    _hosted(program, place, library, "exchange", _by(compiler), emulator)


def _windows_program(source: Path, out: Path) -> None:
    """As the FMU's library is built: zig's clang and LLD, and the C library that Windows has."""
    zig = zig_command()
    made, libraries = out.with_suffix(".o"), [out.with_name("c.lib"), out.with_name("kernel.lib")]
    names = (
        ("msvcrt", "__getmainargs atof atoi exit fclose fopen fread fwrite puts strcmp"),
        ("kernel32", "LoadLibraryA GetProcAddress"),
    )
    flags = [
        "-target",
        "x86_64-windows-gnu",
        "-std=c99",
        "-O2",
        "-mno-stack-arg-probe",
        "-Wall",
        "-Werror",
    ]
    subprocess.run([*zig, "cc", *flags, "-c", str(source), "-o", str(made)], check=True)
    for library, (dll, functions) in zip(libraries, names, strict=True):
        listed = library.with_suffix(".def")
        listed.write_text("\n".join([f"LIBRARY {dll}.dll", "EXPORTS", *functions.split(), ""]))
        subprocess.run(
            [*zig, "dlltool", "-m", "i386:x86-64", "-d", str(listed), "-l", str(library)],
            check=True,
        )
    options = ["/entry:start", "/subsystem:console", "/nodefaultlib", "/lldmingw", f"/out:{out}"]
    subprocess.run([*zig, "lld-link", *options, str(made), *map(str, libraries)], check=True)


@pytest.fixture(scope="module")
def wine(
    tmp_path_factory: pytest.TempPathFactory, need: Callable[..., None]
) -> Iterator[tuple[str, ...]]:
    """Wine's loader and C library are not Microsoft's, but they load what Windows loads."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PATH", f"{os.environ['PATH']}:/usr/lib/wine")  # where Debian's wine64 is
        need("wine64")
        patch.setenv("WINEPREFIX", str(tmp_path_factory.mktemp("wine")))
        patch.setenv("WINEDEBUG", "-all")
        patch.setenv("WINEDLLOVERRIDES", "mscoree,mshtml,winemenubuilder.exe=")
        yield ("wine64",)
        subprocess.run(["wineserver64", "-k"], check=False)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["exchange", "simulate"])
@pytest.mark.parametrize("label", ["hem+rise-fall, coaxial", "fnn-16, coaxial"])
def test_a_host_on_windows_loads_it(label: str, kind: str, fmu3: Any, wine: Sequence[str]) -> None:
    pytest.importorskip("ziglang", reason="pip install ziglang")
    program, place = fmu3(label)
    _hosted(
        program, place, place / "binaries/x86_64-windows/m_fmi3.dll", kind, _windows_program, wine
    )


@pytest.mark.slow
def test_zig_alone_makes_an_fmu(
    models: dict[str, Model],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    need: Callable[..., None],
) -> None:
    pytest.importorskip("ziglang", reason="pip install ziglang")
    from erclutch.export.c.compilers import Compiler
    from erclutch.wings.exporters.fmu import fmu_binaries

    monkeypatch.setattr(fmu_binaries, "native", lambda: Compiler("zig", ("false",)))
    monkeypatch.setattr(fmu_binaries.shutil, "which", lambda name: None)
    monkeypatch.setenv("ZIG_GLOBAL_CACHE_DIR", str(tmp_path / "cache"))
    folder = exported(models["hem+rise-fall, coaxial"], "fmu3", tmp_path / "f")
    said = (folder / "binaries.txt").read_text(encoding="utf-8").splitlines()
    assert [line.split(": by ")[0] for line in said] == [
        "x86_64-linux",
        "x86_64-windows",
        "aarch64-linux",
    ]
    assert all("by zig" in line for line in said)
    assert all(check.other_bits == 0 for check in verify_export(folder))


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_the_windows_library_exports_the_interface_and_needs_only_windows(
    version: int,
    models: dict[str, Model],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    need: Callable[..., None],
) -> None:
    pytest.importorskip("ziglang", reason="pip install ziglang")
    from erclutch.export.c.cross_compiler import Cross

    need("gcc", "objdump", "nm")
    folder = exported(models["hem+rise-fall, coaxial"], f"fmu{version}", tmp_path / "f")
    with zipfile.ZipFile(folder / f"m_fmi{version}.fmu") as archive:
        archive.extractall(tmp_path / "x")
    sources = sorted((tmp_path / "x" / "sources").glob("*.c"))
    made = [tmp_path / "a" / "m.dll", tmp_path / "b" / "m.dll"]
    for path in made:
        path.parent.mkdir()
        Cross("x86_64-windows-gnu").shared(sources, path)
    assert made[0].read_bytes() == made[1].read_bytes()
    said = subprocess.run(
        ["objdump", "-p", str(made[0])], check=True, capture_output=True, text=True
    ).stdout
    native = next((tmp_path / "x" / "binaries").glob("*linux*/*.so"))
    words = ["nm", "-D", "--defined-only", "--format=just-symbols", str(native)]
    wanted = subprocess.run(words, check=True, capture_output=True, text=True).stdout.split()
    assert len(wanted) > 30
    assert re.findall(r"^\s*\[ *\d+\] (\w+)$", said, re.MULTILINE) == sorted(wanted)
    assert re.findall(r"DLL Name: (\S+)", said) == ["msvcrt.dll"]


@pytest.mark.slow
@pytest.mark.usefixtures("own_machine")
@pytest.mark.parametrize("version", [2, 3])
def test_our_functions_are_the_standards(
    version: int, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    """FMPy brings the official headers: every declared function is there, and defined as it is declared."""
    import fmpy

    need("gcc", "nm")
    official = Path(fmpy.__file__).parent / "c-code"
    with zipfile.ZipFile(
        exported(models["bingham, single"], f"fmu{version}", tmp_path / "f") / f"m_fmi{version}.fmu"
    ) as fmu:
        fmu.extractall(tmp_path / "x")
    sources, made = tmp_path / "x" / "sources", tmp_path / "x.o"

    def compiles(text: str) -> bool:
        (sources / "x.c").write_text(text)
        flags = [
            "-std=c11",
            f"-DERC_FMI{version}_HEADER",
            "-include",
            f"fmi{version}Functions.h",
            f"-I{official}",
        ]
        words = ["gcc", *flags, "-c", str(sources / "x.c"), "-o", str(made)]
        return subprocess.run(words, capture_output=True).returncode == 0

    ours = (sources / f"fmu-fmi{version}.c").read_text()
    assert not compiles(ours.replace("CALL(DoStep)(", "CALL(DoStep)(int more, "))
    assert compiles(ours)
    words = ["nm", "-g", "--defined-only", "--format=just-symbols", str(made)]
    found = set(subprocess.run(words, check=True, capture_output=True, text=True).stdout.split())
    header = (official / f"fmi{version}Functions.h").read_text(encoding="utf-8", errors="replace")
    if version == 2:
        both, _, exchange = header.rpartition("Functions for FMI2 for Model Exchange")
        header = both + exchange.partition("Functions for FMI2 for Co-Simulation")[2]
    declared = set(re.findall(r"_Export fmi\w+TYPE +(\w+);", header))
    assert len(declared) > 30
    assert found == declared


@pytest.mark.slow
def test_units_and_ranges_are_in_the_model_description(fmu3: Any) -> None:
    import fmpy

    program, place = fmu3("hem+rise-fall, coaxial")
    described: Any = fmpy.read_model_description(str(place / "modelDescription.xml"))
    variables = {v.name: v for v in described.modelVariables}
    assert variables["E1"].unit == "V"
    assert (float(variables["E1"].min), float(variables["E1"].max)) == program.field.range
    assert (float(variables["effort"].min), float(variables["effort"].max)) == program.limits
    base = {u.name: u.baseUnit for u in described.unitDefinitions}["N*m"]
    assert (base.kg, base.m, base.s, base.factor) == (1, 2, -2, pytest.approx(1.0, rel=1e-15))


@pytest.mark.slow
def test_fmpys_own_simulation_of_a_static_model_does_not_lag(fmu3: Any) -> None:
    import fmpy

    program, place = fmu3("bingham, single")
    time = np.arange(50) * PERIOD
    rows = np.column_stack([np.full(50, 100.0), 20.0 * np.sin(60.0 * time)])
    names = [("time", float), *((n, float) for n in program.inputs)]
    signals = np.array([(t, *row) for t, row in zip(time, rows, strict=True)], dtype=names)
    found: Any = fmpy.simulate_fmu(
        str(place), fmi_type="ModelExchange", input=signals, output=["effort"], step_size=PERIOD, stop_time=time[-1],
        output_interval=PERIOD,
    )  # fmt: skip
    expected = np.interp(found["time"], time, rows[:, 1])
    effort, _ = run(program, np.column_stack([np.full(expected.size, 100.0), expected]))
    assert np.max(np.abs(found["effort"] - effort)) < 1e-9 * program.scale
    lagged = np.roll(effort, 1)
    assert np.max(np.abs(found["effort"] - lagged)[1:]) > 1e-3 * program.scale


@pytest.mark.slow
def test_a_saved_fmu_state_is_restored(fmu3: Any) -> None:
    import fmpy
    from fmpy.fmi3 import FMU3Slave

    _, place = fmu3("hem+rise-fall, coaxial")
    described: Any = fmpy.read_model_description(str(place / "modelDescription.xml"))
    fmu: Any = FMU3Slave(
        guid=described.guid, unzipDirectory=str(place), modelIdentifier="m_fmi3", instanceName="a"
    )
    fmu.instantiate()
    fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()

    def step(k: int, field: float) -> float:
        fmu.setFloat64([1, 2, 3, 4], [field, 0.0, 12.0, 3.0])
        fmu.doStep(currentCommunicationPoint=k * PERIOD, communicationStepSize=PERIOD)
        return fmu.getFloat64([5])[0]

    step(0, 0.0)
    saved = fmu.getFMUState()
    first = [step(k, 500.0) for k in range(1, 9)]
    fmu.setFMUState(saved)
    assert [step(k, 500.0) for k in range(1, 9)] == first
    assert len(set(first)) > 3
    with pytest.raises(Exception, match="fmi3SetFloat64"):
        fmu.setFloat64([99], [1.0])
    fmu.freeFMUState(saved)
    fmu.terminate()
    fmu.freeInstance()


_FORGER = """
#include <stdio.h>
#include "fmu-fmi{version}.c"
#define OF_STATE_(name) FMI(name)
#define OF_STATE(verb) OF_STATE_(STATE(verb, ))
int main(int count, char **words)
{{
    instance *c = (instance *)calloc(1u, sizeof *c); /* no logger */
    unsigned char good[SEALED], *bytes;
    SAVED saved = NULL;
    uint32_t i, size;
    double effort;
    erc_clear(MEMORY(c));
    for (i = 1u; i <= ERC_INPUTS; i++) {{ erc_set(MEMORY(c), i, 10.0 * i); }}
    erc_advance(MEMORY(c), 5.0 * ERC_PERIOD, 1.0);
    OF_STATE(Get)(c, &saved);
    OF_STATE(Serialize)(c, saved, (FMI(Byte) *)good, sizeof good);
    OF_STATE(Free)(c, &saved);
    if (count == 1) {{ fwrite(good, 1u, sizeof good, stdout); return 0; }}
    while (fread(&size, sizeof size, 1u, stdin) == 1u)
    {{
        bytes = (unsigned char *)malloc(size + (size == 0u)); /* on the heap, so that reading beyond its end is seen */
        if (fread(bytes, 1u, size, stdin) != size) {{ return 2; }}
        if (size == SEALED && words[1][0] == 'f') /* forged: with its seal, but not another number of samples */
        {{
            const size_t times = offsetof(erc_memory, time), end = offsetof(erc_memory, flags);
            memcpy(bytes + times, good + times, end - times);
            const uint64_t seal = erc_seal(bytes);
            memcpy(bytes + sizeof(erc_memory), &seal, sizeof seal);
        }}
        saved = NULL;
        if (OF_STATE(DESERIALIZE)(c, (const FMI(Byte) *)bytes, size, &saved) == FMI(OK))
        {{
            putchar('a');
            OF_STATE(Set)(c, saved);
            erc_advance(MEMORY(c), 9.0 * ERC_PERIOD, 1.0);
            erc_get(MEMORY(c), REF_OUTPUT, &effort);
            OF_STATE(Free)(c, &saved);
        }}
        else {{ putchar('r'); }}
        free(bytes);
    }}
    free(c);
    return 0;
}}
"""


def _mutated(good: bytes, rng: np.random.Generator) -> bytes:
    """A state with a flipped bit, a few other bytes, another length, or nothing left of it."""
    made, kind = bytearray(good), rng.integers(4)
    if kind == 0:
        made[rng.integers(len(made))] ^= 1 << rng.integers(8)
    elif kind == 1:
        at, length = rng.integers(len(made) - 8), rng.integers(1, 9)
        made[at : at + length] = rng.bytes(int(length))
    elif kind == 2:
        del made[int(rng.integers(len(made))) :]
    else:
        made[:] = rng.bytes(len(made))
    return bytes(made)


@pytest.mark.slow
@pytest.mark.usefixtures("own_machine")
@pytest.mark.parametrize("version", [2, 3])
def test_a_damaged_fmu_state_is_refused_and_a_forged_one_breaks_nothing(
    version: int, models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc", "clang")
    folder = exported(models["casson+lag, single"], f"fmu{version}", tmp_path / "f")
    with zipfile.ZipFile(folder / f"m_fmi{version}.fmu") as archive:
        archive.extractall(tmp_path / "x")
    sources, forger = tmp_path / "x" / "sources", str(tmp_path / "forger")
    (sources / "forger.c").write_text(_FORGER.format(version=version), encoding="ascii")
    checks = [
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        "-g",
        "-O1",
        "-ffp-contract=off",
    ]
    subprocess.run(
        ["clang", *checks, str(sources / "forger.c"), str(sources / "m.c"), "-o", forger],
        check=True,
    )
    good = subprocess.run([forger], capture_output=True, check=True).stdout
    rng = np.random.default_rng(18)
    states = [good, *(_mutated(good, rng) for _ in range(10_000))]
    given = b"".join(np.uint32(len(s)).tobytes() + s for s in states)

    def answers(kind: str) -> str:
        done = subprocess.run(
            [forger, kind], input=given, capture_output=True, check=False, timeout=300
        )
        assert done.returncode == 0, done.stderr.decode()
        return done.stdout.decode()

    assert answers("damaged") == "".join("a" if s == good else "r" for s in states)
    assert answers("forged") == "".join("a" if len(s) == len(good) else "r" for s in states)


# --- other -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_mujoco_samples_at_the_models_own_period(
    models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc")
    from erclutch.wings.exporters.targets import mujoco as wrapper

    model = models["hem+rise-fall, coaxial"]
    folder, program = (
        exported(model, "mujoco", tmp_path / "m"),
        step_of(model, ExportOptions(name="m", period=PERIOD)),
    )
    mujoco: Any = pytest.importorskip("mujoco")
    with wrapper._imported(program, folder) as module:
        scene: Any = mujoco.MjModel.from_xml_path(str(folder / "m.xml"))
        scene.opt.timestep = 2 * PERIOD
        with pytest.raises(ValueError, match="longer than the model's period"):
            module.m(scene)
        scene.opt.timestep = PERIOD / 4
        data: Any = mujoco.MjData(scene)
        with module.m(scene) as actuator:
            for _ in range(40):
                mujoco.mj_step(scene, data)
            # Four simulation steps a period: the model is sampled ten times, not forty.
            assert actuator.samples == 10
            mujoco.mj_resetData(scene, data)
            mujoco.mj_step(scene, data)
            assert actuator.samples == 1
    assert list(folder.glob("__pycache__")) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("to", "module"), [("onnx", "onnx"), ("fmu2", "fmpy"), ("mujoco", "mujoco")]
)
def test_a_missing_package_is_named(
    to: str, module: str, models: dict[str, Model], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:

    monkeypatch.setitem(sys.modules, module, None)
    program = step_of(models["bingham, single"], ExportOptions(name="m", period=PERIOD))
    does = target(to).value.write if to == "onnx" else lambda *a: list(target(to).value.verify(*a))
    with pytest.raises(ExportError, match=f"{module} is not installed") as caught:
        does(program, tmp_path)
    assert "pip install" in str(caught.value)


def test_no_compiler_is_said(
    models: dict[str, Model], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from erclutch.export.c import compilers

    monkeypatch.setattr(compilers, "natives", lambda: ())
    with pytest.raises(ExportError, match="no C compiler is found"):
        exported(models["bingham, single"], "fmu3", tmp_path / "f")
    assert list(tmp_path.iterdir()) == []


# --- C++ in its build systems ----------------------------------------------------------------------------------------

_USER = """#include <cstdio>
#include "m/m.hpp"

int main() {
    m_model::M device;
    const auto out = device.step({500.0, 0.0, 20.0, 3.0});
    std::printf("%a %u\\n", out.effort, static_cast<unsigned>(out.flags));
}
"""
_ROS_PACKAGE = """<?xml version="1.0"?>
<package format="3"><name>user</name><version>0.0.1</version><description>Uses the model</description>
<maintainer email="nobody@example.com">nobody</maintainer><license>Apache-2.0</license>
<buildtool_depend>ament_cmake</buildtool_depend><depend>m</depend>
<export><build_type>ament_cmake</build_type></export></package>
"""
_ROS_CMAKE = """cmake_minimum_required(VERSION 3.16)
project(user CXX)
find_package(ament_cmake REQUIRED)
find_package(m REQUIRED)
add_executable(user user.cpp)
ament_target_dependencies(user m)
install(TARGETS user DESTINATION lib/user)
ament_package()
"""
_PLAIN_CMAKE = """cmake_minimum_required(VERSION 3.16)
project(user CXX)
enable_testing()
add_subdirectory(m)
add_executable(user user.cpp)
target_link_libraries(user m)
"""


def _in_system(words: Sequence[str], folder: Path) -> str:
    """Output of a system's tool that must not find this test's Python."""
    clean = {"PATH": "/usr/bin:/bin", "HOME": str(folder)}
    done = subprocess.run(words, cwd=folder, env=clean, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _workspace(model: Model, folder: Path, cmake: str) -> tuple[Path, str]:
    """A model's package under a user's, and what the user's program must print."""
    folder.mkdir(parents=True)
    exported(model, "cpp", folder / "m")
    (folder / "user.cpp").write_text(_USER)
    (folder / "CMakeLists.txt").write_text(cmake)
    program = step_of(model, ExportOptions(name="m", period=PERIOD))
    effort, flags = run(program, np.array([[500.0, 0.0, 20.0, 3.0]]))
    return folder, f"{float(effort[0]).hex()} {int(flags[0])}"


def _printed(text: str) -> str:
    effort, flags = text.split()
    return f"{float.fromhex(effort).hex()} {flags}"


@pytest.mark.slow
def test_plain_cmake_takes_it_as_a_folder(
    models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("g++", "cmake")
    folder, expected = _workspace(models["hem+rise-fall, coaxial"], tmp_path / "w", _PLAIN_CMAKE)
    _in_system(["cmake", "-S", ".", "-B", "build"], folder)
    _in_system(["cmake", "--build", "build"], folder)
    assert "100% tests passed, 0 tests failed out of 1" in _in_system(
        ["ctest", "--test-dir", "build"], folder
    )
    assert _printed(_in_system(["build/user"], folder)) == expected


@pytest.mark.slow
def test_ros_2_builds_it_as_a_package(
    models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    """colcon and ament_cmake, as ROS 2 has them."""
    need("g++", "cmake", "colcon")
    folder, expected = _workspace(models["hem+rise-fall, coaxial"], tmp_path / "w", _ROS_CMAKE)
    source = folder / "src" / "user"
    source.mkdir(parents=True)
    (source / "package.xml").write_text(_ROS_PACKAGE)
    for name in ("user.cpp", "CMakeLists.txt"):
        (folder / name).rename(source / name)
    (folder / "m").rename(folder / "src" / "m")
    assert re.findall(r"Finished <<< (\w+)", _in_system(["colcon", "build"], folder)) == [
        "m",
        "user",
    ]
    _in_system(["colcon", "test"], folder)
    assert "1 test, 0 errors, 0 failures, 0 skipped" in _in_system(
        ["colcon", "test-result", "--all"], folder
    )
    assert _printed(_in_system(["install/user/lib/user/user"], folder)) == expected
