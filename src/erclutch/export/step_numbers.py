"""NumPy runs the step from its record, as every target must give it bit for bit, and the inverse for Python."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.evaluation import Numbers, evaluate
from erclutch.arithmetic.precision import FLOAT64, Precision
from erclutch.export.exported_step import LARGEST_ANGLE, NON_FINITE, OUT_OF_REACH, OUTSIDE, ExportedStep
from erclutch.export.step_record import feels_state, next_record, search_record, settled_record, step_record
from erclutch.export.step_recording import StepRecord
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element

AnyArray = NDArray[Any]
Flags = NDArray[np.uint32]


def numbers(step: ExportedStep, precision: Precision | None = None) -> Numbers:
    """The arithmetic of a step, in its own precision or in another one."""
    chosen = precision or step.precision
    network = step.network
    return Numbers(chosen, None if network is None else network.as_exported)


def run(step: ExportedStep, rows: AnyArray) -> tuple[AnyArray, Flags]:
    """Effort and flags of a sequence of rows, shape (n, inputs), from a reset."""
    made, dtype = step_record(step), step.precision.dtype
    effort, *truths = evaluate(made.record, named(made, np.asarray(rows, np.float64).astype(dtype)), numbers(step))
    return effort.copy(), packed(made, truths)


def band_of(step: ExportedStep, rows: AnyArray) -> AnyArray:
    """Low and high end of the band at each of a sequence of rows, shape (n, 2); no rows for a step without alarms."""
    made, dtype = step_record(step), step.precision.dtype
    if step.alarms is None:
        return np.zeros((0, 2), dtype)
    ends = [made.record.after[name] for name in ("low", "high")]
    values = named(made, np.asarray(rows, np.float64).astype(dtype))
    return np.column_stack(evaluate(made.record, values, numbers(step), outputs=ends))


def named(made: StepRecord, rows: AnyArray) -> dict[str, AnyArray]:
    """Rows as the inputs of a record."""
    return dict(zip(made.inputs, np.ascontiguousarray(rows.T), strict=True))


def packed(made: StepRecord, truths: Sequence[AnyArray]) -> Flags:
    """Flags of each row from their truths."""
    flags = sum(np.where(truth, bit, 0) for bit, truth in zip(made.flags, truths, strict=True))
    return np.asarray(flags, np.uint32)


def reference(step: ExportedStep, rows: AnyArray) -> tuple[AnyArray, Flags]:
    """The same with the model's own NumPy in float64, for rows as the precision holds them."""
    made = step_record(step)
    inputs = named(made, np.asarray(rows, np.float64).astype(step.precision.dtype).astype(np.float64))
    at, elements, extras = held_signals(step, made, inputs)
    count = int(np.count_nonzero(at))
    period = step.period or 1.0
    clock = Clock(np.arange(count) * np.float64(period), (Span(0, count, period),) if count else ())
    value = np.zeros(at.size)
    if count:
        value[at] = step.model.effort(elements, clock, extras)
    effort, *truths = evaluate(made.record, inputs, numbers(step, FLOAT64), {made.value: value})
    return effort.copy(), packed(made, truths)


def held_signals(
    step: ExportedStep, made: StepRecord, inputs: dict[str, AnyArray]
) -> tuple[NDArray[np.bool_], list[Element], dict[str, AnyArray]]:
    """Rows from the first good one on; there the fields and slips within their windows, and the further inputs."""
    nodes = (made.started, *made.fields, *made.slips, *made.extras)
    at, *signals = evaluate(made.record, inputs, numbers(step, FLOAT64), outputs=nodes)
    e = step.elements
    kept = [x[at] for x in signals]
    elements = [Element(f, w) for f, w in zip(kept[:e], kept[e : 2 * e], strict=True)]
    return at, elements, dict(zip(step.model.extras, kept[2 * e :], strict=True))


# --- inverse ---------------------------------------------------------------------------------------------------------


def inverse(step: ExportedStep, rows: AnyArray, wanted: AnyArray) -> tuple[AnyArray, Flags]:
    """The signed field for a wanted effort at each row, and flags.

    Args:
        step: what to invert; stages are at rest.
        rows: shape (n, inputs), in the units of the model, speeds even where the step takes angles; fields in them do
            not matter.
        wanted: efforts, shape (n,).

    Returns:
        Fields (E1 - E2 for a coaxial device), 0 where an input is not finite; the nearest end of the range where the
        effort is out of reach.
    """
    dtype = step.precision.dtype
    values = np.asarray(rows, np.float64).astype(dtype)[:, step.elements : step.model_inputs]
    target = np.asarray(wanted, np.float64).astype(dtype)
    bad = ~(np.all(np.isfinite(values), axis=1) & np.isfinite(target))
    head = search_record(step)
    *signals, outside = evaluate(head, dict(zip(head.inputs(), values.T, strict=True)), numbers(step))
    settled = settled_record(step)

    def effort(field: AnyArray, at: NDArray[np.int64]) -> AnyArray:
        inputs = dict(zip(settled.inputs(), [field, *(x[at] for x in signals)], strict=True))
        return evaluate(settled, inputs, numbers(step))[0]

    with np.errstate(all="ignore"):
        field, reached = _Bracketing(step, effort, target).find()
    flags = np.where(outside, OUTSIDE, 0) | np.where(reached, 0, OUT_OF_REACH)
    return np.where(bad, dtype.type(0.0), field), np.where(bad, NON_FINITE, flags).astype(np.uint32)


