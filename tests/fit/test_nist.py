"""The solver against certified answers: the 27 nonlinear regressions of NIST's StRD, as in `studies/nist.py`."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support import nist_problems as nist

PROJECT = Path(__file__).resolve().parents[2]
SCRIPT = PROJECT / "studies" / "nist.py"
FOLDER = PROJECT.parent / "shared" / "data" / "nist_strd"

if not FOLDER.is_dir():
    pytest.skip(
        f"needs the problems of NIST StRD beside the project: {FOLDER}", allow_module_level=True
    )


def test_all_27_problems_are_there() -> None:
    assert set(nist.MODELS) == {path.stem for path in FOLDER.glob("*.dat")}
    assert len(nist.MODELS) == 27


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(nist.MODELS))
def test_both_starts_reach_the_certified_answer(name: str) -> None:
    problem = nist.read(name, FOLDER)
    for start in problem.starts:
        solved = nist.solve(name, problem, start)
        assert solved.digits >= 6.0
        if name != nist.ROUNDING:
            assert solved.error_digits >= 6.0


@pytest.mark.parametrize("name", sorted(nist.MODELS))
def test_derivatives_match_central_differences(name: str) -> None:
    problem = nist.read(name, FOLDER)
    b = problem.values
    slopes, residual = nist.jacobian_of(name, problem, b)
    assert residual.shape == problem.y.shape
    for i in range(b.size):
        step = 1e-6 * abs(b[i]) * (np.arange(b.size) == i)
        high, low = (nist.MODELS[name](list(b + s), problem.x) for s in (step, -step))
        numerical = (high - low) / (2.0 * step[i])
        assert np.allclose(slopes[:, i], numerical, rtol=1e-4, atol=1e-5 * np.abs(numerical).max())


def test_the_certified_residuals_come_out() -> None:
    """The models are those of the files: the sum of squares at the certified values is the certified one."""
    for name in nist.MODELS:
        if name == nist.ROUNDING:
            continue
        text = (FOLDER / f"{name}.dat").read_text()
        certified = float(text.split("Residual Sum of Squares:")[1].split()[0])
        problem = nist.read(name, FOLDER)
        _, residual = nist.jacobian_of(name, problem, problem.values)
        assert np.isclose(residual @ residual, certified, rtol=1e-6), name


@pytest.mark.slow
def test_the_command() -> None:
    done = subprocess.run(
        [sys.executable, SCRIPT, FOLDER], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "27 of 27 to 6 digits from both starts"
    assert done.stderr == ""


@pytest.mark.slow
def test_the_command_without_its_files(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, SCRIPT, tmp_path], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert "Bennett5.dat" in done.stderr


@pytest.mark.slow
def test_a_miss_is_an_exit_code(tmp_path: Path) -> None:
    """The certified values of one problem are changed."""
    for file in FOLDER.glob("*.dat"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    spoilt = tmp_path / "Rat42.dat"
    certified = next(f"{value:.10E}" for value in nist.read("Rat42", FOLDER).values)
    assert certified in spoilt.read_text()
    spoilt.write_text(spoilt.read_text().replace(certified, certified.replace("7", "8")))
    done = subprocess.run(
        [sys.executable, SCRIPT, tmp_path], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 1, done.stderr
    assert done.stdout.splitlines()[-1] == "26 of 27 to 6 digits from both starts"
