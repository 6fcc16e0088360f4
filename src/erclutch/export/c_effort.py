"""The model's own C: a law printed from its record, a network as loops over constant tables, and the equation above."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from numpy.typing import NDArray

from erclutch.export.c_code import Printer, table
from erclutch.export.program import Program
from erclutch.model import TorqueModel
from erclutch.networks.model import NetworkModel


def command(program: Program, n: str) -> str:
    """From field to command."""
    printer = Printer(n, program.precision, {"field": "field"})
    lines = [*printer.lines(program.command), f"return {printer.results(program.command)[0]};"]
    body = "\n".join(f"    {line}" for line in lines)
    return f"""/* What the dynamics work on: {_command_text(program)}. */
static {n}real {n}command({n}real field)
{{
{body}
}}
"""


def _command_text(program: Program) -> str:
    if isinstance(program.model, NetworkModel):
        return "the field itself"
    reference = f"field / {program.model.reference.field:.9g}"
    return reference if program.model.structure.law.stimulus is None else f"the law's function of {reference}"


def equation(program: Program) -> list[str]:
    """The equation and its numbers, as lines of a comment."""
    model = program.model
    if isinstance(model, NetworkModel):
        return _network_equation(program)
    from erclutch.laws.symbolic import equation_text

    law, device = model.structure.law, model.structure.device
    lines = [f"{model.title} ({law.source}). One element, for w > 0 (odd in w):", ""]
    lines += [f"  effort = {equation_text(law)}", ""]
    lines += [f"with E = |field in the fluid| / {model.reference.field:.9g}, w = slip / {model.reference.slip:.9g}."]
    if device == "coaxial":
        lines += ["T = T1 + T2; element 2 drives the other way: its law sees -w2 and its effort counts negative."]
    if law.forward:
        lines += ["The yield effort keeps the sign in which the device drives."]
    if model.structure.friction:
        lines += ["A friction effort T_f tanh(w / w_s) is added for each element."]
    if model.structure.offset:
        lines += ["A constant effort T_0 is added."]
    numbers = {**model.shape, **model.gains}
    return [*lines, "", *(f"  {name:<10} = {value:.17g}" for name, value in numbers.items())]


def _network_equation(program: Program) -> list[str]:
    model = program.model
    assert isinstance(model, NetworkModel)
    s = model.structure
    lines = [f"{model.title}, x = (input - offset) / scale of each input, effort = y {model.scaling.effort_scale:.9g}"]
    lines[0] += f" + {model.scaling.effort_offset:.9g}."
    if s.kind == "rbfn":
        return [*lines, "", "  y = b + sum_i w_i exp(-|x - c_i|^2 / (2 s_i^2))", "", f"Inputs: {', '.join(s.inputs)}."]
    layers = [f"a{i + 1} = tanh(W{i + 1} {'x' if i == 0 else f'a{i}'} + b{i + 1})" for i in range(len(s.hidden))]
    return [
        *lines,
        "",
        f"  {', '.join(layers)}, y = W_out a{len(s.hidden)} + b_out",
        "",
        f"Inputs: {', '.join(s.inputs)}.",
    ]


def law(program: Program, n: str) -> str:
    """Effort of all elements from fluids and slips, and the same at rest."""
    assert program.law is not None
    e = program.elements
    names = {f"x{i + 1}": f"x[{i}]" for i in range(e)} | {f"w{i + 1}": f"w[{i}]" for i in range(e)}
    printer = Printer(n, program.precision, names)
    lines = list(printer.lines(program.law))
    body = "\n".join(f"    {line}" for line in [*lines, f"return {printer.results(program.law)[0]};"])
    return f"""static {n}real {n}rest(const {n}real x[{e}], const {n}real w[{e}])
{{
{body}
}}
"""


def network(program: Program, n: str) -> str:
    """Tables and the forward pass."""
    model = program.model
    assert isinstance(model, NetworkModel)
    count, p = len(model.structure.inputs), program.precision
    tables = [_table(program, n, "offset", model.scaling.offset), _table(program, n, "scale", model.scaling.scale)]
    if model.structure.kind == "rbfn":
        tables += [_table(program, n, "centres", model.weights["centres"].T)]
        tables += [_table(program, n, "spreads", model.weights["spreads"] ** 2)]
        tables += [_table(program, n, "w", model.weights["w"])]
        body, out, start = list(_rbfn(program, n)), "w", model.weights["b"][0]
    else:
        for i in range(1, len(model.structure.hidden) + 1):
            tables += [_table(program, n, f"w{i}", model.weights[f"W{i}"].T)]
            tables += [_table(program, n, f"b{i}", model.weights[f"b{i}"])]
        tables += [_table(program, n, "w_out", model.weights["W_out"][0])]
        body, out, start = list(_fnn(program, n)), "w_out", model.weights["b_out"][0]
    hidden, k = model.structure.hidden[-1], p.constant
    body += _dot(n, p.suffix, hidden, f"a{len(model.structure.hidden)}", f"{n}{out}")
    scale, offset = k(model.scaling.effort_scale), k(model.scaling.effort_offset)
    body += [f"return (({k(float(start))} + total) * {scale}) + {offset};"]
    text = "\n".join(f"    {line}" for line in body)
    loop = "    uint32_t j;\n" if any(line.startswith("for (j") for line in body) else ""
    return (
        "\n".join(tables)
        + f"""
