"""Recursions run over all rows at once, on arrays, on duals, and on arrays with the bits of the C.

::

    recur:    x_k = keep_k x_{k-1} + drive_k     inside each span, x = first in the span's first row
    follow:   x_k = advance(x_{k-1}, inputs_k)   of several states, and of any form

Machine code runs through the rows (Numba, kept on disk), and rounds as the exported C does: a product, then a sum. The
derivative by a parameter follows the same recursion with another drive, so duals pass through it with exact
derivatives, all of them in one pass over the rows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.as_in_c import ArrayAsInC, array_as_in_c
from erclutch.arithmetic.dual import Dual, partial_of, value_of
from erclutch.arithmetic.elementary import less_select
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock

#: The new states from those before and from the inputs of a row.
Advance = Callable[[tuple[Any, ...], tuple[Any, ...]], tuple[Any, ...]]

#: Rows after which Numba, which takes a second to load and to compile, has paid.
_WORTH_COMPILING = 100_000

#: Rows that all recursions of a program run through in Python first, in some 0.1 s: a look at a log needs no compiler.
_PLAIN_ROWS = 1_000_000

F = TypeVar("F", bound=Callable[..., Any])


class _Allowance:
    """Rows that are left for the loop in Python."""

    def __init__(self, rows: int) -> None:
        self.left = rows

    def take(self, rows: int) -> bool:
        """Take rows, if so many are left; a program that was refused once is worth a compiler from then on."""
        if rows > self.left:
            self.left = 0
        else:
            self.left -= rows
        return self.left > 0


plain_rows = _Allowance(_PLAIN_ROWS)


def step_of(clock: Clock) -> Array | float:
    """The sampling step in s where all rows have the same, else that of each row."""
    periods = {span.period for span in clock.spans}
    if len(periods) > 1:
        return clock.steps
    period = next(iter(periods), None)
    return clock.steps if period is None else period


def starts_of(clock: Clock) -> list[int]:
    """First row of each span."""
    return [span.start for span in clock.spans]


def recur(keep: Any, drive: Any, first: Any, clock: Clock) -> Any:
    """The recursion's values, shape (n,).

    Args:
        keep: share of the value before that stays, shape (n,); array or dual.
        drive: what is added in each row, shape (n,); array or dual. An `ArrayAsInC` one asks for the rounding of the C.
        first: the value in the first row of each span: shape (n,) of which those rows count, or a number, or a dual.
        clock: the rows' spans.
    """
    drives = np.asarray(value_of(drive))
    share = np.broadcast_to(np.asarray(value_of(keep)), drives.shape)
    keeps = np.ascontiguousarray(share, np.float64)
    (x,) = _solved(keeps, np.array([drives], np.float64), [value_of(first)], clock)
    if isinstance(drive, ArrayAsInC):
        return array_as_in_c(x)
    seeds = seeds_of(keep, drive, first)
    if not seeds:
        return x

    # The derivative of x_k = keep_k x_{k-1} + drive_k: the same recursion, driven by the derivatives of its parts.
    before = np.concatenate([[0.0], x[:-1]])
    slopes = np.empty((len(seeds), x.size))
    for slope, seed in zip(slopes, seeds, strict=True):
        np.multiply(partial_of(keep, seed), before, out=slope)
        slope += partial_of(drive, seed)
    firsts = [partial_of(first, seed) for seed in seeds]
    partials = _solved(keeps, slopes, firsts, clock)
    return Dual(x, dict(zip(seeds, partials, strict=True)))


def seeds_of(*operands: Any) -> list[int]:
    """Seeds on which some operands depend, in order."""
    return sorted({seed for x in operands if isinstance(x, Dual) for seed in x.partials})


def _solved(keep: Array, x: Array, firsts: list[Any], clock: Clock) -> Array:
    """The recursion of several drives with the same share kept, shape (drives, n), in whose place the values come."""
    starts = starts_of(clock)
    for row, first in zip(x, firsts, strict=True):
        row[starts] = first if np.ndim(first) == 0 else first[starts]
    if clock.carry:
        clock.carry.into(x[:, 0])

    if plain_rows.take(x.size):
        run_plainly(keep, x, starts)
    elif len(x) == 1:
        machine_code(_run_one)(keep, x, np.array(starts))
    else:
        machine_code(run_all)(keep, x, np.array(starts))
    if clock.carry:
        clock.carry.end.append(x[:, clock.carry.at].copy())
    return x


@cache
def machine_code(function: F, inline: bool = False) -> F:
    """A function of numbers and arrays, compiled; IEEE arithmetic is kept.

    The result is kept beside the source or in the user's cache. Where neither can be written, a program compiles anew.

    Args:
        function: to be compiled.
        inline: calls become part of their caller.
    """
    import numba

    options: dict[str, Any] = {
        "nogil": True,
        "forceinline": inline,
        "fastmath": False,
        "error_model": "numpy",
    }
    try:
        return cast(F, numba.njit(cache=True, **options)(function))
    except RuntimeError:  # "no locator available": there is no folder for what is compiled
        return cast(F, numba.njit(**options)(function))


def run_plainly(keep: Array, right: Array, starts: Sequence[int]) -> None:
    """`_run_one` for each drive, in numbers of Python: these round as the machine does."""
    kept = keep.tolist()
    bounds = [*starts, keep.size]
    for drive in right:
        values = drive.tolist()
        for start, stop in pairwise(bounds):
            x = values[start]
            for i in range(start + 1, stop):
                x = kept[i] * x + values[i]
                values[i] = x
        drive[:] = values


def _run_one(keep: Array, right: Array, starts: Array) -> None:
    drive = right[0]
    for at in range(starts.size):
        stop = starts[at + 1] if at + 1 < starts.size else keep.size
        x = drive[starts[at]]
        for i in range(starts[at] + 1, stop):
            x = keep[i] * x + drive[i]
            drive[i] = x


def run_all(keep: Array, right: Array, starts: Array) -> None:
    """`_run_one` for each drive, as machine code."""
    x = np.empty(right.shape[0])
    for at in range(starts.size):
        stop = starts[at + 1] if at + 1 < starts.size else keep.size
        for j in range(x.size):
            x[j] = right[j, starts[at]]
        for i in range(starts[at] + 1, stop):
            for j in range(x.size):
                x[j] = keep[i] * x[j] + right[j, i]
                right[j, i] = x[j]


def follow(
    advance: Advance,
    first: Sequence[Any],
    inputs: Sequence[Any],
    clock: Clock,
    *,
    linear: bool = False,
) -> tuple[Any, ...]:
    """The states of any recursion: ``x_k = advance(x_{k-1}, inputs_k)``, x = first in each span's first row.

    The derivatives are exact. They follow a linear recursion, whose coefficients come from one run of ``advance`` over
    all rows with the states before as duals.

    Args:
        advance: the new states from those before and from the inputs of the row, all tuples of numbers, arrays or
            duals. It uses operators and `less_select` alone, so that Numba can compile it for many rows.
        first: each state in the first row of each span: shape (n,) of which those rows count, or a number, or a dual.
        inputs: shape (n,) or numbers; arrays or duals. An `ArrayAsInC` one asks for the rounding of the C.
        clock: the rows' spans.
        linear: whether the new states are linear in those before; then BLAS finds the values too.

    Returns:
        Each state, shape (n,); duals where an argument is a dual.
    """
    rows = clock.time.size
    starts = starts_of(clock)

    def begun(firsts: Sequence[Any]) -> list[Array]:
        """The states in the first row of each span; those of the first span may come from the rows before."""
        states: list[Array] = []
        for x in firsts:
            of_all_rows = np.broadcast_to(np.asarray(x, np.float64), (rows,))
            states.append(np.asarray(of_all_rows[starts]))
        if not (clock.carry and clock.carry.begin):
            return states
        carried = np.array(states)
        clock.carry.into(carried[:, 0])
        return list(carried)

    def handed_on(states: Sequence[Array]) -> None:
        """Keep the last states for the rows that come later."""
        if clock.carry:
            last = [x[clock.carry.at] for x in states]
            clock.carry.end.append(np.array(last))

    as_in_c = any(isinstance(value_of(x), ArrayAsInC) for x in inputs)
    begin = begun([value_of(x) for x in first])
    values = [value_of(x) for x in inputs]
    if linear and not as_in_c:
        at_rest = [np.zeros(rows) for _ in first]
        solve, drive = _linearised(advance, at_rest, values, starts)
        states = solve([value_of(x) for x in drive], begin)
    else:
        states = _rolled(advance, begin, values, clock)
    handed_on(states)
    if as_in_c:
        return tuple(array_as_in_c(x) for x in states)
    seeds = seeds_of(*first, *inputs)
    if not seeds:
        return tuple(states)

    before = [np.concatenate([[0.0], x[:-1]]) for x in states]
    solve, drive = _linearised(advance, before, inputs, starts)
    partials: dict[int, list[Array]] = {}  # of all states, by seed
    for seed in seeds:
        begin = begun([partial_of(x, seed) for x in first])
        partials[seed] = solve([partial_of(x, seed) for x in drive], begin)
        handed_on(partials[seed])
    duals: list[Dual] = []
    for place, x in enumerate(states):
        of_state: dict[int, Any] = {seed: partials[seed][place] for seed in seeds}
        duals.append(Dual(x, of_state))
    return tuple(duals)


def _linearised(
    advance: Advance,
    before: Sequence[Array],
    inputs: Sequence[Any],
    starts: list[int],
) -> tuple[_Triangular, Sequence[Any]]:
    """The linear system of a recursion around some states, and the new states with their other derivatives."""
    # Seeds of the states are negative: those of parameters count from zero.
    own = [-1 - j for j in range(len(before))]
    states = tuple(Dual(x, {seed: 1.0}) for x, seed in zip(before, own, strict=True))
    after = advance(states, tuple(inputs))
    keeps = [[partial_of(x, seed) for seed in own] for x in after]
    return _Triangular(keeps, starts, before[0].size), after


def _rolled(
    advance: Advance, first: Sequence[Array], inputs: Sequence[Any], clock: Clock
) -> list[Array]:
    """The states row by row, in Python's floats or compiled: with the same bits, as IEEE arithmetic has no choice."""
    rows = clock.time.size
    columns = [np.broadcast_to(np.asarray(x, np.float64), (rows,)) for x in inputs]
    given = np.column_stack(columns)
    begin = np.column_stack(first)  # shape (spans, states)
    states = np.empty((rows, len(first)))
    loop = _loop_of(advance)
    loop.rows += rows
    if loop.rows > _WORTH_COMPILING:
        compiled = loop.compiled()
        compiled(begin, np.array(starts_of(clock)), given, states)
    else:
        # Python's floats are faster than NumPy's, one at a time.
        inputs_of: list[tuple[float, ...]] = [tuple(row) for row in given.tolist()]
        for start, span in zip(begin.tolist(), clock.spans, strict=True):
            state: tuple[float, ...] = tuple(start)
            states[span.start] = state
            for k in range(span.start + 1, span.stop):
                state = advance(state, inputs_of[k])
                states[k] = state
    return [np.ascontiguousarray(states[:, j]) for j in range(len(first))]


