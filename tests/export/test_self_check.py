"""Options of compilers that change arithmetic: the exported C gives the right bits, or it refuses."""

from __future__ import annotations

import math
import re
import subprocess
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path

import pytest

from erclutch.errors import ExportError
from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compilers import Compiler, natives
from erclutch.export.targets import c, python
from erclutch.models.model import Model

#: What the tiny main of an export returns.
RIGHT, WRONG, REFUSED = 0, 1, 2

#: Options that change arithmetic, alone and in the company that makes them work.
OPTIONS = (
    "-Ofast",
    "-O0 -ffast-math",
    "-O2 -ffast-math",
    "-O2 -ffast-math -fno-finite-math-only",
    "-O3 -ffast-math -fno-finite-math-only -march=haswell",
    "-O0 -ffast-math -fno-finite-math-only",
    "-O2 -ffast-math -fno-associative-math",
    "-O2 -ffast-math -fno-reciprocal-math -fno-finite-math-only",
    "-O2 -ffast-math -fno-unsafe-math-optimizations -fno-finite-math-only",
    "-O2 -funsafe-math-optimizations",
    "-O3 -funsafe-math-optimizations -march=haswell",
    "-O2 -fassociative-math",
    "-O2 -fassociative-math -fno-signed-zeros -fno-trapping-math",
    "-O3 -fassociative-math -fno-signed-zeros -fno-trapping-math -march=haswell",
    "-O2 -freciprocal-math",
    "-O2 -ffinite-math-only",
    "-O2 -fno-signed-zeros",
    "-O2 -fno-signed-zeros -fno-trapping-math",
    "-O2 -frounding-math",
    "-O2 -fno-trapping-math",
    "-O2 -fno-math-errno",
    "-O2 -mfma -ffp-contract=fast",
    "-O3 -mfma -ffp-contract=fast",
    "-O2 -mfma -ffp-contract=on",
    "-O3 -march=haswell -std=gnu99 -ffp-contract=fast",
    "-O2 -mfpmath=387",
    "-O2 -mfpmath=both",
    "-O2 -mfpmath=387 -fexcess-precision=fast",
    "-O2 -fexcess-precision=fast",
    "-O2 -ffloat-store",
    "-O2 -fsingle-precision-constant",
    "-O2 -mrecip",
    "-O2 -mpc32",
    "-O2 -mpc64",
    "-O2 -mdaz-ftz",
    "-O2 -fcx-limited-range",
    "-O2 -ffp-model=fast",
    "-O2 -ffp-model=aggressive",
    "-O2 -ffp-model=fast -mfma",
    "-O2 -fapprox-func",
    "-O2 -fdenormal-fp-math=preserve-sign",
    "-O2 -ffp-eval-method=extended",
    "-O2 -ffp-eval-method=double",
    "-O2 -fno-honor-nans -fno-honor-infinities",
)
#: Laws with tanh and power, networks, stages; a compiler that does not know an option refuses, too.
MODELS = ("bingham, single", "herschel-bulkley, single", "fnn-3+rise-fall, single", "rbfn-13+lag, single")


def written(model: Model, folder: Path, precision: str = "float64") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    c.write(step_of(model, ExportOptions(name="m", precision=precision, period=1e-3)), folder)  # type: ignore[arg-type]
    return folder


def answer(compiler: Compiler, folder: Path, options: Sequence[str]) -> int:
    """Of the tiny main, all of it compiled with the options; a compiler's error is a refusal."""
    # The options stand last: they take back what the Makefile asks for.
    command = [*compiler.command, "-std=c99", "-ffp-contract=off", *compiler.flags, *options]
    built = subprocess.run(
        [*command, folder / "m_check.c", folder / "m.c", "-o", folder / "check"], capture_output=True, check=False
    )
    if built.returncode:
        return REFUSED
    return subprocess.run([folder / "check"], capture_output=True, check=False).returncode


def without_macros_and_pragmas(folder: Path) -> None:
    """The C as a compiler sees it that has none of these macros and pragmas; all have that of finite numbers."""
    source = folder / "m.c"
    text = source.read_text("ascii")
    text, refusals = re.subn(r"#if(?![^\n]*FINITE)[^\n]*\n#error[^\n]*\n#endif\n", "", text)
    text, pragmas = re.subn(r"#pragma [^\n]*\n", "", text)
    assert (refusals, pragmas) == (2, 3)
    source.write_text(text, "ascii")


