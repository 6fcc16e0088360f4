"""Target c writes the C99 file, its header, test vectors with a tiny main, and a Makefile."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.c.c_header import header
from erclutch.export.c.c_printer import table
from erclutch.export.c.c_source import source
from erclutch.export.c.compilers import STRICT, Compiler, foreign, natives, run
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_vectors import Vectors, vectors_of
from erclutch.export.target_check import Check, compare
from erclutch.files import scratch_folder

TITLE = "one C99 file with its header, test vectors and make check"
ALARMS = True
_LEVELS = ("-O0", "-O2", "-O3")


def write(step: ExportedStep, folder: Path) -> None:
    """All files of the target."""
    write_core(step, folder)
    write_bench(step, folder)


def write_bench(step: ExportedStep, folder: Path) -> None:
    """The test vectors, their tiny main, the Makefile."""
    texts = {
        f"{step.name}_vectors.h": vectors_header(step, vectors_of(step)),
        f"{step.name}_check.c": check_source(step),
        "Makefile": makefile(step),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii")


def write_core(step: ExportedStep, folder: Path) -> list[Path]:
    """The .c and .h alone, for other targets; returns the files to compile."""
    (folder / f"{step.name}.c").write_text(source(step), encoding="ascii")
    (folder / f"{step.name}.h").write_text(header(step), encoding="ascii")
    return [folder / f"{step.name}.c"]


# --- test bench ------------------------------------------------------------------------------------------------------


def rows_of_bits(step: ExportedStep, name: str, values: NDArray[Any]) -> str:
    """Rows of numbers as a table of their bits."""
    p = step.precision
    digits = p.width // 4
    # One NaN stands for all: what a calculation makes of it is not looked at.
    rows: list[str] = []
    for row in np.asarray(values, p.dtype).view(p.bits):
        words = [f"0x{int(bits):0{digits}x}{p.bits_suffix}" for bits in row]
        rows.append(f"{{{', '.join(words)}}}")
    return table(p.c_bits, name, rows, 1, f"[{values.shape[1]}]")


def vectors_header(step: ExportedStep, vectors: Vectors) -> str:
    """The vectors as tables of bits."""
    n = step.name
    p = step.precision
    by_numpy = vectors.numpy.astype(p.dtype)
    steps = np.column_stack([vectors.rows, vectors.effort, by_numpy])
    fields = np.column_stack([vectors.speeds, vectors.wanted, vectors.field])
    ahead = np.column_stack([vectors.wanted_now, vectors.field_now])
    band = ""
    if step.alarms is not None:
        band = f"\n/* The band behind each step: low, high. */\n{rows_of_bits(step, 'band', vectors.band)}"
    return f"""/* Test vectors of {n}, model {step.digest}.
   All numbers are bits of {p.c_type}, so that NaN and infinities fit and every compiler reads the same. */
#ifndef {n.upper()}_VECTORS_H
#define {n.upper()}_VECTORS_H

#include <stdint.h>

#define STEPS {len(steps)}u
#define FIELDS {len(fields)}u
#define AHEAD {len(ahead)}u
/* One unit in the last place of the largest training effort. */
#define ULP {float(np.spacing(p.dtype.type(step.scale))):.17g}

/* Successive steps from a reset: inputs, effort to the bit, effort of NumPy in float64. */
{rows_of_bits(step, "steps", steps)}
{table("uint32_t", "step_flags", [f"{flag}u" for flag in vectors.flags], 20)}
/* Inverse: inputs, wanted effort, field to the bit. */
{rows_of_bits(step, "fields", fields)}
{table("uint32_t", "field_flags", [f"{flag}u" for flag in vectors.field_flags], 20)}
/* Inverse of the next step, ahead of each of the first steps: wanted effort, field to the bit. */
{rows_of_bits(step, "ahead", ahead)}
{table("uint32_t", "ahead_flags", [f"{flag}u" for flag in vectors.field_now_flags], 20)}{band}
#endif
"""


def bit_functions(step: ExportedStep) -> str:
    """C that turns bits into a number, and a number into bits."""
    n = step.name
    p = step.precision
    return f"""typedef {p.c_bits} word;

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

