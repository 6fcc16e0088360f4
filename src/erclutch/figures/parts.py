"""What the figures of a run share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from erclutch.diagnostics.material import Material
from erclutch.figures.style import BLUE, GREEN, RED

_COLOURS = {"recommended": RED, "best": BLUE, "baseline": GREEN}
_DASHES = {"recommended": "-", "best": "--", "baseline": ":"}


@dataclass(frozen=True)
class Numbers:
    """The numbers behind a figure, in the run's own units.

    Attributes:
        header: names of the columns.
        rows: values.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[object]]


def role_colour(role: str | None) -> str:
    """Colour of a model by why it is shown."""
    return _COLOURS.get(role or "", "#B9BDC4")


def role_line(role: str) -> dict[str, str]:
    """Colour and dash of a model's line."""
    return {"color": _COLOURS[role], "linestyle": _DASHES[role]}


def titled(material: Material, text: str) -> str:
    """A title that says so where a computer made the data."""
    return text if material.badge == "RECORDING" else f"{text} ({material.badge})"
