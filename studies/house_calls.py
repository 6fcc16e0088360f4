"""Which function of the package calls which, so that one can follow a log's way through its files."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from studies.house_code import Module


@dataclass(frozen=True)
class Calls:
    """Which function of the package calls which, as far as the names in a file tell."""

    modules: Sequence[Module]

    @cached_property
    def _homes(self) -> dict[str, tuple[str, ast.FunctionDef]]:
        """Functions and methods by their full name, each with its file."""
        homes: dict[str, tuple[str, ast.FunctionDef]] = {}
        for module in self.modules:
            for node in module.tree.body:
                if isinstance(node, ast.FunctionDef):
                    homes[f"{module.name}.{node.name}"] = (str(module.path), node)
                elif isinstance(node, ast.ClassDef):
                    for method in node.body:
                        if isinstance(method, ast.FunctionDef):
                            homes[f"{module.name}.{node.name}.{method.name}"] = (
                                str(module.path),
                                method,
                            )
        return homes

    def _method(self, name: str, file: str) -> str:
        """The only method of that name among the classes that a file has or imports, or nothing."""
        holders = set(self._names[file].values())
        homes = [
            home
            for home in self._homes
            if home.endswith(f".{name}") and home.rpartition(".")[0] in holders
        ]
        return homes[0] if len(homes) == 1 else ""

    @cached_property
    def _names(self) -> dict[str, dict[str, str]]:
        """By file: what a name in it stands for."""
        meaning: dict[str, dict[str, str]] = {}
        for module in self.modules:
            own = {
                f.rpartition(".")[2]: f for f in self._homes if f.rpartition(".")[0] == module.name
            }
            classes = {
                n.name: f"{module.name}.{n.name}"
                for n in module.tree.body
                if isinstance(n, ast.ClassDef)
            }
            imported = {
                alias.asname or alias.name: f"{node.module}.{alias.name}"
                for node in module.nodes
                if isinstance(node, ast.ImportFrom) and node.module
                for alias in node.names
            }
            meaning[str(module.path)] = {**imported, **own, **classes}
        return meaning

    def way(self, module: str, function: str) -> list[str]:
        """Files of the functions that one enters, each function once, in the order of the calls; runs of one file."""
        seen: set[str] = set()
        files: list[str] = []

        def enter(name: str) -> None:
            if name in seen or name not in self._homes:
                return
            seen.add(name)
            file, body = self._homes[name]
            if not files or files[-1] != file:
                files.append(file)
            holder = name.rpartition(".")[0]
            for call in _in_order(body):
                text = ast.unparse(call.func)
                head, _, tail = text.partition(".")
                meant = (
                    f"{holder}.{tail}"
                    if head in ("self", "cls")
                    else self._names[file].get(head, "")
                )
                if head not in ("self", "cls") and tail:
                    meant = f"{meant}.{tail}"
                enter(
                    meant if meant in self._homes else self._method(text.rpartition(".")[2], file)
                )

        enter(f"{module}.{function}")
        return files


def _in_order(node: ast.AST) -> Iterator[ast.Call]:
    """Calls in the order in which they run: arguments before the call."""
    for child in ast.iter_child_nodes(node):
        yield from _in_order(child)
    if isinstance(node, ast.Call):
        yield node
