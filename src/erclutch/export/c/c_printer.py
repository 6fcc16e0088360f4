"""A record is printed as C: one statement for a value that is used twice, the rest folded into expressions.

Every operation is in brackets, so C evaluates what NumPy evaluated, in the same order. A truth is a condition where it
is used, and 0 or 1 where it is kept. Delay registers of one length lie in one ring buffer.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from erclutch.arithmetic.precision import Precision
from erclutch.arithmetic.record import BINARY, FUNCTIONS, ON_BITS, Node, Record

#: Inputs of a network up to which they are numbers and no array: processors without vectors save the loops, and those
#: with vectors need not wait until numbers that were stored one by one can be loaded together.
WRITTEN_OUT = 16
_WIDEST = 92  # characters of an expression before it gets a name of its own


@dataclass
class Printer:
    """Turns nodes into C.

    Attributes:
        prefix: of every name in the file, with its underscore.
        precision: of constants.
        record: what is printed.
        names: C expression of each input; an input that is not there goes by its own name.
        layout: the record whose delay registers lie in the state; None is the record itself.
        conditions: by the label of a truth, 0 or 1 in C that must be 1 besides for it to hold.
    """

    prefix: str
    precision: Precision
    record: Record
    names: Mapping[str, str] = field(default_factory=dict[str, str])
    layout: Record | None = None
    conditions: Mapping[str, str] = field(default_factory=dict[str, str])
    _text: dict[int, str] = field(default_factory=dict[int, str])
    _comparisons: dict[int, str] = field(default_factory=dict[int, str])
    _tables: dict[Any, str] = field(default_factory=dict[Any, str])

    def lines(self) -> Iterator[str]:
        """Declarations of everything that the outputs and the state need."""
        nodes = self.record.needed()
        uses = Counter(a.index for n in nodes for a in n.arguments)
        uses.update(n.index for n in self.record.outputs)
        # What the state becomes, and what goes into a delay, gets a name: it is written after all else is read.
        new_states = [n.index for n in self.record.after.values()]
        uses.update(2 * new_states)
        entering = [n.arguments[0].index for n in nodes if n.operation == "delay"]
        uses.update(2 * entering)
        choosing = Counter(n.arguments[0].index for n in nodes if n.operation == "choose")
        # A call that is an arm of a choice stays there, however wide: C computes the arm that it takes.
        choices = (n for n in nodes if n.operation == "choose")
        arms = {a.index for n in choices for a in n.arguments[1:] if a.operation == "call"}
        # A test of the bits that chooses gets a name, too: what it says of a number stands behind it.
        testing = [n.index for n in nodes if n.operation == "finite" and n.index in choosing]
        uses.update(2 * testing)
        yield from self._slots()
        filled: set[str] = set()
        for node in nodes:
            if node.operation == "delay" and node.value[0] not in filled:
                filled.add(node.value[0])
                yield from self._fill(node)
            if node.operation == "network" and len(node.arguments) > WRITTEN_OUT:
                inputs = ", ".join(bare(self._text[a.index]) for a in node.arguments)
                yield f"const {self.prefix}real v{node.index}[{len(node.arguments)}] = {{{inputs}}};"
            if node.operation == "table":
                yield from self._table(node)
            text = self._expression(node)
            # An input, a constant, or a truth of the state is as short as its name would be.
            simple = node.operation in ("input", "constant") or (
                node.operation == "state" and node.kind == "truth"
            )
            short = len(text) <= _WIDEST or node.index in arms
            # Bits get a name whatever they are: a cast of a composite expression would break MISRA C 10.8.
            named = node.kind == "bits" or node.operation in (
                "real_from_bits",
                "choose",
                "network",
            )
            folded = uses[node.index] == 1 and short and not named
            if simple or folded:
                self._text[node.index] = text
                continue
            name = self._name(node)
            kept = bare(_as_number(text, node))
            if name in self.conditions:
                kept = f"({kept}) & {self.conditions[name]}"
            yield f"const {self._type(node)} {name} = {kept};"
            self._text[node.index] = f"({name} != 0u)" if node.kind == "truth" else name
            yield from self._finite(node, name)
            if _compares(node) and choosing[node.index] < uses[node.index]:
                self._comparisons[node.index] = text

    def results(self) -> list[str]:
        """The outputs, after `lines`; a truth as 0 or 1."""
        return [bare(_as_number(self._text[n.index], n)) for n in self.record.outputs]

    def kept(self) -> Iterator[str]:
        """Statements that set the state, after `lines`."""
        for name, node in self.record.after.items():
            yield f"state->{name} = {bare(_as_number(self._text[node.index], node))};"
        entering = self.record.entering()
        for name, (length, place) in places_of(self.record).items():
            yield f"state->ring{length}[at{length}][{place}] = {self._text[entering[name][0].index]};"
        for length in rings_of(self.record):
            yield f"state->at{length} = next{length};"

    def _slots(self) -> Iterator[str]:
        """Where in each ring a signal some rows back lies; the oldest one makes room for the present one.

        A place beyond the ring comes from memory that nobody has reset or that somebody has forged: it is taken as 0.
        """
        places = places_of(self.layout or self.record)
        nodes = [n for n in self.record.needed() if n.operation in ("delay", "earlier")]
        for length in sorted({places[n.value[0]][0] for n in nodes}):
            yield f"const uint32_t at{length} = (state->at{length} < {length}u) ? state->at{length} : 0u;"
        for length in rings_of(self.record):
            yield f"const uint32_t next{length} = ((at{length} + 1u) < {length}u) ? (at{length} + 1u) : 0u;"
        reads: set[tuple[int, int]] = set()  # length of the ring, and rows back
        for node in nodes:
            if node.operation == "delay":
                register, rows = node.value
                length, _ = places[register]
                reads.add((length, rows))
        for length, rows in sorted(reads):
            if rows < length - 1:
                ahead = f"(at{length} + {length - rows}u)"
                place = f"({ahead} < {length}u) ? {ahead} : ({ahead} - {length}u)"
                yield f"const uint32_t back{length}_{rows} = {place};"

    def _fill(self, node: Node) -> Iterator[str]:
        """In the first row a delay is full of the present value."""
        length, place = places_of(self.record)[node.value[0]]
        yield f"if ({_number(self._text[node.arguments[1].index])} == 0u)"
        yield "{"
        yield "    uint32_t j;"
        yield f"    for (j = 0u; j < {length}u; j++)"
        yield "    {"
        yield f"        state->ring{length}[j][{place}] = {bare(self._text[node.arguments[0].index])};"
        yield "    }"
        yield "}"

    def _table(self, node: Node) -> Iterator[str]:
        """A table, of truths as bits, 32 a word, printed where it is first used; and the place of the entry."""
        values = np.array(node.value)
        if node.value not in self._tables:
            self._tables[node.value] = name = f"table{node.index}"
            entries = values.ravel().tolist()
            if node.kind == "truth":
                words: list[str] = []
                for start in range(0, len(entries), 32):
                    bits = enumerate(entries[start : start + 32])
                    word = sum(bit << place for place, bit in bits)
                    words.append(f"0x{word:08x}u")
                yield from table("uint32_t", name, words).splitlines()
            elif node.kind == "bits":
                yield from table(
                    "uint8_t", name, [f"{entry}u" for entry in entries], 16
                ).splitlines()
            else:
                reals = list(map(self.precision.constant, entries))
                yield from table(f"{self.prefix}real", name, reals).splitlines()
        at, *more = (f"((uint32_t){self._text[a.index]})" for a in node.arguments)
        for size, place in zip(values.shape[1:], more, strict=True):
            at = f"(({at} * {size}u) + {place})"
        yield f"const uint32_t entry{node.index} = {bare(at)};"

    def _name(self, node: Node) -> str:
        """The value's label, unless another value has the same."""
        label = self.record.labels.get(node.index, "")
        if label and list(self.record.labels.values()).count(label) == 1:
            return label
        return f"t{node.index}"

    def _finite(self, node: Node, name: str) -> Iterator[str]:
        """What a kept truth says of numbers: a static analysis cannot see that the bits do (docs/proof.md)."""
        tested = [n.arguments[0] for n in self._all_of(node) if n.operation == "finite"]
        if tested:
            facts = " && ".join(f"\\is_finite({bare(self._text[x.index])})" for x in tested)
            yield f"/*@ assert ({name} == 0u) || ({facts}); */"

    def _all_of(self, truth: Node) -> Iterator[Node]:
        """The truths that must all hold for this one to hold, but for those behind a name of their own."""
        if truth.operation == "both":
            for part in truth.arguments:
                if not re.fullmatch(r"\(\w+ != 0u\)", self._text[part.index]):
                    yield from self._all_of(part)
        else:
            yield truth

    def _type(self, node: Node) -> str:
        types = {"real": f"{self.prefix}real", "bits": self.precision.c_bits, "truth": "uint32_t"}
        return types[node.kind]

    def _expression(self, node: Node) -> str:
        a = [self._text[n.index] for n in node.arguments]
        if node.operation == "input":
            return self.names.get(str(node.value), str(node.value))
        if node.operation == "state":
            if node.kind == "truth":
                return f"(state->{node.value} != 0u)"
            return f"state->{node.value}"
        if node.operation == "constant":
            return self._constant(node)
        if node.operation in BINARY:
            return f"({a[0]} {BINARY[node.operation]} {a[1]})"
        if node.operation in ON_BITS:
            return f"({a[0]} {ON_BITS[node.operation]} {a[1]})"
        if node.operation in (*FUNCTIONS, "call"):
            name = node.value if node.operation == "call" else node.operation
            return f"{self.prefix}{name}({', '.join(bare(x) for x in a)})"
        if node.operation == "network":
            inputs = [f"v{node.index}"] if len(a) > WRITTEN_OUT else [bare(x) for x in a]
            return f"{self.prefix}network({', '.join(inputs)})"
        if node.operation == "delay":
            return self._delayed(node)
        if node.operation == "earlier":
            return self._earlier(node)
        if node.operation == "choose":
            # Comparisons are written again where they choose: so an analysis sees that the choice keeps to the limits.
            return f"({self._comparisons.get(node.arguments[0].index, a[0])} ? {a[1]} : {a[2]})"
        if node.operation == "table" and node.kind != "truth":
            return f"{self._tables[node.value]}[entry{node.index}]"
        if node.kind == "truth":
            return self._truth(node, a)
        return self._special(node.operation, a)

    def _delayed(self, node: Node) -> str:
        name, rows = node.value
        length, place = places_of(self.record)[name]
        slot = {length: f"at{length}", length - 1: f"next{length}"}.get(
            rows, f"back{length}_{rows}"
        )
        return f"state->ring{length}[{slot}][{place}]"

    def _earlier(self, node: Node) -> str:
        """A row of a ring as the step before has left it."""
        name, rows = node.value
        length, place = places_of(self.layout or self.record)[name]
        at = f"at{length}"
        if rows < length:
            at = f"(({at} + {length - rows}u) < {length}u) ? ({at} + {length - rows}u) : ({at} - {rows}u)"
        return f"state->ring{length}[{at}][{place}]"

    def _truth(self, node: Node, a: Sequence[str]) -> str:
        if node.operation == "less":
            return f"({a[0]} < {a[1]})"
        if node.operation == "finite":
            return f"({self.prefix}finite({bare(a[0])}) != 0u)"
        if node.operation == "opposite":
            if not _number(a[0]):
                return f"(!{a[0]})"
            is_zero = bare(a[0]).replace(" != 0u", " == 0u")
            return f"({is_zero})"
        if node.operation == "table":
            name = self._tables[node.value]
            at = f"entry{node.index}"
            return f"((({name}[{at} >> 5u] >> ({at} & 31u)) & 1u) != 0u)"
        numbers = [_number(x) for x in a]
        on_numbers, on_conditions = ("&", "&&") if node.operation == "both" else ("|", "||")
        if None not in numbers:
            return f"(({numbers[0]} {on_numbers} {numbers[1]}) != 0u)"
        return f"({a[0]} {on_conditions} {a[1]})"

    def _special(self, operation: str, a: Sequence[str]) -> str:
        if operation == "negate":
            return f"(-{a[0]})"
        if operation == "real_from_bits":
            return f"(({self.prefix}real){a[0]})"
        return f"{self.prefix}{operation}({bare(a[0])})"

    def _constant(self, node: Node) -> str:
        if node.kind == "bits":
            value = int(node.value or 0)
            if value < 256:
                return f"{value}{self.precision.bits_suffix}"
            return f"0x{value:x}{self.precision.bits_suffix}"
        text = self.precision.constant(float(node.value or 0.0))
        return f"({text})" if text.startswith("-") else text


