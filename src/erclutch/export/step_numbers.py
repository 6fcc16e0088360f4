"""NumPy runs the step from its record, as every target must give it bit for bit, and the inverse for Python."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.evaluation import evaluate
from erclutch.arithmetic.precision import FLOAT64, Precision
from erclutch.arithmetic.record import Node
from erclutch.arithmetic.row_arithmetic import Numbers
from erclutch.export.exported_step import (
    LARGEST_ANGLE,
    NON_FINITE,
    OUT_OF_REACH,
    OUTSIDE,
    ExportedStep,
)
from erclutch.export.recording.recorded_step import StepRecord
from erclutch.export.step_record import (
    feels_state,
    next_record,
    search_record,
    settled_record,
    step_record,
)
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
    record = step_record(step)
    effort, *truths = evaluate(record.record, _inputs_of(step, rows), numbers(step))
    return effort.copy(), packed(record, truths)


def band_of(step: ExportedStep, rows: AnyArray) -> AnyArray:
    """Low and high end of the band at each of a sequence of rows, shape (n, 2); no rows for a step without alarms."""
    if step.alarms is None:
        return np.zeros((0, 2), step.precision.dtype)
    record = step_record(step).record
    ends = [record.after["low"], record.after["high"]]
    of_rows = evaluate(record, _inputs_of(step, rows), numbers(step), outputs=ends)
    return np.column_stack(of_rows)


def _inputs_of(step: ExportedStep, rows: AnyArray) -> dict[str, AnyArray]:
    """Rows as the precision holds them, as the inputs of the step's record."""
    return named(step_record(step), _as_held(step, rows))


def _as_held(step: ExportedStep, values: AnyArray) -> AnyArray:
    """Numbers as the step's precision holds them."""
    return np.asarray(values, np.float64).astype(step.precision.dtype)


def named(record: StepRecord, rows: AnyArray) -> dict[str, AnyArray]:
    """Rows as the inputs of a record."""
    columns = np.ascontiguousarray(rows.T)
    return dict(zip(record.inputs, columns, strict=True))


def packed(record: StepRecord, truths: Sequence[AnyArray]) -> Flags:
    """Flags of each row from their truths."""
    flags: Any = 0
    for bit, truth in zip(record.flags, truths, strict=True):
        flags = flags + np.where(truth, bit, 0)
    return np.asarray(flags, np.uint32)


def reference(step: ExportedStep, rows: AnyArray) -> tuple[AnyArray, Flags]:
    """Effort and flags by the model's own NumPy in float64, for rows as the precision holds them."""
    record = step_record(step)
    as_held = _as_held(step, rows).astype(np.float64)
    inputs = named(record, as_held)
    started, elements, extras = held_signals(step, record, inputs)
    count = int(np.count_nonzero(started))
    value = np.zeros(started.size)  # effort ahead of its limits
    if count:
        period = step.period or 1.0  # [s]
        time = np.arange(count) * np.float64(period)
        clock = Clock(time, (Span(0, count, period),))
        value[started] = step.model.effort(elements, clock, extras)
    of_model = {record.value: value}
    effort, *truths = evaluate(record.record, inputs, numbers(step, FLOAT64), of_model)
    return effort.copy(), packed(record, truths)


def held_signals(
    step: ExportedStep,
    record: StepRecord,
    inputs: dict[str, AnyArray],
) -> tuple[NDArray[np.bool_], list[Element], dict[str, AnyArray]]:
    """Rows from the first good one on; there the fields and slips within their windows, and the further inputs."""
    nodes = (record.started, *record.fields, *record.slips, *record.extras)
    started, *signals = evaluate(record.record, inputs, numbers(step, FLOAT64), outputs=nodes)
    kept = [signal[started] for signal in signals]
    fields = kept[: step.elements]
    slips = kept[step.elements : 2 * step.elements]
    further = kept[2 * step.elements :]
    elements = [Element(field, slip) for field, slip in zip(fields, slips, strict=True)]
    return started, elements, dict(zip(step.model.extras, further, strict=True))


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
    given = _as_held(step, rows)[:, step.elements : step.model_inputs]  # without the fields
    target = _as_held(step, wanted)
    finite = np.all(np.isfinite(given), axis=1)
    usable = finite & np.isfinite(target)
    head = search_record(step)
    inputs = dict(zip(head.inputs(), given.T, strict=True))
    *signals, outside = evaluate(head, inputs, numbers(step))
    settled = settled_record(step)

    def effort(field: AnyArray, at: NDArray[np.int64]) -> AnyArray:
        arguments = [field]
        arguments += [signal[at] for signal in signals]
        named_arguments = dict(zip(settled.inputs(), arguments, strict=True))
        (settled_effort,) = evaluate(settled, named_arguments, numbers(step))
        return settled_effort

    with np.errstate(all="ignore"):
        field, reached = _Bracketing(step, effort, target).find()
    of_row = np.where(outside, OUTSIDE, 0)
    of_search = np.where(reached, 0, OUT_OF_REACH)
    flags = np.where(usable, of_row | of_search, NON_FINITE)
    zero = step.precision.dtype.type(0.0)
    return np.where(usable, field, zero), flags.astype(np.uint32)


