"""The clang and the LLD in zig (PyPI: ziglang) build shared libraries for other machines.

`zig cc` would first compile its own C library for each machine, which takes minutes. A model's library needs seven
functions of C's library and each machine brings them, so clang compiles, and LLD links against a list of their names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from erclutch.export.c.compilers import EXACT, run, zig_command

#: msvcrt.dll is part of every Windows.
_WINDOWS_C = ("calloc", "free", "malloc", "memcpy", "memset", "strcmp", "strncpy")


@dataclass(frozen=True)
class Cross:
    """zig as a compiler of shared libraries for another machine.

    Attributes:
        target: zig's name of the machine.
    """

    target: str

    @property
    def name(self) -> str:
        """For people."""
        return f"zig for {self.target}"

    def shared(self, sources: Sequence[Path], out: Path) -> None:
        """Compile and link; intermediate files stay in the library's folder.

        Raises:
            ExportError: zig failed; its first words are in the message.
        """
        objects = [out.parent / f"{source.stem}.o" for source in sources]
        machine = ("-mno-stack-arg-probe",) if self._windows else ("-fPIC", "-fvisibility=hidden")
        compiler = [*zig_command(), "cc", "-target", self.target, *EXACT, "-O2", *machine]
        for source, compiled in zip(sources, objects, strict=True):
            self._run([*compiler, "-c", str(source), "-o", str(compiled)], f"compile {source.name}")
        if self._windows:
            self._link_dll(objects, out)
        else:
            # The names that stay open are those of the C library of the program that loads this one.
            linker = [*zig_command(), "ld.lld", "-shared", "-s"]
            self._run([*linker, *map(str, objects), "-o", str(out)], f"link {out.name}")

    @property
    def _windows(self) -> bool:
        return "windows" in self.target

    def _link_dll(self, objects: Sequence[Path], out: Path) -> None:
        """Link a DLL against the functions of Windows' own C library."""
        names = out.parent / "msvcrt.def"
        library = out.parent / "msvcrt.lib"
        lines = ["LIBRARY msvcrt.dll", "EXPORTS", *_WINDOWS_C, ""]
        names.write_text("\n".join(lines), encoding="ascii")
        words = [
            *zig_command(),
            "dlltool",
            "-m",
            "i386:x86-64",
            "-d",
            str(names),
            "-l",
            str(library),
        ]
        self._run(words, "list C's functions")
        # /Brepro: no date inside, so the same model gives the same bytes.
        options = ["/dll", "/noentry", "/nodefaultlib", "/lldmingw", "/Brepro", f"/out:{out}"]
        self._run(
            [*zig_command(), "lld-link", *options, *map(str, objects), str(library)],
            f"link {out.name}",
        )

    def _run(self, words: Sequence[str], what: str) -> None:
        run(words, f"{self.name} cannot {what}", "Mend or remove that compiler")
