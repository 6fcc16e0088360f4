"""A first-order lag, then a delay, stand between a command and the field in the fluid.

::

    x' = (u - x) / tau,   tau = tau_rise while |x| grows, tau_fall while it shrinks;   field(t) = x(t - delay)

discretised exactly for a command held over a sample: x_k = x_{k-1} + (1 - exp(-dt / tau)) (u_k - x_{k-1}). The state
starts settled at the first command of each span. Between samples x is a cubic through its values and slopes, so the
field turns smoothly with the delay and a solver can follow it. All of it is causal: the same recursion runs live.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.dual import chosen, pick, rows_before, value_of
from erclutch.arithmetic.elementary import less_select
from erclutch.arithmetic.recursion import recur, step_of, switched
from erclutch.errors import ExportError
from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import Memory, Place, longest_lag
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock

Rows = NDArray[np.int64]

_MOST_ROWS = 100_000  # of a delay register in an export
#: From so many rows of a span on, on average, it is quicker to move them than to look each up.
_LONG_SPAN = 1000
_TIME = Dimension(time=1)


@dataclass(frozen=True)
class CommandLag:
    """The lag with its delay, as a stage.

    Attributes:
        name, title: for the command line and for people.
        switches: whether the field falls with a time constant of its own.
        takes_places: `respond` also takes the places of the rows that are wanted, in an array.
    """

    name: str
    title: str
    switches: bool
    source: str = "first-order model of the coil and its fluid; no publication of its own"
    place: Place = "command"
    takes_places: bool = True

    @property
    def equation(self) -> str:
        """See `Stage`."""
        tau = "(tau_rise while |x| grows, else tau_fall)" if self.switches else "tau"
        return f"{tau} x' + x = u, E(t) = x(t - delay)"

    def parameters(self, period: float) -> tuple[ShapeParameter, ...]:
        """The dead time, then one time constant or those of rise and fall."""
        meant = {"tau": "the field"}
        if self.switches:
            meant = {"tau_rise": "the rising field", "tau_fall": "the falling field"}
        longest = max(0.05, 5 * period)
        numbers = [
            ShapeParameter("delay", "dead time between command and field", 0.0, longest, _TIME)
        ]
        for name, what in meant.items():
            meaning = f"time constant of {what}"
            upper = longest_lag(period)
            numbers.append(ShapeParameter(name, meaning, 0.2 * period, upper, _TIME, "log"))
        return tuple(numbers)

    def respond(
        self,
        signal: Any,
        clock: Clock,
        q: Sequence[Any],
        rows: slice | Rows,
    ) -> Any:
        """The field in the fluid that follows a command; see `Stage`. The lag runs over all rows regardless."""
        delay, rise, *fall = q
        x, tau = lagged(signal, clock, rise, fall[0] if self.switches else None)
        # x(t - delay) by the cubic through values and slopes of the two rows around it.
        around = _around(clock, float(value_of(delay)), rows)
        s = (around.lead - delay) / around.step  # from 0 at the earlier row to 1 at the later one
        square = s * s
        cube = s * s * s
        first = around.earlier(x)
        last = around.later(x)
        if 2 * around.reach.size < clock.time.size:
            # The slopes of the few rows that are wanted, with the same bits.
            slope_first = (around.earlier(signal) - first) / around.earlier(tau)
            slope_last = (around.later(signal) - last) / around.later(tau)
        else:
            slope = (signal - x) / tau
            slope_first = around.earlier(slope)
            slope_last = around.later(slope)
        bend = slope_first * (cube - 2.0 * square + s) + slope_last * (cube - square)
        return first + (last - first) * (3.0 * square - 2.0 * cube) + bend * around.reach

    def initial(self, signal: Any, q: Mapping[str, float]) -> Mapping[str, Any]:
        """The field has settled at the first command."""
        return {"lag": signal}

    def step(
        self,
        memory: Memory,
        signal: Any,
        q: Mapping[str, float],
        period: float,
    ) -> tuple[Any]:
        """The recursion, then the cubic between the two rows around the delay.

        Raises:
            ExportError: the delay needs a history of too many rows.
        """
        delay, *times = q.values()
        whole = int(delay / period)  # rows
        if whole + 2 > _MOST_ROWS:
            raise ExportError(
                f"a delay of {delay:g} s is {whole} rows at a period of {period:g} s",
                remedy=f"Give a longer --period: at most {_MOST_ROWS} rows",
            )
        before = memory.before("lag")
        share = memory.number(-float(np.expm1(-period / times[0])))
        tau = memory.number(times[0])
        if self.switches:
            grown = (signal - before) * before
            share_fall = memory.number(-float(np.expm1(-period / times[1])))
            share = less_select(grown, 0.0, share_fall, share)
            tau_fall = memory.number(times[1])
            tau = less_select(grown, 0.0, tau_fall, tau)
        x = memory.keep("lag", share * signal - (share - 1.0) * before)
        slope = (signal - x) / tau

        # The two rows around the delay, and the cubic through their values and slopes at s, from 0 to 1.
        old = memory.back("x", x, whole + 1)
        new = memory.back("x", x, whole)
        slope_old = memory.back("slope", slope, whole + 1)
        slope_new = memory.back("slope", slope, whole)
        s = ((whole + 1) * period - delay) / period
        square = s * s
        cube = s * s * s
        bend = slope_old * (cube - 2.0 * square + s) + slope_new * (cube - square)
        return (old + (new - old) * (3.0 * square - 2.0 * cube) + bend * period,)


@dataclass(frozen=True)
class _Around:
    """The two rows around the time t - delay, for each row that is wanted.

    Attributes:
        earlier, later: what a signal is at these two.
        lead: t less the time of the earlier one, in s.
        step: their distance in s.
        reach: the same, shape (wanted rows,). Ahead of a span's first row there is no command to look back to: the two
            rows are the same one, the signal is held, and the reach is 0.
    """

    earlier: Callable[[Any], Any]
    later: Callable[[Any], Any]
    lead: Array | float
    step: Array | float
    reach: Array


def _around(clock: Clock, delay: float, rows: slice | Rows) -> _Around:
    period = step_of(clock)
    count = clock.time.size
    if isinstance(period, float):
        # One step in all spans: the delay reaches back by the same number of rows everywhere.
        whole = int(delay / period)
        lead = (whole + 1) * period
        every_row = isinstance(rows, slice) and rows == slice(None)
        if every_row and len(clock.spans) * _LONG_SPAN <= count:  # no row has to be looked up
            reach = np.full(count, period)
            for span in clock.spans:
                reach[span.start : min(span.start + whole + 1, span.stop)] = 0.0
            return _Around(
                lambda x: rows_before(x, clock, whole + 1),
                lambda x: rows_before(x, clock, whole),
                lead,
                period,
                reach,
            )
        starts = [span.start for span in clock.spans]
        lengths = [span.stop - span.start for span in clock.spans]
        first = np.repeat(starts, lengths)[rows]
        low = np.arange(count)[rows] - whole - 1
        return _at_rows(np.maximum(low, first), np.maximum(low + 1, first), lead, period)

    chosen = np.arange(count)[rows]
    before = np.empty_like(chosen)
    after = np.empty_like(chosen)
    lead = np.empty(chosen.size)
    step = np.empty(chosen.size)
    for span in clock.spans:
        at = slice(*np.searchsorted(chosen, (span.start, span.stop)))
        k = chosen[at]
        if span.stop - span.start == 1:
            low = k - 1
            lead[at] = step[at] = 1.0
        elif span.period is not None:
            whole = int(delay / span.period)
            low = k - whole - 1
            lead[at] = (whole + 1) * span.period
            step[at] = span.period
        else:
            t = clock.time[span.start : span.stop]
            low = np.searchsorted(t, clock.time[k] - delay, side="left") - 1 + span.start
            held = np.clip(low, span.start, span.stop - 2)
            lead[at] = clock.time[k] - clock.time[held]
            step[at] = clock.time[held + 1] - clock.time[held]
        before[at] = np.maximum(low, span.start)
        after[at] = np.maximum(low + 1, span.start)
    return _at_rows(before, after, lead, step)


def _at_rows(before: Rows, after: Rows, lead: Array | float, step: Array | float) -> _Around:
    """The rows around t - delay by their places."""
    reach = np.where(after > before, step, 0.0)
    return _Around(lambda x: pick(x, before), lambda x: pick(x, after), lead, step, reach)


def _share(clock: Clock, tau: Any) -> Any:
    """1 - exp(-dt / tau): one number where all rows have one step."""
    return -np.expm1(-step_of(clock) / tau)


def lagged(
    command: Any,
    clock: Clock,
    rise: Any,
    fall: Any | None,
) -> tuple[Any, Any]:
    """The lagged command, and the time constant at each row."""
    tau = rise
    share = _share(clock, rise)
    if fall is not None:
        # Which of the two holds follows from values alone; derivatives pass through the one that holds.
        u = value_of(command)
        up = np.zeros(u.size) + _share(clock, float(value_of(rise)))
        down = np.zeros(u.size) + _share(clock, float(value_of(fall)))
        rising = switched(u, up, down, clock)
        tau = chosen(rising, rise, fall)
        share = chosen(rising, share, _share(clock, fall))
    # x_k = x_{k-1} + share_k (u_k - x_{k-1}) over each span, from x = u.
    x = recur(1.0 - share, share * command, command, clock)
    return x, tau
