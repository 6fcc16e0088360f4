"""``erclutch plugins`` lists what the registry finds, and the package that each plug-in comes from."""

from __future__ import annotations

from json import dumps
from typing import Annotated

from cyclopts import Parameter

from erclutch.cli import terminal

COMMAND = {
    "help": "List laws, readers, stages, targets and rigs, with the packages that bring them.",
    "panel": "About",
    "place": 2,
}


def plugins(*, json: Annotated[bool, Parameter(negative=())] = False) -> None:
    """List commands, laws, readers, stages, targets and rigs: erclutch's own, and those of installed packages.

    Args:
        json: Print as JSON.
    """
    from erclutch import registry
    from erclutch.errors import PluginError

    def state(plugin: registry.Plugin) -> str:
        try:
            plugin.value  # noqa: B018
        except PluginError as error:
            return error.problem
        return "" if plugin not in registry.hidden(plugin.group) else f"not used: {plugin.name} is erclutch's own"

    found = [
        (plugin, "" if plugin.own else state(plugin))
        for group in registry.GROUPS
        for plugin in (*registry.plugins(group), *registry.hidden(group))
    ]
    if json:
        print(dumps([{**plugin.to_dict(), "problem": problem} for plugin, problem in found], indent=1))
        return
    table = terminal.table("Plug-ins", ["group", "name", "package", "problem"], [], left=4)
    for plugin, problem in found:
        table.add_row(plugin.group, plugin.name, plugin.label, problem)
    terminal.tell(table)
