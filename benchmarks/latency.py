"""One step of a model: the exported C against what else would run it in a controller, in one run on this machine.

    python benchmarks/latency.py                  # fnn-16 in float32, 1 thread
    python benchmarks/latency.py --model fnn-10-6
    python benchmarks/latency.py --law bingham/forward+dahl/field    # a law with a memory beside it, in the same rounds

Same weights, same inputs, same number of calls for all, normalisation included; each result is checked against NumPy.
Rounds are interleaved: one of every contender, then the next, so that what else the machine does meets all alike.
Median and least of the rounds' means; the ratio is that of the least, to float32 at -O3. C is timed by a loop
in C whose input depends on the output before, so that one step cannot overlap the next; Python's callables by a loop in
Python, in each round less a loop over an empty function. Peers: benchmarks/requirements-peers.txt.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import platform
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from erclutch.export import ExportedStep, ExportOptions, step_of
from erclutch.export.c.compilers import EXACT, native
from erclutch.export.targets.c import write_core
from erclutch.export.targets.python import compile_model
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.model import Range
from erclutch.models.networks import network_from_name
from erclutch.models.networks.network_model import NetworkModel, Scaling, table_shapes
from erclutch.models.structure import Reference, Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units

_ROUNDS, _CALLS = 40, 1000
#: Fields and speeds of the timed sample.
SAMPLE = (0.21, 0.0, 12.0, 3.0)


def model_of(specification: str) -> NetworkModel:
    """A network of the paper's rig with random weights: the time does not depend on them."""
    structure = network_from_name(specification, "coaxial")
    rng = np.random.default_rng(0)
    weights = {
        name: rng.normal(size=shape) / np.sqrt(shape[-1])
        for name, shape in table_shapes(structure).items()
    }
    scaling = Scaling(np.array([0.0, 1.0, -2.0]), np.array([0.5, 120.0, 80.0]), 0.01, 0.1)
    ranges = Range((0.0, 0.5), (-200.0, 200.0), (-0.14, 0.13))
    return NetworkModel(
        structure, scaling, weights, {}, Units("N*m", "", "rad/s"), ranges, np.zeros((3, 2))
    )


def law_of(name: str, device: DeviceName) -> TorqueModel:
    """A law with stages, such as ``bingham/forward+dahl/field``: the time does not depend on its numbers."""
    specification, _, dynamics = name.partition("+")
    law = law_from_name(specification, device)
    structure = Structure(device, specification, law, dynamics or "none")
    shape = {s.name: s.lower + 0.3 * (s.upper - s.lower) for s in structure.shapes(1e-3)}
    shape.update({name: 2e-3 for name in shape if name.startswith("tau")})
    gains = {g.name: 0.02 for g in structure.gains()}
    ranges = Range((0.0, 0.5), (-200.0, 200.0), (-0.14, 0.13))
    return TorqueModel(
        structure, Reference(0.5, 100.0, 1e-3), shape, gains, Units("N*m", "", "rad/s"), ranges
    )


@dataclass(frozen=True)
class Contender:
    """Who is timed: a round of so many calls gives seconds a call."""

    name: str
    round: Callable[[int], float]
    result: float


def _loop(call: Callable[[], Any], calls: int) -> float:
    began = perf_counter()
    for _ in range(calls):
        call()
    return (perf_counter() - began) / calls


def in_python(name: str, call: Callable[[], float]) -> Contender:
    """A callable of Python, less an empty one: the least of three, as a busy machine only ever makes it longer."""
    return Contender(
        name,
        lambda calls: _loop(call, calls) - min(_loop(lambda: None, calls) for _ in range(3)),
        call(),
    )


