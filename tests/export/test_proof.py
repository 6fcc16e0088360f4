"""Frama-C's Eva on exported files, by `studies/proof.py`; and what Eva takes for true, proved.

docs/proof.md says in words what follows from this.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.export import ExportOptions, step_of
from erclutch.export.c.compilers import EXACT
from erclutch.export.targets.c import write_core
from erclutch.models.model import Model
from tests.support import proof

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("label", "options"),
    [
        ("bingham, single", ExportOptions("m", "float32", 1e-3)),
        ("casson+lag, single", ExportOptions("m", "float64", 1e-3)),
        ("bingham+rise-fall, coaxial", ExportOptions("m", "float32", 1e-3)),
        ("rbfm-10, coaxial", ExportOptions("m", "float64", 1e-3)),
        ("fnn-3+rise-fall, single", ExportOptions("m", "float32", 1e-3)),
        ("fnn-16, coaxial", ExportOptions("m", "float64", 1e-3)),
        ("bingham+fnn-3, single", ExportOptions("m", "float32", 1e-3)),
        (
            "casson+rise-fall+dahl-2/field+inertia+effort-lag, single",
            ExportOptions("m", "float64", 1e-3),
        ),
        ("bingham, single", ExportOptions("m", "float32", 1e-3, adapt=True)),
    ],
    ids=lambda value: (
        value if isinstance(value, str) else value.precision + ", adapting" * value.adapt
    ),
)
def test_no_alarm_and_all_within_limits_for_any_bits(
    models: dict[str, Model],
    label: str,
    options: ExportOptions,
    tmp_path: Path,
    need: Callable[..., None],
) -> None:
    need("frama-c")
    said = proof.proved(step_of(models[label], options), tmp_path)
    assert said.alarms == 0
    assert said.functions == said.of_functions
    assert set(said.shown) == {"step", "state", "steady", "inverse", "inverse_now"}
    assert all(all(shown) for shown in said.shown.values()), said.shown
    # What Eva takes for true is no more than the two facts that the tests below prove.
    assert 0 < said.assumed <= len(_assertions((tmp_path / "m.c").read_text(encoding="ascii")))


def test_a_limit_that_is_forgotten_is_seen(
    models: dict[str, Model], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("frama-c")
    step = step_of(models["bingham, single"], ExportOptions("m", "float32", 1e-3))
    proof.proved(step, tmp_path)
    source = (tmp_path / "m.c").read_text(encoding="ascii")
    for good, bad, check in (
        ("((value < low) || (high < value))", "(value < low)", "step"),
        ("(low < secant) && (secant < high)", "(low < secant)", "inverse"),
        ("is_finite = m_finite(value)", "is_finite = 1u", "step"),
    ):
        assert good in source
        spoilt = re.sub(r"/\*@ assert \(is_finite.*", "", source) if "finite" in good else source
        (tmp_path / "m.c").write_text(spoilt.replace(good, bad), encoding="ascii")
        said = proof.analysed(
            tmp_path, ["driver.c", "m.c"], "-eva-slevel", "12", "-eva-auto-loop-unroll", "8"
        )
        assert not all(said.shown[check]), bad
    (tmp_path / "m.c").write_text(source.replace("state->effort = 0.0f;", "", 1), encoding="ascii")
    assert proof.analysed(tmp_path, ["driver.c", "m.c"], "-eva-slevel", "12").alarms > 0


def _assertions(source: str) -> list[str]:
    return re.findall(r"/\*@ (assert .*?;) \*/", source)


@pytest.mark.parametrize("every", [9, pytest.param(1, marks=pytest.mark.slow)])
def test_only_two_facts_are_asserted(every: int, models: dict[str, Model], tmp_path: Path) -> None:
    """A kept test of the bits says that the numbers are finite, and what was compared is no NaN; nothing else."""
    for i, model in enumerate(list(models.values())[::every]):
        write_core(
            step_of(model, ExportOptions("m", "float32", 1e-3, "angles" if i % 2 else "speeds")),
            tmp_path,
        )
        source = (tmp_path / "m.c").read_text(encoding="ascii")
        compared = re.findall(
            r"&& \(low < secant\) .*\n *\{\n *(/\*@ assert !\\is_NaN\(secant\); \*/)", source
        )
        assert len(compared) == 1
        functions = re.split(r"\n}\n", source)
        said = [re.findall(r"assert \((\w+) == 0u\) \|\| \((.*)\);", body) for body in functions]
        tests = [
            (body, *fact) for body, facts in zip(functions, said, strict=True) for fact in facts
        ]
        assert len(tests) + len(compared) == len(_assertions(source))
        for body, name, facts in tests:
            tested = re.search(rf"const uint32_t {name} = (.*);", body)
            assert tested is not None
            assert not re.search(r"\||== 0u|!m_", tested[1]), "all parts must hold"
            assert all(
                fact.replace("\\is_finite", "m_finite") in tested[1] for fact in facts.split(" && ")
            )


_EXHAUSTIVE = """
#include <stdio.h>
#include <string.h>
#include "m.c"
static m_real real(uint64_t u)
{
    m_real x;
#if WIDTH == 32
    const uint32_t bits = (uint32_t)u;
#else
    const uint64_t bits = u;
#endif
    memcpy(&x, &bits, sizeof x);
    return x;
}
/* IEEE 754: x - x is 0 for a finite number, and NaN for an infinite one or for NaN. */
static int wrong(uint64_t u)
{
    const volatile m_real zero = 0;
    const m_real x = real(u);
    const int finite = x - x == zero, same = x == x;
    return (m_finite(x) != 0u) != finite || (!same && ((x < 1) || (1 < x) || (x <= 1) || (1 <= x)));
}
int main(void)
{
    unsigned long long count = 0, bad = 0;
    uint64_t u;
#if WIDTH == 32
    for (u = 0; u >> 32 == 0; u++) { bad += (unsigned)wrong(u); count++; }
#else
    uint64_t high, k;
    for (high = 0; high < 4096; high++) /* sign and exponent, with fractions of one bit, of none and of all */
    {
        for (k = 0; k < 54; k++)
        {
            u = high << 52 | (k < 52 ? (uint64_t)1 << k : (k == 52 ? 0 : ((uint64_t)1 << 52) - 1));
            bad += (unsigned)wrong(u); count++;
        }
    }
    if (m_finite(real(0x7ff0000000000000ULL)) != 0u) { bad++; }
#endif
    printf("%llu %llu\\n", count, bad);
    return 0;
}
"""


@pytest.mark.parametrize(("precision", "patterns"), [("float32", 2**32), ("float64", 4096 * 54)])
def test_the_test_of_the_bits_is_is_finite(
    models: dict[str, Model],
    precision: str,
    patterns: int,
    tmp_path: Path,
    need: Callable[..., None],
) -> None:
    """For all numbers of float32; for float64 for all exponents, as no other bit of a number is looked at."""
    need("gcc")
    write_core(step_of(models["bingham, single"], ExportOptions("m", precision)), tmp_path)  # type: ignore[arg-type]
    source = (tmp_path / "m.c").read_text(encoding="ascii")
    mask = "0x7f800000u" if precision == "float32" else "0x7ff0000000000000ULL"
    assert f"return ((m_bits_of(x) & {mask}) != {mask}) ?" in source
    (tmp_path / "all.c").write_text(_EXHAUSTIVE, encoding="ascii")
    flags = [*EXACT, "-O2", f"-DWIDTH={precision[-2:]}"]
    subprocess.run(
        ["gcc", *flags, str(tmp_path / "all.c"), "-o", str(tmp_path / "all")], check=True
    )
    said = subprocess.run(
        [str(tmp_path / "all")], capture_output=True, text=True, check=True
    ).stdout
    assert said.split() == [str(patterns), "0"]
