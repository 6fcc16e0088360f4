"""The loop in Python, for machines without a C compiler: SOFT REAL TIME. Options as those of ``c/loop.c``.

Started by `erclutch.live.session`; it reads the same configuration, table, orders and packets as the loop in C.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import math
import os
import select
import signal
import socket
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import ErclutchError, RunError
from erclutch.live.frame import EVENT_BITS, RingWriter, State
from erclutch.live.orders import SIZE as ORDER_SIZE
from erclutch.live.orders import read_order
from erclutch.live.sample import SAMPLE
from erclutch.live.settings import LoopSettings, settings_of
from erclutch.live.soft_core import InverseFunction, SoftCore, StepFunction
from erclutch.rig.packet import LAST, SIZE, CommandPacket, pack_command, unpack_sensors
from erclutch.saved import Model, load_model

WORD = "SOFT REAL TIME: the loop runs in Python, for want of a C compiler"
_AT_ZERO = 5
_MOST = 64


class SoftRig:
    """The rig's socket."""

    def __init__(self, host: str, port: str, local_port: str, session: str) -> None:
        self._session = int(session, 0)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        loopback = host.startswith("127.")
        self._socket.bind(("127.0.0.1" if loopback else "0.0.0.0", int(local_port)))
        self._socket.connect((host, int(port)))
        self._socket.setblocking(False)

    def receive(self) -> tuple[Any, int]:
        """Samples that came in, dtype `SAMPLE`, and events."""
        samples, count, events = np.zeros(_MOST, SAMPLE), 0, 0
        for _ in range(_MOST):
            try:
                data = self._socket.recv(SIZE + 1)
            except BlockingIOError:
                break
            except OSError:  # an earlier command found no rig, and we are told now
                continue
            packet = unpack_sensors(data, self._session)
            if packet is None:
                events |= EVENT_BITS["bad-packet"]
                continue
            p = packet
            samples[count] = (p.seq, p.time_ns, p.theta, p.alpha, p.torque, p.status, 0)
            count += 1
        return samples[:count], events

    def send(self, seq: int, time_ns: int, command: Any) -> int:
        """Send a command; 0, or the event that it failed."""
        fields = (float(command[name]) for name in ("field1", "field2", "motor_torque"))
        flags = LAST if command["flags"] else 0
        data = pack_command(CommandPacket(self._session, seq, time_ns, *fields, flags=flags))
        for _ in range(3):
            with contextlib.suppress(ConnectionRefusedError):
                try:
                    self._socket.send(data)
                except BlockingIOError:
                    break
                return 0
        return EVENT_BITS["send-failed"]


def model_functions(model: Model, settings: LoopSettings) -> tuple[StepFunction, InverseFunction | None]:
    """A saved model, one row at a time.

    Raises:
        RunError: it has dynamics, past samples or further inputs, which the loop in Python does not run.
    """
    from erclutch.device import Element
    from erclutch.dynamics import Clock, Span
    from erclutch.networks.model import NetworkModel

    structure: Any = model.structure
    past = isinstance(model, NetworkModel) and bool(structure.past or structure.extras)
    if structure.dynamics != "none" or past:
        raise RunError(
            f"{model.name} needs more than the present row, which the loop in Python does not have",
            where=model.name,
            remedy="Install a C compiler, or take a model without dynamics, past samples and further inputs",
        )
    clock = Clock(np.zeros(1), (Span(0, 1, settings.period),))
    last = [0.0]
    low, high = model.trained_on.field, model.trained_on.slip

    def elements(inputs: Sequence[float]) -> tuple[Element, ...]:
        if len(inputs) == 2:
            pairs = [(inputs[0], inputs[1])]
        else:
            first, second, theta_dot, alpha_dot = inputs
            pairs = [(first, theta_dot - alpha_dot), (second, -theta_dot - alpha_dot)]
        return tuple(Element(np.array([f]), np.array([w])) for f, w in pairs)

    def outside(rows: Sequence[Element]) -> bool:
        pairs = [(float(e.field[0]), low) for e in rows] + [(float(e.slip[0]), high) for e in rows]
        return any(not a - 0.01 * (b - a) <= x <= b + 0.01 * (b - a) for x, (a, b) in pairs)

    def step(inputs: Sequence[float]) -> tuple[float, int]:
        if not all(map(math.isfinite, inputs)):
            return last[0], 2
        rows = elements(inputs)
        effort = model.effort(rows, clock, exactly=False)
        value = float(effort[0])
        last[0] = value if math.isfinite(value) else last[0]
        both = len(rows) == 2 and inputs[0] > 0 and inputs[1] > 0
        return last[0], (1 if outside(rows) else 0) | (4 if both else 0)

    def inverse(inputs: Sequence[float], wanted: float) -> tuple[float, int]:
        """Bisection over the signed field: the model's effort grows with it while the motor turns forward."""
        limit = settings.field_limit

        def effort(field: float) -> float:
            pair = (max(field, 0.0), max(-field, 0.0), *inputs[2:]) if len(inputs) == 4 else (field, *inputs[1:])
            return float(model.effort(elements(pair), clock, exactly=False)[0])

        low_field, high_field = (-limit if len(inputs) == 4 else 0.0), limit
        way = 1.0 if effort(high_field) >= effort(low_field) else -1.0
        if not way * effort(low_field) <= way * wanted <= way * effort(high_field):
            return (low_field if way * wanted < way * effort(low_field) else high_field), 16
        for _ in range(12):  # 0.5 / 2^12: a tenth of a volt in 2000 V
            middle = 0.5 * (low_field + high_field)
            if way * effort(middle) < way * wanted:
                low_field = middle
            else:
                high_field = middle
        return 0.5 * (low_field + high_field), 0

    return step, inverse


