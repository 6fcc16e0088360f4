"""Target c: the C99 file, its header, test vectors with a tiny main, a Makefile."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.boards import BOARDS, run_board
from erclutch.export.c_source import header, source
from erclutch.export.check import Check, compare
from erclutch.export.compilers import STRICT, Compiler, foreign, natives, run
from erclutch.export.program import Program
from erclutch.export.vectors import Vectors, vectors_of

TITLE = "one C99 file with its header, test vectors and make check"
_LEVELS = ("-O0", "-O2", "-O3")


def write(program: Program, folder: Path) -> None:
    """All files of the target."""
    write_core(program, folder)
    texts = {
        f"{program.name}_vectors.h": vectors_header(program, vectors_of(program)),
        f"{program.name}_check.c": check_source(program),
        "Makefile": makefile(program),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii", errors="replace")


def write_core(program: Program, folder: Path) -> list[Path]:
    """The .c and .h alone, for other targets; returns the files to compile."""
    (folder / f"{program.name}.c").write_text(source(program), encoding="ascii", errors="replace")
    (folder / f"{program.name}.h").write_text(header(program), encoding="ascii", errors="replace")
    return [folder / f"{program.name}.c"]


# --- test bench ------------------------------------------------------------------------------------------------------


def _words(program: Program, values: NDArray[Any]) -> list[str]:
    """Numbers as their bits."""
    digits = program.precision.width // 4
    held = np.asarray(values, program.precision.dtype)
    # One NaN stands for all: what a calculation makes of it is not looked at.
    return [f"0x{int(b):0{digits}x}{program.precision.bits_suffix}" for b in held.view(program.precision.bits).ravel()]


def _rows(program: Program, name: str, values: NDArray[Any]) -> str:
    words, width = _words(program, values), values.shape[1]
    rows = ["{" + ", ".join(words[i : i + width]) + "}" for i in range(0, len(words), width)]
    return (
        f"static const {program.precision.c_bits} {name}[{len(rows)}][{width}] = {{\n    "
        + ",\n    ".join(rows)
        + "\n};"
    )


def _flags(name: str, values: NDArray[np.uint32]) -> str:
    words = [f"{int(v)}u" for v in values]
    lines = [", ".join(words[i : i + 20]) for i in range(0, len(words), 20)]
    return f"static const uint32_t {name}[{len(words)}] = {{\n    " + ",\n    ".join(lines) + "\n};"


def vectors_header(program: Program, vectors: Vectors) -> str:
    """The vectors as tables of bits."""
    n, p = program.name, program.precision
    steps = np.column_stack([vectors.rows, vectors.effort, vectors.numpy.astype(p.dtype)])
    fields = np.column_stack([vectors.speeds, vectors.wanted, vectors.field])
    return f"""/* Test vectors of {n}, model {program.digest}.
   All numbers are bits of {p.c_type}, so that NaN and infinities fit and every compiler reads the same. */
#ifndef {n.upper()}_VECTORS_H
#define {n.upper()}_VECTORS_H

#include <stdint.h>

#define STEPS {len(steps)}u
#define FIELDS {len(fields)}u
/* One unit in the last place of the largest training effort. */
#define ULP {float(np.spacing(p.dtype.type(program.scale))):.17g}

/* Successive steps from a reset: inputs, effort to the bit, effort of NumPy in float64. */
{_rows(program, "steps", steps)}

{_flags("step_flags", vectors.flags)}

/* Inverse: inputs, wanted effort, field to the bit. */
{_rows(program, "fields", fields)}

{_flags("field_flags", vectors.field_flags)}

