"""The brake stops its flywheel, and says what it is."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from erclutch_rig_brake import CHANNELS, Brake, rig


def test_a_current_stops_the_flywheel() -> None:
    brake = Brake()
    brake.speed = 20.0
    brake.command(SimpleNamespace(E1=0.5, motor_torque=0.0))
    for _ in range(200):
        brake.step()
    assert abs(brake.speed) < 0.1
    assert brake.angle > 0.0
    brake.command(SimpleNamespace(E1=float("inf"), motor_torque=0.0))
    brake.step()
    assert brake.current <= 1.0


def test_it_says_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BRAKE_ADDRESS", "10.0.0.2:5005")
    found = rig()
    assert (found.host, found.port, found.device, found.channels) == (
        "10.0.0.2",
        5005,
        "single",
        CHANNELS,
    )