static {n}real {n}network(const {n}real v[{count}])
{{
    uint32_t i;
{loop}    {n}real x[{count}];
{_declare(program, n)}
    for (i = 0u; i < {count}u; i++)
    {{
        x[i] = (v[i] - {n}offset[i]) / {n}scale[i];
    }}
{text}
}}

{_base(program, n)}
{_rest(program, n)}"""
    )


def _declare(program: Program, n: str) -> str:
    model = program.model
    assert isinstance(model, NetworkModel)
    return (
        "\n".join(f"    {n}real a{i}[{h}];" for i, h in enumerate(model.structure.hidden, start=1))
        + "\n"
        + (
            f"    {n}real s[4] = {{0.0{program.precision.suffix}, 0.0{program.precision.suffix}, "
            f"0.0{program.precision.suffix}, 0.0{program.precision.suffix}}};\n    {n}real total;"
        )
    )


def _table(program: Program, n: str, name: str, values: NDArray[Any]) -> str:
    """A table; a matrix row by row, all neurons' weights of one input together so that compilers can use vectors."""
    numbers = [program.precision.constant(float(v)) for v in values.ravel()]
    return table(f"{n}real", f"{n}{name}", numbers)


#: Inputs up to which a layer's sums are written out: processors without vectors save the loop.
_WRITTEN_OUT = 16


def _fnn(program: Program, n: str) -> Iterator[str]:
    model = program.model
    assert isinstance(model, NetworkModel)
    before, width = "x", len(model.structure.inputs)
    for layer, hidden in enumerate(model.structure.hidden, start=1):
        a, bias = f"a{layer}", f"{n}b{layer}[i]"
        if width <= _WRITTEN_OUT:
            terms = [f"({n}w{layer}[i + {j * hidden}u] * {before}[{j}])" for j in range(width)]
            yield from _loop("i", hidden, [*_sum(n, [bias, *terms]), f"{a}[i] = {n}tanh_hold(sum);"])
        else:
            yield from _loop("i", hidden, [f"{a}[i] = {bias};"])
            inner = [f"{a}[i] = {a}[i] + ({n}w{layer}[(j * {hidden}u) + i] * {before}[j]);"]
            yield from _loop("j", width, list(_loop("i", hidden, inner)))
            yield from _loop("i", hidden, [f"{a}[i] = {n}tanh_hold({a}[i]);"])
        # A loop of its own: held arguments are read from memory, so compilers make no branch of them and use vectors.
        yield from _loop("i", hidden, [f"{a}[i] = {n}tanh_held({a}[i]);"])
        before, width = a, hidden


def _rbfn(program: Program, n: str) -> Iterator[str]:
    model = program.model
    assert isinstance(model, NetworkModel)
    hidden, width, zero = model.structure.hidden[0], len(model.structure.inputs), f"0.0{program.precision.suffix}"
    half = f"(-0.5{program.precision.suffix})"
    if width <= _WRITTEN_OUT:
        distances = [f"const {n}real d{j} = x[{j}] - {n}centres[i + {j * hidden}u];" for j in range(width)]
        body = [*distances, *_sum(n, [f"(d{j} * d{j})" for j in range(width)])]
        yield from _loop("i", hidden, [*body, f"a1[i] = {n}exp_hold(({half} * sum) / {n}spreads[i]);"])
        yield from _loop("i", hidden, [f"a1[i] = {n}exp_held(a1[i]);"])
        return
    yield from _loop("i", hidden, [f"a1[i] = {zero};"])
    inner = [f"const {n}real distance = x[j] - {n}centres[(j * {hidden}u) + i];"]
    inner += ["a1[i] = a1[i] + (distance * distance);"]
    yield from _loop("j", width, list(_loop("i", hidden, inner)))
    yield from _loop("i", hidden, [f"a1[i] = {n}exp_hold(({half} * a1[i]) / {n}spreads[i]);"])
    yield from _loop("i", hidden, [f"a1[i] = {n}exp_held(a1[i]);"])


