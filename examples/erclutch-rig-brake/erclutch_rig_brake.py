"""A single brake on a flywheel that a motor turns, SIMULATED, behind UDP: a rig with one device and named channels.

``erclutch live --rig brake`` starts the simulation as a process of its own. With BRAKE_ADDRESS=HOST:PORT and
BRAKE_SESSION in the environment it talks to a real controller instead, which speaks the same packets.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys

from erclutch.wings.rig.interface import Measurement
from erclutch.wings.rig.rig_plugins import UdpRig
from erclutch.wings.rig.rig_server import RigServer

PERIOD = 1e-3  # s
INERTIA = 2e-3  # kg m^2
#: What the channels of a single device are on this rig. Names and units go into frames, recordings and the page.
CHANNELS = {
    "position": "flywheel angle [rad]",
    "effort": "brake torque [N m]",
    "field": "coil current [A]",
    "drive": "motor torque [N m]",
}
LARGEST_CURRENT = 1.0  # A


class Brake:
    """The simulated brake: Bingham, with a coil that lags by 5 ms."""

    period = PERIOD

    def __init__(self) -> None:
        self.time = self.angle = self.speed = self.current = self.torque = 0.0
        self._asked = self._motor = 0.0

    def sense(self) -> Measurement:
        """The sensors; the axis that this rig has not stays at zero."""
        return Measurement(self.time, self.angle, 0.0, 0.0, self.torque)

    def command(self, command: object) -> None:
        """What the loop asks for over the next period."""
        self._asked = min(max(float(getattr(command, "E1", 0.0)), 0.0), LARGEST_CURRENT)
        self._motor = float(getattr(command, "motor_torque", 0.0))

    def step(self) -> None:
        """Let a period pass."""
        self.current += (self._asked - self.current) * (1.0 - math.exp(-PERIOD / 5e-3))
        self.torque = 2.0 * self.current**1.5 * math.tanh(self.speed / 0.5) + 1e-3 * self.speed
        self.speed += PERIOD * (self._motor - self.torque) / INERTIA
        self.angle += PERIOD * self.speed
        self.time += PERIOD

    def close(self) -> None:
        """No current, no motor."""
        self._asked = self._motor = 0.0

    def __enter__(self) -> Brake:
        return self

    def __exit__(self, *what: object) -> None:
        self.close()


def rig() -> UdpRig:
    """What ``erclutch live --rig brake`` asks for."""
    host, _, port = os.environ.get("BRAKE_ADDRESS", "").rpartition(":")
    session = int(os.environ.get("BRAKE_SESSION", "1"))
    if not host:
        host, port = "127.0.0.1", _simulated(session)
    return UdpRig(
        "brake",
        host,
        int(port),
        session,
        device="single",
        channels=CHANNELS,
        field_limit=LARGEST_CURRENT,
    )


def _simulated(session: int) -> str:
    """Start the simulation, which ends with this process; returns its port."""
    command = [sys.executable, "-m", "erclutch_rig_brake", str(session), str(os.getpid())]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    return process.stdout.readline().strip()


def main(session: str, parent: str) -> None:
    """Serve the brake until the process that started it is gone."""
    server = RigServer(Brake(), session=int(session), lead=2.0 * math.pi, device="single")
    print(server.port, flush=True)
    server.run(lambda: os.getppid() != int(parent))


if __name__ == "__main__":
    main(*sys.argv[1:])
