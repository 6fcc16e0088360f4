"""A quick start by what is imported, which a busy machine cannot blur: `erclutch --help` and `import erclutch`."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import erclutch
from tests.support.exported_models import MODELS

#: Public names that come with a wing: tests/wings/test_public_names.py looks for them.
OF_WINGS = {
    name: home.split(".")[1]
    for name, home in erclutch._HOME_OF.items()
    if home.startswith("wings.")
}
HEAVY = (
    "numpy",
    "scipy",
    "pandas",
    "pyarrow",
    "pint",
    "sympy",
    "rich",
    "cyclopts",
    "h5py",
    "threadpoolctl",
)


def imported_by(code: str) -> set[str]:
    """Top-level packages in memory after a piece of code."""
    # A program that has ended its answer writes what comes later to stderr.
    tail = (
        "\nimport sys; every = sorted({name.partition('.')[0] for name in sys.modules})"
        "\nprint('MODULES', *every, file=sys.__stdout__)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code + tail], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split()[1:])


def command(*arguments: str) -> str:
    return (
        f"import sys; sys.argv = ['erclutch', {', '.join(map(repr, arguments))}]\nfrom "
        "erclutch.cli import main\nmain()"
    )


@pytest.mark.slow
def test_the_package_alone_brings_nothing() -> None:
    assert imported_by("import erclutch; erclutch.__version__") & set(HEAVY) == set()


@pytest.mark.slow
def test_a_name_of_the_package_brings_what_it_needs() -> None:
    found = imported_by("import erclutch; erclutch.ErclutchError")
    assert found & set(HEAVY) == set()
    found = imported_by("import erclutch; erclutch.Settings")
    assert "numpy" in found
    assert found & {"pandas", "sympy", "rich", "cyclopts", "h5py", "pyarrow"} == set()


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [(), ("--help",), ("--version",)])
def test_help_brings_no_numbers(arguments: tuple[str, ...]) -> None:
    found = imported_by(command(*arguments))
    assert found & {"numpy", "scipy", "pandas", "pyarrow", "pint", "sympy", "h5py"} == set()
    if arguments != ("--version",):  # two thirds of the time of the page of all commands
        assert found & {"cyclopts", "rich"} == set()


@pytest.mark.slow
@pytest.mark.parametrize(("given", "taken"), [("", "1"), ("3", "3")])
def test_a_command_has_one_thread_of_blas_where_the_user_asks_for_no_others(
    given: str, taken: str
) -> None:
    """Two threads took 0.4 of the 1.3 CPU s of `inspect` on 74,068 rows, to wait for each other."""
    code = (
        "import os, sys; os.environ.pop('OPENBLAS_NUM_THREADS', None); sys.argv = ['erclutch', '--version']\n"
        f"if {given!r}: os.environ['OPENBLAS_NUM_THREADS'] = {given!r}\n"
        "from erclutch.__main__ import main\nmain()\n"
        f"assert os.environ['OPENBLAS_NUM_THREADS'] == {taken!r}"
    )
    assert "erclutch" in imported_by(code)


@pytest.mark.slow
def test_help_of_no_command_brings_numbers() -> None:
    """All commands are asked in one process: a package that one of them imports stays in memory."""
    code = (
        "from erclutch.cli import main\nfrom erclutch.cli.command_list import commands\n"
        "assert not any(main([command.name, '--help']) for command in commands())"
    )
    assert (
        imported_by(code) & {"numpy", "scipy", "pandas", "pyarrow", "pint", "sympy", "h5py"}
        == set()
    )


@pytest.mark.slow
def test_an_export_brings_nothing_that_only_a_fit_or_a_log_needs(tmp_path: Path) -> None:
    """Half of its time is Python's and sympy's start; each of these takes as long again."""
    model = tmp_path / "model.json"
    model.write_text(json.dumps(MODELS["fnn-16, coaxial"].to_dict()), encoding="utf-8")
    found = imported_by(command("export", str(model), "--out", str(tmp_path / "exported")))
    assert "erclutch" in found
    assert found & {"scipy", "pandas", "pyarrow", "pint", "h5py", "matplotlib", "numba"} == set()


def test_every_public_name_is_there() -> None:
    for name in set(erclutch.__all__) - set(OF_WINGS):
        assert getattr(erclutch, name) is not None
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        erclutch.nonsense  # noqa: B018  # pyright: ignore[reportAttributeAccessIssue]


def test_the_main_job_of_the_docstring() -> None:
    called = [
        line for line in (erclutch.__doc__ or "").splitlines() if "build_dataset(log)" in line
    ]
    assert called
    assert all("erclutch.compare(" in line for line in called)
