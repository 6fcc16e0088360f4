"""A section has a title, a template, and the values that fill it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from erclutch.report.numbers.run_material import Material


@dataclass(frozen=True)
class Section:
    """One section of a report.

    Attributes:
        name: anchor, and name of the template.
        title: on the page.
        short: title in the list of contents.
        fill: gives the values for the template by name; None leaves the section out.
        folded: whether it stands among the details, which a reader opens.
        printed: whether a folded section is printed too.
    """

    name: str
    title: str
    short: str
    fill: Callable[[Material], Any]
    folded: bool = False
    printed: bool = False
