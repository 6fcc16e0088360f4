"""A network in C has tables, and its forward pass is loops over them."""

from __future__ import annotations

from collections.abc import Iterator

from erclutch.arithmetic.precision import FLOAT32, Precision
from erclutch.export.c.c_printer import WRITTEN_OUT, indented, table
from erclutch.models.networks.network_model import NetworkModel


def network(model: NetworkModel, n: str, p: Precision) -> str:
    """Tables and the forward pass."""
    model, k, zero, active = model.folded, p.constant, f"0.0{p.suffix}", ""
    count, hidden, to = len(model.structure.inputs), model.structure.hidden, model.scaling
    written, scaled = count <= WRITTEN_OUT, model.structure.kind == "rbfn"
    tables = {} if written else {"offset": to.offset, **({"scale": to.scale} if scaled else {})}
    # A matrix lies row by row, all neurons' weights of one input together, so that compilers can use vectors.
    if model.structure.kind == "rbfn":
        tables |= {"centres": model.weights["centres"].T, "spreads": model.weights["spreads"] ** 2}
        body, out, weights, start = list(_rbfn(model, n, p)), "w", model.weights["w"], model.weights["b"][0]
    else:
        for i in range(1, len(hidden) + 1):
            tables |= {f"w{i}": model.weights[f"W{i}"].T, f"b{i}": model.weights[f"b{i}"]}
        # Float32's tanh has no choices, so compilers keep vectors of it inside the last sum too.
        body, out, active = list(_fnn(model, n, p)), "w_out", f"{n}tanh_held" if p is FLOAT32 else ""
        weights, start = model.weights["W_out"][0], model.weights["b_out"][0]
    tables[out] = weights
    loop = ["uint32_t j;"] if any(line.startswith("for (j") for line in body) else []
    declared = ["uint32_t i;", *loop, *(f"{n}real a{i}[{h}];" for i, h in enumerate(hidden, 1))]
    declared += [f"{n}real s[4] = {{{zero}, {zero}, {zero}, {zero}}};", f"{n}real total;"]
    if written:
        ends = zip(map(k, map(float, to.offset)), map(k, map(float, to.scale)), strict=True)
        moved = [
            f"const {n}real x{j} = (v{j} - ({offset})){f' / {scale}' if scaled else ''};"
            for j, (offset, scale) in enumerate(ends)
        ]
        given = ", ".join(f"{n}real v{j}" for j in range(count))
    else:
        each = f"x[i] = (v[i] - {n}offset[i]){f' / {n}scale[i]' if scaled else ''};"
        moved = [f"{n}real x[{count}];", *_loop("i", count, [each])]
        given = f"const {n}real v[{count}]"
    body += _dot(hidden[-1], f"a{len(hidden)}", f"{n}{out}", active)
    body += [f"return {k(float(start))} + total;"]
    held = [table(f"{n}real", f"{n}{name}", [k(float(v)) for v in values.ravel()]) for name, values in tables.items()]
    about = "The effort's scale lies in the tables" + ("." if scaled else ", and those of the inputs.")
    text = indented([*declared, *moved, *body])
    return "\n".join(held) + f"\n/* {about} */\nstatic {n}real {n}network({given})\n{{\n{text}\n}}\n"


def _fnn(model: NetworkModel, n: str, p: Precision) -> Iterator[str]:
    before, width = "x", len(model.structure.inputs)
    for layer, hidden in enumerate(model.structure.hidden, start=1):
        a, bias = f"a{layer}", f"{n}b{layer}[i]"
        if width <= WRITTEN_OUT:
            inputs = [f"x{j}" if before == "x" else f"{before}[{j}]" for j in range(width)]
            terms = [f"({n}w{layer}[i + {j * hidden}u] * {x})" for j, x in enumerate(inputs)]
            yield from _loop("i", hidden, [*_sum(n, [bias, *terms]), f"{a}[i] = {n}tanh_hold(sum);"])
        else:
            yield from _loop("i", hidden, [f"{a}[i] = {bias};"])
            inner = [f"{a}[i] = {a}[i] + ({n}w{layer}[(j * {hidden}u) + i] * {before}[j]);"]
            yield from _loop("j", width, list(_loop("i", hidden, inner)))
            yield from _loop("i", hidden, [f"{a}[i] = {n}tanh_hold({a}[i]);"])
        # A loop of its own: held arguments are read from memory, so compilers make no branch of them and use vectors.
        if layer < len(model.structure.hidden) or p is not FLOAT32:
            yield from _loop("i", hidden, [f"{a}[i] = {n}tanh_held({a}[i]);"])
        before, width = a, hidden


def _rbfn(model: NetworkModel, n: str, p: Precision) -> Iterator[str]:
    hidden, width, zero = model.structure.hidden[0], len(model.structure.inputs), f"0.0{p.suffix}"
    half = f"(-0.5{p.suffix})"
    if width <= WRITTEN_OUT:
        distances = [f"const {n}real d{j} = x{j} - {n}centres[i + {j * hidden}u];" for j in range(width)]
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


def _dot(count: int, a: str, weights: str, active: str) -> list[str]:
    """Four running sums, pairs, then the rest, of what a function makes of the values."""
    whole = count // 4 * 4
    lines: list[str] = []
    if whole:
        lines += [f"for (i = 0u; i < {whole}u; i += 4u)", "{"]
        lines += [f"    s[{k}] = s[{k}] + ({weights}[i + {k}u] * {active}({a}[i + {k}u]));" for k in range(4)]
        lines += ["}"]
    lines += ["total = (s[0] + s[1]) + (s[2] + s[3]);"]
    lines += [f"total = total + ({weights}[{i}] * {active}({a}[{i}]));" for i in range(whole, count)]
    return lines
