"""Every package that the sources import is declared, and the stubs in typings/ name only what their packages have."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
#: Programs of others that check an export. Whoever verifies one has it, or reads in one line what to install.
VERIFIERS = {"fmpy", "mujoco", "onnxruntime"}


def imported(source: str) -> set[str]:
    """Top names of the packages that a module imports, at its head or later."""
    found = set(
        re.findall(
            r"^ *(?:import (\w+)(?:[\w.]*)(?: as \w+)?$|from (\w+)[\w.]* import )",
            source,
            re.MULTILINE,
        )
    )
    return (
        {name for pair in found for name in pair if name}
        - set(sys.stdlib_module_names)
        - {"erclutch"}
    )


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def declared() -> set[str]:
    """Names of the distributions in dependencies and extras."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = [
        *project["dependencies"],
        *(line for extra in project["optional-dependencies"].values() for line in extra),
    ]
    return {normal(re.split(r"[^\w.-]", line)[0]) for line in lines}


@pytest.mark.slow
def test_every_imported_package_is_declared():
    homes, known, missing = packages_distributions(), declared(), dict[str, str]()
    for path in sorted((ROOT / "src").rglob("*.py")):
        for name in imported(path.read_text(encoding="utf-8")) - VERIFIERS:
            if not known & {normal(home) for home in homes.get(name, [name])}:
                missing[name] = path.name
    assert not missing


def test_an_undeclared_package_would_be_found():
    assert imported(
        "import os\ndef f():\n    import zstandard\n    from lz4.frame import compress\n"
    ) == {
        "zstandard",
        "lz4",
    }


def named(stub: Path) -> Iterator[str]:
    """Public names that a stub defines."""
    for node in ast.parse(stub.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target.id


@pytest.mark.slow
@pytest.mark.parametrize(
    "stub", sorted((ROOT / "typings").rglob("*.pyi")), ids=lambda p: p.parent.name + "." + p.stem
)
@pytest.mark.filterwarnings("default")
def test_a_stub_names_what_its_package_has(stub: Path):
    parts = stub.relative_to(ROOT / "typings").with_suffix("").parts
    module = import_module(".".join(part for part in parts if part != "__init__"))
    assert [
        name for name in named(stub) if not name.startswith("_") and not hasattr(module, name)
    ] == []
