"""Commands come from the registry: ours and those of other packages, listed without an import of any."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass

from erclutch import registry
from erclutch.registry import Plugin

GROUP = "erclutch.commands"
#: Headings of ``erclutch --help`` in their order; a wing may bring a heading of its own, which then comes after these.
PANELS = (
    "The road of a log",
    "More logs",
    "Live",
    "The digital TWIN and the paper",
    "For papers",
    "About",
)
#: Heading of the commands that other packages bring.
OF_OTHERS = "Of other packages"

#: A command of ours tells its help in a literal, so that ``--help`` imports none of them.
_MARK = re.compile(r"^COMMAND = (\{.*?^\})", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Command:
    """A command as ``erclutch --help`` shows it.

    Attributes:
        plugin: its value is the function that runs.
        help: one sentence.
        panel: the heading that it stands under.
        place: its place there.
    """

    plugin: Plugin
    help: str
    panel: str
    place: int

    @property
    def name(self) -> str:
        """What a user types after ``erclutch``."""
        return self.plugin.name


def commands() -> list[Command]:
    """All commands, by heading and place."""
    listed = [_own(plugin) if plugin.own else _foreign(plugin) for plugin in registry.plugins(GROUP)]
    return sorted(listed, key=lambda command: (_rank(command.panel), command.panel, command.place, command.name))


def _own(plugin: Plugin) -> Command:
    marked = _MARK.search(registry.own_text(plugin))
    assert marked is not None, f"COMMAND of {plugin.source} is no literal that spans lines"
    told = ast.literal_eval(marked.group(1))
    return Command(plugin, told["help"], told["panel"], told["place"])


def _foreign(plugin: Plugin) -> Command:
    from importlib.metadata import PackageNotFoundError, metadata

    try:
        summary = metadata(plugin.package)["Summary"] or ""
    except PackageNotFoundError:
        summary = ""
    return Command(plugin, f"{summary} ({plugin.label})".strip(), OF_OTHERS, 0)


def _rank(panel: str) -> int:
    """A heading that is not listed comes after those that are, and the one of other packages last."""
    if panel == OF_OTHERS:
        return len(PANELS) + 1
    return PANELS.index(panel) if panel in PANELS else len(PANELS)
