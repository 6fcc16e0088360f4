"""The lag has one time constant, for a rising and a falling field."""

from __future__ import annotations

from erclutch.models.stages.command_lag import CommandLag

STAGE = CommandLag("lag", "delay and first-order lag of the command", switches=False)
