"""Values of the main job show themselves: a line in a shell, a small table in a notebook, a DataFrame, a plot.

A value writes its line itself. Tables and plots come from a presenter, which stands above all values: the face of the
package hands it down to this module.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from pandas import DataFrame


class Presenter(Protocol):
    """What makes tables, HTML and plots of values."""

    def html(self, value: Any) -> str:
        """See `Shown._repr_html_`."""
        ...

    def table(self, value: Any) -> DataFrame:
        """See `Shown.table`."""
        ...

    def frame(self, value: Any) -> DataFrame:
        """See `Shown.to_frame`."""
        ...

    def plot(self, value: Any, name: str | None = None, **options: Any) -> Any:
        """See `Shown.plot`."""
        ...

    def report(self, value: Any) -> Any:
        """The whole report of a run, for a notebook."""
        ...


_given: list[Callable[[], Presenter]] = []


def present_by(presenter: Callable[[], Presenter]) -> None:
    """Take tables and plots from what this function gives; it is called when the first value asks for one."""
    _given[:] = [presenter]


def presenter() -> Presenter:
    """The presenter.

    Raises:
        SettingError: none was handed down, because nobody has imported the package itself.
    """
    if not _given:
        from erclutch.errors import SettingError

        raise SettingError("nothing is here to show values", remedy="Import erclutch first")
    return _given[0]()


def one_line(value: object, name: str, *facts: str) -> str:
    """A value in a line: its class, its name and some facts, without what could move a terminal's cursor."""
    # Here, so that a start of the package imports next to nothing.
    from erclutch.errors import printable

    return printable(f"{type(value).__name__}({name}: {', '.join(facts)})")


class Shown:
    """What a value shows of itself beside its line."""

    def _repr_html_(self) -> str:
        return presenter().html(self)

    def table(self) -> DataFrame:
        """The table that a notebook shows, whole and unrounded, as a DataFrame."""
        return presenter().table(self)

    def to_frame(self) -> DataFrame:
        """All rows as a DataFrame with units in the names of its columns and the time, if any, in its index."""
        return presenter().frame(self)

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
        return presenter().plot(self, name, **options)
