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
from erclutch.export.recording.recorded_step import StepRecord

_WIDEST = 90  # characters of an expression that is used once and gets no name
#: MATLAB breaks a row of a matrix with dots; a semicolon ends it.
_SAME_ROW = ", ...\n        "
_NEXT_ROW = "; ...\n        "
_PATTERNS = {
    "negate": "(-{0})",
    "less": "({0} < {1})",
    "finite": "isfinite({0})",
    "both": "({0} && {1})",
    "either": "({0} || {1})",
    "opposite": "(~{0})",
    "choose": "pick({0}, {1}, {2})",
}


def number_class(step: ExportedStep) -> str:
    """MATLAB's class of the step's numbers."""
    return "single" if step.precision.width == 32 else "double"


def _number(step: ExportedStep, value: float) -> str:
    single = step.precision.width == 32
    held = step.precision.round(value)
    if np.isinf(value):
        text = "Inf" if value > 0 else "-Inf"
    elif single:
        text = f"{held:.9g}"
    else:
        text = repr(float(held))
    if single:
        return f"single({text})"
    return f"({text})" if text.startswith("-") else text


def step_function(step: ExportedStep, record: StepRecord) -> str:
    """NAME_step.m: [effort, flags, state] = NAME_step(u, state)."""
    n = step.name
    inputs = "\n".join(
        f"%   u({i + 1})  {comment(f'{name} [{unit}]')}"
        for i, (name, unit) in enumerate(zip(step.inputs, step.units, strict=True))
    )
    equation = "\n".join(f"% {comment(line)}".rstrip() for line in step.model.equation())
    helpers = _PICK if step.network is None else f"{_PICK}\n{_network(step)}"
    period = ""
    if step.stages or step.filter:
        period = f"\n%   Call it every {step.period:.9g} s."
    elif step.model.past:
        period = "\n%   Call it at the sampling period of the training data."
    return f"""function [effort, flags, state] = {n}_step(u, state) %#codegen
%{n.upper()}_STEP One sample of {step.headline}.
%   [EFFORT, FLAGS, STATE] = {n.upper()}_STEP(U, STATE), all of class {number_class(step)} but FLAGS, which is uint32.
%   STATE has {record.size} elements, zeros before the first sample.
{inputs}
%   effort in {comment(step.model.units.effort or "1")}; flags by bits: 1 far from the training
%   rows, 2 input not finite, 4 both fields on, 8 effort limited.{period}
%
% Written by erclutch {__version__} from the numbers of {n}.c. Model {step.digest}
%
{equation}
    assert(isa(u, '{number_class(step)}') && isa(state, '{number_class(step)}'));
{indented(_lines(step, record))}
end

{helpers}"""


def block_function(step: ExportedStep, record: StepRecord) -> str:
    """NAME_block.m: the step with its state inside, for a MATLAB Function block."""
    n = step.name
    return f"""function [effort, flags] = {n}_block(u) %#codegen
%{n.upper()}_BLOCK {n}_step with its state inside: for a MATLAB Function block.
    persistent state
    if isempty(state)
        state = zeros({record.size}, 1, '{number_class(step)}');
    end
    [effort, flags, state] = {n}_step({number_class(step)}(u), state);
end
"""


