"""Records of any shape: all rows at once give what one row after the other gives, and what plain Python gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.arithmetic.elementary import absolute
from erclutch.arithmetic.evaluation import evaluate
from erclutch.arithmetic.precision import FLOAT32, FLOAT64, Precision
from erclutch.arithmetic.record import Record
from erclutch.arithmetic.row_arithmetic import _NUMPY, _ON_NUMBERS, Numbers
from tests.support.examples import examples

_OPERATIONS = (
    "add",
    "subtract",
    "multiply",
    "choose",
    "tanh",
    "delay",
    "state",
    "call",
    "hold",
    "latch",
)


def _random_record(draw: st.DrawFn) -> Record:
    """Sums, choices, functions, delays and states over two inputs; each state may hang on anything, also on itself."""
    record = Record()
    values: list[Any] = [record.input("a"), record.input("b"), record.state("going", kind="truth")]
    going = values.pop()
    record.node_of(going)
    states: list[str] = []
    for k in range(draw(st.integers(1, 12))):
        one, other = (values[draw(st.integers(0, len(values) - 1))] for _ in range(2))
        operation = draw(st.sampled_from(_OPERATIONS))
        if operation == "choose":
            values.append(record.choose(record.less(one, other), one, 0.5 * other))
        elif operation == "tanh":
            values.append(np.tanh(one))
        elif operation == "delay":
            values.append(
                record.operand("delay", one, going, value=(f"r{k}", draw(st.integers(1, 4))))
            )
        elif operation == "state":
            states.append(f"s{k}")
            values.append(record.state(f"s{k}"))
        elif operation == "hold":  # the last value, and where that one is negative too, half of it
            state = record.state(f"h{k}")
            first = record.choose(record.less(0.0, one), one, state)
            values += [state, record.choose(record.less(other, -0.2), 0.5 * other, first)]
            record.keep(f"h{k}", values[-1])
        elif operation == "latch":
            latched = record.either(record.less(one, other), record.state(f"l{k}", kind="truth"))
            record.keep(f"l{k}", latched)
            values.append(record.choose(latched, one, other))
        elif operation == "call":
            values.append(record.call("halved", lambda x: 0.5 * x, x=one))
        else:
            values.append(0.5 * getattr(np, operation)(one, other))
    for name in states:
        record.keep(name, np.tanh(values[draw(st.integers(0, len(values) - 1))]))
    record.keep("going", record.less(-1e9, values[0]))
    record.give(values[-1])
    record.give(record.less(values[-1], values[0]))
    return record


class _RowByRow:
    """The same record one row after the other, with nothing of the evaluation but its operations."""

    def __init__(self, record: Record, precision: Precision) -> None:
        self.record, self.numbers = record, Numbers(precision)
        self.state: dict[str, Any] = {}
        self.past: dict[str, list[Any]] = {}

    def row(self, inputs: dict[str, Any]) -> list[Any]:
        known: dict[int, Any] = {}
        for node in self.record.needed():
            a = [known[n.index] for n in node.arguments]
            if node.operation == "input":
                known[node.index] = inputs[node.value]
            elif node.operation == "state":
                known[node.index] = self.state.get(node.value, self.numbers.zero(node))
            elif node.operation == "delay":
                name, rows = node.value
                before = self.past.setdefault(name, []) if a[1][0] else []
                self.past[name] = [a[0], *(before or [a[0]] * 4)][:5]
                known[node.index] = self.past[name][rows]
            elif node.operation == "call":
                called = self.record.calls[node.value]
                known[node.index] = evaluate(
                    called, dict(zip(called.inputs(), a, strict=True)), self.numbers
                )[0]
            else:
                known[node.index] = self.numbers.apply(node, a)
        self.state = {name: known[n.index] for name, n in self.record.after.items()}
        return [known[n.index] for n in self.record.outputs]


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(data=st.data(), rows=st.integers(1, 12), precision=st.sampled_from([FLOAT64, FLOAT32]))
def test_all_rows_at_once_are_the_rows_one_by_one(
    data: st.DataObject, rows: int, precision: Precision
) -> None:
    record = data.draw(st.composite(_random_record)())
    rng = np.random.default_rng(rows)
    inputs = {name: rng.normal(size=rows).astype(precision.dtype) for name in ("a", "b")}
    together = evaluate(record, inputs, Numbers(precision))
    single = _RowByRow(record, precision)
    alone = [single.row({name: x[k : k + 1] for name, x in inputs.items()}) for k in range(rows)]
    for j, found in enumerate(together):
        np.testing.assert_array_equal(
            found, np.concatenate([np.broadcast_to(row[j], 1) for row in alone])
        )


@pytest.mark.slow
@settings(max_examples=examples(50), deadline=None)
@given(data=st.data())
def test_a_flat_record_is_the_record_with_its_calls(data: st.DataObject) -> None:
    record = data.draw(st.composite(_random_record)())
    flat = record.flat()
    inputs = {name: np.random.default_rng(1).normal(size=9) for name in ("a", "b")}
    assert not any(n.operation == "call" for n in flat.nodes)
    for one, other in zip(
        evaluate(record, inputs, Numbers(FLOAT64)),
        evaluate(flat, inputs, Numbers(FLOAT64)),
        strict=True,
    ):
        np.testing.assert_array_equal(one, other)


def test_a_given_value_stands_in_and_what_only_it_needed_is_not_computed() -> None:
    record = Record()
    hidden = record.input("absent") + 1.0
    record.give(2.0 * hidden)
    found = evaluate(
        record, {"a": np.zeros(3)}, Numbers(FLOAT64), {hidden.node: np.array([1.0, 2.0, 3.0])}
    )
    assert found[0].tolist() == [2.0, 4.0, 6.0]
    with pytest.raises(KeyError, match="absent"):
        evaluate(record, {"a": np.zeros(3)}, Numbers(FLOAT64))


@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64], ids=lambda p: p.name)
@pytest.mark.parametrize("operation", _ON_NUMBERS)
def test_a_number_has_the_bits_of_an_array_of_one(operation: str, precision: Precision) -> None:
    """Numbers that the C meets: both zeros, infinities, NaN, the smallest and the largest, and what rounds."""
    largest = np.finfo(precision.dtype).max
    smallest = np.finfo(precision.dtype).smallest_subnormal
    numbers = [
        0.0,
        -0.0,
        1.0,
        -1.3,
        0.1,
        1e-20,
        -np.inf,
        np.inf,
        np.nan,
        largest,
        -largest,
        smallest,
        -smallest,
    ]
    on_arrays = absolute if operation == "absolute" else _NUMPY[operation]
    truths = np.array([True, False])
    reals = np.array(numbers, precision.dtype)
    operands = {"both": [truths, truths], "either": [truths, truths], "opposite": [truths]}.get(
        operation
    )
    operands = operands or {"choose": [truths, reals, reals], "finite": [reals]}.get(operation)
    operands = operands or [reals] * (1 if operation in ("negate", "absolute") else 2)
    with np.errstate(all="ignore"):
        for chosen in np.ndindex(*map(len, operands)):
            taken = [values[place] for values, place in zip(operands, chosen, strict=True)]
            of_arrays = on_arrays(*(np.array([x]) for x in taken))
            of_numbers = np.array([_ON_NUMBERS[operation](*taken)])
            assert of_numbers.dtype == of_arrays.dtype
            if not (of_arrays.dtype != np.bool_ and np.isnan(of_arrays[0])):
                assert of_numbers.tobytes() == of_arrays.tobytes(), (operation, taken)
            else:
                assert np.isnan(of_numbers[0])


@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64], ids=lambda p: p.name)
def test_a_lag_runs_in_numbers_with_the_bits_of_arrays(
    precision: Precision, monkeypatch: pytest.MonkeyPatch
) -> None:
    record = Record()
    signal, before = record.input("a"), record.state("lag")
    share = record.choose(record.less(before * signal, 0.0), 0.3, 0.1)
    after = before + share * (signal - before)
    record.keep("lag", after)
    record.give(after)
    record.give(record.less(after, 0.2))
    rows = np.random.default_rng(1).normal(size=500).astype(precision.dtype)
    rows[[70, 300]] = np.inf, np.nan
    lag, low = evaluate(record, {"a": rows}, Numbers(precision))
    monkeypatch.setattr(Numbers, "on_numbers", {})
    lag_in_arrays, low_in_arrays = evaluate(record, {"a": rows}, Numbers(precision))
    assert (
        (lag.dtype, low.dtype)
        == (lag_in_arrays.dtype, low_in_arrays.dtype)
        == (precision.dtype, np.bool_)
    )
    assert np.array_equal(lag, lag_in_arrays, equal_nan=True)
    assert np.array_equal(low, low_in_arrays)