class SoftLoop:
    """Sense, estimate, control, interlock, command, once a period, as well as Python can."""

    def __init__(self, settings: LoopSettings, core: SoftCore, rig: SoftRig, ring: RingWriter, steps: int) -> None:
        self._period = round(settings.period * 1e9)
        self._settings, self._core, self._rig, self._ring, self._steps = settings, core, rig, ring, steps
        self._seq = 0
        self._carried = 0

    def run(self, ended: Any, orders: int) -> None:
        """Until told to end, then at zero field."""
        tick, deadline, at_zero, stopping = 0, time.monotonic_ns() + 2 * self._period, 0, False
        while at_zero < _AT_ZERO:
            self._sleep(deadline)
            if not stopping and (ended() or tick >= self._steps or self._take_orders(orders)):
                self._core.stop()
                stopping = True
            self._step(tick, deadline)
            at_zero += stopping
            late = time.monotonic_ns() - deadline
            periods = late // self._period + 1 if late > 0 else 1
            self._carried |= EVENT_BITS["overrun"] if periods > 1 else 0
            deadline += periods * self._period
            tick += periods
        self._ring.put(state=int(State.STOPPED))

    @staticmethod
    def _sleep(deadline: int) -> None:
        wait = deadline - time.monotonic_ns()
        if wait > 0:
            time.sleep(1e-9 * wait)

    def _step(self, tick: int, deadline: int) -> None:
        woken = time.monotonic_ns()
        late = woken - deadline
        samples, events = self._rig.receive()
        command, frame = self._core.step(samples, tick, late_ns=max(late, 0), events=events | self._carried)
        self._seq += 1
        self._carried = self._rig.send(self._seq, woken, command)
        frame["time_ns"], frame["lateness_ns"] = woken, max(min(late, 2**31 - 1), -(2**31))
        frame["step_ns"] = min(time.monotonic_ns() - woken, 2**32 - 1)
        self._ring.write(frame)
        core = self._core
        program = core.program
        self._ring.put(
            state=int(core.state),
            trip_reason=core.trip_reason,
            program=program,
            mode=int(self._settings.programs[program].mode),
            sensor_seq=core.sensor_seq,
        )

    def _take_orders(self, orders: int) -> bool:
        for _ in range(4):
            if orders < 0 or not select.select([orders], [], [], 0)[0]:
                return False
            data = os.read(orders, ORDER_SIZE)
            if not data:
                return True
            order = read_order(data)
            if order is None:
                self._core.refuse()
            elif self._core.order(*order):
                return True
        return False


def main(words: Sequence[str]) -> int:
    """Run until told to end; exit code 2 if it cannot start."""
    parser = argparse.ArgumentParser(prog="erclutch-loop")
    for name, count in (("config", 1), ("ring", 1), ("udp", 4), ("library", 2), ("model", 2), ("table", 1)):
        parser.add_argument(f"--{name}", nargs=count)
    for name, default in (("orders", -1), ("steps", 2**63), ("priority", 80), ("cpu", -1)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args(words)
    parent = os.getppid()
    told: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, lambda number, _frame: told.append(number))
    try:
        if given.library:
            raise RunError("a rig's library needs the loop in C", remedy="Install a C compiler")
        table = np.fromfile(given.table[0]).reshape(-1, 3) if given.table else np.zeros((0, 3))
        settings = settings_of(Path(given.config[0]).read_bytes(), table)
        step: StepFunction | None = None
        inverse: InverseFunction | None = None
        if given.model:
            step, inverse = model_functions(load_model(given.model[0]), settings)
        ring = RingWriter(given.ring[0])
        rig = SoftRig(*given.udp)
    except ErclutchError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    if step is not None and inverse is not None:  # imports and caches now, not in the first step
        still = (0.0,) * (2 if settings.device == "single" else 4)
        step(still)
        inverse(still, 0.0)
    with contextlib.suppress(AttributeError, OSError, ValueError):
        if given.priority > 0:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(given.priority))
    ring.put(realtime=WORD, pid=os.getpid())
    gc.collect()
    gc.freeze()
    gc.disable()
    loop = SoftLoop(settings, SoftCore(settings, step, inverse), rig, ring, given.steps)
    loop.run(lambda: bool(told) or os.getppid() != parent, given.orders)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