def _compares(truth: Node) -> bool:
    """Whether a truth is made of comparisons of numbers."""
    if truth.operation in ("both", "either", "opposite"):
        return all(map(_compares, truth.arguments))
    return truth.operation == "less"


def _number(condition: str) -> str | None:
    """A kept truth, 0 or 1, that a condition asks for."""
    inner = bare(condition)
    return inner.removesuffix(" != 0u") if inner.endswith(" != 0u") else None


def _as_number(text: str, node: Node) -> str:
    """An expression to keep: a truth as 0 or 1."""
    if node.kind != "truth":
        return text
    return _number(text) or f"{text} ? (uint32_t)1u : (uint32_t)0u"


def indented(lines: Iterable[str]) -> str:
    """The lines of a function's body."""
    return "\n".join(f"    {line}" for line in lines)


def bare(text: str) -> str:
    """Without brackets around all of it."""
    if not text.startswith("(") or not text.endswith(")"):
        return text
    depth = 0
    for i, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0 and i < len(text) - 1:
            return text
    return text[1:-1]


def rings_of(record: Record) -> dict[int, int]:
    """Rings of delay registers by length, and how many registers lie in each."""
    return dict(Counter(record.registers().values()))


def places_of(record: Record) -> dict[str, tuple[int, int]]:
    """Length of the ring and place in its rows of each register."""
    taken: Counter[int] = Counter()
    places: dict[str, tuple[int, int]] = {}
    for name, length in record.registers().items():
        places[name] = (length, taken[length])
        taken[length] += 1
    return places


