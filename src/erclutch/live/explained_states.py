"""What the loop does on each event in each of its states, found by asking its own C core.

    for line in transitions():
        print(line.state.name, line.event, line.next.name)

Nothing is written down twice: each event is played to a core that was brought into the state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.live.c_core import Core
from erclutch.live.layout import CONSTANTS, EVENT_BITS, SAMPLE
from erclutch.live.orders import Order
from erclutch.live.ring import State
from erclutch.live.settings import REST, LoopProgram, LoopSettings, Mode

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


class _Played:
    """A core with a rig that sends a good sample each period, until the events say otherwise."""

    def __init__(self, settings: LoopSettings, model: Path | None) -> None:
        self.settings = settings
        self.core, self.tick, self.before = Core(self.settings, model), 0, 0.0

    def step(self, good: bool = True, status: int = 0, late: float = 0.0, finite: bool = True) -> Any:
        self.tick += 1
        sample = np.zeros(int(good), SAMPLE)
        sample["seq"], sample["time_ns"], sample["status"] = self.tick, self.tick * 1_000_000, status
        sample["theta"] = 1e-3 * self.tick if finite else np.nan
        return self.core.step(sample, self.tick, late_ns=round(1e9 * late))[1].copy()

    def silence(self, periods: int) -> Any:
        for _ in range(periods - 1):
            self.step(good=False)
        return self.step(good=False)

    def order(self, *orders: tuple[Order, float], good: bool = True) -> Any:
        for order, value in orders:
            if self.core.order(order, value):
                self.core.stop()
        return self.step(good)

    def into(self, state: State) -> _Played:
        if state is not State.STARTING:
            for _ in range(80):
                self.before = float(self.step()["field1"])
        if state in (State.TRIPPED, State.READY):
            self.order((Order.ZERO, 0.0))
        if state is State.READY:
            self.order((Order.RESET, 0.0))
        assert self.core.state == state
        return self


_EVENTS: dict[str, Callable[[_Played], Any]] = {
    "a good sample": lambda p: p.step(),
    "one period without a sample": lambda p: p.silence(1),
    "{degrade} periods without a sample": lambda p: p.silence(p.settings.hold + 1),
    "{trip} periods without a sample": lambda p: p.silence(p.settings.trip),
    "a sample that is not finite": lambda p: p.step(finite=False),
    "a wake-up more than {late:g} ms late": lambda p: p.step(late=p.settings.late_trip + 1e-3),
    "the rig reports a fault": lambda p: p.step(status=CONSTANTS["ERC_STATUS_FAULT"]),
    "the rig's watchdog acted": lambda p: p.step(status=CONSTANTS["ERC_STATUS_WATCHDOG"]),
    "order: zero fields": lambda p: p.order((Order.ZERO, 0.0)),
    "order: reset": lambda p: p.order((Order.RESET, 0.0)),
    "order: reset, without a sample since": lambda p: (p.step(good=False), p.order((Order.RESET, 0.0), good=False))[1],
    "order: run a program": lambda p: p.order((Order.PROGRAM, 0.0)),
    "order: run a program that is not there": lambda p: p.order((Order.PROGRAM, 9.0)),
    "order: stop, a signal, or the parent is gone": lambda p: p.order((Order.STOP, 0.0)),
}


def transitions(settings: LoopSettings = _PUSH, model: Path | None = None) -> Iterator[Transition]:
    """Each event in each state, as the C core answers it.

    Args:
        settings: of the core; the first of its two programs keeps the field on.
        model: compiled, where this program needs a model.

    Raises:
        RunError: no compiler is there to build the core.
    """
    for state in (State.STARTING, State.RUNNING, State.TRIPPED, State.READY):
        for event, play in _EVENTS.items():
            played = _Played(settings, model).into(state)
            frame = play(played)
            names = tuple(name for name, bit in EVENT_BITS.items() if frame["events"] & bit)
            limits = played.settings
            text = event.format(degrade=limits.hold + 1, trip=limits.trip, late=1e3 * limits.late_trip)
            after = State.STOPPED if "stopping" in names else State(played.core.state)
            yield Transition(state, text, after, _field(names, float(frame["field1"]), after), names)


def _field(names: tuple[str, ...], field: float, after: State) -> str:
    if after is not State.RUNNING or field == 0.0:
        return "zero"
    return "reduced" if "degrade" in names else "held" if "hold" in names else "by the program"
