"""The exported step in NumPy, bit for bit: what every target must give, and the inverse for Python.

Rows are worked on together except where the state runs from row to row. `reference` replaces the arithmetic by the
model's own NumPy in float64 and keeps the rest: what the C is measured against.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.device import Element
from erclutch.dynamics import Clock, Span
from erclutch.elementary import elementary
from erclutch.export.graph import evaluate
from erclutch.export.program import (
    BOTH_FIELDS,
    LARGEST_ANGLE,
    LIMITED,
    NON_FINITE,
    OUT_OF_REACH,
    OUTSIDE,
    Filter,
    Lag,
    Program,
    Window,
)
from erclutch.model import TorqueModel
from erclutch.networks.model import NetworkModel
from erclutch.precision import FLOAT64, Precision

Array = NDArray[Any]
Flags = NDArray[np.uint32]


@dataclass(frozen=True)
class Held:
    """Rows after the input stage.

    Attributes:
        started: rows from the first good one on.
        flags: of each row.
        fields, slips: of each element, within the windows.
        extras: further inputs.
    """

    started: NDArray[np.bool_]
    flags: Flags
    fields: list[Array]
    slips: list[Array]
    extras: list[Array]


def run(program: Program, rows: Array) -> tuple[Array, Flags]:
    """Effort and flags of a sequence of rows, shape (n, inputs), from a reset."""
    p = program.precision
    held = receive(program, np.asarray(rows, np.float64).astype(p.dtype), p)
    at = held.started
    effort = np.zeros(at.size, p.dtype)
    if np.any(at):
        fluids = [_in_fluid(program, x[at]) for x in held.fields]
        inputs = _inputs(program, fluids, [w[at] for w in held.slips], [x[at] for x in held.extras])
        effort[at] = effort_of(program, inputs)
    return _limited(program, effort, held, p)


def reference(program: Program, rows: Array) -> tuple[Array, Flags]:
    """The same with the model's own NumPy in float64, for rows as the precision holds them."""
    held_rows = np.asarray(rows, np.float64).astype(program.precision.dtype).astype(np.float64)
    held = receive(program, held_rows, FLOAT64)
    at = held.started
    count = int(np.count_nonzero(at))
    period = program.period or 1.0
    clock = Clock(np.arange(count) * np.float64(period), (Span(0, count, period),) if count else ())
    elements = [Element(f[at], w[at]) for f, w in zip(held.fields, held.slips, strict=True)]
    effort = np.zeros(at.size)
    model = program.model
    if count and isinstance(model, TorqueModel):
        effort[at] = model.effort(elements, clock)
    elif count and isinstance(model, NetworkModel):
        names = model.structure.extras
        extras = {name: x[at] for name, x in zip(names, held.extras, strict=True)}
        effort[at] = model.effort(elements, clock, extras)
    return _limited(program, effort, held, FLOAT64)


# --- input -----------------------------------------------------------------------------------------------------------