def _sum(n: str, terms: list[str]) -> list[str]:
    """A sum from left to right, a few terms a line."""
    lines: list[str] = []
    total = terms[0]
    for i, term in enumerate(terms[1:], start=1):
        total = f"({total} + {term})" if i < len(terms) - 1 else f"{total} + {term}"
        if len(total) > 100 and i < len(terms) - 1:
            lines.append(f"const {n}real sum{i} = {total[1:-1]};")
            total = f"sum{i}"
    return [*lines, f"const {n}real sum = {total};"]


def _loop(index: str, count: int, body: list[str]) -> Iterator[str]:
    yield f"for ({index} = 0u; {index} < {count}u; {index}++)"
    yield "{"
    for line in body:
        yield f"    {line}"
    yield "}"


def _dot(n: str, suffix: str, count: int, a: str, weights: str) -> list[str]:
    """Four running sums, pairs, then the rest."""
    whole = count // 4 * 4
    lines: list[str] = []
    if whole:
        lines += [f"for (i = 0u; i < {whole}u; i += 4u)", "{"]
        lines += [f"    s[{k}] = s[{k}] + ({weights}[i + {k}u] * {a}[i + {k}u]);" for k in range(4)]
        lines += ["}"]
    lines += ["total = (s[0] + s[1]) + (s[2] + s[3]);"]
    lines += [f"total = total + ({weights}[{i}] * {a}[{i}]);" for i in range(whole, count)]
    return lines


def _base(program: Program, n: str) -> str:
    e, half = program.elements, f"0.5{program.precision.suffix}"
    w = e + len(program.extras)
    if e == 1:
        lines = ["v[0] = x[0];", "v[1] = w[0];"]
    elif "w1" in program.base:
        lines = ["v[0] = x[0] - x[1];", "v[1] = w[0];", "v[2] = w[1];"]
    else:
        lines = ["v[0] = x[0] - x[1];", f"v[1] = {half} * (w[0] - w[1]);", f"v[2] = (-{half}) * (w[0] + w[1]);"]
    body = "\n".join(f"    {line}" for line in lines)
    return f"""/* {", ".join(program.base)} of the present row. */
static void {n}base(const {n}real x[{e}], const {n}real w[{w}], {n}real v[{len(program.base)}])
{{
{body}
}}
"""


def _rest(program: Program, n: str) -> str:
    model = program.model
    assert isinstance(model, NetworkModel)
    e, base, extras = program.elements, len(program.base), len(program.extras)
    lines = [f"{n}base(x, w, v);"]
    for k in range(len(program.past)):
        lines += [f"v[{(k + 1) * base + i}] = v[{i}];" for i in range(base)]
    at = (len(program.past) + 1) * base
    lines += [f"v[{at + i}] = w[{e + i}];" for i in range(extras)]
    body = "\n".join(f"    {line}" for line in lines)
    return f"""/* Effort at rest: all past rows as the present one. */
static {n}real {n}rest(const {n}real x[{e}], const {n}real w[{e + extras}])
{{
    {n}real v[{len(model.structure.inputs)}];
{body}
    return {n}network(v);
}}
"""


def present(program: Program, n: str) -> str:
    """Effort of the present row with the past ones of the state."""
    if not program.past:
        return ""
    e, base, extras = program.elements, len(program.base), len(program.extras)
    back = program.rows_back
    past = "\n".join(f"        {n}back(state, {k}u, &v[{(i + 1) * base}]);" for i, k in enumerate(program.past))
    at = (len(program.past) + 1) * base
    more = "".join(f"    v[{at + i}] = w[{e + i}];\n" for i in range(extras))
    model = program.model
    assert isinstance(model, NetworkModel)
    return f"""/* The base inputs some rows back; the first row's before there was one. */
static void {n}back(const {n}state *state, uint32_t rows, {n}real v[{base}])
{{
    const uint32_t at = ((state->past_at + {back}u) - rows) % {back}u;
    uint32_t i;
    for (i = 0u; i < {base}u; i++)
    {{
        v[i] = state->past[at][i];
    }}
}}

static {n}real {n}present({n}state *state, const {n}real x[{e}], const {n}real w[{e + extras}])
{{
    {n}real v[{len(model.structure.inputs)}];
    uint32_t i;
    uint32_t j;
    {n}base(x, w, v);
    if (state->settled == 0u)
    {{
        for (j = 0u; j < {back}u; j++)
        {{
            for (i = 0u; i < {base}u; i++)
            {{
                state->past[j][i] = v[i];
            }}
        }}
    }}
    {{
{past}
    }}
    for (i = 0u; i < {base}u; i++)
    {{
        state->past[state->past_at][i] = v[i];
    }}
    state->past_at = (state->past_at + 1u) % {back}u;
{more}    return {n}network(v);
}}
"""


def effort(program: Program, n: str) -> str:
    """Law or network."""
    return law(program, n) if isinstance(program.model, TorqueModel) else network(program, n)
