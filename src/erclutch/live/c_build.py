"""Machine code for this machine: the loop and its core, compiled once with the user's compiler and kept in a cache.

A compiler is ``$CC``, cc, gcc, clang, or the one in the package ``ziglang`` (the extra ``compiler``).
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from erclutch.errors import ErclutchError

SOURCES = Path(__file__).parent / "c"
#: No -ffast-math, ever: it would delete the guards against NaN.
FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion")
#: Only what has no input or output: for tests, accelerated runs and comparison.
CORE = ("erc_core.c", "erc_sensors.c", "erc_control.c", "erc_interlock.c", "erc_packet.c")
_SECONDS = 120.0


class CompilerError(ErclutchError):
    """There is no compiler, or it failed."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: the words that start it, and what it says of itself."""

    command: tuple[str, ...]
    version: str


def find_compiler() -> Compiler | None:
    """The first compiler that answers; None where there is none."""
    candidates = [shlex.split(os.environ["CC"])] if os.environ.get("CC") else []
    candidates += [[name] for name in ("cc", "gcc", "clang") if shutil.which(name)]
    if importlib.util.find_spec("ziglang") is not None:
        candidates.append([sys.executable, "-m", "ziglang", "cc"])
    for command in candidates:
        try:
            said = subprocess.run([*command, "--version"], capture_output=True, text=True, timeout=30, check=True)
        except (OSError, subprocess.SubprocessError):
            continue
        return Compiler(tuple(command), said.stdout.splitlines()[0] if said.stdout else command[0])
    return None


def cache_folder() -> Path:
    """Where compiled files are kept: ``$ERCLUTCH_CACHE``, or ``erclutch`` in the user's cache folder."""
    given = os.environ.get("ERCLUTCH_CACHE")
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "erclutch"


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
    if chosen is None:
        raise CompilerError(
            "no C compiler", remedy="Install one (Debian, Ubuntu: apt install gcc), or pip install 'erclutch[compiler]'"
        )
    options = [*FLAGS, *flags, *(("-shared", "-fPIC") if shared else ())]
    headers = sorted({h for s in sources for h in s.parent.glob("*.h")})
    parts = [chosen.version, *chosen.command, *options, *libraries]
    digest = hashlib.sha256("\0".join(parts).encode())
    for file in (*sources, *headers):
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    target = cache_folder() / digest.hexdigest()[:24] / name
    if not whole(target):
        _compile(chosen, [*options, *(str(s) for s in sources)], list(libraries), target)
    return target


def note_whole(made: Path) -> Path:
    """Write a compiled file's digest beside it; returns where."""
    note = made.with_name(f"{made.name}.sha256")
    note.write_text(hashlib.sha256(made.read_bytes()).hexdigest(), encoding="ascii")
    return note


def whole(target: Path) -> bool:
    """Whether a compiled file is there as it was written; a damaged one is made again, never loaded."""
    try:
        noted = target.with_name(f"{target.name}.sha256").read_text(encoding="ascii")
        return hashlib.sha256(target.read_bytes()).hexdigest() == noted
    except (OSError, ValueError):
        return False


def _compile(compiler: Compiler, words: list[str], libraries: list[str], target: Path) -> None:
    """Into a folder beside, then renamed: two that compile at once do not meet."""
    try:
        target.parent.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".building-", dir=target.parent.parent) as folder:
            made = Path(folder) / target.name
            said = subprocess.run(
                [*compiler.command, *words, "-o", str(made), *libraries],
                capture_output=True,
                text=True,
                timeout=_SECONDS,
            )
            if said.returncode or not made.exists():
                raise CompilerError(
                    f"{' '.join(compiler.command)} failed: {said.stderr.strip()[-800:] or said.returncode}",
                    where=target.name,
                    remedy="Set CC to another compiler, or pip install 'erclutch[compiler]'",
                )
            target.parent.mkdir(exist_ok=True)
            note = note_whole(made)
            os.replace(made, target)
            os.replace(note, target.with_name(note.name))
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CompilerError(
            f"cannot compile: {error}", where=str(target.parent), remedy="Set ERCLUTCH_CACHE to a folder for it"
        ) from error


def loop_program(compiler: Compiler | None = None) -> Path:
    """The loop, ready to run."""
    return build("erclutch-loop", sorted(SOURCES.glob("*.c")), libraries=("-lm", "-ldl"), compiler=compiler)


def core_library(compiler: Compiler | None = None) -> Path:
    """The loop's core as a library."""
    return build("liberclutch-core.so", [SOURCES / name for name in CORE], shared=True, compiler=compiler)