def receive(program: Program, rows: Array, p: Precision) -> Held:
    """Input stage: last good row for a bad one, speeds from angles, flags, windows."""
    good = np.all(np.isfinite(rows), axis=1)
    moving = 2 if program.elements == 2 else 1
    at = slice(moving, 2 * moving)
    if program.filter is not None:
        good &= np.all(np.abs(np.where(np.isfinite(rows), rows, 0.0))[:, at] < LARGEST_ANGLE, axis=1)
    started = np.logical_or.accumulate(good)
    last = np.maximum.accumulate(np.where(good, np.arange(len(rows)), 0))
    values = rows[last]
    if program.filter is not None:
        values = values.copy()
        for k in range(moving, 2 * moving):
            values[:, k] = _speeds(program.filter, p.dtype.type(program.period or 0.0), rows[:, k], good, p)
    flags = np.where(good, 0, NON_FINITE).astype(np.uint32)
    with np.errstate(over="ignore", invalid="ignore"):
        fields, slips = _elements(program, values)
    extras = [values[:, 2 * moving + k] for k in range(len(program.extras))]
    outside = np.zeros(len(rows), np.bool_)
    for signals, windows in ((fields, [program.field] * 2), (slips, [program.slip] * 2), (extras, program.extras)):
        for x, window in zip(signals, windows, strict=False):
            outside |= (x < p.dtype.type(window.warn[0])) | (p.dtype.type(window.warn[1]) < x)
    flags |= np.where(outside, OUTSIDE, 0).astype(np.uint32)
    if program.elements == 2:
        both = p.dtype.type(program.both)
        flags |= np.where((both < fields[0]) & (both < fields[1]), BOTH_FIELDS, 0).astype(np.uint32)
    flags[~started] = NON_FINITE
    return Held(
        started,
        flags,
        [_hold(x, program.field, p) for x in fields],
        [_hold(x, program.slip, p) for x in slips],
        [_hold(x, window, p) for x, window in zip(extras, program.extras, strict=True)],
    )


def _elements(program: Program, values: Array) -> tuple[list[Array], list[Array]]:
    if program.elements == 1:
        return [values[:, 0]], [values[:, 1]]
    theta_dot, alpha_dot = values[:, 2], values[:, 3]
    return [values[:, 0], values[:, 1]], [theta_dot - alpha_dot, -theta_dot - alpha_dot]


def _hold(x: Array, window: Window, p: Precision) -> Array:
    low, high = (p.dtype.type(v) for v in window.hold)
    below = np.where(x < high, x, high)
    return np.where(low < below, below, low)


def _speeds(filter_: Filter, period: Any, measured: Array, good: NDArray[np.bool_], p: Precision) -> Array:
    number = p.dtype.type
    g, h = number(filter_.g), number(filter_.h)
    position = speed = number(0.0)
    started = False
    out = np.zeros(measured.size, p.dtype)
    for k in range(measured.size):
        if good[k] and not started:
            position, started = _turned(measured[k], filter_, p), True
        elif started:
            predicted = position + period * speed
            innovation = _turned(measured[k] - predicted, filter_, p) if good[k] else number(0.0)
            position = _turned(predicted + g * innovation, filter_, p)
            speed = speed + h * innovation / period
        out[k] = speed
    return out


def _turned(x: Any, filter_: Filter, p: Precision) -> Any:
    """An angle less whole turns, within half a turn of zero."""
    if filter_.turn is None:
        return x
    number = p.dtype.type
    magic = number(1.5 * 2.0**p.fraction)
    turns = (x * number(1.0 / filter_.turn) + magic) - magic
    return x - turns * number(filter_.turn)


# --- dynamics --------------------------------------------------------------------------------------------------------


def _command(program: Program, field: Array) -> Array:
    return evaluate(program.command, {"field": field}, program.precision)[0]


def _in_fluid(program: Program, field: Array) -> Array:
    command = _command(program, field)
    return command if program.lag is None else _respond(program.lag, command, program.precision)


def run_lag(lag: Lag, command: Array) -> Array:
    """The field in the fluid after a sequence of commands, in float64."""
    return _respond(lag, command, FLOAT64)


def _respond(lag: Lag, command: Array, p: Precision) -> Array:
    """`erclutch.dynamics.respond` on a uniform period, row by row."""
    number = p.dtype.type
    rise, fall = number(lag.rise), number(lag.rise if lag.fall is None else lag.fall)
    tau_rise, tau_fall = number(lag.tau_rise), number(lag.tau_fall)
    one, zero = number(1.0), number(0.0)
    x, slope = np.empty_like(command), np.empty_like(command)
    before = command[0]
    with np.errstate(all="ignore"):
        for k, u in enumerate(command):
            rising = (u - before) * before >= zero
            share = rise if rising else fall
            before = u if k == 0 else share * u - (share - one) * before
            x[k] = before
            slope[k] = (u - before) / (tau_rise if rising else tau_fall)
        old = np.maximum(np.arange(command.size) - (lag.rows - 1), 0)
        new = np.maximum(np.arange(command.size) - (lag.rows - 2), 0)
        bend = slope[old] * number(lag.bend_before) + slope[new] * number(lag.bend_after)
        # Ahead of the first row the history is level: its slopes are zero.
        bend[: lag.rows - 1] = slope[new][: lag.rows - 1] * number(lag.bend_after)
        return x[old] + (x[new] - x[old]) * number(lag.forward) + bend * number(lag.reach)