_LOOP = """
#define _POSIX_C_SOURCE 199309L
#include <time.h>
{include}
double timed(long steps, double *last);
double timed(long steps, double *last)
{{
    struct timespec a, b;
    {real} in[4] = {{0.21{suffix}, 0.0{suffix}, 12.0{suffix}, 3.0{suffix}}};
    {real} out = 0;
    long i;
    {prepare}
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (i = 0; i < steps; i++)
    {{
        {call}
        in[{last}] = 12.0{suffix} + out * 0.0{suffix}; /* the next step waits for this one */
    }}
    clock_gettime(CLOCK_MONOTONIC, &b);
    *last = (double)out;
    return ((double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec)) / (double)steps;
}}
"""


def in_c(
    name: str, text: str, sources: list[Path], work: Path, level: str, *flags: str
) -> Contender:
    """A loop in C."""
    main, library = work / "loop.c", work / f"loop{abs(hash((text, level)))}.so"
    main.write_text(text, encoding="ascii")
    files = [str(main), *map(str, sources), "-o", str(library)]
    command = [
        *native().command,
        *EXACT,
        level,
        "-shared",
        "-fPIC",
        "-I",
        str(work),
        *files,
        *flags,
    ]
    subprocess.run(command, check=True, capture_output=True)
    loop = ctypes.CDLL(str(library)).timed
    loop.restype, loop.argtypes = ctypes.c_double, (ctypes.c_long, ctypes.POINTER(ctypes.c_double))
    last = ctypes.c_double()
    loop(1, ctypes.byref(last))
    return Contender(name, lambda calls: loop(calls, ctypes.byref(last)), last.value)


def beside(name: str, work: Path) -> list[Contender]:
    """A law in float32, of a single device and of the pair, whose two elements remember apart."""
    found: list[Contender] = []
    for device in ("single", "coaxial"):
        program = step_of(law_of(name, device), ExportOptions(f"law_{device}", "float32", 1e-3))
        made = exported(program, work, "-O3")
        found.append(replace(made, name=f"{name}, {device}, float32, -O3"))
    return found


def exported(program: ExportedStep, work: Path, level: str) -> Contender:
    """The exported C, all of its step: flags, limits, last good row."""
    n, p = program.name, program.precision
    text = _LOOP.format(
        include=f'#include "{n}.h"\nstatic {n}_state state;',
        real=p.c_type,
        last=program.elements,
        suffix=p.suffix,
        prepare=f"{n}_reset(&state);",
        call=f"(void){n}_step(&state, in, &out);",
    )
    name = f"erclutch C, {p.name}, {native().name} {level}"
    return in_c(name, text, write_core(program, work), work, level)


def from_python(program: ExportedStep) -> Contender:
    """The compiled step as a function of Python."""
    step = compile_model(program).step
    return in_python(
        f"erclutch compiled step from Python, {program.precision.name}", lambda: step(*SAMPLE)
    )


# --- peers -----------------------------------------------------------------------------------------------------------


def raw() -> np.ndarray:
    """The network's inputs of the sample."""
    return np.array([SAMPLE[0] - SAMPLE[1], SAMPLE[2], SAMPLE[3]])


def numpy_effort(model: NetworkModel) -> Callable[[], float]:
    """The model's own NumPy, from fields and slips."""
    e1, e2, theta, alpha = (np.array([v]) for v in SAMPLE)
    elements, clock = (
        [Element(e1, theta - alpha), Element(e2, -theta - alpha)],
        Clock(np.zeros(1), (Span(0, 1, 1e-3),)),
    )
    return lambda: float(model.effort(elements, clock)[0])


def numpy_least(model: NetworkModel) -> Callable[[], float]:
    """The least NumPy that gives the number."""
    s, w, x = model.scaling, model.weights, raw()
    layers = [(w[f"W{i + 1}"], w[f"b{i + 1}"]) for i in range(len(model.structure.hidden))]
    out, bias = w["W_out"][0], w["b_out"][0]

    def call() -> float:
        a = (x - s.offset) / s.scale
        for matrix, offset in layers:
            a = np.tanh(matrix @ a + offset)
        return float(out @ a + bias) * s.effort_scale + s.effort_offset

    return call