"""


def check_source(step: ExportedStep) -> str:
    """The tiny main. With PRINT defined it prints every result instead, for erclutch verify."""
    n = step.name
    p = step.precision
    digits = p.width // 4
    form = "PRIx32" if p.width == 32 else "PRIx64"
    return f"""/* Checks {n} on this machine: make check. Exit code 0 if every bit is as expected. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "{n}.h"
#include "{n}_vectors.h"

{bit_functions(step)}static int is_same({n}_real x, word expected, uint32_t flags, uint32_t expected_flags)
{{
#ifdef PRINT
    printf("%0{digits}" {form} " %" PRIu32 "\\n", bits_of(x), flags);
#endif
    return bits_of(x) == expected && flags == expected_flags;
}}

static void load({n}_real input[{n.upper()}_INPUTS], const word row[{n.upper()}_INPUTS])
{{
    unsigned j;
    for (j = 0u; j < {n.upper()}_INPUTS; j++)
    {{
        input[j] = number(row[j]);
    }}
}}

int main(void)
{{
    static {n}_state state;
    {n}_real input[{n.upper()}_INPUTS];
    unsigned bad_steps = 0u;
    unsigned bad_fields = 0u;
    double largest = 0.0;
    unsigned i;
    if ({n}_reset(&state) != 0u)
    {{
        (void)fputs("{n}: the compiler's options changed the arithmetic\\n", stderr);
        return 2;
    }}
    for (i = 0u; i < STEPS; i++)
    {{
        {n}_real effort;
        double difference;
        uint32_t flags;
        load(input, steps[i]);
        flags = {n}_step(&state, input, &effort);
        bad_steps += is_same(effort, steps[i][{n.upper()}_INPUTS], flags, step_flags[i]) ? 0u : 1u;
        difference = (double)effort - (double)number(steps[i][{n.upper()}_INPUTS + 1u]);
        difference = difference < 0.0 ? -difference : difference;
        largest = difference > largest ? difference : largest;
    }}
    for (i = 0u; i < FIELDS; i++)
    {{
        {n}_real field;
        uint32_t flags;
        load(input, fields[i]);
        flags = {n}_inverse(input, number(fields[i][{n.upper()}_INPUTS]), &field);
        bad_fields += is_same(field, fields[i][{n.upper()}_INPUTS + 1u], flags, field_flags[i]) ? 0u : 1u;
    }}
    (void){n}_reset(&state);
    for (i = 0u; i < AHEAD; i++)
    {{
        {n}_real found;
        uint32_t flags;
        load(input, steps[i]);
        flags = {n}_inverse_now(&state, input, number(ahead[i][0]), &found);
        bad_fields += is_same(found, ahead[i][1], flags, ahead_flags[i]) ? 0u : 1u;
        (void){n}_step(&state, input, &found);
    }}{_BAND.format(n=n) if step.alarms else ""}
#ifndef PRINT
    printf("{n}: %u steps, %u not to the bit; %u inverses, %u not to the bit; largest difference from NumPy %.3g ulp "
           "of the largest effort\\n",
           STEPS, bad_steps, FIELDS + AHEAD, bad_fields, largest / ULP);
#endif
    return (bad_steps == 0u && bad_fields == 0u) ? 0 : 1;
}}
"""


#: What a tiny main does more of a step with alarms.
_BAND = """
    (void){n}_reset(&state);
    for (i = 0u; i < STEPS; i++)
    {{
        {n}_real effort;
        load(input, steps[i]);
        (void){n}_step(&state, input, &effort);
        bad_steps += is_same(state.low, band[i][0], 0u, 0u) ? 0u : 1u;
        bad_steps += is_same(state.high, band[i][1], 0u, 0u) ? 0u : 1u;
    }}"""


def makefile(step: ExportedStep) -> str:
    """The Makefile."""
    n = step.name
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


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The vectors under every compiler and emulator of this machine."""
    with scratch_folder() as work:
        yield from verify_in(Path(work), step, folder)


def verify_in(work: Path, step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The same, in a folder that may hold objects of `compile_model` already."""
    vectors = vectors_of(step)
    if not natives() and not foreign():
        raise ExportError(
            "no C compiler is found", where=str(folder), remedy="Install one, for example gcc"
        )
    for compiler in natives():
        for level in _LEVELS:
            printed = run_check(compiler, folder, work, step, level)
            yield compare(step, vectors, f"{compiler.name} {level}", printed)
    for compiler in foreign():
        printed = run_check(compiler, folder, work, step, "-O2")
        yield compare(step, vectors, f"{compiler.name} (QEMU)", printed)


def run_check(
    compiler: Compiler,
    folder: Path,
    work: Path,
    step: ExportedStep,
    level: str,
) -> str:
    """What the tiny main prints of its results."""
    bench = work / f"{compiler.name}.o"
    if not bench.is_file():  # the same at every level, and quickest with few optimisations
        compiler.build([folder / f"{step.name}_check.c"], bench, "-DPRINT", "-O1", "-c")
    static = ("-static",) if compiler.runner else ()
    compiled = _object_in(work, compiler, level)
    model = compiled if compiled.is_file() else folder / f"{step.name}.c"
    compiler.build([model, bench], work / "check", level, *static)
    # The tiny main's exit code says whether its own expectations were met; here the printed bits are compared.
    words = [*compiler.runner, str(work / "check")]
    return run(
        words, f"the check compiled by {compiler.name} did not pass", "Export the model again"
    )


def compile_model(
    compiler: Compiler,
    folder: Path,
    work: Path,
    step: ExportedStep,
    level: str,
) -> Path:
    """The exported file as an object, for more programs than the tiny main: most of a compiler's time goes into it."""
    made = _object_in(work, compiler, level)
    compiler.build([folder / f"{step.name}.c"], made, level, "-c")
    return made


def _object_in(work: Path, compiler: Compiler, level: str) -> Path:
    return work / f"{compiler.name}{level}.o"
