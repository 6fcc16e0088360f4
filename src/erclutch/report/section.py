"""What a section is: a title, a template, and the values that fill it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from erclutch.diagnostics.material import Material


class Section(ABC):
    """One section of a report."""

    #: Anchor, name of the template, title on the page, title in the list of contents.
    name: ClassVar[str]
    title: ClassVar[str]
    short: ClassVar[str]

    @abstractmethod
    def fill(self, material: Material) -> dict[str, Any] | None:
        """Values for the template; None leaves the section out."""

    @property
    def template(self) -> str:
        """File of the template."""
        return f"{self.name}.html.j2"