@dataclass
class _Loop:
    """A step that is to run over many rows; `rows` counts those that it has run over."""

    advance: Advance
    rows: int = 0
    made: Any = None

    def compiled(self) -> Callable[..., None]:
        """The loop as machine code, by Numba, without fast-math."""
        if self.made is None:
            import numba

            _teach_numba()
            step: Any = numba.njit(error_model="numpy")(self.advance)

            def loop(first: Any, starts: Any, given: Any, states: Any) -> None:
                span = 0
                for k in range(given.shape[0]):
                    if span < starts.size and k == starts[span]:
                        states[k] = first[span]
                        span += 1
                    else:
                        after = step(states[k - 1], given[k])
                        for j in range(states.shape[1]):
                            states[k, j] = after[j]

            self.made = numba.njit(nogil=True, error_model="numpy")(loop)
        return self.made


@cache
def _loop_of(advance: Advance) -> _Loop:
    """The step's loop, which is the same at every call, so that its rows add up."""
    return _Loop(advance)


@cache
def _teach_numba() -> None:
    """Tell Numba what `less_select` does."""
    from numba import extending

    def choice(a: Any, b: Any, yes: Any, no: Any) -> Any:
        def choose(a: Any, b: Any, yes: Any, no: Any) -> Any:
            return yes if a < b else no

        return choose

    extending.overload(less_select)(choice)