def function(
    prefix: str,
    precision: Precision,
    name: str,
    record: Record,
    about: str,
) -> str:
    """A record of inputs and one output as a function."""
    printer = Printer(prefix, precision, record)
    needed = {n.value for n in record.needed() if n.operation == "input"}
    arguments = ", ".join(f"{prefix}real {given}" for given in record.inputs())
    unused = [f"(void){given};" for given in record.inputs() if given not in needed]
    body = indented([*printer.lines(), *unused, f"return {printer.results()[0]};"])
    return f"/* {about}. */\nstatic {prefix}real {prefix}{name}({arguments})\n{{\n{body}\n}}\n"


def functions_used(records: Sequence[Record]) -> set[str]:
    """Names of the elementary functions that records use, also through calls."""
    used: set[str] = set()
    for record in records:
        used |= {n.operation for n in record.needed() if n.operation in FUNCTIONS}
        used |= functions_used(list(record.calls.values()))
    return used


def table(
    c_type: str,
    name: str,
    values: Sequence[str],
    per_line: int = 4,
    of: str = "",
) -> str:
    """A constant table."""
    rows: list[str] = []
    for first in range(0, len(values), per_line):
        rows.append(", ".join(values[first : first + per_line]))
    body = ",\n    ".join(rows)
    return f"static const {c_type} {name}[{len(values)}]{of} = {{\n    {body}\n}};\n"
