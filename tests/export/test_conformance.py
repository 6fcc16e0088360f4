"""Every model on every target: the bits of the emulation, and NumPy's numbers within the stated bounds."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.export import Check, Options, export_model, program_of, verify_export
from erclutch.export.check import ulps
from erclutch.export.emulate import inverse, reference, run
from erclutch.export.program import NON_FINITE, OUT_OF_REACH, Program
from erclutch.export.rounding import bound
from erclutch.export.vectors import ordinary, rows_of
from erclutch.model import TorqueModel
from erclutch.precision import FLOAT64
from erclutch.saved import Model

#: Bounds of docs/export.md, in units of the last place at the largest training effort: float64 has NumPy's bits.
BOUND = {"float64": 0.0, "float32": 8.0}
PERIOD = 1e-3


def program(model: Model, precision: str = "float64", **options: object) -> Program:
    return program_of(model, Options(**{"name": "m", "precision": precision, "period": PERIOD, **options}))  # type: ignore[arg-type]


def _against_numpy(model: Model, precision: str, count: int) -> None:
    made = program(model, precision)
    rows = rows_of(made, np.random.default_rng(5), count)
    effort, flags = run(made, rows)
    expected, expected_flags = reference(made, rows)
    assert np.all(np.isfinite(effort))
    assert np.array_equal(flags, expected_flags)
    difference = np.abs(effort - expected)
    assert ulps(made, float(np.max(difference))) <= BOUND[precision]
    # The stated bound of the error analysis, NumPy's own rounding included, holds row by row.
    assert np.all(difference <= bound(made, rows) + bound(made, rows, FLOAT64))


def test_step_is_numpys(model: Model) -> None:
    _against_numpy(model, "float64", 300)


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_step_is_numpys_on_ten_thousand_rows(model: Model, precision: str) -> None:
    _against_numpy(model, precision, 10_000)


@pytest.mark.slow
def test_a_fitted_model_gives_predicts_bits(tmp_path: Path, need: Callable[..., None]) -> None:
    """Gains of 1e7 that cancel, large weights: what a unit in the last place of an exp becomes."""
    from erclutch.runs import read_run

    need("gcc")
    command = [sys.executable, "-m", "erclutch"]
    subprocess.run(
        [*command, "simulate", "training", "--seconds", "20", "--out", "log.parquet"], cwd=tmp_path, check=True
    )
    words = ["fit", "log.parquet", "--device", "coaxial", "--derivative", "difference", "--lag", "none", "--out", "run"]
    subprocess.run([*command, *words, "--models", "rbfm-10", "fnn-16", "rbfn-50"], cwd=tmp_path, check=True)
    fitted = read_run(tmp_path / "run")
    kernels = fitted.model("rbfm-10")
    assert isinstance(kernels, TorqueModel)
    assert max(abs(g) for g in kernels.gains.values()) > 1e4
    for name in sorted(fitted.names):
        model = fitted.model(name)
        _against_numpy(model, "float64", 10_000)
        folder = export_model(model, tmp_path / name, "python", Options(name="m", period=PERIOD))
        _sound(verify_export(folder), "float64", 2)


def test_numpys_own_functions_would_not_do(models: dict[str, Model]) -> None:
    """That the bits agree is no chance: with NumPy's exp and tanh they do not."""
    from erclutch.device import Element
    from erclutch.dynamics import Clock

    rng = np.random.default_rng(4)
    elements = [Element(rng.uniform(0.0, 600.0, 2000), rng.uniform(-30.0, 30.0, 2000)) for _ in range(2)]
    clock = Clock(np.zeros(2000), ())
    for label in ("fnn-16, coaxial", "hem, coaxial", "seo-seo, coaxial", "rbfn-50, coaxial"):
        model = models[label]
        own, other = (model.effort(elements, clock, exactly=flag) for flag in (True, False))
        assert np.count_nonzero(own != other) > 0
        assert np.max(np.abs(own - other)) < 1e-13 * np.max(np.abs(own))


