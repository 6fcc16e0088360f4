"""Options of compilers that change arithmetic: the exported C gives the right bits, or it refuses."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Callable
from itertools import product
from pathlib import Path

import pytest

from erclutch.errors import ExportError
from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compilers import Compiler, natives
from erclutch.export.targets import c, python
from erclutch.models.model import Model
from tests.support.changed_arithmetic import (
    ALWAYS_TOLD_IN_CPP,
    CPP,
    MODELS,
    OPTIONS,
    PRECISIONS,
    REFUSED,
    RIGHT,
    C,
    answer,
    without_macros_and_pragmas,
    written,
)


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
        printed = subprocess.run(
            [folder / "main"], capture_output=True, text=True, check=True
        ).stdout.strip()
        assert printed == said if said else printed.startswith("0 ") and " 2" not in printed


@pytest.mark.slow
def test_a_library_with_changed_arithmetic_is_not_loaded(
    models: dict[str, Model],
    need: Callable[..., None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
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
    with pytest.raises(
        ExportError, match="changed the order or the rounding of its sums and products"
    ):
        python.load(library)
    smallest = math.ulp(0.0)
    assert smallest * 1.0 > 0.0, "the library switched subnormal numbers off in this process"


@pytest.fixture(scope="module")
def exports(
    models: dict[str, Model], tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[bool, str, str], Path]:
    """Folders by whether the C has its macros and pragmas, by model and by precision; written once for all options."""
    folders: dict[tuple[bool, str, str], Path] = {}
    for guarded, label, precision in product((True, False), MODELS, PRECISIONS):
        folder = written(models[label], tmp_path_factory.mktemp("m"), precision)
        if not guarded:
            without_macros_and_pragmas(folder)
        folders[guarded, label, precision] = folder
    return folders


@pytest.mark.slow
@pytest.mark.parametrize("options", OPTIONS)
def test_the_right_bits_or_a_refusal(
    exports: dict[tuple[bool, str, str], Path], options: str, need: Callable[..., None]
) -> None:
    """Each option with each model as an old compiler sees it, in turn in both precisions; one of them as written.

    zig is a younger clang: one of the two in turn, so that each option meets each compiler. ``make attack`` tries all
    of them with all of them.
    """
    need("gcc")
    number = OPTIONS.index(options)
    tried = [(False, label, PRECISIONS[(number + place) % 2]) for place, label in enumerate(MODELS)]
    tried.append((True, MODELS[number % len(MODELS)], PRECISIONS[number // len(MODELS) % 2]))
    for place, each in enumerate(tried):
        left_out = ("clang", "zig")[(number // 2 + place) % 2]
        for compiler in natives():
            if compiler.name == left_out:
                continue
            assert answer(compiler, exports[each], options.split()) in (RIGHT, REFUSED), (
                compiler.name,
                *each,
            )


@pytest.mark.slow
@pytest.mark.parametrize("options", OPTIONS)
def test_the_right_bits_or_a_refusal_as_cpp(
    exports: dict[tuple[bool, str, str], Path], options: str, need: Callable[..., None]
) -> None:
    need("gcc")
    folder = exports[
        options in ALWAYS_TOLD_IN_CPP, MODELS[OPTIONS.index(options) % len(MODELS)], "float64"
    ]
    for compiler in natives():
        assert answer(compiler, folder, options.split(), CPP) in (RIGHT, REFUSED), compiler.name


@pytest.mark.slow
def test_the_same_file_is_right_as_c_and_as_cpp(
    models: dict[str, Model], need: Callable[..., None], tmp_path: Path
) -> None:
    """A refusal of options says something only where the file is not refused without them."""
    need("gcc")
    folder = written(models["bingham, single"], tmp_path)
    for compiler in natives():
        answers = [answer(compiler, folder, ["-O2"], language) for language in (C, CPP)]
        assert answers == [RIGHT, RIGHT], compiler.name
