"""What the loop does on each event in each of its states, found by asking its own C core.

    for line in transitions():
        print(line.state.name, line.event, line.next.name)

Nothing is written down twice: each event is played to a core that was brought into the state.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import CONSTANTS, EVENT_BITS, SAMPLE
from erclutch.wings.live.orders import Order
from erclutch.wings.live.ring import State
from erclutch.wings.live.settings import REST, LoopProgram, LoopSettings, Mode

_PUSH = LoopSettings(programs=(LoopProgram("push", Mode.TRACK, amplitude=1e3), REST))


@dataclass(frozen=True)
class Transition:
    """One event in one state.

    Attributes:
        state: before the event.
        event: what happens, for people.
        next: the state after it.
        field: "zero", "held", "reduced" or "by the program": what goes out in that step.
        said: names of the events that the frame then holds.
    """

    state: State
    event: str
    next: State
    field: str
    said: tuple[str, ...]


@dataclass(frozen=True)
class Period:
    """What a core meets in a period: orders, then a sample or none.

    Attributes:
        orders: each with its value.
        good: a sample comes.
        finite: the sample's angle is a number.
        late: of the wake-up, in s.
        status: of the rig, as bits.
        times: how often that happens.
    """

    orders: tuple[tuple[Order, float], ...] = ()
    good: bool = True
    finite: bool = True
    late: float = 0.0
    status: int = 0
    times: int = 1


def _ordered(order: Order, value: float = 0.0, *, good: bool = True) -> Period:
    return Period(((order, value),), good)


#: What brings a core into each state.
WAYS: Mapping[State, tuple[Period, ...]] = {
    State.STARTING: (),
    State.RUNNING: (Period(times=80),),
    State.TRIPPED: (Period(times=80), _ordered(Order.ZERO)),
    State.READY: (Period(times=80), _ordered(Order.ZERO), _ordered(Order.RESET)),
}


def events_of(settings: LoopSettings = _PUSH) -> dict[str, tuple[Period, ...]]:
    """Each event, with the limits of the settings in its name, and the periods that play it."""
    hold = settings.hold + 1
    trip = settings.trip
    late = settings.late_trip
    return {
        "a good sample": (Period(),),
        "one period without a sample": (Period(good=False),),
        f"{hold} periods without a sample": (Period(good=False, times=hold),),
        f"{trip} periods without a sample": (Period(good=False, times=trip),),
        "a sample that is not finite": (Period(finite=False),),
        f"a wake-up more than {1e3 * late:g} ms late": (Period(late=late + 1e-3),),
        "the rig reports a fault": (Period(status=CONSTANTS["ERC_STATUS_FAULT"]),),
        "the rig's watchdog acted": (Period(status=CONSTANTS["ERC_STATUS_WATCHDOG"]),),
        "order: zero fields": (_ordered(Order.ZERO),),
        "order: reset": (_ordered(Order.RESET),),
        "order: reset, without a sample since": (
            Period(good=False),
            _ordered(Order.RESET, good=False),
        ),
        "order: run a program": (_ordered(Order.PROGRAM),),
        "order: run a program that is not there": (_ordered(Order.PROGRAM, 9.0),),
        "order: stop, a signal, or the parent is gone": (_ordered(Order.STOP),),
    }


class _Played:
    """A core with a rig."""

    def __init__(self, settings: LoopSettings, model: Path | None) -> None:
        self.core = Core(settings, model)
        self.tick = 0  # periods so far

    def play(self, periods: Iterable[Period]) -> Any:
        """The last frame; None of no period."""
        frame: Any = None
        for period in periods:
            for order, value in period.orders:
                if self.core.order(order, value):
                    self.core.stop()
            for _ in range(period.times):
                frame = self._step(period)
        return frame

    def _step(self, period: Period) -> Any:
        self.tick += 1
        sample = np.zeros(int(period.good), SAMPLE)
        sample["seq"] = self.tick
        sample["time_ns"] = self.tick * 1_000_000
        sample["status"] = period.status
        sample["theta"] = 1e-3 * self.tick if period.finite else np.nan
        _, frame = self.core.step(sample, self.tick, late_ns=round(1e9 * period.late))
        return frame.copy()  # the core writes its next frame into the same place


def transitions(settings: LoopSettings = _PUSH, model: Path | None = None) -> Iterator[Transition]:
    """Each event in each state, as the C core answers it.

    Args:
        settings: of the core; the first of its two programs keeps the field on.
        model: compiled, where this program needs a model.

    Raises:
        RunError: no compiler is there to build the core.
    """
    for state, way in WAYS.items():
        for event, periods in events_of(settings).items():
            played = _Played(settings, model)
            played.play(way)
            assert played.core.state == state
            frame = played.play(periods)
            names = tuple(name for name, bit in EVENT_BITS.items() if frame["events"] & bit)
            after = State(played.core.state)
            if "stopping" in names:
                after = State.STOPPED
            field = "by the program"
            if after is not State.RUNNING or frame["field1"] == 0.0:
                field = "zero"
            elif "degrade" in names:
                field = "reduced"
            elif "hold" in names:
                field = "held"
            yield Transition(state, event, after, field, names)
