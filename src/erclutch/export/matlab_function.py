"""A step record as a MATLAB function that MATLAB Coder and Simulink take (%#codegen), and that runs in GNU Octave."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from erclutch._version import __version__
from erclutch.export.c_effort import equation
from erclutch.export.graph import BINARY, Node
from erclutch.export.program import Program
from erclutch.export.step_record import StepRecord
from erclutch.networks.model import NetworkModel

_WIDEST = 90


def _class(program: Program) -> str:
    return "single" if program.precision.width == 32 else "double"


def _number(program: Program, value: float) -> str:
    if np.isinf(value):
        text = "Inf" if value > 0 else "-Inf"
    else:
        held = program.precision.round(value)
        text = f"{held:.9g}" if program.precision.width == 32 else repr(float(held))
    return f"single({text})" if program.precision.width == 32 else (f"({text})" if text.startswith("-") else text)


def step_function(program: Program, record: StepRecord) -> str:
    """NAME_step.m: [effort, flags, state] = NAME_step(u, state)."""
    n = program.name
    body = list(_lines(program, record))
    text = "\n".join(f"    {line}" if line else "" for line in body)
    inputs = "\n".join(
        f"%   u({i + 1})  {name} [{unit}]"
        for i, (name, unit) in enumerate(zip(program.inputs, program.units, strict=True))
    )
    comment = "\n".join(f"% {line}".rstrip() for line in equation(program))
    helpers = _helpers(program, record)
    return f"""function [effort, flags, state] = {n}_step(u, state) %#codegen
%{n.upper()}_STEP One sample of {program.model.title} ({program.model.name}).
%   [EFFORT, FLAGS, STATE] = {n.upper()}_STEP(U, STATE), all of class {_class(program)} but FLAGS, which is uint32.
%   STATE has {record.size} elements, zeros before the first sample.
{inputs}
%   effort in {program.model.units.effort or "1"}; flags by bits: 1 outside the training range, 2 input not finite,
%   4 both fields on, 8 effort limited.{_period(program)}
%
% Written by erclutch {__version__} from the numbers of {n}.c. Model {program.digest}
%
{comment}
    assert(isa(u, '{_class(program)}') && isa(state, '{_class(program)}'));
{text}
end

{helpers}"""


def _period(program: Program) -> str:
    if program.lag or program.filter:
        return f"\n%   Call it every {program.period:.9g} s."
    return "\n%   Call it at the sampling period of the training data." if program.past else ""


def block_function(program: Program, record: StepRecord) -> str:
    """NAME_block.m: the step with its state inside, for a MATLAB Function block."""
    n = program.name
    return f"""function [effort, flags] = {n}_block(u) %#codegen
%{n.upper()}_BLOCK {n}_step with its state inside: for a MATLAB Function block.
    persistent state
    if isempty(state)
        state = zeros({record.size}, 1, '{_class(program)}');
    end
    [effort, flags, state] = {n}_step({_class(program)}(u), state);