# --- effort ----------------------------------------------------------------------------------------------------------


def _inputs(program: Program, fluids: list[Array], slips: list[Array], extras: list[Array]) -> list[Array]:
    """What the effort is computed from: fluids and slips for a law, the network's inputs otherwise."""
    if isinstance(program.model, TorqueModel):
        return [*fluids, *slips]
    base = base_of(program, fluids, slips)
    past = [x[np.maximum(np.arange(x.size) - k, 0)] for k in program.past for x in base]
    return [*base, *past, *extras]


def base_of(program: Program, fluids: list[Array], slips: list[Array]) -> list[Array]:
    """A network's inputs of the present row."""
    if program.elements == 1:
        return [fluids[0], slips[0]]
    signed = fluids[0] - fluids[1]
    if "w1" in program.base:
        return [signed, *slips]
    half = program.precision.dtype.type(0.5)
    return [signed, half * (slips[0] - slips[1]), -half * (slips[0] + slips[1])]


def effort_of(program: Program, inputs: list[Array]) -> Array:
    """Law or network, shape (n,)."""
    if program.law is not None:
        half = len(inputs) // 2
        names = [f"x{i + 1}" for i in range(half)] + [f"w{i + 1}" for i in range(half)]
        return evaluate(program.law, dict(zip(names, inputs, strict=True)), program.precision)[0]
    return _network(program, np.array(inputs, program.precision.dtype))


def _network(program: Program, x: Array) -> Array:
    model, p = program.model, program.precision
    assert isinstance(model, NetworkModel)
    functions, tables = elementary(p), {k: v.astype(p.dtype) for k, v in model.weights.items()}
    s, number = model.scaling, p.dtype.type
    with np.errstate(all="ignore"):
        a: Any = (x - s.offset.astype(p.dtype)[:, None]) / s.scale.astype(p.dtype)[:, None]
        if model.structure.kind == "rbfn":
            square: Any = number(0.0)
            for j in range(len(a)):
                distance = a[j] - tables["centres"][:, j : j + 1]
                square = square + distance * distance
            spread = (model.weights["spreads"] ** 2).astype(p.dtype)[:, None]
            a = functions["exp"](number(-0.5) * square / spread)
            out, start = tables["w"], tables["b"][0]
        else:
            for layer in range(1, len(model.structure.hidden) + 1):
                total: Any = tables[f"b{layer}"][:, None]
                for j in range(len(a)):
                    total = total + tables[f"W{layer}"][:, j : j + 1] * a[j]
                a = functions["tanh"](total)
            out, start = tables["W_out"][0], tables["b_out"][0]
        return (start + _sum(out[:, None] * a)) * number(s.effort_scale) + number(s.effort_offset)


def _sum(terms: Array) -> Array:
    """Four running sums side by side, then pairs, then what is left over: the order of the C."""
    whole = len(terms) // 4 * 4
    four = [np.zeros_like(terms[0]) for _ in range(4)]
    for i in range(whole):
        four[i % 4] = four[i % 4] + terms[i]
    total = (four[0] + four[1]) + (four[2] + four[3])
    for i in range(whole, len(terms)):
        total = total + terms[i]
    return total


