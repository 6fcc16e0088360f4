"""The loop and its core are compiled for this machine once, with the user's compiler, and kept in a cache.

A compiler is ``$CC``, gcc, clang, cc, or the one in the package ``ziglang``, which the extra ``live`` brings.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from erclutch.errors import ErclutchError, ExportError
from erclutch.export.c.compilers import Compiler, natives, run, shared_flags
from erclutch.files import cache_folder, scratch_folder

SOURCES = Path(__file__).parent / "c"
#: No -ffast-math, ever: it would delete the guards against NaN.
FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion")
#: Only what has no input or output: for tests, accelerated runs and comparison.
_PARTS = (
    "core",
    "config",
    "sensors",
    "turned",
    "plausible",
    "control",
    "torque",
    "inverse",
    "interlock",
    "packet",
)
CORE = tuple(f"erc_{part}.c" for part in _PARTS)


class CompilerError(ErclutchError):
    """There is no compiler, or it failed."""


def find_compiler() -> Compiler:
    """The first compiler that answers.

    Raises:
        CompilerError: there is none.
    """
    for compiler in natives():
        if _version(compiler):
            return compiler
    raise CompilerError("there is no C compiler", remedy='Get one: pip install "erclutch[live]"')


@cache
def _version(compiler: Compiler) -> str:
    """What a compiler says of itself; empty where it does not answer."""
    try:
        return run([*compiler.command, "--version"], "", "", patience=30.0) or compiler.name
    except ExportError:
        return ""


def build(
    name: str,
    sources: Sequence[Path],
    *,
    shared: bool = False,
    libraries: Sequence[str] = ("-lm",),
    flags: Sequence[str] = (),
    compiler: Compiler | None = None,
) -> Path:
    """Compile, unless the same sources were compiled by the same compiler before.

    Args:
        name: of the program or library.
        sources: C files; headers beside them count as well.
        shared: a library instead of a program.
        libraries: linker options.
        flags: further options.
        compiler: None takes `find_compiler`.

    Raises:
        CompilerError: none is there, it failed, or the cache cannot be written.
    """
    chosen = compiler or find_compiler()
    options = [*FLAGS, *chosen.flags, *flags]
    if shared:
        options += shared_flags(Path(name))
    folders = {source.parent for source in sources}
    headers = sorted(header for folder in folders for header in folder.glob("*.h"))
    parts = [_version(chosen), *chosen.command, *options, *libraries]
    digest = hashlib.sha256("\0".join(parts).encode())
    for file in (*sources, *headers):
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    target = cache_folder() / digest.hexdigest()[:24] / name
    words = [*chosen.command, *options, *map(str, sources)]

    def compiled(folder: Path) -> Path:
        made = folder / name
        problem = f"{' '.join(chosen.command)} failed"
        remedy = 'Set CC to another compiler, or pip install "erclutch[live]", which brings one'
        try:
            run([*words, "-o", str(made), *libraries], problem, remedy)
        except ExportError as error:
            raise CompilerError(error.problem, where=name, remedy=error.remedy) from error
        return made

    return cached(target, compiled)


def cached(target: Path, make: Callable[[Path], Path]) -> Path:
    """A compiled file of the cache, with its digest beside it; a damaged one is made again, never loaded.

    Args:
        target: the file.
        make: makes it in a folder, and returns it. It is renamed then: two that compile at once do not meet.

    Raises:
        CompilerError: the cache cannot be written.
    """
    try:
        kept_digest = _digest_of(target).read_text(encoding="ascii")
        if hashlib.sha256(target.read_bytes()).hexdigest() == kept_digest:
            return target
    except (OSError, ValueError):
        pass  # it is not there, or not whole
    try:
        target.parent.parent.mkdir(parents=True, exist_ok=True)
        with scratch_folder(".building-", target.parent) as folder:
            made = make(Path(folder))
            target.parent.mkdir(exist_ok=True)
            note = _digest_of(made)
            digest = hashlib.sha256(made.read_bytes()).hexdigest()
            note.write_text(digest, encoding="ascii")
            os.replace(made, target)
            os.replace(note, _digest_of(target))
    except OSError as error:
        raise CompilerError(
            f"cannot compile: {error}",
            where=str(target.parent),
            remedy="Set ERCLUTCH_CACHE to a folder for it",
        ) from error
    return target


def _digest_of(made: Path) -> Path:
    return made.with_name(f"{made.name}.sha256")


def loop_program(compiler: Compiler | None = None) -> Path:
    """The loop, ready to run."""
    sources = sorted(SOURCES.glob("*.c"))
    return build("erclutch-loop", sources, libraries=("-lm", "-ldl"), compiler=compiler)


def core_library(compiler: Compiler | None = None) -> Path:
    """The loop's core as a library."""
    sources = [SOURCES / name for name in CORE]
    return build("liberclutch-core.so", sources, shared=True, compiler=compiler)


@cache
def loaded_core() -> ctypes.CDLL:
    """The library of `core_library`, looked up and loaded once a process."""
    return ctypes.CDLL(str(core_library()))
