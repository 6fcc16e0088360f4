"""What stands between a command and the field in the fluid: a first-order lag, then a delay.

::

    x' = (u - x) / tau,   tau = tau_rise while |x| grows, tau_fall while it shrinks;   field(t) = x(t - delay)

discretised exactly for a command held over a sample: x_k = x_{k-1} + (1 - exp(-dt / tau)) (u_k - x_{k-1}). The state
starts settled at the first command of each span. Between samples x is a cubic through its values and slopes, so the
field turns smoothly with the delay and a solver can follow it. All of it is causal: the same recursion runs live.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from erclutch.dual import Dual, Value, pick, value_of
from erclutch.exact import Exact

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

#: Which lag a model has; one that has a lag has a delay too.
DynamicsForm = Literal["none", "lag", "rise-fall"]


@dataclass(frozen=True)
class Span:
    """Rows [start, stop) without a gap; ``period`` in s, or None where the steps differ."""

    start: int
    stop: int
    period: float | None


@dataclass(frozen=True)
class Clock:
    """When the rows of a data set were sampled.

    Attributes:
        time: time stamps in s, shape (n,), increasing inside each span.
        spans: gapless stretches that cover all rows in order.
    """

    time: Array
    spans: tuple[Span, ...]


def respond(
    command: Any, clock: Clock, *, delay: Any, rise: Any, fall: Any | None = None, rows: slice = slice(None)
) -> Any:
    """The field in the fluid that follows a command.

    Args:
        command: shape (n,); an array, or a dual. Of an `Exact` array the recursion runs row by row, with the rounding
            of the exported C; of others through BLAS, which is faster and on some processors rounds otherwise.
        clock: the rows' clock.
        delay: dead time in s, not negative; number or dual.
        rise: time constant in s, positive; number or dual.
        fall: time constant while the field shrinks in magnitude; None: the same as rise.
        rows: which rows of the result are wanted; the lag runs over all of them regardless.

    Returns:
        Shape (n,), or that of the rows; a dual where any argument is one.
    """
    x, tau = _lag(command, clock, rise, fall)
    return _delayed(x, (command - x) / tau, clock, delay, rows)


def _parts(x: Any) -> tuple[Any, dict[int, Value]]:
    return (x.value, x.partials) if isinstance(x, Dual) else (x, {})


def _delayed(x: Any, slope: Any, clock: Clock, delay: Any, rows: slice) -> Any:
    """x(t - delay) by the cubic through values and slopes of the two rows around it."""
    before, after, lead, step = _bracket(clock, float(value_of(delay)), rows)
    # Ahead of a span's first row there is no command to look back to: the two rows are the same one and it is held.
    reach = np.where(after > before, step, 0.0)
    s = (lead - delay) / step
    first, last = pick(x, before), pick(x, after)
    square, cube = s * s, s * s * s
    bend = pick(slope, before) * (cube - 2.0 * square + s) + pick(slope, after) * (cube - square)
    return first + (last - first) * (3.0 * square - 2.0 * cube) + bend * reach


def _bracket(clock: Clock, delay: float, rows: slice) -> tuple[Rows, Rows, Array, Array]:
    """For t - delay at each of the rows: the rows around it, t less the earlier one's time, and their distance in s."""
    chosen = np.arange(clock.time.size)[rows]
    before, after = np.empty_like(chosen), np.empty_like(chosen)
    lead, step = np.empty(chosen.size), np.empty(chosen.size)
    for span in clock.spans:
        at = slice(*np.searchsorted(chosen, (span.start, span.stop)))
        k = chosen[at]
        if span.stop - span.start == 1:
            low, lead[at], step[at] = k - 1, 1.0, 1.0
        elif span.period is not None:
            whole = int(delay / span.period)
            low = k - whole - 1
            lead[at], step[at] = (whole + 1) * span.period, span.period
        else:
            t = clock.time[span.start : span.stop]
            low = np.searchsorted(t, clock.time[k] - delay, side="left") - 1 + span.start
            held = np.clip(low, span.start, span.stop - 2)
            lead[at], step[at] = clock.time[k] - clock.time[held], clock.time[held + 1] - clock.time[held]
        before[at], after[at] = np.maximum(low, span.start), np.maximum(low + 1, span.start)
    return before, after, lead, step


def _lag(command: Any, clock: Clock, rise: Any, fall: Any | None) -> tuple[Any, Any]:
    """The lagged command, and the time constant at each row."""
    u, u_partials = _parts(command)
    rise_tau, fall_tau = float(value_of(rise)), None if fall is None else float(value_of(fall))
    x, rising = _follow(u, clock, rise_tau, fall_tau)
    if fall is None or fall_tau is None or rising is None:
        tau = rise
        share = _share(clock, None, rise_tau, rise_tau)
    else:
        # Numbers times masks: a dual stays one, and each of the two carries its own derivative.
        tau = rise * rising + fall * ~rising
        share = _share(clock, rising, rise_tau, fall_tau)
    tau_value, tau_partials = _parts(tau)
    if not (u_partials or tau_partials):
        return x, tau
    partials: dict[int, Value] = {
        seed: _filter(np.broadcast_to(v, u.shape), clock, share) for seed, v in u_partials.items()
    }
    # d(share)/d(tau) drives the sensitivity through the same filter: s_k = s_{k-1} + g_k (v_k - s_{k-1}).
    drive = _innovation(u, x, clock) * _share_slope(clock, tau_value) / share
    for seed, partial in tau_partials.items():
        partials[seed] = partials.get(seed, 0.0) + _filter(drive * partial, clock, share, settled=False)
    return Dual(x, partials), tau