class _Triangular:
    """The system of a linear recursion of m states, solved for one drive after another.

    Args:
        keeps: share of each state before (second index) that enters each state (first index), shape (n,) or numbers.
        starts: first row of each span.
        rows: n.
    """

    def __init__(self, keeps: Sequence[Sequence[Any]], starts: list[int], rows: int) -> None:
        m = len(keeps)
        self.starts = starts
        self.rows = rows
        self.states = m
        # The unknowns stand row by row, all states of a row together, so state i of a row stands m + i - j below
        # state j of the row before. BLAS wants each diagonal as a line.
        self.band = np.zeros((2 * m, m * rows), order="F")
        last_of_spans = [start - 1 for start in starts if start]
        for i, kept in enumerate(keeps):
            for j, keep in enumerate(kept):
                line = self.band[m + i - j, j::m]
                of_all_rows = np.broadcast_to(np.asarray(keep), (rows,))
                line[:-1] = -of_all_rows[1:]
                line[last_of_spans] = 0.0  # nothing goes on into another span

    def __call__(self, drive: Sequence[Any], first: Sequence[Array]) -> list[Array]:
        from scipy.linalg.blas import dtbsv

        m = self.states
        right = np.empty(m * self.rows)
        for i, (driven, begin) in enumerate(zip(drive, first, strict=True)):
            right[i::m] = driven
            places = [m * start + i for start in self.starts]
            right[places] = begin
        x: Array = dtbsv(2 * m - 1, self.band, right, lower=1, diag=1, overwrite_x=1)
        return [np.ascontiguousarray(x[i::m]) for i in range(m)]


