"""A step record is printed as a MATLAB function for Coder and Simulink (%#codegen) that also runs in GNU Octave."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch._version import __version__
from erclutch.arithmetic.elementary import format_of
from erclutch.arithmetic.record import BINARY, Node
from erclutch.export.c.c_printer import indented
from erclutch.export.encode import comment
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_recording import StepRecord

_WIDEST = 90
_PATTERNS = {
    "negate": "(-{0})",
    "less": "({0} < {1})",
    "finite": "isfinite({0})",
    "both": "({0} && {1})",
    "either": "({0} || {1})",
    "opposite": "(~{0})",
    "choose": "pick({0}, {1}, {2})",
}


def _class(step: ExportedStep) -> str:
    return "single" if step.precision.width == 32 else "double"


def _number(step: ExportedStep, value: float) -> str:
    if np.isinf(value):
        text = "Inf" if value > 0 else "-Inf"
    else:
        held = step.precision.round(value)
        text = f"{held:.9g}" if step.precision.width == 32 else repr(float(held))
    return f"single({text})" if step.precision.width == 32 else (f"({text})" if text.startswith("-") else text)


def step_function(step: ExportedStep, record: StepRecord) -> str:
    """NAME_step.m: [effort, flags, state] = NAME_step(u, state)."""
    n = step.name
    inputs = "\n".join(
        f"%   u({i + 1})  {comment(f'{name} [{unit}]')}"
        for i, (name, unit) in enumerate(zip(step.inputs, step.units, strict=True))
    )
    equation = "\n".join(f"% {comment(line)}".rstrip() for line in step.model.equation())
    helpers = _PICK if step.network is None else f"{_PICK}\n{_network(step)}"
    return f"""function [effort, flags, state] = {n}_step(u, state) %#codegen
%{n.upper()}_STEP One sample of {step.headline}.
%   [EFFORT, FLAGS, STATE] = {n.upper()}_STEP(U, STATE), all of class {_class(step)} but FLAGS, which is uint32.
%   STATE has {record.size} elements, zeros before the first sample.
{inputs}
%   effort in {comment(step.model.units.effort or "1")}; flags by bits: 1 far from the training
%   rows, 2 input not finite, 4 both fields on, 8 effort limited.{_period(step)}
%
% Written by erclutch {__version__} from the numbers of {n}.c. Model {step.digest}
%
{equation}
    assert(isa(u, '{_class(step)}') && isa(state, '{_class(step)}'));
{indented(_lines(step, record))}
end

{helpers}"""


def _period(step: ExportedStep) -> str:
    if step.stages or step.filter:
        return f"\n%   Call it every {step.period:.9g} s."
    return "\n%   Call it at the sampling period of the training data." if step.model.past else ""


def block_function(step: ExportedStep, record: StepRecord) -> str:
    """NAME_block.m: the step with its state inside, for a MATLAB Function block."""
    n = step.name
    return f"""function [effort, flags] = {n}_block(u) %#codegen
%{n.upper()}_BLOCK {n}_step with its state inside: for a MATLAB Function block.
    persistent state
    if isempty(state)
        state = zeros({record.size}, 1, '{_class(step)}');
    end
    [effort, flags, state] = {n}_step({_class(step)}(u), state);
