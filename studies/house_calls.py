"""Which function of the package calls which, so that one can follow a log's way through its files."""

from __future__ import annotations

import ast
from collections import defaultdict
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
        called_so = self._by_last_name.get(name, ())
        homes = [home for home in called_so if home.rpartition(".")[0] in holders]
        return homes[0] if len(homes) == 1 else ""

    @cached_property
    def _by_last_name(self) -> dict[str, list[str]]:
        """Functions and methods by the last part of their full name."""
        homes: dict[str, list[str]] = defaultdict(list)
        for home in self._homes:
            homes[home.rpartition(".")[2]].append(home)
        return homes

    @cached_property
    def _modules(self) -> dict[str, str]:
        """The module's name of each file."""
        return {str(module.path): module.name for module in self.modules}

    @cached_property
    def _names(self) -> dict[str, dict[str, str]]:
        """By file: what a name in it stands for."""
        meaning: dict[str, dict[str, str]] = {}
        for module in self.modules:
            own = {
                n.name: f"{module.name}.{n.name}"
                for n in module.tree.body
                if isinstance(n, ast.FunctionDef)
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

    @cached_property
    def _tables(self) -> dict[str, list[str]]:
        """Tables of rules by their full name: constants of modules in which functions stand, in their order."""
        tables: dict[str, list[str]] = {}
        for module in self.modules:
            for node in module.tree.body:
                if isinstance(node, ast.Assign):
                    target, value = node.targets[0], node.value
                elif isinstance(node, ast.AnnAssign) and node.value is not None:
                    target, value = node.target, node.value
                else:
                    continue
                named = [each for each in ast.walk(value) if isinstance(each, ast.Name)]
                called = {id(call.func) for call in ast.walk(value) if isinstance(call, ast.Call)}
                named = [each for each in named if id(each) not in called]
                named.sort(key=lambda each: (each.lineno, each.col_offset))
                meanings = [self._names[str(module.path)].get(each.id, "") for each in named]
                rules = [meaning for meaning in meanings if meaning in self._homes]
                if isinstance(target, ast.Name) and rules:
                    tables[f"{module.name}.{target.id}"] = rules
        return tables

    def way(self, module: str, function: str, *, rules: bool = False) -> list[str]:
        """Files of the functions that one enters, each function once, in the order of the calls; runs of one file.

        Args:
            module: in which the way begins.
            function: with which it begins.
            rules: whether the functions in a table (a constant of a module) are entered where the table is named. Else
                the way leads past them, as it does for a reader who takes from the table what each rule settles.
        """
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
                if isinstance(call, ast.Name):
                    table = self._names[file].get(call.id, f"{self._modules[file]}.{call.id}")
                    for rule in self._tables.get(table, ()) if rules else ():
                        enter(rule)
                    continue
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


def _in_order(node: ast.AST) -> Iterator[ast.Call | ast.Name]:
    """Calls in the order in which they run, arguments before the call, and the names that are read on the way."""
    for child in ast.iter_child_nodes(node):
        yield from _in_order(child)
    if isinstance(node, ast.Call) or (
        isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
    ):
        yield node
