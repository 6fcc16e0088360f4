"""The C itself: warnings, MISRA, sanitizers under fuzzed input, speed of the export, and what stands in the files."""

from __future__ import annotations

import gc
import re
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.export import ExportOptions, export_model, step_of
from erclutch.export.c.c_header import header
from erclutch.export.c.compilers import EXACT, STRICT
from erclutch.export.c.model_abi import wrapper
from erclutch.export.step_numbers import inverse, run
from erclutch.export.targets.c import write_core
from erclutch.models.model import Model

pytestmark = pytest.mark.slow

#: Advisory rules of MISRA C:2012 that the file does not keep; docs/export.md says why. Required ones: none.
ADVISORY = {
    "misra-c2012-2.5",
    "misra-c2012-8.9",
    "misra-c2012-12.1",
    "misra-c2012-15.5",
    "misra-c2012-19.2",
}


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_no_warning(
    models: dict[str, Model], compiler: str, tmp_path: Path, need: Callable[..., None]
) -> None:
    need(compiler)
    more = ("-Wshadow", "-Wcast-qual", "-Wstrict-prototypes", "-Wfloat-equal", "-Wdouble-promotion")
    for i, model in enumerate(models.values()):
        options = ExportOptions(
            f"m{i}", "float32" if i % 2 else "float64", 1e-3, "angles" if i % 3 == 0 else "speeds"
        )
        program = step_of(model, options)
        files = write_core(program, tmp_path)
        (tmp_path / f"m{i}_abi.c").write_text(wrapper(program), encoding="ascii")
        for source in (*files, tmp_path / f"m{i}_abi.c"):
            command = [
                compiler,
                *EXACT,
                *STRICT,
                *more,
                "-c",
                str(source),
                "-o",
                str(tmp_path / "m.o"),
            ]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("label", ["hem+rise-fall, coaxial", "casson+lag, single"])
