"""An FMU holds a binary for each machine for which a compiler is found."""

from __future__ import annotations

import importlib.util
import platform
import shutil
import sys
import zipfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from erclutch.errors import ExportError
from erclutch.export.c.compilers import EXACT, Compiler, native, run, shared_flags
from erclutch.export.c.cross_compiler import Cross


@dataclass(frozen=True)
class Platform:
    """A machine that an FMU may carry a binary for.

    Attributes:
        folder2, folder3: its folder in binaries/ by FMI 2.0 (None: that version knows no such machine) and 3.0.
        suffix: of a shared library.
        machine: platform.machine() and sys.platform where it is this one.
        gcc: name of a cross compiler.
        zig: target of zig.
    """

    folder2: str | None
    folder3: str
    suffix: str
    machine: tuple[str, str]
    gcc: str
    zig: str

    def folder(self, version: int) -> str | None:
        """Its folder in binaries/."""
        return self.folder2 if version == 2 else self.folder3


PLATFORMS = (
    Platform(
        "linux64",
        "x86_64-linux",
        "so",
        ("x86_64", "linux"),
        "x86_64-linux-gnu-gcc",
        "x86_64-linux-gnu",
    ),
    Platform(
        "win64",
        "x86_64-windows",
        "dll",
        ("AMD64", "win32"),
        "x86_64-w64-mingw32-gcc",
        "x86_64-windows-gnu",
    ),
    Platform(
        None,
        "aarch64-linux",
        "so",
        ("aarch64", "linux"),
        "aarch64-linux-gnu-gcc",
        "aarch64-linux-gnu",
    ),
)


@dataclass(frozen=True)
class Builder:
    """How the binary of a machine is made.

    Attributes:
        folder: of the machine in binaries/.
        suffix: of a shared library there.
        name: of the compiler.
        shared: compiles sources to a shared library.
        needed: the FMU is of no use here without it.
    """

    folder: str
    suffix: str
    name: str
    shared: Callable[[Sequence[Path], Path], None]
    needed: bool = False


def _here(version: int) -> str | None:
    """The folder in binaries/ of this machine."""
    machine = (platform.machine(), sys.platform)
    return next((known.folder(version) for known in PLATFORMS if known.machine == machine), None)


def builders(version: int) -> Iterator[Builder]:
    """This machine's own compiler, and for each other one a cross compiler, or zig from PyPI."""
    zig = importlib.util.find_spec("ziglang") is not None
    for known in PLATFORMS:
        folder = known.folder(version)
        cross = Cross(known.zig)
        if folder is None:
            continue
        if folder == _here(version):
            own = cross.shared if native().name == "zig" else partial(_shared, native())
            yield Builder(folder, known.suffix, native().name, own, needed=True)
        elif shutil.which(known.gcc):
            compiler = Compiler(known.gcc, (known.gcc,))
            yield Builder(folder, known.suffix, known.gcc, partial(_shared, compiler))
        elif zig:
            yield Builder(folder, known.suffix, cross.name, cross.shared)


def _shared(compiler: Compiler, sources: Sequence[Path], out: Path) -> None:
    flags = [*EXACT, *compiler.flags, "-O2", "-fvisibility=hidden", *shared_flags(out)]
    words = [*compiler.command, *flags, *map(str, sources), "-o", str(out)]
    run(
        words,
        f"{compiler.name} cannot compile the FMU's binary",
        "Mend or remove that compiler",
        patience=600.0,
    )


def build_binaries(
    version: int,
    sources: Sequence[Path],
    name: str,
    binaries: Path,
) -> list[str]:
    """Compile for every machine, side by side, and say what came of it.

    Raises:
        ExportError: the compiler for this machine failed. One for another machine that fails leaves its binary out.
    """

    def build(builder: Builder) -> str:
        place = binaries / builder.folder
        place.mkdir(parents=True)
        out = place / f"{name}.{builder.suffix}"
        try:
            builder.shared(sources, out)
        except ExportError as error:
            if builder.needed:
                raise
            shutil.rmtree(place)
            return f"{builder.folder}: left out, {' '.join(error.problem.split())}"
        # Debugging data and import libraries stay out: they are large and name folders of this machine.
        for other in place.iterdir():
            if other != out:
                other.unlink()
        return f"{builder.folder}: by {builder.name}"

    with ThreadPoolExecutor() as pool:
        return list(pool.map(build, builders(version)))


def check_binary(version: int, path: Path) -> None:
    """Whether there is a binary for this machine.

    Raises:
        ExportError: there is none.
    """
    folder = _here(version)
    with zipfile.ZipFile(path) as archive:
        names: Sequence[str] = archive.namelist()
    if folder is None or not any(name.startswith(f"binaries/{folder}/") for name in names):
        raise ExportError(
            "has no binary for this machine",
            where=str(path),
            remedy="Export it again on this machine",
        )
