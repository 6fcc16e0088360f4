"""Options that few need fold to a line of ``--help``; ``--help-all`` shows them."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cyclopts import Group
from cyclopts.help.formatters import DefaultFormatter
from cyclopts.help.inline_text import InlineText
from rich.console import Console
from rich.text import Text

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import ConsoleOptions

HELP_ALL = "--help-all"
# Defaults that say nothing: a flag that is not given is off.
_NO_VALUE = (
    "()",
    '""',
    "False",
)

_LEAST_WIDTH = 20  # columns


@dataclass
class _Help:
    whole: bool = False


_HELP = _Help()


@contextmanager
def whole_help(*, whole: bool) -> Generator[None]:
    """Show all options for a while, or fold those that few need."""
    before = _HELP.whole
    _HELP.whole = whole
    try:
        yield
    finally:
        _HELP.whole = before


def folded(name: str, sort_key: float) -> Group:
    """A group of options that ``--help`` shows as one line."""
    return Group(name, sort_key=sort_key, help_formatter=_show)


class Flowing(DefaultFormatter):
    """Groups of options in which each text fills its lines: a line of a docstring ends for no reader."""

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        """Print one group, on a screen of next to no columns as on one of a few: a word would be cut without end."""
        if console.width < _LEAST_WIDTH:
            console = Console(width=_LEAST_WIDTH)
            options = console.options
        for entry in panel.entries:
            description = entry.description
            if isinstance(description, InlineText) and isinstance(
                description.primary_renderable, Text
            ):
                words = description.primary_renderable.plain.split()
                description.primary_renderable.plain = " ".join(words)
        entries: list[HelpEntry] = []
        for entry in panel.entries:
            # As a user would type it: of several values ``pdf png``, and not Python's ``('pdf', 'png')``.
            default = None if entry.default in _NO_VALUE else entry.default
            if default is not None and default.startswith("("):
                default = default.strip("()").replace(",", "").replace("'", "")
            entries.append(entry.copy(default=default))
        panel.entries = entries
        super().__call__(console, options, panel)


def _show(console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
    if _HELP.whole:
        Flowing()(console, options, panel)
        return
    title = str(panel.title).partition(":")[0]
    names = [entry.names[0] for entry in panel.entries if entry.names]
    first = names[:3]
    if len(names) > 3:
        first.append("...")
    count = f"{len(names)} option{'s' if len(names) > 1 else ''}"
    line = f"{title}: {count} ({', '.join(first)}), with {HELP_ALL}"
    console.print(line, markup=False, highlight=False, soft_wrap=True)
