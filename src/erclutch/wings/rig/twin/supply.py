"""The high-voltage unit turns a command into a voltage, first-order with a slew limit; one channel a clutch.

Both channels at once are not for this rig: the smaller command is held at zero, as the supply's interlock would.
"""

from __future__ import annotations

from erclutch.wings.rig.twin.integrate import decay
from erclutch.wings.rig.twin.jit import compiled
from erclutch.wings.rig.twin.part_parameters import Supply


@compiled
def voltage_after(
    voltage: float,
    command: float,
    supply: Supply,
    dt: float,
) -> float:
    """Voltage one step later; the command is clipped to its range. Below 1 mV it is off."""
    wanted = (
        min(max(command, 0.0), supply.command_limit) / supply.command_limit * supply.voltage_limit
    )
    change = (wanted - voltage) * (1.0 - decay(dt / supply.time_constant))
    after = voltage + min(max(change, -supply.slew_down * dt), supply.slew_up * dt)
    return after if after > 1e-3 else 0.0


@compiled
def interlocked(first: float, second: float) -> tuple[float, float, bool]:
    """Commands with at most one of them above zero, and whether one had to give way."""
    if first > 0.0 and second > 0.0:
        return (first, 0.0, True) if first >= second else (0.0, second, True)
    return first, second, False