@pytest.mark.slow
def test_parts_of_fast_math_are_refused_when_compiled(
    models: dict[str, Model], need: Callable[..., None], tmp_path: Path
) -> None:
    need("gcc")
    gcc, folder = Compiler("gcc", ("gcc",)), written(models["bingham, single"], tmp_path)
    assert answer(gcc, folder, ["-O2"]) == RIGHT
    options = ["-O2", "-ffast-math", "-fno-finite-math-only"]
    assert answer(gcc, folder, options) == REFUSED
    without_macros_and_pragmas(folder)
    assert answer(gcc, folder, ["-O2"]) == RIGHT
    assert answer(gcc, folder, options) == REFUSED


@pytest.mark.slow
def test_nothing_comes_out_of_arithmetic_that_was_changed(
    models: dict[str, Model], need: Callable[..., None], tmp_path: Path
) -> None:
    """Whoever does not look at what the reset returns gets efforts and fields of 0, each with a flag."""
    need("gcc")
    folder = written(models["casson+lag, single"], tmp_path)
    without_macros_and_pragmas(folder)
    (folder / "main.c").write_text(
        """#include <stdio.h>
#include "m.h"
int main(void)
{
    m_state state;
    m_real input[M_INPUTS] = {0.9, 3.0}, effort = 1.0, field = 1.0;
    unsigned i, flags = 255u, reset = m_reset(&state);
    for (i = 0u; i < 20u; i++) { flags &= m_step(&state, input, &effort); }
    printf("%u %g %u ", reset, effort, flags);
    flags = m_steady(input, &effort);
    printf("%g %u ", effort, flags);
    flags = m_inverse(input, 0.1, &field);
    printf("%g %u ", field, flags);
    flags = m_inverse_now(&state, input, 0.1, &field);
    printf("%g %u\\n", field, flags);
    return 0;
}
""",
        "ascii",
    )
    for options, said in (
        (["-ffp-contract=off"], None),
        (["-mfma", "-ffp-contract=fast"], "256 0 2 0 2 0 2 0 2"),
        (["-funsafe-math-optimizations"], "256 0 2 0 2 0 2 0 2"),
    ):
        command = ["gcc", "-std=c99", "-O2", *options, "main.c", "m.c", "-o", "main"]
        subprocess.run(command, cwd=folder, check=True)
        printed = subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout.strip()
        assert printed == said if said else printed.startswith("0 ") and " 2" not in printed


def test_a_library_with_changed_arithmetic_is_not_loaded(
    models: dict[str, Model], need: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compilers of CC: the command's own options come first, so a wrapper adds these behind them."""
    need("gcc")
    step = step_of(models["bingham, single"], ExportOptions(name="m"))
    wrapper = tmp_path / "cc"
    wrapper.write_text('#!/bin/sh\nexec gcc "$@" -ffast-math -fno-finite-math-only\n')
    wrapper.chmod(0o755)
    with pytest.raises(ExportError, match="changes the numbers of this file"):
        python.build(step, tmp_path, Compiler("cc", (str(wrapper),)))
    monkeypatch.setattr("erclutch.export.c.c_source.COMPILE_TIME", "")
    c.source.cache_clear()
    try:
        library = python.build(step, tmp_path, Compiler("cc", (str(wrapper),)))
    finally:
        c.source.cache_clear()
    with pytest.raises(ExportError, match="changed the order or the rounding of its sums and products"):
        python.load(library)
    smallest = math.ulp(0.0)
    assert smallest * 1.0 > 0.0, "the library switched subnormal numbers off in this process"


@pytest.fixture(scope="module")
def exports(models: dict[str, Model], tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[bool, str, str], Path]:
    """Folders by whether the C has its macros and pragmas, by model and by precision; written once for all options."""
    folders: dict[tuple[bool, str, str], Path] = {}
    for guarded, label, precision in product((True, False), MODELS, ("float64", "float32")):
        folder = written(models[label], tmp_path_factory.mktemp("m"), precision)
        if not guarded:
            without_macros_and_pragmas(folder)
        folders[guarded, label, precision] = folder
    return folders


@pytest.mark.slow
@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("guarded", [True, False], ids=["guarded", "old compiler"])
def test_the_right_bits_or_a_refusal(
    exports: dict[tuple[bool, str, str], Path], options: str, guarded: bool, need: Callable[..., None]
) -> None:
    need("gcc")
    for label, precision in product(MODELS, ("float64", "float32")):
        folder = exports[guarded, label, precision]
        for compiler in natives():
            assert answer(compiler, folder, options.split()) in (RIGHT, REFUSED), (compiler.name, label, precision)
