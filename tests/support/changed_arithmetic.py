"""Options of compilers that change arithmetic, and what an exported C answers under them."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compilers import Compiler
from erclutch.export.targets import c
from erclutch.models.model import Model

#: What the tiny main of an export returns.
RIGHT, WRONG, REFUSED = 0, 1, 2
#: How a compiler takes a file whose name ends in .c.
C, CPP = ("-std=c99",), ("-x", "c++", "-std=c++17")  # C++17: numbers in hexadecimal

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
#: Options that no compiler of C++17 has without the macro that refuses them (of gcc before 3.3, which has no C++17). As
#: C++ without that macro, gcc 12 gives wrong numbers under it; with it, the file is refused.
ALWAYS_TOLD_IN_CPP = ("-O2 -mfpmath=both",)
#: Laws with tanh and power, networks, stages; a compiler that does not know an option refuses, too.
MODELS = (
    "bingham, single",
    "herschel-bulkley, single",
    "fnn-3+rise-fall, single",
    "rbfn-13+lag, single",
)
PRECISIONS = ("float64", "float32")


def written(model: Model, folder: Path, precision: str = "float64") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    c.write(step_of(model, ExportOptions(name="m", precision=precision, period=1e-3)), folder)  # type: ignore[arg-type]
    return folder


def answer(
    compiler: Compiler, folder: Path, options: Sequence[str], language: Sequence[str] = C
) -> int:
    """Of the tiny main, with the file compiled and linked under the options; a compiler's error is a refusal.

    The tiny main computes with bits alone, so no option changes it: it is compiled once, without any.
    """
    plain = [*language, "-ffp-contract=off", *compiler.flags]
    bench = folder / f"check-{compiler.name}-{'cpp' if language is CPP else 'c'}.o"
    if not bench.exists():
        words = [*compiler.command, *plain, "-O1", "-c", folder / "m_check.c", "-o", bench]
        subprocess.run(words, capture_output=True, check=True)
    # The options stand last: they take back what the Makefile asks for. The bench stands first: it is no source of C++.
    words = [*compiler.command, bench, *plain, *options, folder / "m.c", "-o", folder / "check"]
    built = subprocess.run(words, capture_output=True, check=False)
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