def scikit_learn(model: NetworkModel) -> Callable[[], float]:
    """MLPRegressor.predict, normalisation by NumPy."""
    from sklearn.neural_network import MLPRegressor

    s, w, x = model.scaling, model.weights, raw()
    hidden = model.structure.hidden
    net = MLPRegressor(hidden_layer_sizes=hidden, activation="tanh", random_state=0)
    rng = np.random.default_rng(0)
    net.partial_fit(rng.normal(size=(9, 3)), rng.normal(size=9))
    net.coefs_ = [*(w[f"W{i + 1}"].T for i in range(len(hidden))), w["W_out"].T]
    net.intercepts_ = [*(w[f"b{i + 1}"] for i in range(len(hidden))), w["b_out"]]
    return lambda: float(
        net.predict(((x - s.offset) / s.scale)[None])[0] * s.effort_scale + s.effort_offset
    )


def pytorch(model: NetworkModel) -> Callable[[], float]:
    """A module in float32 under inference_mode, normalisation inside."""
    import torch as t

    t.set_num_threads(1)
    s, w = model.scaling, {k: t.tensor(v, dtype=t.float32) for k, v in model.weights.items()}
    offset, scale = (t.tensor(v, dtype=t.float32) for v in (s.offset, s.scale))
    x, layers = raw().astype(np.float32), range(1, len(model.structure.hidden) + 1)

    def call() -> float:
        with t.inference_mode():
            a = (t.from_numpy(x) - offset) / scale
            for i in layers:
                a = t.tanh(t.addmv(w[f"b{i}"], w[f"W{i}"], a))
            return float((w["W_out"] @ a + w["b_out"]) * s.effort_scale + s.effort_offset)

    return call


def onnx_runtime(model: NetworkModel) -> Callable[[], float]:
    """A session on one thread, all optimisations, normalisation inside; its run of one sample."""
    import onnx
    import onnxruntime as ort
    from onnx import TensorProto, helper, numpy_helper

    s, f = model.scaling, np.float32
    tables = {"offset": s.offset[None], "scale": s.scale[None]}
    tables |= {"gain": np.array([[s.effort_scale]]), "shift": np.array([[s.effort_offset]])}
    nodes = [
        helper.make_node("Sub", ["x", "offset"], ["x0"]),
        helper.make_node("Div", ["x0", "scale"], ["a0"]),
    ]
    count = len(model.structure.hidden)
    for i in range(1, count + 1):
        tables |= {f"W{i}": model.weights[f"W{i}"].T, f"b{i}": model.weights[f"b{i}"][None]}
        nodes += [helper.make_node("Gemm", [f"a{i - 1}", f"W{i}", f"b{i}"], [f"z{i}"])]
        nodes += [helper.make_node("Tanh", [f"z{i}"], [f"a{i}"])]
    tables |= {"W": model.weights["W_out"].T, "b": model.weights["b_out"][None]}
    nodes += [helper.make_node("Gemm", [f"a{count}", "W", "b"], ["u"])]
    nodes += [
        helper.make_node("Mul", ["u", "gain"], ["v"]),
        helper.make_node("Add", ["v", "shift"], ["y"]),
    ]
    initial = [
        numpy_helper.from_array(np.ascontiguousarray(v, f), name) for name, v in tables.items()
    ]
    inputs = [helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, 3])]
    outputs = [helper.make_tensor_value_info("y", TensorProto.FLOAT, [1, 1])]
    graph = helper.make_graph(nodes, "step", inputs, outputs, initial)
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    onnx.checker.check_model(made)
    options = ort.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    session = ort.InferenceSession(
        made.SerializeToString(), options, providers=["CPUExecutionProvider"]
    )
    feed = {"x": raw().astype(f)[None]}
    return lambda: float(session.run(None, feed)[0][0, 0])