end
"""


def _lines(program: Program, record: StepRecord) -> Iterator[str]:
    places = {name: f"state({i + 1})" for i, name in enumerate(record.after)}
    at = len(record.after)
    for register in record.registers:
        places |= {f"{register.name}@{k}": f"state({at + k})" for k in register.reads}
        at += register.length
    places |= {name: f"u({i + 1})" for i, name in enumerate(record.inputs)}
    texts: dict[int, str] = {}
    nodes = record.graph.needed()
    uses = Counter(a.index for n in nodes for a in n.arguments)
    uses.update(n.index for n in record.graph.outputs)
    for node in nodes:
        text = _expression(program, node, [texts[a.index] for a in node.arguments], places)
        plain = node.operation in ("input", "constant")
        if plain or (uses[node.index] == 1 and len(text) <= _WIDEST and node.operation != "network"):
            texts[node.index] = text
            continue
        yield f"t{node.index} = {text};"
        texts[node.index] = f"t{node.index}"
    yield f"effort = {texts[record.effort.index]};"
    yield f"flags = uint32({texts[record.flags.index]});"
    yield f"next = zeros({record.size}, 1, '{_class(program)}');"
    for i, node in enumerate(record.after.values()):
        yield f"next({i + 1}) = {texts[node.index]};"
    at = len(record.after)
    for register in record.registers:
        first, last, now = at + 1, at + register.length, texts[register.now.index]
        moved = f"[{now}; state({first}:{last - 1})]" if register.length > 1 else now
        yield f"if {places[str(record.started)]} > 0.5"
        yield f"    next({first}:{last}) = {moved};"
        yield "else"
        yield f"    next({first}:{last}) = {now};"
        yield "end"
        at = last
    yield "state = next;"


def _expression(program: Program, node: Node, a: list[str], places: dict[str, str]) -> str:
    operation = node.operation
    if operation == "input":
        return places[str(node.value)]
    if operation == "constant":
        return _number(program, float(node.value or 0.0))
    if operation in BINARY:
        return f"({a[0]} {BINARY[operation]} {a[1]})"
    if operation == "negate":
        return f"(-{a[0]})"
    if operation == "less_select":
        return f"pick({a[0]} < {a[1]}, {a[2]}, {a[3]})"
    if operation == "power":
        return f"max({a[0]}, realmin('{_class(program)}')) ^ {a[1]}"
    if operation == "network":
        return f"network([{'; '.join(a)}])"
    return f"{'abs' if operation == 'absolute' else operation}({', '.join(a)})"


def _helpers(program: Program, record: StepRecord) -> str:
    pick = """function y = pick(condition, yes, no)
    if condition
        y = yes;
    else
        y = no;
    end
end
"""
    if any(n.operation == "network" for n in record.graph.needed()):
        return f"{pick}\n{_network(program)}"
    return pick


def _matrix(program: Program, values: NDArray[np.float64]) -> str:
    digits = 9 if program.precision.width == 32 else 17
    rows = np.atleast_2d(np.asarray(values, program.precision.dtype))
    lines = [", ".join(f"{float(v):.{digits}g}" for v in row) for row in rows]
    # MATLAB breaks a row of a matrix with dots; a semicolon ends it.
    text = "; ...\n        ".join(_wrapped(line) for line in lines)
    return f"{_class(program)}([{text}])"


def _wrapped(line: str) -> str:
    numbers = line.split(", ")
    groups = [", ".join(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]
    return ", ...\n        ".join(groups)


def _network(program: Program) -> str:
    model = program.model
    assert isinstance(model, NetworkModel)
    s, w = model.scaling, model.weights
    lines = [f"x = (x - {_matrix(program, s.offset[:, None])}) ./ {_matrix(program, s.scale[:, None])};"]
    if model.structure.kind == "rbfn":
        lines += [f"centres = {_matrix(program, w['centres'])};"]
        lines += [f"squares = {_matrix(program, w['spreads'][:, None] ** 2)};"]
        lines += [f"a = zeros({model.structure.hidden[0]}, 1, '{_class(program)}');"]
        lines += ["for i = 1:numel(a)", "    d = x - centres(i, :)';"]
        lines += [f"    a(i) = exp({_number(program, -0.5)} * sum(d .* d) / squares(i));", "end"]
        out, start = w["w"], w["b"][0]
    else:
        lines += ["a = x;"] if not model.structure.hidden else []
        before = "x"
        for i in range(1, len(model.structure.hidden) + 1):
            lines += [f"w{i} = {_matrix(program, w[f'W{i}'])};", f"b{i} = {_matrix(program, w[f'b{i}'][:, None])};"]
            lines += [f"a{i} = tanh(w{i} * {before} + b{i});"]
            before = f"a{i}"
        lines += [f"a = {before};"]
        out, start = w["W_out"][0], w["b_out"][0]
    lines += [f"y = {_matrix(program, out[None, :])} * a + {_number(program, float(start))};"]
    lines += [f"y = y * {_number(program, s.effort_scale)} + {_number(program, s.effort_offset)};"]
    body = "\n".join(f"    {line}" for line in lines)
    return f"function y = network(x)\n{body}\nend\n"
