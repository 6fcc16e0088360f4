"""One file of the package as the measure of the house reads it, how dense some files are, and what imports what."""

from __future__ import annotations

import ast
import io
import tokenize
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePosixPath

PACKAGE = "erclutch"
#: Nodes with nothing below them that is counted.
_LEAVES = (ast.Name, ast.Constant, ast.expr_context, ast.operator)


@dataclass(frozen=True)
class Module:
    """One file of the package.

    Attributes:
        path: inside the package.
        text: all of it.
    """

    path: PurePosixPath
    text: str

    @cached_property
    def tree(self) -> ast.Module:
        """Parsed."""
        return ast.parse(self.text)

    @cached_property
    def nodes(self) -> list[ast.AST]:
        """All of the tree but names, constants and operators, which are most of it and are not counted."""
        found: list[ast.AST] = []
        left: list[ast.AST] = [self.tree]
        for node in left:
            if isinstance(node, _LEAVES):
                continue
            if not isinstance(node, ast.Attribute):
                found.append(node)
            left.extend(ast.iter_child_nodes(node))
        return found

    @property
    def name(self) -> str:
        """As in an import."""
        parts = [PACKAGE, *self.path.with_suffix("").parts]
        return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

    @cached_property
    def said(self) -> set[int]:
        """Lines of strings that stand alone: docstrings."""
        alone = (
            n for n in self.nodes if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant)
        )
        return {
            line
            for node in alone
            for line in range(node.lineno, 1 + (node.end_lineno or node.lineno))
        }

    @cached_property
    def code(self) -> str:
        """The text without comments and docstrings."""
        kept: list[str] = []
        before = tokenize.NEWLINE
        for token in tokenize.generate_tokens(io.StringIO(self.text).readline):
            statement = before in (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.NL)
            if token.type != tokenize.COMMENT and not (token.type == tokenize.STRING and statement):
                kept.append(
                    "\n" if token.type in (tokenize.NEWLINE, tokenize.NL) else token.string + " "
                )
            if token.type not in (tokenize.COMMENT, tokenize.NL):
                before = token.type
        return "".join(kept)


@dataclass(frozen=True)
class Density:
    """What makes code slow to read.

    Attributes:
        lines: lines of code; docstrings and comments are no code.
        tokens: of code, a line of code.
        comments: a line of code.
        private: private functions at the top of a module.
        named_once: share of them that are named once at most in their module.
        called_once: share of them that have one caller there; the others that are named once are handed on as values:
            a row of a table, a callback, what is registered.
        longest: lines of the longest file, and its place.
    """

    lines: int
    tokens: float
    comments: float
    private: int
    named_once: float
    called_once: float
    longest: tuple[int, str]

    @staticmethod
    def of(modules: Sequence[Module]) -> Density:
        """Counts of all modules together."""
        silent = {
            tokenize.NL,
            tokenize.NEWLINE,
            tokenize.INDENT,
            tokenize.DEDENT,
            tokenize.ENDMARKER,
        }
        tokens = comments = lines = private = once = called_once = 0
        for module in modules:
            code_lines: set[int] = set()
            for token in tokenize.generate_tokens(io.StringIO(module.text).readline):
                if token.type == tokenize.COMMENT:
                    comments += 1
                elif token.type not in silent and token.start[0] not in module.said:
                    tokens += 1
                    code_lines.add(token.start[0])
            lines += len(code_lines)
            named = Counter(node.id for node in ast.walk(module.tree) if isinstance(node, ast.Name))
            calls = [node.func for node in module.nodes if isinstance(node, ast.Call)]
            called_here = Counter(call.id for call in calls if isinstance(call, ast.Name))
            for node in module.tree.body:
                if isinstance(node, ast.FunctionDef) and node.name.startswith("_"):
                    private += 1
                    if named[node.name] <= 1:
                        once += 1
                        called_once += called_here[node.name] == 1
        longest = max((module.text.count("\n"), str(module.path)) for module in modules)
        return Density(
            lines=lines,
            tokens=tokens / max(lines, 1),
            comments=comments / max(lines, 1),
            private=private,
            named_once=once / max(private, 1),
            called_once=called_once / max(private, 1),
            longest=longest,
        )


# --- imports ---------------------------------------------------------------------------------------------------------


def imports(module: Module, names: set[str], *, lazy: bool) -> Iterator[str]:
    """Modules of the package that one imports at run time."""
    for node in module.nodes if lazy else _at_head(module.tree.body):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            deeper = {f"{node.module}.{alias.name}" for alias in node.names} & names
            yield from deeper or ({node.module} & names)


def imports_by_text(module: Module) -> Iterator[str]:
    """Modules of the package that a string in a call of `import_module` names."""
    for node in module.nodes:
        if isinstance(node, ast.Call) and called(node) in ("import_module", "__import__"):
            for word in node.args:
                if isinstance(word, ast.Constant) and str(word.value).startswith(f"{PACKAGE}."):
                    yield str(word.value)


def called(node: ast.Call) -> str:
    """The last word of what is called."""
    function = node.func
    return function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")


def _at_head(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that run when a module is imported, without those for the type checker."""
    for node in body:
        if isinstance(node, ast.If):
            if "TYPE_CHECKING" not in ast.unparse(node.test):
                yield from _at_head(node.body)
            yield from _at_head(node.orelse)
        elif isinstance(node, ast.Try):
            yield from _at_head(node.body)
        else:
            yield node


def circles_in(arrows: Mapping[str, set[str]]) -> list[list[str]]:
    """Groups of nodes that can be reached from each other, by repeatedly following all arrows."""
    reached = {name: set(targets) for name, targets in arrows.items()}
    for middle in reached:
        for targets in reached.values():
            if middle in targets:
                targets |= reached[middle]
    groups = {
        tuple(sorted(n for n in reached[name] if name in reached.get(n, ()))) for name in reached
    }
    return [list(group) for group in sorted(groups) if len(group) > 1]