def _sound(checks: list[Check], precision: str, least: int) -> None:
    assert len(checks) >= least
    assert [c.where for c in checks if not c.passed or c.other_bits != 0] == []
    assert max(c.ulp for c in checks) <= BOUND[precision]


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_every_compiler_and_processor_gives_the_same_bits(
    model: Model, precision: str, tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc", "clang", "qemu-aarch64", "qemu-ppc", "aarch64-linux-gnu-gcc", "powerpc-linux-gnu-gcc")
    need("arm-none-eabi-gcc", "qemu-system-arm")
    folder = export_model(model, tmp_path / "c", "c", Options(name="m", precision=precision, period=PERIOD))  # type: ignore[arg-type]
    checks = verify_export(folder)
    # gcc and clang at three levels, two processors under qemu-user, two boards.
    _sound(checks, precision, 10)
    assert all(c.note.endswith("flash") for c in checks if c.where.startswith("Cortex"))


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("label", ["fnn-16, coaxial", "rbfn-50, coaxial", "seo-seo/power+rise-fall, single"])
def test_zig_gives_the_same_bits(label: str, precision: str, models: dict[str, Model], tmp_path: Path) -> None:
    """Another clang with its own C library, from PyPI: what a machine without a compiler gets."""
    pytest.importorskip("ziglang", reason="pip install ziglang")
    from erclutch.export.c import run_check
    from erclutch.export.check import compare
    from erclutch.export.compilers import natives
    from erclutch.export.vectors import vectors_of

    made = program(models[label], precision)
    folder = export_model(models[label], tmp_path / "c", "c", Options(name="m", precision=precision, period=PERIOD))  # type: ignore[arg-type]
    zig = next(c for c in natives() if c.name == "zig")
    for level in ("-O0", "-O2", "-O3"):
        printed = run_check(zig, folder, tmp_path, made, level)
        check = compare(made, vectors_of(made), level, printed)
        assert check.other_bits == 0, check
        assert check.ulp <= BOUND[precision]


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_python_gives_the_same_bits(model: Model, precision: str, tmp_path: Path, need: Callable[..., None]) -> None:
    need("gcc")
    folder = export_model(model, tmp_path / "p", "python", Options(name="m", precision=precision, period=PERIOD))  # type: ignore[arg-type]
    _sound(verify_export(folder), precision, 2)


@pytest.mark.parametrize("inputs", ["angles"])
@pytest.mark.parametrize("label", ["hem+rise-fall, coaxial", "fnn-16, coaxial", "casson+lag, single"])
def test_angles_are_differentiated_as_live_does(models: dict[str, Model], label: str, inputs: str) -> None:
    from erclutch.differentiate import Derivative, live

    made = program(models[label], inputs=inputs, derivative=Derivative("kalman", 120.0))
    plain = program(models[label])
    e = made.elements
    speeds = ordinary(plain, np.random.default_rng(2), 300)
    rows = speeds.copy()
    # Smooth enough to stay within half a turn: the wrap has a test of its own.
    rows[:, e : 2 * e] = 0.3 * np.sin(np.outer(np.arange(300) * PERIOD, 40.0 + 7.0 * np.arange(e)))
    for k in range(e, 2 * e):
        filter_ = live(Derivative("kalman", 120.0), PERIOD)
        speeds[:, k] = [filter_.step(x) for x in rows[:, k]]
    effort, flags = run(made, rows)
    expected, expected_flags = run(plain, speeds)
    assert np.array_equal(flags, expected_flags)
    assert np.max(np.abs(effort - expected)) <= 1e-10 * made.scale


def test_an_angle_that_wraps_is_the_angle_that_goes_on(models: dict[str, Model]) -> None:
    made = program(models["hem+rise-fall, coaxial"], inputs="angles")
    angle = np.cumsum(np.full(2000, 0.025))
    rows = np.column_stack([np.full(2000, 300.0), np.zeros(2000), angle, 0.4 * angle])
    wrapped = rows.copy()
    wrapped[:, 2:] %= 2 * np.pi
    through, _ = run(made, rows)
    around, _ = run(made, wrapped)
    assert angle[-1] > 14 * np.pi
    assert np.max(np.abs(through - around)) < 1e-9 * made.scale


def test_the_last_good_row_stands_in_for_a_bad_one(models: dict[str, Model]) -> None:
    made = program(models["hem, coaxial"])
    rows = ordinary(made, np.random.default_rng(1), 20)
    rows[:3, 0] = np.nan
    rows[7] = np.inf
    effort, flags = run(made, rows)
    assert list(effort[:3]) == [0.0, 0.0, 0.0]
    assert effort[7] == effort[6] != 0.0
    assert list(flags[[0, 1, 2, 7]] & NON_FINITE) == [NON_FINITE] * 4
    assert not np.any(flags[[3, 4, 8]] & NON_FINITE)


@pytest.mark.parametrize("precision", ["float64", pytest.param("float32", marks=pytest.mark.slow)])
def test_inverse_gives_the_field_of_an_effort(model: Model, precision: str) -> None:
    made = program(model, precision)
    rng = np.random.default_rng(11)
    at_rest = replace(made, lag=None)
    rows = ordinary(made, rng, 64)
    copies = made.rows_back + 1  # a network that looks back sees the same row all the time
    wanted = run(at_rest, np.repeat(rows, copies, axis=0))[0][copies - 1 :: copies]
    field, flags = inverse(made, rows, wanted)
    # Every one of these efforts is that of some field, so all are within reach.
    assert np.mean((flags & OUT_OF_REACH) == 0) > (0.99 if made.search.monotone_share == 1.0 else 0.9)
    again = rows.copy()
    again[:, 0] = np.maximum(field, 0.0) if made.elements == 2 else field
    if made.elements == 2:
        again[:, 1] = np.maximum(-field, 0.0)
    reached = (flags & OUT_OF_REACH) == 0
    steep = made.scale * 2.0 ** (-14 if precision == "float32" else -40)
    found = run(at_rest, np.repeat(again, copies, axis=0))[0][copies - 1 :: copies]
    assert np.max(np.abs(found - wanted)[reached]) <= steep


def test_out_of_reach_gives_the_nearest_end_and_says_so(models: dict[str, Model]) -> None:
    made = program(models["hem, coaxial"])
    speeds = np.array([[0.0, 0.0, 20.0, 0.0]] * 2)
    field, flags = inverse(made, speeds, np.array([1e3, -1e3]))
    assert list(flags & OUT_OF_REACH) == [OUT_OF_REACH] * 2
    assert list(field) == [made.search.plus, made.search.minus]
