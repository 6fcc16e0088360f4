"""Values of the main job show themselves: a line in a shell, a card in a notebook, a table, a DataFrame, a plot."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pandas import DataFrame


def _notebook() -> Any:
    """`erclutch.report.notebook`, by its name: the room of reports stands above all rooms that it shows."""
    return import_module("erclutch.report.notebook")


class Shown:
    """What a value shows of itself; `erclutch.report.notebook_cards` knows how for each class."""

    def __repr__(self) -> str:
        return str(_notebook().line(self))

    def _repr_html_(self) -> str:
        return str(_notebook().html(self))

    def shown_by(self, name: str) -> Any:
        """What a function of `erclutch.report.notebook` makes of the value."""
        return getattr(_notebook(), name)(self)

    def table(self) -> DataFrame:
        """The table that a notebook shows, whole and unrounded, as a DataFrame."""
        return self.shown_by("table")

    def to_frame(self) -> DataFrame:
        """All rows as a DataFrame with units in the names of its columns and the time, if any, in its index."""
        return self.shown_by("frame")

    def plot(self, name: str | None = None, **options: Any) -> Any:
        """Draw with matplotlib.

        Args:
            name: which plot; None: the first that the value has. A wrong name lists them.
            options: of the plot: ``start`` and ``seconds`` of a section.

        Returns:
            The axes, or an array of them where the plot has several panels.

        Raises:
            SettingError: no such plot.
            CheckError: the value cannot give it.
        """
        return _notebook().plot(self, name, **options)
