"""This lag has a time constant of its own for a falling field."""

from __future__ import annotations

from erclutch.models.stages.command_lag import CommandLag

STAGE = CommandLag(
    "rise-fall", "delay and lags of the rising and of the falling field", switches=True
)
