"""The lag with one time constant."""

from __future__ import annotations

from erclutch.models.stages.command_lag import CommandLag

STAGE = CommandLag("lag", "delay and first-order lag of the command", switches=False)
