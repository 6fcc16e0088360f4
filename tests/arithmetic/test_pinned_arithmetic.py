"""The bits of our own functions, in every way in which they are computed, stay as they are kept beside this file.

They are made of additions, multiplications and divisions, which all processors round alike. `tests/conftest.py` says
how to pin anew after a change that is meant.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from erclutch.arithmetic.dual import Dual, chosen, partial_of, pick, seed, value_of
from erclutch.arithmetic.elementary import absolute, elementary, less_select, sign_of, table_entry
from erclutch.arithmetic.evaluation import evaluate
from erclutch.arithmetic.precision import PRECISIONS, PrecisionName
from erclutch.arithmetic.record import Record, recorded, traced
from erclutch.arithmetic.recursion import starts_of, step_of, switched
from erclutch.arithmetic.row_arithmetic import Numbers
from erclutch.signals.clock import Clock, Span
from tests.support.pinning import Pinned

#: Both signs, over all magnitudes, and what stands at the edges.
SIZES = np.concatenate([np.ldexp(1.0 + np.arange(40) / 40.0, k) for k in range(-40, 12)])
EDGES = [
    0.0,
    -0.0,
    np.inf,
    -np.inf,
    np.nan,
    1e308,
    -1e308,
    5e-324,
    88.0,
    -88.0,
    709.0,
    -709.0,
    20.0,
    -20.0,
]
X = np.concatenate([SIZES, -SIZES, EDGES])


def digest(values: Any, kind: Any) -> int:
    """All bits of some numbers, each turned by its place."""
    bits = (
        np.ascontiguousarray(values, np.float32 if kind.itemsize == 4 else np.float64)
        .view(kind)
        .astype(np.uint64)
    )
    bits[np.isnan(np.asarray(values, np.float64))] = 7  # one NaN is as good as another
    places = np.arange(bits.size, dtype=np.uint64)
    return int(np.bitwise_xor.reduce(bits * (2 * places + np.uint64(1))))


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_functions_keep_their_bits(precision: PrecisionName, pinned: Pinned) -> None:
    p = PRECISIONS[precision]
    found: dict[str, Any] = {}
    with np.errstate(all="ignore"):
        x = X.astype(p.dtype)
        for name, function in elementary(p).items():
            given = (
                [(x,)]
                if name != "power"
                else [(np.abs(x), p.dtype.type(n)) for n in (-0.75, 0.1, 0.5, 1.5, 2.9)]
            )
            if name.endswith("_held"):
                given = [(elementary(p)[name.replace("_held", "_hold")](x),)]
            found[name] = [digest(function(*one), p.bits) for one in given]
            made = traced(name, p)
            found[name].append(
                dict(sorted(Counter(node.operation for node in made.needed()).items()))
            )
    pinned(found)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_numbers_of_a_precision(precision: PrecisionName, pinned: Pinned) -> None:
    p = PRECISIONS[precision]
    values = (0.0, -0.0, 1.0, 0.1, -2.5, 1e-40, 1e30, 3e38)
    ahead = np.nextafter(np.array([1.0, -3.0, 0.0], p.dtype), p.dtype.type(9.0))
    about = [str(p.dtype), str(p.bits), p.c_bits, p.bits_suffix, p.epsilon, vars(p)]
    own = [[p.constant(v), p.round(v)] for v in values]
    one = np.ones(1, p.dtype)
    pinned(
        [
            *about,
            own,
            p.steps(ahead, np.array([1.0, -3.0, 0.0], p.dtype)),
            p.steps(one + one + one, one),
        ]
    )


def test_choices(pinned: Pinned) -> None:
    x = np.array([-2.0, -0.0, 0.0, 3.0, np.nan])
    found: list[Any] = [
        absolute(x),
        sign_of(x),
        less_select(x, 0.0, 1.0, 2.0),
        less_select(1.0, 2.0, 3.0, 4.0),
    ]
    found += [table_entry([5.0, 6.0, 7.0], np.array([0, 2, 1])), chosen(x > 0, x, -x)]
    a, b = seed([2.0, 3.0])
    for made in (
        a * b,
        a / b,
        a - b,
        b**a,
        a**2.0,
        2.0**a,
        np.exp(a),
        np.tanh(a),
        np.sqrt(b),
        -a,
        1.0 - a,
        4.0 / b,
    ):
        found.append([value_of(made), partial_of(made, 0), partial_of(made, 1)])
    many = Dual(np.arange(4.0), {0: np.ones(4), 1: 2.0})
    found += [
        [value_of(d), partial_of(d, 0), partial_of(d, 1), partial_of(d, 5)]
        for d in (many, pick(many, slice(1, 3)))
    ]
    pinned(found)


def test_steps_of_clocks(pinned: Pinned) -> None:
    time = np.array([0.0, 0.1, 0.2, 1.0, 2.0, 2.1, 2.4, 9.0])
    spans = (Span(0, 3, 0.1), Span(3, 4, 0.1), Span(4, 7, None), Span(7, 8, None))
    clock, even = Clock(time, spans), Clock(time[:3], spans[:1])
    u = np.sin(np.arange(8.0) * 2.0)
    pinned(
        [
            clock.steps,
            step_of(clock),
            step_of(even),
            starts_of(clock),
            switched(u, 0.5 * u, 0.3 * u, clock),
        ]
    )


def test_records(pinned: Pinned) -> None:
    """What is written down of a step with a state, and what its rows come to."""
    record = Record()
    x, y = record.input("x"), record.input("y")
    going = record.state("going", kind="truth")
    before = record.choose(going, record.state("sum"), 0.5)
    total = record.label(before + x * y - x / (y * y + 1.0), "total")
    record.keep("sum", total)
    record.keep("going", record.either(going, record.less(x, 3.0)))
    good = record.both(record.finite(x), record.opposite(record.less(y, x)))
    late = record.operand("delay", total, going, value=("total", 2))
    bent = record.call("bent", lambda a, b: np.tanh(a) * np.exp(-b) + (a * a) ** 0.75, a=x, b=y)
    record.give(record.choose(good, late + bent, -total))
    rows = {"x": np.sin(np.arange(9.0)), "y": np.cos(np.arange(9.0))}
    kinds = [[n.operation, n.kind, len(n.arguments)] for n in record.needed()]
    folded = recorded(lambda a: (a + 0.0) * 1.0 + 2.0 * 3.0 - a**2 + a**0.5, ["a"])
    found = [
        evaluate(record, rows, Numbers(PRECISIONS[p], None))[0] for p in ("float32", "float64")
    ]
    flat = [n.operation for n in record.flat().needed()]
    pinned(
        [
            kinds,
            record.inputs(),
            record.registers(),
            sorted(record.entering()),
            found,
            flat,
            [n.operation for n in folded.needed()],
        ]
    )
