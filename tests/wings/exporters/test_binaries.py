"""Which compiler makes which binary of an FMU, and with which words zig is called; no compiler runs."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest

from erclutch.errors import ExportError
from erclutch.export.c import cross_compiler
from erclutch.export.c.compilers import EXACT, Compiler, zig_command
from erclutch.export.c.cross_compiler import Cross
from erclutch.wings.exporters.fmu import fmu_binaries
from erclutch.wings.exporters.fmu.fmu_binaries import (
    Builder,
    build_binaries,
    builders,
    check_binary,
)


@pytest.fixture
def linux(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A PC with Linux and gcc, without zig and cross compilers."""
    monkeypatch.setattr(fmu_binaries.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(fmu_binaries.sys, "platform", "linux")
    monkeypatch.setattr(fmu_binaries, "native", lambda: Compiler("gcc", ("gcc",)))
    monkeypatch.setattr(fmu_binaries.shutil, "which", lambda name: None)
    monkeypatch.setattr(fmu_binaries.importlib.util, "find_spec", lambda name: None)
    return monkeypatch


def made_by(version: int) -> list[tuple[str, str, str, bool]]:
    return [(b.folder, b.suffix, b.name, b.needed) for b in builders(version)]


@pytest.mark.parametrize(("version", "own"), [(2, "linux64"), (3, "x86_64-linux")])
def test_this_machines_binary_is_made_by_its_own_compiler(
    linux: pytest.MonkeyPatch, version: int, own: str
) -> None:
    assert made_by(version) == [(own, "so", "gcc", True)]
    linux.setattr(fmu_binaries, "native", lambda: Compiler("zig", ("zig",)))
    (builder,) = builders(version)
    assert getattr(builder.shared, "__self__", None) == Cross("x86_64-linux-gnu")


def test_other_machines_get_a_cross_compiler_or_zig(linux: pytest.MonkeyPatch) -> None:
    linux.setattr(
        fmu_binaries.shutil,
        "which",
        lambda name: name if name == "x86_64-w64-mingw32-gcc" else None,
    )
    windows = ("x86_64-windows", "dll", "x86_64-w64-mingw32-gcc", False)
    assert made_by(3)[1:] == [windows]
    linux.setattr(fmu_binaries.importlib.util, "find_spec", lambda name: name == "ziglang" or None)
    assert made_by(3)[1:] == [windows, ("aarch64-linux", "so", "zig for aarch64-linux-gnu", False)]
    assert made_by(2)[1:] == [("win64", *windows[1:])]
    linux.setattr(fmu_binaries.platform, "machine", lambda: "riscv64")
    assert [needed for *_, needed in made_by(3)] == [False, False, False]


def test_a_binary_stands_alone_in_its_folder(linux: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def shared(sources: Sequence[Path], out: Path) -> None:
        out.write_bytes(b"made")
        out.with_suffix(".o").write_bytes(b"left over")

    linux.setattr(
        fmu_binaries,
        "builders",
        lambda version: iter([Builder("a", "so", "one", shared, needed=True)]),
    )
    assert build_binaries(3, [], "m", tmp_path) == ["a: by one"]
    assert [p.relative_to(tmp_path).as_posix() for p in sorted(tmp_path.rglob("*"))] == [
        "a",
        "a/m.so",
    ]

    def fails(sources: Sequence[Path], out: Path) -> None:
        raise ExportError("no way", remedy="Mend it")

    for needed in (False, True):
        builder = Builder("b", "so", "two", fails, needed=needed)
        linux.setattr(fmu_binaries, "builders", lambda version, builder=builder: iter([builder]))
        if needed:
            with pytest.raises(ExportError, match="no way"):
                build_binaries(3, [], "m", tmp_path / "other")
        else:
            assert build_binaries(3, [], "m", tmp_path) == ["b: left out, no way"]
            assert not (tmp_path / "b").exists()


@pytest.mark.usefixtures("linux")
def test_a_binary_for_this_machine_must_be_there(tmp_path: Path) -> None:
    path = tmp_path / "m.fmu"
    for version, there in ((2, "binaries/linux64/m.so"), (3, "binaries/x86_64-linux/m.so")):
        for name in (there, "binaries/win64/m.dll"):
            with zipfile.ZipFile(path, "w") as archive:
                archive.writestr(name, b"")
            if name == there:
                check_binary(version, path)
            else:
                with pytest.raises(ExportError, match="no binary for this machine"):
                    check_binary(version, path)


def zigs_words(target: str, folder: Path, patch: pytest.MonkeyPatch) -> list[list[str]]:
    called: list[list[str]] = []
    patch.setattr(cross_compiler, "run", lambda words, *_: called.append(list(words)))
    Cross(target).shared([Path("a.c"), Path("b.c")], folder / "m.so")
    return [
        [word.replace(str(folder), "OUT") for word in words[len(zig_command()) :]]
        for words in called
    ]


def test_zigs_words_for_linux(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = ["-target", "aarch64-linux-gnu", *EXACT, "-O2", "-fPIC", "-fvisibility=hidden"]
    compiled = [["cc", *machine, "-c", f"{name}.c", "-o", f"OUT/{name}.o"] for name in "ab"]
    linked = ["ld.lld", "-shared", "-s", "OUT/a.o", "OUT/b.o", "-o", "OUT/m.so"]
    assert zigs_words("aarch64-linux-gnu", tmp_path, monkeypatch) == [*compiled, linked]
    assert "-ffp-contract=off" in EXACT


def test_zigs_words_for_windows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    *compiled, listed, linked = zigs_words("x86_64-windows-gnu", tmp_path, monkeypatch)
    assert all("-mno-stack-arg-probe" in words and "-fPIC" not in words for words in compiled)
    assert listed == [
        "dlltool",
        "-m",
        "i386:x86-64",
        "-d",
        "OUT/msvcrt.def",
        "-l",
        "OUT/msvcrt.lib",
    ]
    assert (tmp_path / "msvcrt.def").read_text().startswith("LIBRARY msvcrt.dll\nEXPORTS\n")
    options = ["/dll", "/noentry", "/nodefaultlib", "/lldmingw", "/Brepro", "/out:OUT/m.so"]
    assert linked == ["lld-link", *options, "OUT/a.o", "OUT/b.o", "OUT/msvcrt.lib"]
