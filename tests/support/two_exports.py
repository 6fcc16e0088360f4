"""Two exports in one program of C or C++: separate files, or all in one file, as a unity build joins them."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from erclutch.export.c.compilers import EXACT
from erclutch.export.exported_step import ExportedStep

WARNED = ("-O1", "-Wall", "-Wextra", "-Werror")


class Built(NamedTuple):
    """What a program printed, and what its compiler said where it refused."""

    printed: str
    refused: str


def include_of(header: Path) -> str:
    """A line that includes a header."""
    return f'#include "{header}"'


def main_of(body: Sequence[str]) -> str:
    """The main function of a program."""
    lines = "\n".join(body)
    return f"#include <stdio.h>\nint main(void)\n{{\n{lines}\nreturn 0;\n}}\n"


def effort_of(step: ExportedStep, row: Sequence[float]) -> str:
    """C that prints the effort of the first row after a reset, to the bit."""
    n, given = step.name, ", ".join(map(repr, row))
    return f"""{{
    static {n}_state state;
    {n}_real effort, input[{n.upper()}_INPUTS] = {{{given}}};
    (void){n}_reset(&state);
    (void){n}_step(&state, input, &effort);
    printf("%a\\n", (double)effort);
}}"""


def program(
    folder: Path,
    sources: Sequence[Path],
    headers: Sequence[Path],
    body: Sequence[str],
    *,
    one_file: bool,
) -> Built:
    """Compile and run a program that includes the headers; with ``one_file`` it includes the sources themselves."""
    main = folder / "main.c"
    main.write_text("\n".join([*map(include_of, sources if one_file else headers), main_of(body)]))
    files = [main] if one_file else [main, *sources]
    words = ["gcc", *EXACT, *WARNED, *map(str, files), "-o", str(folder / "main")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode:
        return Built("", done.stderr)
    return Built(subprocess.check_output([str(folder / "main")], text=True), "")