def test_the_example_in_the_header_compiles_and_runs(
    models: dict[str, Model], label: str, tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc")
    program = step_of(models[label], ExportOptions("m", "float32", 1e-3))
    (source,) = write_core(program, tmp_path)
    said = (tmp_path / "m.h").read_text()
    assert said.count("SPDX-License-Identifier: Apache-2.0") == 1
    example = re.findall(
        r"^       (.+;)$", said.partition("Example: ")[2].partition("*/")[0], re.MULTILINE
    )
    assert len(example) == 7
    calls = "\n".join([*example, 'printf("%u %d\\n", (unsigned)flags, effort > 0.0f);'])
    (tmp_path / "main.c").write_text(
        f'#include <stdio.h>\n#include "m.h"\nint main(void)\n{{\n{calls}\nreturn 0;\n}}\n'
    )
    command = [
        "gcc",
        *EXACT,
        *STRICT,
        str(source),
        str(tmp_path / "main.c"),
        "-o",
        str(tmp_path / "example"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert subprocess.check_output([str(tmp_path / "example")], text=True) == "0 1\n"


@pytest.mark.parametrize(
    "label", ["hem+rise-fall, coaxial", "fnn-7, coaxial", "casson+lag, single"]
)
def test_no_required_rule_of_misra_is_broken(
    models: dict[str, Model], label: str, tmp_path: Path, need: Callable[..., None]
) -> None:
    need("cppcheck")
    program = step_of(models[label], ExportOptions("m", "float32", 1e-3, "angles"))
    write_core(program, tmp_path)
    # incorrectLogicOperator: cppcheck takes the hexadecimal limits -0x1.8p-1 and 0x1.8p-1 for the same number.
    words = ["cppcheck", "--std=c99", "--addon=misra", "--enable=warning,portability", "-q"]
    words += [
        "--suppress=incorrectLogicOperator",
        "--suppress=missingIncludeSystem",
        str(tmp_path / "m.c"),
    ]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stderr
    found = set(re.findall(r"\[([\w.-]+)\]$", said, re.MULTILINE))
    assert "misra-c2012-19.2" in found, "the addon ran"
    assert found <= ADVISORY, said


_FUZZ = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "m.h"
static unsigned long long seed = 88172645463325252ULL;
static unsigned long long next(void) {{ seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17; return seed; }}
static m_real any(void)
{{
    m_real x;
    unsigned long long u = next();
    memcpy(&x, &u, sizeof x);
    return (next() & 3u) ? x : (m_real)((double)(next() % 2000001u) / 1000.0 - 1000.0);
}}
int main(void)
{{
    m_state *state = malloc(sizeof *state); /* on the heap, so that a step beyond its end is seen */
    long i;
    (void)m_reset(state);
    for (i = 0; i < {count}; i++)
    {{
        m_real *in = malloc(sizeof *in * M_INPUTS);
        m_real out;
        unsigned k;
        for (k = 0; k < M_INPUTS; k++) {{ in[k] = any(); }}
        (void)m_step(state, in, &out);
        if (!(out - out == 0)) {{ printf("not finite\\n"); return 1; }}
        (void)m_steady(in, &out);
        if (!(out - out == 0)) {{ printf("not finite\\n"); return 1; }}
        if (i % 16 == 0)
        {{
            (void)m_inverse(in, any(), &out);
            if (!(out - out == 0)) {{ printf("not finite\\n"); return 1; }}
            (void)m_inverse_now(state, in, any(), &out);
            if (!(out - out == 0)) {{ printf("not finite\\n"); return 1; }}
        }}
        if (i % 97 == 0) /* memory that nobody has reset, or that somebody has forged */
        {{
            for (k = 0; k < sizeof *state; k++) {{ ((unsigned char *)state)[k] = (unsigned char)next(); }}
            (void)m_inverse_now(state, in, any(), &out);
            (void)m_step(state, in, &out);
            (void)m_inverse_now(state, in, any(), &out);
            (void)m_reset(state);
        }}
        free(in);
    }}
    free(state);
    return 0;
}}
"""


def test_sanitizers_find_nothing_under_any_input(
    model: Model, tmp_path: Path, need: Callable[..., None]
) -> None:
    need("clang")
    precision = "float64" if len(model.name) % 2 else "float32"
    program = step_of(
        model, ExportOptions("m", precision, 1e-3, "angles" if "lag" in model.name else "speeds")
    )  # type: ignore[arg-type]
    files = write_core(program, tmp_path)
    (tmp_path / "fuzz.c").write_text(_FUZZ.format(count=20_000), encoding="ascii")
    checks = "-fsanitize=address,undefined,float-cast-overflow,unsigned-integer-overflow"
    # Unsigned sums wrap by definition; these do so on purpose where the exponent's bits are put together.
    allowed = "-fno-sanitize=unsigned-integer-overflow"
    command = [
        "clang",
        *EXACT,
        "-g",
        "-O1",
        checks,
        allowed,
        "-fno-sanitize-recover=all",
        "-I",
        str(tmp_path),
    ]
    command += [str(tmp_path / "fuzz.c"), *map(str, files), "-o", str(tmp_path / "fuzz")]
    subprocess.run(command, check=True, capture_output=True)
    done = subprocess.run(
        [str(tmp_path / "fuzz")], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_header_says_that_a_log_had_no_field_and_rounds_the_period(
    models: dict[str, Model],
) -> None:
    """A joint without a field got "0 .. 0, held within 0 .. 0", and a clock of ROS "every 0.00999999916 s"."""
    model: Any = models["casson+lag, single"]
    still = replace(model, trained_on=replace(model.trained_on, field=(0.0, 0.0)))
    text = header(step_of(still, ExportOptions("m", period=0.00999999916)))
    assert "no field in the log: leave it 0" in text
    assert "Call the step every 0.01 s" in text


def test_the_file_says_what_it_is(models: dict[str, Model], tmp_path: Path) -> None:
    model = models["hem+rise-fall, coaxial"]
    folder = export_model(model, tmp_path / "out", options=ExportOptions("clutch", "float32"))
    header = (folder / "clutch.h").read_text(encoding="ascii")
    source = (folder / "clutch.c").read_text(encoding="ascii")
    digest = model.to_dict()["digest"]
    for words in (
        digest,
        "E1",
        "rad/s",
        "trained on",
        "additions",
        "error analysis allows",
        "Call the step every 0.001 s",
    ):
        assert words in header
    assert "expm1" not in header
    assert "effort = " in source
    assert "T_y_1" in source
    # A model with a memory has NULL, of a header that needs no library.
    assert re.findall(r"#include <(.*)>", header + source) == ["stdint.h", "stddef.h"]
    assert not re.search(
        r"\b(malloc|static (?!const|clutch_real clutch|uint32_t clutch|void clutch)\w+ \w+;)",
        source,
    )
    # Whole numbers and hexadecimal floats only: nothing for a compiler to round its own way.
    code = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
    assert {
        n
        for n in re.findall(r"(?<![\w.])\d+\.\d+(?:e[-+]?\d+)?f?", code)
        if float(n.rstrip("f")) % 1
    } <= {"0.5f"}


def test_the_abi_of_the_live_loop(
    models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc")
    from erclutch.export.targets.python import build, load

    program = step_of(models["hem+rise-fall, coaxial"], ExportOptions("m"))
    library = build(program, tmp_path)
    model = load(library)  # through ctypes alone, as any program does that knows the ABI
    rows = np.array([[100.0, 0.0, 12.0, 3.0], [np.nan, 0.0, 12.0, 3.0], [300.0, 200.0, 12.0, 99.0]])
    effort, flags = run(program, rows)
    assert [model.step(*row) for row in rows.tolist()] == effort.tolist()
    assert model.flags == flags[-1] == 1 | 4
    assert model.digest == program.digest
    field, _ = inverse(program, rows[:1], np.array([0.2]))
    assert model.inverse(rows[0].tolist(), 0.2) == field[0]
    names = subprocess.run(
        ["nm", "-D", "--undefined-only", str(library)], capture_output=True, text=True, check=True
    )
    wanted = {
        line.split()[-1].split("@")[0]
        for line in names.stdout.splitlines()
        if " w " not in f" {line} "
    }
    assert not {n for n in wanted if not n.startswith(("_", "mem"))}, "no libm, nothing of Python"


def test_steady_is_the_step_at_rest(models: dict[str, Model], need: Callable[..., None]) -> None:
    need("gcc")
    from erclutch.export.targets.python import compile_model

    program = step_of(models["hem+rise-fall, coaxial"], ExportOptions("m"))
    model = compile_model(program)
    row = (300.0, 0.0, 12.0, 3.0)
    for _ in range(400):
        effort = model.step(*row)
    assert model.steady(row) == pytest.approx(effort, rel=1e-12)
    step = compile_model(program).step  # outlives its model
    gc.collect()
    assert np.isfinite([step(*row) for _ in range(1000)]).all()
    with pytest.raises(TypeError, match="one number an input"):
        model.step(1.0)
    with pytest.raises(TypeError):
        model.step("a", 0.0, 0.0, 0.0)