def _limited(program: Program, effort: Array, held: Held, p: Precision) -> tuple[Array, Flags]:
    low, high = (p.dtype.type(v) for v in program.limits)
    flags = held.flags.copy()
    good = np.isfinite(effort)
    beyond = ~good | (effort < low) | (high < effort)
    flags[held.started & beyond] |= LIMITED
    inside = np.where(effort < high, effort, high)
    inside = np.where(low < inside, inside, low)
    inside[~held.started] = 0.0
    for k in np.flatnonzero(~good):
        inside[k] = inside[k - 1] if k else 0.0
    return inside, flags


# --- inverse ---------------------------------------------------------------------------------------------------------


def steady_of(program: Program, held: Held) -> Callable[[Array, NDArray[np.int64]], Array]:
    """Effort at rest for signed fields at some of the rows."""
    p = program.precision

    def effort(signed: Array, rows: NDArray[np.int64]) -> Array:
        zero = p.dtype.type(0.0)
        fields = [np.where(zero < signed, signed, zero), np.where(signed < zero, -signed, zero)]
        if program.elements == 1:
            fields = [signed]
        fluids = [_command(program, f) for f in fields]
        slips, extras = [w[rows] for w in held.slips], [x[rows] for x in held.extras]
        if isinstance(program.model, TorqueModel):
            return effort_of(program, [*fluids, *slips])
        base = base_of(program, fluids, slips)
        return effort_of(program, [*base, *(x for _ in program.past for x in base), *extras])

    return effort


def inverse(program: Program, rows: Array, wanted: Array) -> tuple[Array, Flags]:
    """The signed field for a wanted effort at each row, and flags.

    Args:
        program: what to invert; dynamics are at rest.
        rows: shape (n, inputs), in the units of the model, speeds even where the step takes angles; fields in them do
            not matter.
        wanted: efforts, shape (n,).

    Returns:
        Fields (E1 - E2 for a coaxial device), 0 where an input is not finite; the nearest end of the range where the
        effort is out of reach.
    """
    p = program.precision
    values = np.asarray(rows, np.float64).astype(p.dtype)
    values[:, : program.elements] = 0.0
    target = np.asarray(wanted, np.float64).astype(p.dtype)
    bad = ~(np.all(np.isfinite(values), axis=1) & np.isfinite(target))
    held = receive(replace(program, filter=None), np.where(bad[:, None], p.dtype.type(0.0), values), p)
    flags = _without_field(program, held, values)
    search = _Bracketing(program, steady_of(program, held), target)
    with np.errstate(all="ignore"):
        field, reached = search.find()
    flags[~reached] |= OUT_OF_REACH
    flags[bad] = NON_FINITE
    return np.where(bad, p.dtype.type(0.0), field), flags


def _without_field(program: Program, held: Held, values: Array) -> Flags:
    """Flags of speeds and further inputs only: the fields in the input are not used."""
    low, high = (program.precision.dtype.type(v) for v in program.field.warn)
    zero = program.precision.dtype.type(0.0)
    if not (zero < low or high < zero):
        return held.flags & np.uint32(OUTSIDE)
    middle = values.copy()
    middle[:, : program.elements] = program.precision.dtype.type(program.field.range[0])
    rows = np.where(np.isfinite(middle), middle, zero)
    return receive(replace(program, filter=None), rows, program.precision).flags & np.uint32(OUTSIDE)


@dataclass
class _Bracketing:
    """The search for one field a row: brackets outward from the origin, then secants and halvings in turn."""

    program: Program
    effort: Callable[[Array, NDArray[np.int64]], Array]
    wanted: Array

    def find(self) -> tuple[Array, NDArray[np.bool_]]:
        s, n = self.program.search, self.wanted.size
        number = self.program.precision.dtype.type
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
                step = number((end - s.origin) / s.segments)
                at = np.full(n, number(s.origin) + number(i) * step)
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

    def _close(self, rows: NDArray[np.int64], a: Array, miss_a: Array, b: Array, miss_b: Array) -> Array:
        s = self.program.search
        number = self.program.precision.dtype.type
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