def inverse_now(
    step: ExportedStep,
    rows: AnyArray,
    wanted: AnyArray,
) -> tuple[AnyArray, Flags]:
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
    elements = step.elements
    inputs = step.model_inputs
    values = _as_held(step, rows)
    target = _as_held(step, wanted)
    others = values[:, elements:inputs]  # without the fields
    finite = np.all(np.isfinite(others), axis=1)
    usable = finite & np.isfinite(target)
    if step.filter is not None:
        angles = values[:, elements : 2 * elements]
        usable &= np.all(np.abs(angles) < LARGEST_ANGLE, axis=1)

    # Numbers of the state ahead of each row, and what the delay registers hold then.
    record = step_record(step)
    memory = [node for node in record.record.needed() if node.operation in ("state", "delay")]
    held = evaluate(record.record, named(record, values), numbers(step), outputs=memory)
    before: dict[tuple[str, Any], AnyArray] = {}
    for node, numbers_of_rows in zip(memory, held, strict=True):
        # The record of the next step reads a register by the operation "earlier".
        operation = "earlier" if node.operation == "delay" else "state"
        before[operation, node.value] = numbers_of_rows
    ahead = next_record(step)
    state_of: dict[Node, AnyArray] = {}
    for node in ahead.needed():
        numbers_of_rows = before.get((node.operation, node.value))
        if numbers_of_rows is not None:
            state_of[node] = numbers_of_rows

    def effort(field: AnyArray, at: NDArray[np.int64]) -> AnyArray:
        signals = {"field": field}
        for i in range(elements, inputs):
            signals[f"u{i}"] = values[at, i]
        state = {node: numbers_of_rows[at] for node, numbers_of_rows in state_of.items()}
        (next_effort,) = evaluate(ahead, signals, numbers(step), state)
        return next_effort

    with np.errstate(all="ignore"):
        field, reached = _Bracketing(step, effort, target).find()
    of_search = np.where(reached, 0, OUT_OF_REACH)
    flags = np.where(usable, of_search, NON_FINITE)
    zero = step.precision.dtype.type(0.0)
    return np.where(usable, field, zero), flags.astype(np.uint32)


@dataclass
class _Bracketing:
    """The search for one field a row: brackets outward from the origin, then secants and halvings in turn.

    The same search in C is printed by `erclutch.export.c.c_inverse`; the order of its operations is that of these
    lines.

    Attributes:
        step: with the ends and the tolerances of the search.
        effort: of fields at some rows.
        wanted: of each row, shape (n,).
    """

    step: ExportedStep
    effort: Callable[[AnyArray, NDArray[np.int64]], AnyArray]
    wanted: AnyArray

    def find(self) -> tuple[AnyArray, NDArray[np.bool_]]:
        """The field of each row, and whether its effort is within reach."""
        search = self.step.search
        count = self.wanted.size
        number = self.step.precision.dtype.type
        rows = np.arange(count)
        origin = np.full(count, number(search.origin))
        miss = self.effort(origin, rows) - self.wanted
        best = origin.copy()
        best_miss = np.abs(miss)
        done = best_miss <= number(search.tolerance)

        # On each side in turn, one segment further out.
        ends = [end for end in (search.plus, search.minus) if end != search.origin]
        inner = [origin, origin.copy()]  # the inner end of the bracket, by side
        inner_miss = [miss, miss.copy()]
        for i in range(1, search.segments + 1):
            for side, end in enumerate(ends):
                stride = number((end - search.origin) / search.segments)
                outer = np.full(count, number(search.origin) + number(i) * stride)
                miss = self.effort(outer, rows) - self.wanted
                rises = (inner_miss[side] <= 0) & (miss >= 0)
                falls = (inner_miss[side] >= 0) & (miss <= 0)
                take = (rises | falls) & ~done
                if np.any(take):
                    best[take] = self._close(
                        rows[take],
                        inner[side][take],
                        inner_miss[side][take],
                        outer[take],
                        miss[take],
                    )
                    done |= take
                size = np.abs(miss)
                nearer = ~done & (size < best_miss)
                best[nearer] = outer[nearer]
                best_miss[nearer] = size[nearer]
                inner[side] = outer
                inner_miss[side] = miss
        return best, done

    def _close(
        self,
        rows: NDArray[np.int64],
        a: AnyArray,
        miss_a: AnyArray,
        b: AnyArray,
        miss_b: AnyArray,
    ) -> AnyArray:
        """The fields between a and b where the miss crosses zero."""
        search = self.step.search
        number = self.step.precision.dtype.type
        half = number(0.5)
        tolerance = number(search.tolerance)
        width = number(search.width)
        x = half * (a + b)
        going = np.ones(rows.size, np.bool_)  # rows whose field is not found yet
        for i in range(search.most):
            next_x = half * (a + b)
            if i % 2 == 0:  # a secant; every other time a halving, which always gets on
                slope = (b - a) / (miss_b - miss_a)
                secant = b - miss_b * slope
                low = np.where(a < b, a, b)
                high = np.where(a < b, b, a)
                inside = (low < secant) & (secant < high)
                next_x = np.where(inside, secant, next_x)
            x = np.where(going, next_x, x)
            miss = np.asarray(self.effort(x, rows) - self.wanted[rows])

            # The end on the side of x moves to it.
            same_side = (miss < 0) == (miss_a < 0)
            moves_a = going & same_side
            moves_b = going & ~same_side
            a = np.where(moves_a, x, a)
            b = np.where(moves_b, x, b)
            miss_a = np.where(moves_a, miss, miss_a)
            miss_b = np.where(moves_b, miss, miss_b)
            close = np.abs(miss) <= tolerance
            narrow = np.abs(b - a) <= width
            going &= ~(close | narrow)
            if not np.any(going):
                break
        return x
