"""Limits of rigs at random, and what numbers break of them."""

from __future__ import annotations

import math

import numpy as np

from erclutch.signals.array import Array
from erclutch.wings.design.courses import Commands
from erclutch.wings.design.limits import RigLimits

#: Smallest and largest of what is drawn, evenly over the logarithm; what may be left out is, half of the time.
NEEDED = {"field": (1e-3, 1e4), "speed": (1e-3, 1e3), "acceleration": (1e-2, 1e5)}
OFTEN = {"field_rate": (1e-2, 1e6), "stroke": (1e-4, 1e3)}
IDLE = (0.01, 1.0)  # share of the largest effort, half of the time
EXPONENT = (0.5, 4.0)
HEAT = {"heat": (1e-3, 1e3), "effort": (1e-2, 1e3)}
RESTS = (0.0, 0.1, 0.5)


def random_limits(rng: np.random.Generator) -> RigLimits:
    """Limits of a small or a large rig."""
    ranges = dict(NEEDED)
    for further in ({"field_rate": OFTEN["field_rate"]}, {"stroke": OFTEN["stroke"]}, HEAT):
        if rng.random() < 0.5:
            ranges |= further
    drawn: dict[str, float] = {}
    for name, (low, high) in ranges.items():
        drawn[name] = math.exp(rng.uniform(math.log(low), math.log(high)))
    if "effort" in drawn and rng.random() < 0.5:
        drawn["idle_effort"] = drawn["effort"] * rng.uniform(*IDLE)
        drawn["slow_effort"] = drawn["idle_effort"] * rng.uniform(*IDLE)
        drawn["exponent"] = rng.uniform(*EXPONENT)
    return RigLimits(**drawn, rest=float(rng.choice(RESTS)))


def broken(
    commands: Commands, limits: RigLimits, rate: float, *, signed: bool = False
) -> list[str]:
    """The limits that the numbers break as they stand, asked without any tolerance."""
    speed, field, position = commands.speed, commands.field, commands.position
    field_rate = np.abs(np.diff(field)) * rate
    acceleration = np.abs(np.diff(speed)) * rate
    power = (
        np.mean(_largest_effort(commands, limits, rate) * np.abs(speed))
        if limits.heat < math.inf
        else 0.0
    )
    rest = max(math.ceil(limits.rest * rate), 1)  # rows
    moves_at_rest = any(
        np.any(course[:rest]) or np.any(course[-rest:]) for course in (field, speed)
    )
    holds = {
        "field": np.abs(field).max() <= limits.field and (signed or field.min() >= 0.0),
        "field_rate": field_rate.max() <= limits.field_rate,
        "speed": np.abs(speed).max() <= limits.speed,
        "acceleration": acceleration.max() <= limits.acceleration,
        "stroke": np.abs(position).max() <= 0.5 * limits.stroke,
        "heat": power <= limits.heat,
        "rest": not moves_at_rest,
    }
    return [name for name, is_kept in holds.items() if not is_kept]


def _largest_effort(commands: Commands, limits: RigLimits, rate: float) -> Array:
    """The effort that a device may give: by the largest field of the last 50 ms, and by the speed."""
    felt = np.abs(commands.field)
    for before in range(1, math.ceil(0.05 * rate) + 1):
        gone = np.abs(commands.field[:-before])
        felt = np.maximum(felt, np.concatenate([np.zeros(min(before, felt.size)), gone]))
    idle = min(limits.idle_effort, limits.effort)
    slow = min(limits.slow_effort, idle)
    without_field = slow + (idle - slow) * np.abs(commands.speed) / limits.speed
    return (
        without_field + (limits.effort - without_field) * (felt / limits.field) ** limits.exponent
    )
