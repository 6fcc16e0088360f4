"""A finding is one thing that a check of the data saw, with what to do about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from erclutch.errors import worded


@dataclass(frozen=True)
class Finding:
    """One thing that a check saw.

    Attributes:
        level: "warning" or "note".
        subject: what it is about.
        message: what was seen, with value and limit.
        remedy: what to do.
    """

    level: Literal["warning", "note"]
    subject: str
    message: str
    remedy: str

    def __str__(self) -> str:
        return worded(f"{self.message}. {self.remedy}.")
