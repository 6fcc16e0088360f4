"""A rig behind UDP in Python, with nothing but the standard library: the packets, a watchdog, and a device to replace.

    python peer.py 5005 42 &
    erclutch live --rig udp --address 127.0.0.1:5005 --session 42 --program tracking-slow

It answers each command with its next sample; without commands it goes on by its own clock, and its watchdog sets the
fields to zero after 15 ms.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import socket
import struct
import sys
import time
import zlib

PERIOD, WATCHDOG = 0.001, 0.015
BODY = struct.Struct("<IIQQdddII4x")  # and a CRC-32 of these 60 bytes
DEVICE = 0  # 0: the coaxial pair; 1: one brake, clutch or damper, which has field1, theta and torque alone
SENSORS, COMMAND = 0x31535245, 0x31435245


class Device:
    """Two Bingham clutches on an inertia: put your sensors and outputs in its place."""

    def __init__(self) -> None:
        self.theta = self.theta_dot = self.alpha = self.alpha_dot = self.torque = 0.0

    def step(self, field1: float, field2: float, motor: float) -> None:
        """Let a period pass."""
        drive1 = math.tanh((self.theta_dot - self.alpha_dot) / 2.0)
        drive2 = math.tanh((-self.theta_dot - self.alpha_dot) / 2.0)
        self.torque = 2.0 * (field1**2 * drive1 + field2**2 * drive2) - 4e-4 * self.alpha_dot
        self.theta_dot += PERIOD * (motor - 2e-3 * self.theta_dot) / 3e-4
        self.alpha_dot += PERIOD * (self.torque - 1e-3 * math.tanh(self.alpha_dot)) / 2e-4
        self.theta += PERIOD * self.theta_dot
        self.alpha += PERIOD * self.alpha_dot


def command_in(data: bytes, session: int) -> tuple[int, float, float, float, int] | None:
    """Number, fields, motor torque and flags of a packet; None if it is not whole, or not for us."""
    if len(data) != 64 or struct.unpack_from("<I", data, 60)[0] != zlib.crc32(data[:60]):
        return None
    magic, of, seq, _, field1, field2, motor, flags, device = BODY.unpack_from(data)
    return (
        (seq, field1, field2, motor, flags)
        if (magic, of, device) == (COMMAND, session, DEVICE)
        else None
    )


def main(port: int, session: int) -> None:
    """Serve for ever."""
    device, seq, last, heard, watchdog = Device(), 0, 0, -math.inf, True
    field1 = field2 = motor = 0.0
    due, loop = math.inf, None
    with contextlib.suppress(
        AttributeError, OSError
    ):  # a rig does not wait for a browser; without permission it may
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(70))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wire:
        wire.bind(("127.0.0.1", port))
        while True:
            wait = min(max(0.0, due - time.monotonic()), 0.1)
            taken = False
            if select.select([wire], [], [], wait)[0]:
                data, sender = wire.recvfrom(65)
                found = command_in(data, session)
                # While the watchdog holds, a loop that was started anew may count from one again.
                if found is not None and (watchdog or found[0] > last):
                    last, field1, field2, motor, flags = found
                    field1, field2 = (0.0, 0.0) if flags & 1 else (field1, field2)
                    heard, watchdog, taken, loop = time.monotonic(), False, True, sender
            if loop is None or (not taken and time.monotonic() < due):
                continue
            if time.monotonic() - heard > WATCHDOG:
                field1 = field2 = motor = 0.0
                watchdog = True
            device.step(field1, field2, motor)
            seq += 1
            now = time.monotonic_ns()
            values = (device.theta, device.alpha, device.torque)
            body = BODY.pack(SENSORS, session, seq, now, *values, 1 if watchdog else 0, DEVICE)
            wire.sendto(body + struct.pack("<I", zlib.crc32(body)), loop)
            due = time.monotonic() + (1.5 if taken else 1.0) * PERIOD


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
