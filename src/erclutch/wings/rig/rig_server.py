"""A rig behind its UDP port takes commands, steps and answers; without commands its watchdog zeroes the fields.

Serves anything with the `SteppedRig` interface. Time passes with each command; without one, by the rig's own clock.
"""

from __future__ import annotations

import math
import select
import socket
import time
from collections import Counter
from collections.abc import Callable

from erclutch.signals.device import DeviceName
from erclutch.wings.rig.interface import RigCommand, SteppedRig
from erclutch.wings.rig.packet import (
    FAULT,
    LAST,
    NUMBERS,
    SIZE,
    WATCHDOG,
    CommandPacket,
    SensorPacket,
    pack_sensors,
    unpack_command,
)

#: No valid command for so long: fields to zero [s]. Far enough from 20 ms for what the operating system is late by.
WATCHDOG_TIME = 0.015
_Address = tuple[str, int]


class RigEnd(Exception):  # noqa: N818  # as StopIteration: an end, not an error
    """A rig has nothing more to give: a replay is over."""


class RigServer:
    """One rig, one port, one loop at a time.

    Args:
        rig: what is served.
        port: UDP port on loopback; 0 takes a free one.
        session: number that packets must carry.
        lead: of the screw in m: the table's position as an angle. 1 turn where there is none.
        device: that hangs on the rig; packets of another device are dropped.
        host: address to listen at; anything but loopback is the user's own decision.
        watch: called with (monotonic time in s, command) whenever the rig takes a command; for tests.

    Attributes:
        counts: valid, bad, stale and foreign packets, steps without a command, watchdog trips.
    """

    def __init__(
        self,
        rig: SteppedRig,
        *,
        session: int,
        lead: float,
        device: DeviceName = "coaxial",
        port: int = 0,
        host: str = "127.0.0.1",
        watch: Callable[[float, RigCommand], None] = lambda now, command: None,
    ) -> None:
        self.rig = rig
        self.counts: Counter[str] = Counter()
        self._session = session
        self._device = NUMBERS[device]
        self._turns = 2.0 * math.pi / lead
        self._watch = watch
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((host, port))
        self._socket.setblocking(False)
        self._loop: _Address | None = None
        self._last_seq = 0
        self._seq = 0
        self._heard = -math.inf
        self._zeroed = True

    @property
    def port(self) -> int:
        """UDP port that it listens at."""
        return int(self._socket.getsockname()[1])

    def run(self, stop: Callable[[], bool]) -> None:
        """Serve until told to stop, or until the rig has nothing more to give; then fields are zero."""
        period = self.rig.period
        due = math.inf
        try:
            while not stop():
                command = self._wait(due)
                now = time.monotonic()
                if command is not None:
                    self._take(command, now)
                elif self._loop is None:
                    continue  # nobody has spoken yet: a rig at rest
                elif now < due:
                    self._guard(now)
                    continue
                self._guard(now)
                self.rig.step()
                self.counts["steps"] += 1
                self._answer()
                due = now + (1.5 * period if command is not None else period)
        except RigEnd:
            self.counts["ended"] = 1
        finally:
            self.rig.close()
            self._watch(time.monotonic(), RigCommand())
            self._socket.close()

    def _wait(self, due: float) -> CommandPacket | None:
        """The newest command, or None when the time has come to go on without or to look at the watchdog."""
        watchdog = math.inf if self._zeroed else self._heard + WATCHDOG_TIME
        until = min(due, watchdog) - time.monotonic()
        wait = max(0.0, min(until, 0.05))
        newest = self._drain()
        if newest is None and select.select([self._socket], [], [], wait)[0]:
            newest = self._drain()
        return newest

    def _drain(self) -> CommandPacket | None:
        newest = None
        for _ in range(64):
            try:
                data, sender = self._socket.recvfrom(SIZE + 1)
            except OSError:  # nothing there, or an old answer found no loop
                break
            packet = unpack_command(data, self._session)
            packet = None if packet is not None and packet.device != self._device else packet
            if packet is not None and self._accepted(packet, sender):
                newest = packet
            elif packet is None:
                self.counts["bad"] += 1
        return newest

    def _accepted(self, packet: CommandPacket, sender: _Address) -> bool:
        """One loop at a time: another one is heard, and numbers may start anew, once the watchdog has acted."""
        if self._zeroed:
            if sender != self._loop or packet.seq <= self._last_seq:
                self.counts["loops"] += 1
            self._loop = sender
        elif sender != self._loop:
            self.counts["foreign"] += 1
            return False
        elif packet.seq <= self._last_seq:
            self.counts["stale"] += 1
            return False
        self._last_seq = packet.seq
        self.counts["valid"] += 1
        return True

    def _take(self, packet: CommandPacket, now: float) -> None:
        self._heard = now
        self._zeroed = False
        self._command(RigCommand(packet.field1, packet.field2, packet.motor_torque))
        if packet.flags & LAST:
            self._command(RigCommand())

    def _guard(self, now: float) -> None:
        if not self._zeroed and now - self._heard >= WATCHDOG_TIME:
            self._zeroed = True
            self.counts["watchdog"] += 1
            self._command(RigCommand())

    def _command(self, command: RigCommand) -> None:
        self.rig.command(command)
        self._watch(time.monotonic(), command)

    def _answer(self) -> None:
        self._seq += 1
        m = self.rig.sense()
        status = (WATCHDOG if self._zeroed else 0) | (
            FAULT if getattr(self.rig, "fault", False) else 0
        )
        alpha = m.alpha_raw * self._turns
        now = time.monotonic_ns()
        packet = SensorPacket(
            self._session, self._seq, now, m.theta, alpha, m.torque, status, self._device
        )
        assert self._loop is not None
        try:
            self._socket.sendto(pack_sensors(packet), self._loop)
        except OSError:
            self.counts["unsent"] += 1
