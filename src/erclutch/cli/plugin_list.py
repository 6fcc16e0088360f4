"""All that the registry finds is listed, with the package that each plug-in comes from."""

from __future__ import annotations

from erclutch.cli import terminal


def list_plugins(*, json: bool, check: bool = False) -> bool:
    """Print commands, laws, readers, stages, targets and rigs: erclutch's own, and those of installed packages.

    Args:
        json: as JSON.
        check: each of another package is loaded in a process of its own, and laws and stages are recorded there.

    Returns:
        Whether nothing is wrong with any.
    """
    from erclutch import registry
    from erclutch.cli.plugin_check import fault_of
    from erclutch.errors import PluginError

    def problem_of(plugin: registry.Plugin) -> str:
        if plugin.why_unused:
            return plugin.why_unused
        if check:
            return fault_of(plugin)
        try:
            plugin.value  # noqa: B018
        except PluginError as error:
            return error.problem
        return ""

    problems: list[tuple[registry.Plugin, str]] = []
    for group in registry.GROUPS:
        for plugin in (*registry.plugins(group), *registry.hidden(group)):
            problems.append((plugin, "" if plugin.own else problem_of(plugin)))
    if json:
        terminal.say_json(
            [{**plugin.to_dict(), "problem": problem} for plugin, problem in problems]
        )
    else:
        table = terminal.table("Plug-ins", ["group", "name", "package", "problem"], [], left=4)
        for plugin, problem in problems:
            table.add_row(plugin.group, plugin.name, plugin.label, problem)
        terminal.tell(table)
    return not any(problem for _, problem in problems)