end
"""


def _lines(step: ExportedStep, made: StepRecord) -> Iterator[str]:
    record = made.record.flat()
    places = {name: f"u({i + 1})" for i, name in enumerate(made.inputs)}
    places |= {name: f"state({i + 1})" for i, name in enumerate(record.after)}
    at = len(record.after)
    for name, length in record.registers().items():
        places[name], at = str(at), at + length
    texts: dict[int, str] = {}
    tables: dict[Any, str] = {}
    nodes = record.needed()
    uses = Counter(a.index for n in nodes for a in n.arguments)
    uses.update(n.index for n in [*record.outputs, *record.after.values()])
    for node in nodes:
        name = f"table{node.index}"
        if node.operation == "table":
            places[name] = tables.setdefault(node.value, name)
        if places.get(name) == name:
            rows = "; ...\n        ".join(" ".join(str(int(entry)) for entry in row) for row in node.value)
            yield f"table{node.index} = logical([{rows}]);"
        text = _expression(step, node, [texts[a.index] for a in node.arguments], places)
        plain = node.operation in ("input", "constant", "state")
        if plain or (uses[node.index] == 1 and len(text) <= _WIDEST and node.operation != "network"):
            texts[node.index] = text
            continue
        yield f"t{node.index} = {text};"
        texts[node.index] = f"t{node.index}"
    effort, *truths = (texts[n.index] for n in record.outputs)
    yield f"effort = {effort};"
    yield f"flags = {' + '.join(f'{bit} * uint32({t})' for bit, t in zip(made.flags, truths, strict=True))};"
    yield f"next = zeros({made.size}, 1, '{_class(step)}');"
    for i, node in enumerate(record.after.values()):
        yield f"next({i + 1}) = {texts[node.index]};"
    entering = record.entering()
    for name, length in record.registers().items():
        first, now, going = int(places[name]) + 1, *(texts[n.index] for n in entering[name])
        last = first + length - 1
        moved = f"[{now}; state({first}:{last - 1})]" if length > 1 else now
        yield f"if {going}"
        yield f"    next({first}:{last}) = {moved};"
        yield "else"
        yield f"    next({first}:{last}) = {now};"
        yield "end"
    yield "state = next;"


def _expression(step: ExportedStep, node: Node, a: list[str], places: dict[str, str]) -> str:
    operation = node.operation
    if operation in ("input", "state"):
        place = places[str(node.value)]
        return f"({place} > 0.5)" if node.kind == "truth" else place
    if operation == "delay":
        name, rows = node.value
        return f"pick({a[1]}, state({int(places[name]) + rows}), {a[0]})"
    if operation == "constant":
        return _number(step, float(node.value or 0.0))
    if operation in BINARY:
        return f"({a[0]} {BINARY[operation]} {a[1]})"
    if operation in _PATTERNS:
        return _PATTERNS[operation].format(*a)
    if operation == "nearest":
        magic = _number(step, format_of(step.precision).magic)
        return f"(({a[0]} + {magic}) - {magic})"
    if operation == "power":
        return f"max({a[0]}, realmin('{_class(step)}')) ^ {a[1]}"
    if operation == "table":
        return f"{places[f'table{node.index}']}(fix({a[0]}) + 1, fix({a[1]}) + 1)"
    if operation == "network":
        return f"network([{'; '.join(a)}])"
    return f"{'abs' if operation == 'absolute' else operation}({', '.join(a)})"


_PICK = """function y = pick(condition, yes, no)
    if condition
        y = yes;
    else
        y = no;
    end
end
"""


def _matrix(step: ExportedStep, values: NDArray[np.float64]) -> str:
    digits = 9 if step.precision.width == 32 else 17
    rows = np.atleast_2d(np.asarray(values, step.precision.dtype))
    lines = [", ".join(f"{float(v):.{digits}g}" for v in row) for row in rows]
    # MATLAB breaks a row of a matrix with dots; a semicolon ends it.
    text = "; ...\n        ".join(_wrapped(line) for line in lines)
    return f"{_class(step)}([{text}])"


def _wrapped(line: str) -> str:
    numbers = line.split(", ")
    groups = [", ".join(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]
    return ", ...\n        ".join(groups)


def _network(step: ExportedStep) -> str:
    model = step.network
    assert model is not None
    s, w = model.scaling, model.weights
    lines = [f"x = (x - {_matrix(step, s.offset[:, None])}) ./ {_matrix(step, s.scale[:, None])};"]
    if model.structure.kind == "rbfn":
        lines += [f"centres = {_matrix(step, w['centres'])};"]
        lines += [f"squares = {_matrix(step, w['spreads'][:, None] ** 2)};"]
        lines += [f"a = zeros({model.structure.hidden[0]}, 1, '{_class(step)}');"]
        lines += ["for i = 1:numel(a)", "    d = x - centres(i, :)';"]
        lines += [f"    a(i) = exp({_number(step, -0.5)} * sum(d .* d) / squares(i));", "end"]
        out, start = w["w"], w["b"][0]
    else:
        for i in range(1, len(model.structure.hidden) + 1):
            lines += [f"w{i} = {_matrix(step, w[f'W{i}'])};", f"b{i} = {_matrix(step, w[f'b{i}'][:, None])};"]
            lines += [f"a{i} = tanh(w{i} * {f'a{i - 1}' if i > 1 else 'x'} + b{i});"]
        lines += [f"a = a{len(model.structure.hidden)};"]
        out, start = w["W_out"][0], w["b_out"][0]
    lines += [f"y = {_matrix(step, out[None, :])} * a + {_number(step, float(start))};"]
    lines += [f"y = y * {_number(step, s.effort_scale)} + {_number(step, s.effort_offset)};"]
    return f"function y = network(x)\n{indented(lines)}\nend\n"