#endif
"""


def check_source(program: Program) -> str:
    """The tiny main. With PRINT defined it prints every result instead, for erclutch verify."""
    n, p = program.name, program.precision
    digits = p.width // 4
    form = "PRIx32" if p.width == 32 else "PRIx64"
    return f"""/* Checks {n} on this machine: make check. Exit code 0 if every bit is as expected. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "{n}.h"
#include "{n}_vectors.h"

typedef {p.c_bits} word;

static {n}_real number(word bits)
{{
    {n}_real x;
    memcpy(&x, &bits, sizeof x);
    return x;
}}

static word bits_of({n}_real x)
{{
    word bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}}

static int is_same({n}_real x, word expected, uint32_t flags, uint32_t expected_flags)
{{
#ifdef PRINT
    printf("%0{digits}" {form} " %" PRIu32 "\\n", bits_of(x), flags);
#endif
    return bits_of(x) == expected && flags == expected_flags;
}}

{_main(n)}"""


def _main(n: str) -> str:
    return f"""int main(void)
{{
    static {n}_state state;
    unsigned bad_steps = 0u;
    unsigned bad_fields = 0u;
    double largest = 0.0;
    unsigned i;
    unsigned j;
    {n}_reset(&state);
    for (i = 0u; i < STEPS; i++)
    {{
        {n}_real input[{n.upper()}_INPUTS];
        {n}_real effort;
        double difference;
        uint32_t flags;
        for (j = 0u; j < {n.upper()}_INPUTS; j++)
        {{
            input[j] = number(steps[i][j]);
        }}
        flags = {n}_step(&state, input, &effort);
        bad_steps += is_same(effort, steps[i][{n.upper()}_INPUTS], flags, step_flags[i]) ? 0u : 1u;
        difference = (double)effort - (double)number(steps[i][{n.upper()}_INPUTS + 1u]);
        difference = difference < 0.0 ? -difference : difference;
        largest = difference > largest ? difference : largest;
    }}
    for (i = 0u; i < FIELDS; i++)
    {{
        {n}_real input[{n.upper()}_INPUTS];
        {n}_real field;
        uint32_t flags;
        for (j = 0u; j < {n.upper()}_INPUTS; j++)
        {{
            input[j] = number(fields[i][j]);
        }}
        flags = {n}_inverse(input, number(fields[i][{n.upper()}_INPUTS]), &field);
        bad_fields += is_same(field, fields[i][{n.upper()}_INPUTS + 1u], flags, field_flags[i]) ? 0u : 1u;
    }}
#ifndef PRINT
    printf("{n}: %u steps, %u not to the bit; %u inverses, %u not to the bit; largest difference from NumPy %.3g ulp "
           "of the largest effort\\n",
           STEPS, bad_steps, FIELDS, bad_fields, largest / ULP);
#endif
    return (bad_steps == 0u && bad_fields == 0u) ? 0 : 1;
}}
"""


def makefile(program: Program) -> str:
    """The Makefile."""
    n = program.name
    return f"""# make check: compile {n} and its test vectors, and compare every bit.
# -ffp-contract=off keeps products and sums apart (no fused multiply-add), so that all processors give the same bits.

CC ?= cc
CFLAGS ?= -O2
EXACT = -std=c99 -ffp-contract=off
WARN = {" ".join(STRICT)}

.PHONY: check
check: {n}_check
\t./{n}_check

{n}_check: {n}_check.c {n}.c {n}.h {n}_vectors.h
\t$(CC) $(CFLAGS) $(EXACT) $(WARN) {n}_check.c {n}.c -o $@

.PHONY: clean
clean:
\trm -f {n}_check
"""


# --- verify ----------------------------------------------------------------------------------------------------------


def verify(program: Program, folder: Path) -> Iterator[Check]:
    """The vectors under every compiler and emulator of this machine."""
    vectors = vectors_of(program)
    if not natives() and not foreign():
        raise ExportError("no C compiler is found", where=str(folder), remedy="Install one, for example gcc")
    with tempfile.TemporaryDirectory() as work:
        for compiler in natives():
            for level in _LEVELS:
                yield compare(
                    program,
                    vectors,
                    f"{compiler.name} {level}",
                    run_check(compiler, folder, Path(work), program, level),
                )
        for compiler in foreign():
            printed = run_check(compiler, folder, Path(work), program, "-O2")
            yield compare(program, vectors, f"{compiler.name} (QEMU)", printed)
        for board in BOARDS:
            if board.here():
                outcome = run_board(board, program, folder, Path(work))
                yield compare(program, vectors, f"{board.name} (QEMU)", outcome.printed, outcome.note)


def run_check(compiler: Compiler, folder: Path, work: Path, program: Program, *flags: str) -> str:
    """What the tiny main prints of its results."""
    sources: Sequence[Path] = [folder / f"{program.name}_check.c", folder / f"{program.name}.c"]
    static = ("-static",) if compiler.runner else ()
    compiler.build(sources, work / "check", "-DPRINT", *flags, *static)
    # The tiny main's exit code says whether its own expectations were met; here the printed bits are compared.
    words = [*compiler.runner, str(work / "check")]
    return run(words, f"the check compiled by {compiler.name} did not pass", "Export the model again")