def _lines(step: ExportedStep, printed: StepRecord) -> Iterator[str]:
    """The body of the step: a line for each value that is used more than once or would be too wide in place."""
    record = printed.record.flat()
    registers = record.registers()  # rows by name
    # Where a name lies: inputs in u, numbers of the state first in state, then the delay registers.
    places = {name: f"u({i})" for i, name in enumerate(printed.inputs, start=1)}
    places |= {name: f"state({i})" for i, name in enumerate(record.after, start=1)}
    taken = len(record.after)
    for name, rows in registers.items():
        places[name] = str(taken)
        taken += rows

    nodes = record.needed()
    uses = Counter(argument.index for node in nodes for argument in node.arguments)
    uses.update(node.index for node in (*record.outputs, *record.after.values()))
    texts: dict[int, str] = {}
    tables: dict[Any, str] = {}  # the name under which a table was written
    for node in nodes:
        if node.operation == "table":
            name = f"table{node.index}"
            places[name] = tables.setdefault(node.value, name)
            if places[name] == name:  # the first node of this table: it is written once
                table_rows: list[str] = []
                for row in node.value:
                    table_rows.append(" ".join(str(int(entry)) for entry in row))
                yield f"{name} = logical([{_NEXT_ROW.join(table_rows)}]);"
        text = _expression(step, node, [texts[a.index] for a in node.arguments], places)
        plain = node.operation in ("input", "constant", "state")
        once = uses[node.index] == 1 and len(text) <= _WIDEST and node.operation != "network"
        if plain or once:
            texts[node.index] = text
        else:
            yield f"t{node.index} = {text};"
            texts[node.index] = f"t{node.index}"

    effort, *truths = (texts[node.index] for node in record.outputs)
    raised = [f"{bit} * uint32({truth})" for bit, truth in zip(printed.flags, truths, strict=True)]
    yield f"effort = {effort};"
    yield f"flags = {' + '.join(raised)};"
    yield f"next = zeros({printed.size}, 1, '{number_class(step)}');"
    for i, node in enumerate(record.after.values(), start=1):
        yield f"next({i}) = {texts[node.index]};"
    entering = record.entering()
    for name, rows in registers.items():
        signal, row_before = entering[name]
        now = texts[signal.index]
        first = int(places[name]) + 1
        last = first + rows - 1
        moved = f"[{now}; state({first}:{last - 1})]" if rows > 1 else now
        yield f"if {texts[row_before.index]}"
        yield f"    next({first}:{last}) = {moved};"
        yield "else"
        yield f"    next({first}:{last}) = {now};"
        yield "end"
    yield "state = next;"


def _expression(
    step: ExportedStep,
    node: Node,
    a: list[str],
    places: dict[str, str],
) -> str:
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
        return f"max({a[0]}, realmin('{number_class(step)}')) ^ {a[1]}"
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
    """A matrix of constants, four numbers a line."""
    digits = 9 if step.precision.width == 32 else 17
    rows: list[str] = []
    for row in np.atleast_2d(np.asarray(values, step.precision.dtype)):
        numbers = [f"{float(number):.{digits}g}" for number in row]
        lines = [", ".join(numbers[first : first + 4]) for first in range(0, len(numbers), 4)]
        rows.append(_SAME_ROW.join(lines))
    return f"{number_class(step)}([{_NEXT_ROW.join(rows)}])"


def _network(step: ExportedStep) -> str:
    model = step.network
    assert model is not None
    scaling = model.scaling
    weights = model.weights
    hidden = model.structure.hidden

    def matrix(values: NDArray[np.float64]) -> str:
        return _matrix(step, values)

    def column(values: NDArray[np.float64]) -> str:
        return _matrix(step, values[:, None])

    def number(value: float) -> str:
        return _number(step, value)

    lines = [f"x = (x - {column(scaling.offset)}) ./ {column(scaling.scale)};"]
    if model.structure.kind == "rbfn":
        lines += [
            f"centres = {matrix(weights['centres'])};",
            f"squares = {column(weights['spreads'] ** 2)};",
            f"a = zeros({hidden[0]}, 1, '{number_class(step)}');",
            "for i = 1:numel(a)",
            "    d = x - centres(i, :)';",
            f"    a(i) = exp({number(-0.5)} * sum(d .* d) / squares(i));",
            "end",
        ]
        out = weights["w"]
        start = weights["b"][0]
    else:
        before = "x"
        for i in range(1, len(hidden) + 1):
            lines += [
                f"w{i} = {matrix(weights[f'W{i}'])};",
                f"b{i} = {column(weights[f'b{i}'])};",
                f"a{i} = tanh(w{i} * {before} + b{i});",
            ]
            before = f"a{i}"
        lines.append(f"a = a{len(hidden)};")
        out = weights["W_out"][0]
        start = weights["b_out"][0]
    lines.append(f"y = {matrix(out[None, :])} * a + {number(float(start))};")
    lines.append(f"y = y * {number(scaling.effort_scale)} + {number(scaling.effort_offset)};")
    return f"function y = network(x)\n{indented(lines)}\nend\n"
