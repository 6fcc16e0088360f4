"""A record of arithmetic as C: one statement a value that is used twice, the rest folded into expressions.

Every operation is in brackets, so C evaluates what NumPy evaluated, in the same order.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from erclutch.export.graph import BINARY, FUNCTIONS, ON_BITS, Graph, Node
from erclutch.precision import Precision

_WIDEST = 92  # characters of an expression before it gets a name of its own


@dataclass
class Printer:
    """Turns nodes into C.

    Attributes:
        prefix: of every name in the file, with its underscore.
        precision: of constants.
        names: C expression of each input.
    """

    prefix: str
    precision: Precision
    names: Mapping[str, str]
    _text: dict[int, str] = field(default_factory=dict[int, str])

    def lines(self, graph: Graph) -> Iterator[str]:
        """Declarations of everything that the outputs need."""
        nodes = graph.needed()
        uses = Counter(a.index for n in nodes for a in n.arguments)
        uses.update(n.index for n in graph.outputs)
        for node in nodes:
            text = self._expression(node)
            simple = node.operation in ("input", "constant")
            folded = uses[node.index] == 1 and len(text) <= _WIDEST and not _named(node)
            if simple or folded:
                self._text[node.index] = text
                continue
            c_type = f"{self.prefix}real" if node.kind == "real" else self.precision.c_bits
            yield f"const {c_type} t{node.index} = {_bare(text)};"
            self._text[node.index] = f"t{node.index}"

    def results(self, graph: Graph) -> list[str]:
        """The outputs, after `lines`."""
        return [_bare(self._text[n.index]) for n in graph.outputs]

    def _expression(self, node: Node) -> str:
        a = [self._text[n.index] for n in node.arguments]
        if node.operation == "input":
            return self.names[str(node.value)]
        if node.operation == "constant":
            return self._constant(node)
        if node.operation in BINARY:
            return f"({a[0]} {BINARY[node.operation]} {a[1]})"
        if node.operation in ON_BITS:
            return f"({a[0]} {ON_BITS[node.operation]} {a[1]})"
        if node.operation in FUNCTIONS:
            return f"{self.prefix}{node.operation}({', '.join(_bare(x) for x in a)})"
        return self._special(node.operation, a)

    def _special(self, operation: str, a: Sequence[str]) -> str:
        if operation == "negate":
            return f"(-{a[0]})"
        if operation == "less_select":
            return f"(({a[0]} < {a[1]}) ? {a[2]} : {a[3]})"
        if operation == "real_from_bits":
            return f"(({self.prefix}real){a[0]})"
        return f"{self.prefix}{operation}({_bare(a[0])})"

    def _constant(self, node: Node) -> str:
        if node.kind == "bits":
            value = int(node.value or 0)
            return f"{value}{self.precision.bits_suffix}" if value < 256 else f"0x{value:x}{self.precision.bits_suffix}"
        text = self.precision.constant(float(node.value or 0.0))
        return f"({text})" if text.startswith("-") else text


def _named(node: Node) -> bool:
    """Bits get a name whatever they are: a cast of a composite expression would break MISRA C 10.8."""
    return node.kind == "bits" or node.operation in ("less_select", "real_from_bits")


def _bare(text: str) -> str:
    """Without brackets around all of it."""
    if not text.startswith("(") or not text.endswith(")"):
        return text
    depth = 0
    for i, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0 and i < len(text) - 1:
            return text
    return text[1:-1]


def functions_used(graphs: Sequence[Graph]) -> set[str]:
    """Names of the functions that records call."""
    return {n.operation for g in graphs for n in g.needed() if n.operation in FUNCTIONS}


def table(c_type: str, name: str, values: Sequence[str], per_line: int = 4) -> str:
    """A constant table."""
    rows = [", ".join(values[i : i + per_line]) for i in range(0, len(values), per_line)]
    return f"static const {c_type} {name}[{len(values)}] = {{\n    " + ",\n    ".join(rows) + "\n};\n"
