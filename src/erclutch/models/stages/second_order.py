"""The command passes a second-order lag: a coil and its current controller, which may overshoot."""

from __future__ import annotations

from erclutch.models.stages.oscillator import Oscillator

STAGE = Oscillator(
    "second-order",
    "second-order lag of the command",
    "a damped oscillator; any book on control",
    "command",
    "c",
)