def switched(u: Array, up: Array, down: Array, clock: Clock) -> NDArray[np.bool_]:
    """Rows in which x_k = x_{k-1} + share_k (u_k - x_{k-1}), settled at first, grows in magnitude, shape (n,).

    Args:
        u: what x follows, shape (n,).
        up: the share in rows in which x grows, shape (n,).
        down: the share in rows in which it shrinks, shape (n,).
        clock: the rows' spans.
    """
    rising = np.ones(u.size, np.bool_)
    if clock.carry and clock.carry.begin:  # the state of the recursion that follows
        u = u.copy()
        clock.carry.into(u[:1])
    u = np.ascontiguousarray(u, np.float64)
    if plain_rows.take(u.size):
        run_switched_plainly(u, up, down, starts_of(clock), rising)
    else:
        machine_code(run_switched)(u, up, down, np.array(starts_of(clock)), rising)
    return rising


def run_switched_plainly(
    u: Array,
    up: Array,
    down: Array,
    starts: Sequence[int],
    rising: NDArray[np.bool_],
) -> None:
    """`run_switched` in numbers of Python."""
    followed = u.tolist()
    shares = down.tolist(), up.tolist()
    grows = [True] * u.size
    for start, stop in pairwise([*starts, u.size]):
        x = followed[start]
        for i in range(start + 1, stop):
            grows[i] = (followed[i] - x) * x >= 0.0
            share = shares[grows[i]][i]
            x = (1.0 - share) * x + share * followed[i]
    rising[:] = grows


def run_switched(
    u: Array, up: Array, down: Array, starts: Array, rising: NDArray[np.bool_]
) -> None:
    """`run_switched_plainly` as machine code."""
    for at in range(starts.size):
        stop = starts[at + 1] if at + 1 < starts.size else u.size
        x = u[starts[at]]
        for i in range(starts[at] + 1, stop):
            rising[i] = (u[i] - x) * x >= 0.0
            share = up[i] if rising[i] else down[i]
            x = (1.0 - share) * x + share * u[i]
