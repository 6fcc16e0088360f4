"""This module finds the C compilers and emulators of this machine and runs them with limits."""

from __future__ import annotations

import errno
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from erclutch.errors import ExportError
from erclutch.files import scratch_folder

#: What makes every compiler give the same bits.
EXACT = ("-std=c99", "-ffp-contract=off")
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror")


def shared_flags(library: Path) -> tuple[str, ...]:
    """What makes a compiler link a shared library instead of a program.

    With the options of fast-math, which a wrapper in CC may add, gcc and clang put a start file into a library for
    Linux. The file switches subnormal numbers off in each process that loads the library. Plain C needs no start file.
    """
    if library.suffix == ".dll":
        return ("-shared",)
    if library.suffix == ".so":
        return ("-shared", "-fPIC", "-nostartfiles")
    return ("-shared", "-fPIC")


@dataclass(frozen=True)
class Compiler:
    """A C compiler.

    Attributes:
        name: for people: gcc, clang, zig.
        command: how to call it.
        runner: what runs its programs here; empty for this machine's own.
        flags: that it needs besides.
    """

    name: str
    command: tuple[str, ...]
    runner: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()

    def build(self, sources: Sequence[Path], out: Path, *flags: str) -> None:
        """Compile and link.

        Raises:
            ExportError: the compiler failed; its first words are in the message.
        """
        options = [*EXACT, *self.flags, *flags]
        words = [*self.command, *options, *map(str, sources), "-o", str(out)]
        run(
            words,
            f"{self.name} cannot compile {sources[0].name}",
            "Use another compiler, or set CC to one",
        )


def run(
    words: Sequence[str],
    problem: str,
    remedy: str,
    *,
    patience: float = 120.0,
) -> str:
    """Standard output of a program.

    Raises:
        ExportError: it could not start, failed, or took too long.
    """
    try:
        # A compiler that is ended with this program leaves its own temporary files: they go with this folder.
        with scratch_folder() as folder:
            done = subprocess.run(
                words,
                capture_output=True,
                text=True,
                timeout=patience,
                stdin=subprocess.DEVNULL,
                errors="replace",
                env={**os.environ, "TMPDIR": folder},
            )
    except subprocess.TimeoutExpired as error:
        raise ExportError(f"{problem}: no end after {patience:g} s", remedy=remedy) from error
    except OSError as error:
        raise ExportError(f"{problem}: {error.strerror or error}", remedy=remedy) from error
    if done.returncode:
        words_of_it = (done.stderr or done.stdout).strip()[:600]
        if os.strerror(errno.ENOSPC) in words_of_it:  # no other compiler would help
            remedy = "Make room on that disk, or give another place"
        raise ExportError(f"{problem} (exit {done.returncode}): {words_of_it}", remedy=remedy)
    return done.stdout


def zig_command() -> tuple[str, ...]:
    """The command that runs zig out of its package: its binary, else a Python that starts it, in 25 ms more."""
    zig = importlib.util.find_spec("ziglang")
    places: list[str] = getattr(zig, "submodule_search_locations", None) or []
    binaries = [Path(place, name) for place in places for name in ("zig", "zig.exe")]
    there = next((binary for binary in binaries if binary.is_file()), None)
    if there is None:
        return (sys.executable, "-P", "-m", "ziglang")
    return (str(there),)


@cache
def natives() -> tuple[Compiler, ...]:
    """Compilers for this machine, the one of CC first."""
    compilers: list[Compiler] = []
    chosen = os.environ.get("CC", "").split()
    if chosen and shutil.which(chosen[0]):
        compilers.append(Compiler(Path(chosen[0]).name, tuple(chosen)))
    for name in ("gcc", "clang", "cc"):
        known = any(compiler.name == name for compiler in compilers)
        # cc is as a rule another name of a compiler that is there already.
        another_name = name == "cc" and bool(compilers)
        if shutil.which(name) and not known and not another_name:
            compilers.append(Compiler(name, (name,)))
    if importlib.util.find_spec("ziglang") is not None:
        # Without the flag its code is for this very processor, and a cache or a folder may be another one's, too.
        compilers.append(Compiler("zig", (*zig_command(), "cc"), flags=("-mcpu=baseline",)))
    return tuple(compilers)


def native() -> Compiler:
    """The compiler for this machine.

    Raises:
        ExportError: there is none.
    """
    if not natives():
        raise ExportError(
            "no C compiler is found",
            remedy="Install one (Debian, Ubuntu: apt install gcc libc6-dev; anywhere: pip install ziglang), or set CC",
        )
    return natives()[0]


@cache
def foreign() -> tuple[Compiler, ...]:
    """Compilers for other processors whose programs an emulator runs here."""
    known = (
        ("arm64", "aarch64-linux-gnu-gcc", "qemu-aarch64", "/usr/aarch64-linux-gnu"),
        ("big-endian PowerPC", "powerpc-linux-gnu-gcc", "qemu-ppc", "/usr/powerpc-linux-gnu"),
    )
    return tuple(
        Compiler(name, (compiler,), (emulator, "-L", libraries))
        for name, compiler, emulator, libraries in known
        if shutil.which(compiler) and shutil.which(emulator)
    )


@cache
def cpp_compilers() -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Name and command of each C++ compiler of this machine."""
    here = [name for name in ("g++", "clang++") if shutil.which(name)]
    installed = tuple((name, (name,)) for name in here)
    if installed:
        return installed
    zig = importlib.util.find_spec("ziglang") is not None
    return (("zig", (*zig_command(), "c++")),) if zig else ()