def casadi(model: NetworkModel, work: Path) -> Contender:
    """C that CasADi generates (double, libm), compiled by the same compiler, timed by the same loop."""
    import casadi as ca

    s, w = model.scaling, model.weights
    x = ca.SX.sym("x", 4)
    a = (ca.vertcat(x[0] - x[1], x[2], x[3]) - s.offset) / s.scale
    for i in range(1, len(model.structure.hidden) + 1):
        a = ca.tanh(ca.mtimes(ca.DM(w[f"W{i}"]), a) + w[f"b{i}"])
    y = (ca.mtimes(ca.DM(w["W_out"]), a) + w["b_out"]) * s.effort_scale + s.effort_offset
    here = Path.cwd()
    os.chdir(work)
    try:
        ca.Function("net", [x], [y]).generate("net.c")
    finally:
        os.chdir(here)
    declared = "int net(const double **arg, double **res, long long *iw, double *w, int mem);"
    text = _LOOP.format(
        include=f"{declared}\nstatic double room[4096];",
        real="double",
        last=2,
        suffix="",
        prepare="const double *arg[8] = {in}; double *res[8] = {&out};",
        call="(void)net(arg, res, 0, room, 0);",
    )
    return in_c("CasADi's C, float64", text, [work / "net.c"], work, "-O3", "-lm")


# --- the table -------------------------------------------------------------------------------------------------------


def contenders(model: NetworkModel, work: Path) -> tuple[list[Contender], list[str]]:
    """All that are installed, and what is missing."""
    made: list[Contender] = []
    for precision in ("float32", "float64"):
        program = step_of(
            model, ExportOptions("net32" if precision == "float32" else "net64", precision)
        )  # type: ignore[arg-type]
        made += [exported(program, work, level) for level in ("-O2", "-O3")]
        made.append(from_python(program))
    calls: list[tuple[str, Callable[[NetworkModel], Callable[[], float]], str]] = [
        ("NumPy, as little as it takes", numpy_least, "numpy"),
        ("NumPy, NetworkModel.effort", numpy_effort, "numpy"),
        ("ONNX Runtime, float32", onnx_runtime, "onnx onnxruntime"),
        ("scikit-learn MLPRegressor", scikit_learn, "scikit-learn"),
        ("PyTorch, float32", pytorch, "torch"),
    ]
    missing: list[str] = []
    for name, make, package in calls:
        try:
            made.append(in_python(name, make(model)))
        except ImportError:
            missing.append(f"{name:52}not installed: pip install {package}")
    try:
        made.append(casadi(model, work))
    except ImportError:
        missing.append(f"{'CasADi C, float64':52}not installed: pip install casadi")
    return made, missing


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--model", default="fnn-16")
    parser.add_argument("--law", default="bingham/forward+dahl/field")
    asked = parser.parse_args()
    model = model_of(asked.model)
    expected = numpy_effort(model)()
    # One sample is too little for threads: none may start.
    with tempfile.TemporaryDirectory() as folder, threadpool_limits(1):
        found, missing = contenders(model, Path(folder))
        laws = beside(asked.law, Path(folder))
        for c in found:
            assert abs(c.result - expected) < 1e-5 * max(1.0, abs(expected)), (
                c.name,
                c.result,
                expected,
            )
            c.round(_CALLS // 10)
        found += laws
        times = np.array([[c.round(_CALLS) for c in found] for _ in range(_ROUNDS)])
    middle, least = np.median(times, axis=0), times.min(axis=0)
    load = ", ".join(f"{x:.1f}" for x in os.getloadavg())
    print(
        f"One step of {model.name}, normalisation included; {platform.machine()}, {native().name}, one thread."
    )
    print(f"{_ROUNDS} interleaved rounds of {_CALLS} calls each; load {load}.")
    print(f"{'ns a step':52}{'median':>12}{'least':>12}{'times ours':>12}{'off NumPy':>12}")
    for c, m, s in zip(found, 1e9 * middle, 1e9 * least, strict=True):
        off = "" if c in laws else f"{abs(c.result - expected):12.1e}"
        print(f"{c.name:52}{m:12.1f}{s:12.1f}{s / (1e9 * least[1]):12.1f}{off}")
    print("\n".join(missing))


if __name__ == "__main__":
    main()
