"""A play operator follows a signal with a gap: it moves only once the signal has gone its way to the edge of the gap.

::

    x_k = clip(x_{k-1}, u_k - edge, u_k + edge)     inside each span, x = u in the span's first row
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.arithmetic.as_in_c import ArrayAsInC, array_as_in_c
from erclutch.arithmetic.dual import Dual, partial_of, value_of
from erclutch.arithmetic.recursion import machine_code, plain_rows, seeds_of, starts_of
from erclutch.signals.clock import Clock


def play(u: Any, edge: Any, clock: Clock) -> Any:
    """The operator's value in all rows, shape (n,); a dual where a dual comes in.

    Args:
        u: what x follows once it has gone its way to the edge, shape (n,); array or dual. An `ArrayAsInC` one asks for
            the bits of the step: the arithmetic is the same.
        edge: how far u goes before x moves; a number or a dual.
        clock: the rows' spans.
    """
    followed = np.ascontiguousarray(value_of(u), np.float64)
    begin = followed[:1].copy()
    if clock.carry:
        clock.carry.into(begin)
    rows = followed.size
    gap = float(value_of(edge))
    starts = starts_of(clock)
    x = np.empty(rows)
    moved_in = np.empty(rows, np.int64)
    side = np.empty(rows)
    if plain_rows.take(rows):
        values: list[float] = [0.0] * rows
        rows_moved = [0] * rows
        sides = [0.0] * rows
        _run_play(followed.tolist(), gap, begin.tolist(), starts, values, rows_moved, sides)
        x[:], moved_in[:], side[:] = values, rows_moved, sides
    else:
        machine_code(_run_play)(followed, gap, begin, np.array(starts), x, moved_in, side)
    if clock.carry:
        clock.carry.end.append(x[clock.carry.at : clock.carry.at + 1].copy())
    if isinstance(value_of(u), ArrayAsInC):
        return array_as_in_c(x)
    seeds = seeds_of(u, edge)
    if not seeds:
        return x

    # What x is was settled in the row in which it last moved: there it was u and an edge to one side.
    partials: dict[int, Any] = {}
    for seed in seeds:
        of_u = np.broadcast_to(np.asarray(partial_of(u, seed)), followed.shape)
        partials[seed] = of_u[moved_in] + side * partial_of(edge, seed)
    return Dual(x, partials)


def _run_play(
    u: Any,
    edge: float,
    begin: Any,
    starts: Any,
    x: Any,
    moved_in: Any,
    side: Any,
) -> None:
    """Fill in x, the row in which it last moved, and to which side; all of them arrays, or all of them lists."""
    for at in range(len(starts)):
        stop = starts[at + 1] if at + 1 < len(starts) else len(u)
        first = starts[at]
        held = begin[0] if at == 0 else u[first]
        last = first
        way = 0.0
        x[first] = held
        moved_in[first] = last
        side[first] = way
        for i in range(first + 1, stop):
            if held < u[i] - edge:
                held = u[i] - edge
                last = i
                way = -1.0
            elif u[i] + edge < held:
                held = u[i] + edge
                last = i
                way = 1.0
            x[i] = held
            moved_in[i] = last
            side[i] = way
