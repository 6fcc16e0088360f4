"""Which tests of the core may ask for what a wing brings: those run once more without any wing, in a copy.

The others run once: that they ask for nothing of a wing is shown by the sources of their rooms, and where a room finds
its readers by name, by a fixture that looks at each test.
"""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Rooms that import no room with a registry's group of the wings, and look up no such group but that of readers.
NO_GROUP_OF_A_WING = ("arithmetic", "fit", "logs", "models", "signals")
#: Words of a test that may ask for a wing all the same: by a room above, a command or a process, such as the one that
#: finds the reader of a sheet's text.
MAY_ASK = re.compile(
    r"erclutch\.(?:cli|export|report|runs|wings)|wings|subprocess|\bmain\(|registry|[pP]lugin|xls|\bods\b|sheet"
)
SUPPORT = re.compile(r"tests\.support(?:\.| import )(\w+)")
TESTS = ROOT / "tests"


@cache
def asking_tests(test: Path) -> frozenset[str]:
    """Names of a file's tests that may lead to a wing: by a word of their own, or by a name that stands for such words.

    A name is that of an import, a fixture, a helper or a constant, of the file or of a conftest.py of its room.
    """
    if not may_ask(test):
        return frozenset()
    names = _asking_names(test)
    return frozenset(name for name in _top_level_tests(test) if name in names)


def arguments(test: Path) -> list[str]:
    """What pytest is given so that those tests of a file run which may lead to a wing."""
    asking = asking_tests(test)
    return (
        [str(test)]
        if asking == _top_level_tests(test)
        else [f"{test}::{name}" for name in sorted(asking)]
    )


def _top_level_tests(test: Path) -> frozenset[str]:
    tree = ast.parse(test.read_text("utf-8"))
    assert not any(
        isinstance(node, ast.ClassDef) and node.name.startswith("Test") for node in tree.body
    ), test
    return frozenset(
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and node.name[:5] == "test_"
    )


@cache
def _asking_names(file: Path) -> frozenset[str]:
    """Names of a file's top level that may lead to a wing; what binds no name may lead all of them there."""
    tree = ast.parse(file.read_text("utf-8"))
    rooms = [folder / "conftest.py" for folder in file.parents if TESTS in folder.parents]
    asking = {
        name for room in rooms if room.exists() and room != file for name in _asking_names(room)
    }
    bound = {node: _bound_names(node) for node in tree.body}
    for node in tree.body:
        if MAY_ASK.search(_code(node)) or _imports_what_may_ask(node):
            asking |= bound[node] or set[str]().union(*bound.values())
    while True:
        led = {name for node in tree.body if _used_names(node) & asking for name in bound[node]}
        if led <= asking:
            return frozenset(asking)
        asking |= led


def _code(node: ast.stmt) -> str:
    """Without comments; the first string of a file tells and does nothing."""
    return (
        ""
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        else ast.unparse(node)
    )


def _imports_what_may_ask(node: ast.stmt) -> bool:
    """Of what tests share, and of other tests."""
    if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("tests"):
        return False
    modules = {f"{node.module}.{name.name}" for name in node.names} | {str(node.module)}
    shared = [ROOT / f"{module.replace('.', '/')}.py" for module in modules]
    return any(path.exists() and may_ask(path) for path in shared)


def _bound_names(node: ast.stmt) -> set[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {(name.asname or name.name).partition(".")[0] for name in node.names}
    return {
        n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
    }


def _used_names(node: ast.stmt) -> set[str]:
    """Names in the code, arguments (which are fixtures), and texts that may be names of fixtures."""
    used = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
    used |= {n.arg for n in ast.walk(node) if isinstance(n, ast.arg)}
    return used | {
        n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and isinstance(n.value, str)
    }


@cache
def may_ask(test: Path) -> bool:
    """Whether a file of tests, or what tests share that it imports, has a word that may lead to a wing."""
    text = test.read_text("utf-8")
    shared = [ROOT / f"tests/support/{name}.py" for name in SUPPORT.findall(text)]
    return MAY_ASK.search(text) is not None or any(
        path.exists() and may_ask(path) for path in shared
    )
