"""Steps of the internal states stay stable for any rate and are of second order at a midpoint rate."""

from __future__ import annotations

from erclutch.wings.rig.twin.jit import compiled


@compiled
def decay(x: float) -> float:
    """exp(-x) for x >= 0 to third order, between 0 and 1, and going to 0 for large x. A third of the cost of exp."""
    return 1.0 / (1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0))))


@compiled
def toward(state: float, target: float, rate_step: float) -> float:
    """A state that approaches a target at a rate: one step of rate x dt."""
    return target + (state - target) * decay(rate_step)