def inverse_now(step: ExportedStep, rows: AnyArray, wanted: AnyArray) -> tuple[AnyArray, Flags]:
    """The signed field that gives a wanted effort in a step, with the state as the rows before have left it, and flags.

    Args:
        step: what to invert.
        rows: successive inputs from a reset, shape (n, inputs). The fields of a row matter for the rows behind alone.
        wanted: effort of each row, shape (n,).

    Returns:
        Fields (E1 - E2 for a coaxial device), 0 where another input is not finite; the nearest end of the range where
        the effort is out of reach, which it is in all rows if a dead time lies between field and effort.
    """
    if not feels_state(step):
        return inverse(step, rows, wanted)
    e, dtype = step.elements, step.precision.dtype
    values, target = np.asarray(rows, np.float64).astype(dtype), np.asarray(wanted, np.float64).astype(dtype)
    bad = ~(np.all(np.isfinite(values[:, e : step.model_inputs]), axis=1) & np.isfinite(target))
    if step.filter is not None:
        bad |= np.any(~(np.abs(values[:, e : 2 * e]) < LARGEST_ANGLE), axis=1)
    ahead, before = next_record(step), _state_before(step, values)

    def effort(field: AnyArray, at: NDArray[np.int64]) -> AnyArray:
        inputs = {f"u{i}": values[at, i] for i in range(e, step.model_inputs)}
        given = {n: before[n.operation, n.value][at] for n in ahead.needed() if (n.operation, n.value) in before}
        return evaluate(ahead, {"field": field, **inputs}, numbers(step), given)[0]

    with np.errstate(all="ignore"):
        field, reached = _Bracketing(step, effort, target).find()
    flags = np.where(bad, NON_FINITE, np.where(reached, 0, OUT_OF_REACH))
    return np.where(bad, dtype.type(0.0), field), flags.astype(np.uint32)


def _state_before(step: ExportedStep, values: AnyArray) -> dict[tuple[str, Any], AnyArray]:
    """Numbers of the state ahead of each row, and what the delay registers hold then, by operation and name."""
    made = step_record(step)
    nodes = [n for n in made.record.needed() if n.operation in ("state", "delay")]
    found = evaluate(made.record, named(made, values), numbers(step), outputs=nodes)
    operations = ("earlier" if n.operation == "delay" else "state" for n in nodes)
    return {(o, n.value): x for o, n, x in zip(operations, nodes, found, strict=True)}


@dataclass
class _Bracketing:
    """The search for one field a row: brackets outward from the origin, then secants and halvings in turn."""

    step: ExportedStep
    effort: Callable[[AnyArray, NDArray[np.int64]], AnyArray]
    wanted: AnyArray

    def find(self) -> tuple[AnyArray, NDArray[np.bool_]]:
        s, n = self.step.search, self.wanted.size
        number = self.step.precision.dtype.type
        rows = np.arange(n)
        origin = np.full(n, number(s.origin))
        miss = self.effort(origin, rows) - self.wanted
        best, best_miss = origin.copy(), np.abs(miss)
        done = best_miss <= number(s.tolerance)
        left = [origin, origin.copy()]
        left_miss = [miss, miss.copy()]
        ends = [e for e in (s.plus, s.minus) if e != s.origin]
        for i in range(1, s.segments + 1):
            for side, end in enumerate(ends):
                stride = number((end - s.origin) / s.segments)
                at = np.full(n, number(s.origin) + number(i) * stride)
                miss = self.effort(at, rows) - self.wanted
                crossed = ((left_miss[side] <= 0) & (miss >= 0)) | ((left_miss[side] >= 0) & (miss <= 0))
                take = crossed & ~done
                if np.any(take):
                    chosen = rows[take]
                    best[take] = self._close(chosen, left[side][take], left_miss[side][take], at[take], miss[take])
                    done |= take
                nearer = ~done & (np.abs(miss) < best_miss)
                best[nearer], best_miss[nearer] = at[nearer], np.abs(miss)[nearer]
                left[side], left_miss[side] = at, miss
        return best, done

    def _close(self, rows: NDArray[np.int64], a: AnyArray, miss_a: AnyArray, b: AnyArray, miss_b: AnyArray) -> AnyArray:
        s = self.step.search
        number = self.step.precision.dtype.type
        half, tolerance, width = number(0.5), number(s.tolerance), number(s.width)
        a, b, miss_a, miss_b = a.copy(), b.copy(), miss_a.copy(), miss_b.copy()
        x = half * (a + b)
        open_ = np.ones(rows.size, np.bool_)
        for i in range(s.most):
            middle = half * (a + b)
            secant = b - miss_b * ((b - a) / (miss_b - miss_a))
            low, high = np.where(a < b, a, b), np.where(a < b, b, a)
            inside = (low < secant) & (secant < high)
            new = np.where(inside, secant, middle) if i % 2 == 0 else middle
            x = np.where(open_, new, x)
            miss = np.asarray(self.effort(x, rows) - self.wanted[rows])
            same = (miss < 0) == (miss_a < 0)
            a, miss_a = np.where(open_ & same, x, a), np.where(open_ & same, miss, miss_a)
            b, miss_b = np.where(open_ & ~same, x, b), np.where(open_ & ~same, miss, miss_b)
            open_ &= ~((np.abs(miss) <= tolerance) | (np.abs(b - a) <= width))
            if not np.any(open_):
                break
        return x
