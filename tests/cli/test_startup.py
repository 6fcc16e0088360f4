"""A quick start by what is imported, which a busy machine cannot blur: `erclutch --help` and `import erclutch`."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("numpy", "scipy", "pandas", "pyarrow", "pint", "sympy", "rich", "cyclopts", "h5py", "threadpoolctl")


def imported_by(code: str) -> set[str]:
    """Top-level packages in memory after a piece of code."""
    tail = "\nimport sys; print('MODULES', *sorted({name.partition('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", code + tail], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split()[1:])


def command(*arguments: str) -> str:
    return (
        f"import sys; sys.argv = ['erclutch', {', '.join(map(repr, arguments))}]\nfrom erclutch.cli import main\nmain()"
    )


def test_the_package_alone_brings_nothing() -> None:
    assert imported_by("import erclutch; erclutch.__version__") & set(HEAVY) == set()


def test_a_name_of_the_package_brings_what_it_needs() -> None:
    found = imported_by("import erclutch; erclutch.ErclutchError")
    assert found & set(HEAVY) == set()
    found = imported_by("import erclutch; erclutch.Settings")
    assert "numpy" in found
    assert found & {"pandas", "sympy", "rich", "cyclopts", "h5py", "pyarrow"} == set()


@pytest.mark.parametrize("arguments", [(), ("--help",), ("--version",)])
def test_help_brings_no_numbers(arguments: tuple[str, ...]) -> None:
    found = imported_by(command(*arguments))
    assert found & {"numpy", "scipy", "pandas", "pyarrow", "pint", "sympy", "h5py"} == set()


@pytest.mark.parametrize("name", ["fit", "inspect", "flowcurve", "laws", "demo"])
def test_help_of_a_command_brings_no_numbers(name: str) -> None:
    found = imported_by(command(name, "--help"))
    assert found & {"numpy", "scipy", "pandas", "pyarrow", "pint", "sympy", "h5py"} == set()


def test_every_public_name_is_there() -> None:
    import erclutch

    for name in erclutch.__all__:
        assert getattr(erclutch, name) is not None
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        erclutch.nonsense  # noqa: B018  # pyright: ignore[reportAttributeAccessIssue]


def test_the_main_job_of_the_docstring() -> None:
    import erclutch

    called = [line for line in (erclutch.__doc__ or "").splitlines() if "build_dataset(log)" in line]
    assert called
    assert all("erclutch.compare(" in line for line in called)