def _steps(clock: Clock) -> Array:
    """Sampling step that ends at each row, in s; the first row of a span gets the following one's."""
    steps = np.empty(clock.time.size)
    for span in clock.spans:
        at = slice(span.start, span.stop)
        if span.period is not None:
            steps[at] = span.period
        elif span.stop - span.start > 1:
            steps[at] = np.diff(clock.time[at], prepend=2 * clock.time[span.start] - clock.time[span.start + 1])
        else:
            steps[at] = 1.0  # a lone row is settled, whatever the step
    return steps


def _share(clock: Clock, rising: NDArray[np.bool_] | None, rise: float, fall: float) -> Array:
    """1 - exp(-dt / tau) at each row."""
    share = np.empty(clock.time.size)
    for span in clock.spans:
        at = slice(span.start, span.stop)
        steps = _steps(clock)[at] if span.period is None else np.float64(span.period)
        up = -np.expm1(-steps / rise)
        share[at] = up if rising is None else np.where(rising[at], up, -np.expm1(-steps / fall))
    return share


def _share_slope(clock: Clock, tau: Value) -> Array:
    steps = _steps(clock)
    return -np.exp(-steps / tau) * steps / tau**2


def _innovation(u: Array, x: Array, clock: Clock) -> Array:
    """u_k - x_{k-1}; zero where a span starts settled."""
    out = np.empty_like(u)
    for span in clock.spans:
        out[span.start] = 0.0
        out[span.start + 1 : span.stop] = u[span.start + 1 : span.stop] - x[span.start : span.stop - 1]
    return out


def _filter(u: Array, clock: Clock, share: Array, *, settled: bool = True) -> Array:
    """x_k = x_{k-1} + share_k (u_k - x_{k-1}) over each span, from x = u (settled) or x = 0.

    The recursion is a lower bidiagonal system, x_k - (1 - share_k) x_{k-1} = share_k u_k, which BLAS runs through
    forward.
    """
    if isinstance(u, Exact) and settled:
        return _row_by_row(u, clock, share)
    from scipy.linalg.blas import dtbsv

    drive = share * u
    band = np.ones((2, u.size), order="F")
    band[1, :-1] = share[1:] - 1.0
    for span in clock.spans:
        drive[span.start] = u[span.start] if settled else 0.0
        if span.start:
            band[1, span.start - 1] = 0.0
    return dtbsv(1, band, drive, lower=1, diag=1, overwrite_x=1)


def _row_by_row(u: Array, clock: Clock, share: Array) -> Array:
    """`_filter` in Python's floats, which round as the exported C does; BLAS rounds otherwise on some processors."""
    out: list[float] = []
    pairs = list(zip((share * u).tolist(), (share - 1.0).tolist(), strict=True))
    for span in clock.spans:
        rest = pairs[span.start + 1 : span.stop]
        out += accumulate(rest, lambda x, pair: pair[0] - pair[1] * x, initial=float(u[span.start]))
    return np.array(out)


def _follow(u: Array, clock: Clock, rise: float, fall: float | None) -> tuple[Array, NDArray[np.bool_] | None]:
    """The lagged command and, where rise and fall differ, which rows were rising."""
    if fall is None:
        return _filter(u, clock, _share(clock, None, rise, rise)), None
    if isinstance(u, Exact):
        return _switched(u, clock, _share(clock, None, rise, rise), _share(clock, None, fall, fall))
    middle = np.sqrt(rise * fall)
    rising = _rises(u, _filter(u, clock, _share(clock, None, middle, middle)), clock)
    # Which rows rise depends on the response itself. Each pass is right up to at least one row further than the
    # last; in practice a handful settles all of them.
    for _ in range(_PASSES):
        x = _filter(u, clock, _share(clock, rising, rise, fall))
        again = _rises(u, x, clock)
        if np.array_equal(again, rising):
            return x, rising
        rising = again
    return _switched(u, clock, _share(clock, None, rise, rise), _share(clock, None, fall, fall))


_PASSES = 12


def _rises(u: Array, x: Array, clock: Clock) -> NDArray[np.bool_]:
    """Rows over which the field grows in magnitude, away from zero."""
    before = np.empty_like(x)
    before[1:] = x[:-1]
    for span in clock.spans:
        before[span.start] = u[span.start]
    return (u - before) * before >= 0.0


def _switched(u: Array, clock: Clock, up: Array, down: Array) -> tuple[Array, NDArray[np.bool_]]:
    """The same, row by row: for a share of the way gone at each row while rising, and while falling."""
    rows = list(zip(u.tolist(), up.tolist(), down.tolist(), strict=True))
    out: list[float] = []
    rising: list[bool] = []
    for span in clock.spans:
        state = rows[span.start][0]
        out.append(state)
        rising.append(True)
        for command, share_up, share_down in rows[span.start + 1 : span.stop]:
            rises = (command - state) * state >= 0.0
            share = share_up if rises else share_down
            state = share * command - (share - 1.0) * state
            out.append(state)
            rising.append(rises)
    return np.array(out), np.array(rising, np.bool_)


def cut_spans(spans: Sequence[Span], start: int, stop: int) -> tuple[Span, ...]:
    """The parts of ``spans`` inside rows [start, stop), counted from start."""
    kept = ((max(s.start, start), min(s.stop, stop), s.period) for s in spans)
    return tuple(Span(a - start, b - start, period) for a, b, period in kept if b - a >= 2)
