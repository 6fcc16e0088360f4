"""Commands come from the registry: ours and those of other packages, listed without an import of any."""

from __future__ import annotations

import ast
import re
import textwrap
from dataclasses import dataclass
from typing import Any

from erclutch import registry
from erclutch.errors import printable
from erclutch.registry import Plugin

GROUP = "erclutch.commands"
#: Headings of ``erclutch --help`` in their order. A wing may bring a heading of its own, which then comes after these;
#: another package names a heading in its entry points: ``[project.entry-points."erclutch.commands.more_logs"]``.
PANELS = (
    "The road of a log",
    "More logs",
    "Live",
    "The digital TWIN and the paper",
    "For papers",
    "About",
)
#: Heading of the commands of other packages that name none.
OF_OTHERS = "Of other packages"
_AFTER_OURS = 1000
_LONGEST = 300  # letters of what another package says of itself

#: A command of ours tells its help in a literal, so that ``--help`` imports none of them.
_MARK = re.compile(r"^COMMAND = (\{.*?\})$", re.MULTILINE | re.DOTALL)
_SAYS = ("help", "panel", "place")


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
    from importlib.metadata import metadata

    listed: list[Command] = []
    for plugin in registry.plugins(GROUP):
        if plugin.own:
            mark = _MARK.search(registry.own_text(plugin))
            about: dict[str, Any] = ast.literal_eval(mark.group(1)) if mark else {}
            if any(key not in about for key in _SAYS):
                wanted = "a literal with help, panel and place"
                raise plugin.fault(f"has to say COMMAND = {{...}} in {plugin.source}, {wanted}")
            listed.append(Command(plugin, about["help"], about["panel"], about["place"]))
            continue
        try:
            summary = str(metadata(plugin.package).json.get("summary", ""))
        except Exception:  # the package says nothing of itself that can be read
            summary = ""
        panel = OF_OTHERS
        if plugin.part:  # of the group's name: one of our headings, or a heading of its own
            words = plugin.part.replace("_", " ")
            ours = [panel for panel in PANELS if panel.lower() == words.lower()]
            capital = words[:1].upper() + words[1:]
            panel = ours[0] if ours else capital
        in_a_line = textwrap.shorten(printable(summary[:_LONGEST]), _LONGEST, placeholder=" ...")
        help_line = f"{in_a_line} ({plugin.label})".strip()
        listed.append(Command(plugin, help_line, panel, _AFTER_OURS))

    def place(command: Command) -> tuple[int, str, int, str]:
        """By heading, and below it by the place that the command asks for."""
        rank = len(PANELS)  # a heading that is not listed comes after those that are
        if command.panel in PANELS:
            rank = PANELS.index(command.panel)
        elif command.panel == OF_OTHERS:
            rank = len(PANELS) + 1
        return rank, command.panel, command.place, command.name

    return sorted(listed, key=place)
