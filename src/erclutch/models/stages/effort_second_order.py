"""The effort passes a second-order lag: a load cell on a structure that may swing."""

from __future__ import annotations

from erclutch.models.stages.oscillator import Oscillator

STAGE = Oscillator(
    "effort-second-order",
    "second-order lag of the effort",
    "a damped oscillator; any book on vibration",
    "effort",
    "s",
)
