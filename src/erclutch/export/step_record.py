"""The whole step as one record of arithmetic and choices, state in and state out: for targets that are not C.

Every condition is a choice between two numbers, so the record has no branches and prints as a dataflow graph (ONNX) or
as straight-line code (MATLAB). `emulate` says the same of whole sequences; the conformance tests hold both together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from erclutch.elementary import less_select
from erclutch.export.graph import Graph, Node, Traced
from erclutch.export.program import BOTH_FIELDS, LARGEST_ANGLE, LIMITED, NON_FINITE, OUTSIDE, Program, Window
from erclutch.networks.model import NetworkModel

_INFINITE = float("inf")


@dataclass(frozen=True)
class Register:
    """The last values of a signal, the newest first.

    Attributes:
        name: of it; the value k rows back is the graph's input ``name@k``.
        length: values.
        now: what goes in; it fills the whole register at the first good row.
        reads: the k that are read.
    """

    name: str
    length: int
    now: Node
    reads: tuple[int, ...]


@dataclass(frozen=True)
class StepRecord:
    """One step.

    Attributes:
        graph: its arithmetic; ``network`` nodes stand for the forward pass.
        inputs: the graph's names of the step's inputs.
        effort, flags: results; flags as a whole number.
        after: new value of each number of the state, all of them 0 after a reset.
        registers: the rest of the state.
        started: name of the number that is 1 once a good row has come; None without a state.
    """

    graph: Graph
    inputs: tuple[str, ...]
    effort: Node
    flags: Node
    after: Mapping[str, Node]
    registers: tuple[Register, ...]
    started: str | None

    @property
    def size(self) -> int:
        """Numbers of the state."""
        return len(self.after) + sum(r.length for r in self.registers)


def has_memory(program: Program) -> bool:
    """Whether the effort depends on earlier rows (other than in place of a bad one)."""
    return bool(program.lag or program.past or program.filter)


def step_record(program: Program, *, remember: bool = True) -> StepRecord:
    """The record of a program's step.

    Args:
        program: what to record.
        remember: keep the last good row to stand in for a bad one; without it, and only for a model without memory,
            there is no state, and the effort of a bad row is 0.
    """
    made = _Step(program, remember or has_memory(program))
    made.receive()
    made.result()
    graph = made.graph
    effort, flags = (made.node(x) for x in (made.effort, made.flags))
    after = {name: made.node(x) for name, x in made.after.items()}
    graph.outputs = [effort, flags, *after.values(), *(r.now for r in made.registers)]
    started = "started" if made.remember else None
    return StepRecord(graph, tuple(made.names), effort, flags, after, tuple(made.registers), started)


def inlined(graph: Graph, into: Graph, inputs: Mapping[str, Any]) -> list[Traced]:
    """The outputs of a record as values of another one."""
    known: dict[int, Node] = {}
    for node in graph.needed():
        if node.operation == "input":
            known[node.index] = inputs[str(node.value)].node
        else:
            arguments = tuple(known[a.index] for a in node.arguments)
            known[node.index] = into.node(node.operation, arguments, node.value, node.kind)
    return [Traced(into, known[n.index]) for n in graph.outputs]


def _is(condition: Any, yes: Any, no: Any) -> Any:
    """Yes where a condition is 1, no where it is 0."""
    if isinstance(condition, float):
        return yes if condition else no
    return less_select(0.5, condition, yes, no)


def _held(x: Any, low: float, high: float) -> Any:
    below = less_select(x, high, x, high)
    return less_select(low, below, below, low)


@dataclass
class _Step:
    """The step while it is recorded."""

    program: Program
    remember: bool
    graph: Graph = field(default_factory=Graph)
    names: list[str] = field(default_factory=list[str])
    after: dict[str, Any] = field(default_factory=dict[str, Any])
    registers: list[Register] = field(default_factory=list[Register])
    effort: Any = 0.0
    flags: Any = 0.0

    def node(self, x: Any) -> Node:
        return x.node if isinstance(x, Traced) else self.graph.node("constant", (), float(x))

    def number(self, name: str) -> Traced:
        return self.graph.input(name)

    # --- input ---------------------------------------------------------------------------------------------------

    def receive(self) -> None:
        """The last good row, and what is known of it."""
        p, e = self.program, self.program.elements
        self.names = [f"u{i}" for i in range(len(p.inputs))]
        given: list[Any] = [self.number(name) for name in self.names]
        good: Any = 1.0
        for i, x in enumerate(given):
            angle = p.filter is not None and e <= i < 2 * e
            good = less_select(np.absolute(x), LARGEST_ANGLE if angle else _INFINITE, good, 0.0)
        self.good = good
        self.started: Any = good
        self.started_before: Any = 0.0
        rows: list[Any] = [_is(good, x, 0.0) for x in given]
        if self.remember:
            self.started_before = self.number("started")
            self.started = _is(good, 1.0, self.started_before)
            self.after["started"] = self.started
            for i, x in enumerate(given):
                if p.filter is not None and e <= i < 2 * e:
                    rows[i] = self._speed(x, i - e)
                    continue
                rows[i] = _is(good, x, self.number(f"last{i}"))
                self.after[f"last{i}"] = rows[i]
        self.rows = rows

    def _speed(self, measured: Any, i: int) -> Any:
        """The derivative filter of one angle."""
        f, period = self.program.filter, self.program.period or 0.0
        assert f is not None
        position, speed = self.number(f"position{i}"), self.number(f"speed{i}")
        predicted = position + period * speed
        innovation = _is(self.good, self._turned(measured - predicted), 0.0)
        first = _is(self.good, self._turned(measured), position)
        turned = self._turned(predicted + f.g * innovation)
        self.after[f"position{i}"] = _is(self.started_before, turned, first)
        now = _is(self.started_before, speed + f.h * innovation / period, speed)
        self.after[f"speed{i}"] = now
        return now

    def _turned(self, x: Any) -> Any:
        f = self.program.filter
        assert f is not None
        if f.turn is None:
            return x
        magic = 1.5 * 2.0**self.program.precision.fraction
        turns = (x * (1.0 / f.turn) + magic) - magic
        return x - turns * f.turn

    # --- effort --------------------------------------------------------------------------------------------------

    def result(self) -> None:
        """Effort, flags and what is remembered."""
        p, rows, e = self.program, self.rows, self.program.elements
        fields = rows[:e]
        slips = [rows[1]] if e == 1 else [rows[2] - rows[3], -rows[2] - rows[3]]
        extras = rows[2 * e :]
        windows = [p.field] * e + [p.slip] * e + list(p.extras)
        outside: Any = 0.0
        for x, window in zip([*fields, *slips, *extras], windows, strict=True):
            outside = less_select(x, window.warn[0], 1.0, less_select(window.warn[1], x, 1.0, outside))
        both: Any = 0.0
        if e == 2:
            both = less_select(p.both, fields[0], less_select(p.both, fields[1], 1.0, 0.0), 0.0)
        fields, slips = self._within(fields, [p.field] * e), self._within(slips, [p.slip] * e)
        extras = self._within(extras, list(p.extras))
        value = self._effort(fields, slips, extras)
        self._limit(value, OUTSIDE * outside + BOTH_FIELDS * both)

    def _within(self, signals: list[Any], windows: list[Window]) -> list[Any]:
        return [_held(x, *w.hold) for x, w in zip(signals, windows, strict=True)]

    def _limit(self, value: Any, flags: Any) -> None:
        low, high = self.program.limits
        before: Any = self.number("effort_before") if self.remember else 0.0
        held = less_select(np.absolute(value), _INFINITE, _held(value, low, high), before)
        within = less_select(value, low, 0.0, less_select(high, value, 0.0, 1.0))
        limited = less_select(np.absolute(value), _INFINITE, 1.0 - within, 1.0)
        self.effort = _is(self.started, held, 0.0)
        if self.remember:
            self.after["effort_before"] = self.effort
        flags = flags + LIMITED * limited + _is(self.good, 0.0, float(NON_FINITE))
        self.flags = _is(self.started, flags, float(NON_FINITE))

    def _effort(self, fields: list[Any], slips: list[Any], extras: list[Any]) -> Any:
        p = self.program
        fluids = [self._fluid(x, i) for i, x in enumerate(fields)]
        if p.law is not None:
            names = [f"x{i + 1}" for i in range(p.elements)] + [f"w{i + 1}" for i in range(p.elements)]
            return inlined(p.law, self.graph, dict(zip(names, [*fluids, *slips], strict=True)))[0]
        assert isinstance(p.model, NetworkModel)
        base = self._base(fluids, slips)
        back = p.rows_back
        pasts = [self._register(f"past{i}", back, x, p.past) for i, x in enumerate(base)] if back else []
        past = [values[k] for k in p.past for values in pasts]
        nodes = tuple(self.node(x) for x in [*base, *past, *extras])
        return Traced(self.graph, self.graph.node("network", nodes))

    def _base(self, fluids: list[Any], slips: list[Any]) -> list[Any]:
        if self.program.elements == 1:
            return [fluids[0], slips[0]]
        signed = fluids[0] - fluids[1]
        if "w1" in self.program.base:
            return [signed, *slips]
        return [signed, 0.5 * (slips[0] - slips[1]), -0.5 * (slips[0] + slips[1])]

    def _register(self, name: str, length: int, now: Any, reads: tuple[int, ...]) -> dict[int, Any]:
        """The values that were k rows back; before the first row all is as in the first."""
        self.registers.append(Register(name, length, self.node(now), tuple(k for k in reads if k)))
        return {k: _is(self.started_before, self.number(f"{name}@{k}"), now) if k else now for k in reads}

    def _fluid(self, applied: Any, i: int) -> Any:
        """What the field in the fluid is: command, lag, delay."""
        u = inlined(self.program.command, self.graph, {"field": applied})[0]
        lag = self.program.lag
        if lag is None:
            return u
        before = _is(self.started_before, self.number(f"lag{i}"), u)
        rise, tau = lag.rise, lag.tau_rise
        share: Any = rise
        if lag.fall is not None:
            grown = (u - before) * before
            share, tau = less_select(grown, 0.0, lag.fall, rise), less_select(grown, 0.0, lag.tau_fall, tau)
        rest = share - 1.0 if isinstance(share, Traced) else self._rounded(share) - 1.0
        x = _is(self.started_before, share * u - rest * before, u)
        slope = (u - x) / tau
        self.after[f"lag{i}"] = x
        old, new = lag.rows - 1, lag.rows - 2
        values = self._register(f"x{i}", old, x, (old, new))
        slopes = self._register(f"slope{i}", old, slope, (old, new))
        bend = slopes[old] * lag.bend_before + slopes[new] * lag.bend_after
        return values[old] + (values[new] - values[old]) * lag.forward + bend * lag.reach

    def _rounded(self, value: float) -> float:
        return self.program.precision.round(value)
