"""A network in C has tables, and its forward pass is loops over them.

An FNN in float32 has two texts of one pass, with the same operations and so the same bits. Where a processor has
vectors, all arguments of tanh are held first, and nothing branches. Elsewhere each sum goes straight on to its tanh:
nothing is stored in between, and a compiler passes over the polynomials where tanh is 1 already.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from erclutch.arithmetic.precision import FLOAT32, Precision
from erclutch.export.c.c_printer import WRITTEN_OUT, indented, table
from erclutch.models.networks.network_model import NetworkModel

LONG = 100  # letters of a sum, after which a line begins
_LANES = 4  # running sums of the last layer
#: Whether a processor has vectors of float32: x86, POWER, Arm beyond the microcontrollers. What is proved has them too.
HAS_VECTORS = " || ".join(
    f"defined({macro})"
    for macro in ("__SSE2__", "_M_X64", "__ARM_NEON", "__ALTIVEC__", "__FRAMAC__")
)


def network(model: NetworkModel, n: str, p: Precision) -> str:
    """Tables and the forward pass of a network, as C.

    Args:
        model: the network.
        n: prefix of all names of the export.
        p: precision of the C.
    """
    folded = model.folded
    weights = folded.weights
    count = len(folded.structure.inputs)

    # A matrix lies row by row, all neurons' weights of one input together, so that compilers can use vectors.
    numbers: dict[str, np.ndarray] = {}  # of each table by its name
    if not _is_written_out(folded):
        numbers["offset"] = folded.scaling.offset
        if _is_rbfn(folded):
            numbers["scale"] = folded.scaling.scale
    if _is_rbfn(folded):
        numbers["centres"] = weights["centres"].T
        numbers["spreads"] = weights["spreads"] ** 2
        numbers["w"] = weights["w"]
    else:
        for layer in range(1, len(folded.structure.hidden) + 1):
            numbers[f"w{layer}"] = weights[f"W{layer}"].T
            numbers[f"b{layer}"] = weights[f"b{layer}"]
        numbers["w_out"] = weights["W_out"][0]
    tables: list[str] = []
    for name, values in numbers.items():
        constants = [p.constant(value) for value in values.ravel().tolist()]
        tables.append(table(f"{n}real", f"{n}{name}", constants))

    # Inputs from their offset; those of an RBFN in their scale too, since its spreads cannot hold it.
    if _is_written_out(folded):
        moved: list[str] = []
        for j in range(count):
            offset = p.constant(float(folded.scaling.offset[j]))
            scale = f" / {p.constant(float(folded.scaling.scale[j]))}" if _is_rbfn(folded) else ""
            moved.append(f"const {n}real x{j} = (v{j} - ({offset})){scale};")
    else:
        scale = f" / {n}scale[i]" if _is_rbfn(folded) else ""
        each = _loop("i", count, [f"x[i] = (v[i] - {n}offset[i]){scale};"])
        moved = [f"{n}real x[{count}];", *each]

    about = "The effort's scale lies in the tables, and those of the inputs."
    if _is_rbfn(folded):
        about = "The effort's scale lies in the tables."
    parameters = f"const {n}real v[{count}]"
    if _is_written_out(folded):
        parameters = ", ".join(f"{n}real v{j}" for j in range(count))
    head = f"static {n}real {n}network({parameters})"
    body = [*_declarations(folded, n, p), *moved, *_forward(folded, n, p)]
    lines = [*tables, f"/* {about} */"]
    *before_the_last, neurons = folded.structure.hidden
    written_out = max(count, *before_the_last, 0) <= WRITTEN_OUT
    if _is_rbfn(folded) or p is not FLOAT32 or not written_out or neurons < _LANES:
        return "\n".join([*lines, head, "{", indented(body), "}\n"])
    scalar = [*_declarations(folded, n, p, stored=len(folded.structure.hidden) - 1), *moved]
    scalar += _one_by_one(folded, n, p)
    lines += [f"#if {HAS_VECTORS}", head, "{", indented(body), "}"]
    lines += ["#else", head, "{", indented(scalar), "}", "#endif\n"]
    return "\n".join(lines)


def _is_rbfn(model: NetworkModel) -> bool:
    return model.structure.kind == "rbfn"


def _is_written_out(model: NetworkModel) -> bool:
    """Whether each input has a variable of its own; more of them are an array."""
    return len(model.structure.inputs) <= WRITTEN_OUT


# --- head of the function ---------------------------------------------------------------------------------------------


def _declarations(
    model: NetworkModel,
    n: str,
    p: Precision,
    stored: int | None = None,
) -> Iterator[str]:
    """Counters, and the values of so many layers; None: of all."""
    widths = [len(model.structure.inputs)]  # of what each layer takes
    if not _is_rbfn(model):
        widths += model.structure.hidden[:-1]
    yield "uint32_t i;"
    if max(widths) > WRITTEN_OUT:  # a line of C does not write them out
        yield "uint32_t j;"
    for layer, neurons in enumerate(model.structure.hidden[:stored], start=1):
        yield f"{n}real a{layer}[{neurons}];"
    zero = _zero(p)
    yield f"{n}real s[4] = {{{zero}, {zero}, {zero}, {zero}}};"
    yield f"{n}real total;"


# --- forward pass -----------------------------------------------------------------------------------------------------


def _forward(model: NetworkModel, n: str, p: Precision) -> Iterator[str]:
    """From the moved inputs to the effort."""
    hidden = model.structure.hidden
    last = f"a{len(hidden)}"
    width = len(model.structure.inputs)  # of what a layer takes
    if _is_rbfn(model):
        neurons = hidden[0]
        half = f"(-0.5{p.suffix})"
        if width <= WRITTEN_OUT:
            distances = [
                f"const {n}real d{j} = x{j} - {n}centres[i + {j * neurons}u];" for j in range(width)
            ]
            squares = [f"(d{j} * d{j})" for j in range(width)]
            held = f"a1[i] = {n}exp_hold(({half} * sum) / {n}spreads[i]);"
            yield from _loop("i", neurons, [*distances, *_sum(n, squares), held])
        else:
            yield from _loop("i", neurons, [f"a1[i] = {_zero(p)};"])
            distance = f"const {n}real distance = x[j] - {n}centres[(j * {neurons}u) + i];"
            of_one_input = _loop("i", neurons, [distance, "a1[i] = a1[i] + (distance * distance);"])
            yield from _loop("j", width, list(of_one_input))
            held = f"a1[i] = {n}exp_hold(({half} * a1[i]) / {n}spreads[i]);"
            yield from _loop("i", neurons, [held])
        yield from _loop("i", neurons, [f"a1[i] = {n}exp_held(a1[i]);"])
        yield from _dot(neurons, last, f"{n}w")
        yield f"return {p.constant(float(model.weights['b'][0]))} + total;"
        return

    before = "x"
    for layer, neurons in enumerate(hidden, start=1):
        a = f"a{layer}"
        bias = f"{n}b{layer}[i]"
        if width <= WRITTEN_OUT:
            inputs = [f"x{j}" if before == "x" else f"{before}[{j}]" for j in range(width)]
            terms = [f"({n}w{layer}[i + {j * neurons}u] * {x})" for j, x in enumerate(inputs)]
            held = f"{a}[i] = {n}tanh_hold(sum);"
            yield from _loop("i", neurons, [*_sum(n, [bias, *terms]), held])
        else:
            yield from _loop("i", neurons, [f"{a}[i] = {bias};"])
            weight = f"{n}w{layer}[(j * {neurons}u) + i]"
            of_one_input = _loop("i", neurons, [f"{a}[i] = {a}[i] + ({weight} * {before}[j]);"])
            yield from _loop("j", width, list(of_one_input))
            yield from _loop("i", neurons, [f"{a}[i] = {n}tanh_hold({a}[i]);"])
        # A loop of its own: held arguments are read from memory, so compilers make no branch of them and use vectors.
        if layer < len(hidden) or p is not FLOAT32:
            yield from _loop("i", neurons, [f"{a}[i] = {n}tanh_held({a}[i]);"])
        before, width = a, neurons
    # Float32's tanh has no choices, so compilers keep vectors of it inside the last sum too.
    yield from _dot(hidden[-1], last, f"{n}w_out", f"{n}tanh_held" if p is FLOAT32 else "")
    yield f"return {p.constant(float(model.weights['b_out'][0]))} + total;"


def _one_by_one(model: NetworkModel, n: str, p: Precision) -> Iterator[str]:
    """The pass of an FNN without vectors, from the moved inputs to the effort: each sum goes on to its tanh at once."""
    hidden = model.structure.hidden
    values = [f"x{j}" for j in range(len(model.structure.inputs))]
    for layer, neurons in enumerate(hidden, start=1):
        if layer < len(hidden):
            active = f"a{layer}[i] = {n}tanh_held({n}tanh_hold(sum));"
            yield from _loop(
                "i", neurons, [*_sum(n, _terms(n, layer, neurons, values, "i + ")), active]
            )
            values = [f"a{layer}[{i}]" for i in range(neurons)]
            continue

        # The order of the last sum is that of `_dot`.
        whole = neurons // 4 * 4
        if whole:
            yield f"for (i = 0u; i < {whole}u; i += 4u)"
            yield "{"
            for lane in range(4):
                yield from (
                    f"    {line}"
                    for line in _sum(
                        n, _terms(n, layer, neurons, values, "i + ", lane), f"sum_{lane}_"
                    )
                )
            for lane in range(4):
                active = f"{n}tanh_held({n}tanh_hold(sum_{lane}_))"
                yield f"    s[{lane}] = s[{lane}] + ({n}w_out[i + {lane}u] * {active});"
            yield "}"
        yield "total = (s[0] + s[1]) + (s[2] + s[3]);"
        for i in range(whole, neurons):
            yield "{"
            terms = _terms(n, layer, neurons, values, "", i)
            yield from (f"    {line}" for line in _sum(n, terms))
            yield f"    total = total + ({n}w_out[{i}] * {n}tanh_held({n}tanh_hold(sum)));"
            yield "}"
    yield f"return {p.constant(float(model.weights['b_out'][0]))} + total;"


def _terms(
    n: str,
    layer: int,
    neurons: int,
    values: list[str],
    place: str,
    on: int = 0,
) -> list[str]:
    """Bias and weighted values of the neuron so many places on from a place."""
    terms = [f"{n}b{layer}[{place}{on}u]"]
    for j, value in enumerate(values):
        terms.append(f"({n}w{layer}[{place}{j * neurons + on}u] * {value})")
    return terms


def _dot(
    count: int,
    a: str,
    weights: str,
    active: str = "",
) -> Iterator[str]:
    """Weights times what a function makes of the values: four running sums, pairs of these, then the rest."""
    whole = count // 4 * 4
    if whole:
        yield f"for (i = 0u; i < {whole}u; i += 4u)"
        yield "{"
        for k in range(4):
            yield f"    s[{k}] = s[{k}] + ({weights}[i + {k}u] * {active}({a}[i + {k}u]));"
        yield "}"
    yield "total = (s[0] + s[1]) + (s[2] + s[3]);"
    for i in range(whole, count):
        yield f"total = total + ({weights}[{i}] * {active}({a}[{i}]));"


# --- C ----------------------------------------------------------------------------------------------------------------


def _sum(n: str, terms: list[str], name: str = "sum") -> list[str]:
    """A sum from left to right by its name, a few terms a line."""
    lines: list[str] = []
    total, *further = terms
    for i, term in enumerate(further, start=1):
        if i == len(further):
            total = f"{total} + {term}"
            break
        total = f"({total} + {term})"
        if len(total) > LONG:
            lines.append(f"const {n}real {name}{i} = {total[1:-1]};")
            total = f"{name}{i}"
    return [*lines, f"const {n}real {name} = {total};"]


def _loop(index: str, count: int, body: list[str]) -> Iterator[str]:
    yield f"for ({index} = 0u; {index} < {count}u; {index}++)"
    yield "{"
    for line in body:
        yield f"    {line}"
    yield "}"


def _zero(p: Precision) -> str:
    return f"0.0{p.suffix}"
