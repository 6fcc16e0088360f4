"""All that the registry finds is listed, with the package that each plug-in comes from."""

from __future__ import annotations

from erclutch.cli import terminal


def list_plugins(*, json: bool) -> None:
    """Print commands, laws, readers, stages, targets and rigs: erclutch's own, and those of installed packages."""
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
        terminal.say_json([{**plugin.to_dict(), "problem": problem} for plugin, problem in found])
        return
    table = terminal.table("Plug-ins", ["group", "name", "package", "problem"], [], left=4)
    for plugin, problem in found:
        table.add_row(plugin.group, plugin.name, plugin.label, problem)
    terminal.tell(table)
