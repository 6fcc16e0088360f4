"""``erclutch laws`` prints the tables of laws and of stages."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from erclutch.cli import terminal

COMMAND = {
    "help": "List the laws and stages; with --plugins readers, targets and rigs too, and who brings them.",
    "panel": "About",
    "place": 1,
}


def laws(
    *,
    plugins: Annotated[bool, Parameter(negative=())] = False,
    check: Annotated[bool, Parameter(negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> None:
    """List the laws: name, equation (made from the code that is fitted, for w > 0), parameters, source; and the stages.

    E is the field divided by the largest field of the training data, w the slip divided by its root mean square.

    Args:
        plugins: List in place of equations all that the registry finds: commands, laws, readers, stages, targets and
            rigs, with the packages that bring them and what is wrong with any.
        check: List the same, and record each law and stage of another package as an export would, in a process of its
            own: what cannot be exported is said now and not after a fit. The exit code is 1 if anything is wrong.
        json: Print as JSON.
    """
    if plugins or check:
        from erclutch.cli.plugin_list import list_plugins

        if not list_plugins(json=json, check=check) and check:
            raise SystemExit(1)
        return
    from erclutch.errors import PluginError
    from erclutch.models.laws import Law, law_from_name, shown_laws
    from erclutch.models.laws.symbolic import equation_text
    from erclutch.models.stages import shown_stages

    # A law or stage of another package that fails is named, and all others are listed.
    failed: list[PluginError] = []
    all_laws: list[tuple[str, Law, str]] = []  # name, law, equation
    for name in shown_laws(failed):
        law = law_from_name(name)
        try:
            all_laws.append((name, law, equation_text(law)))
        except PluginError as error:
            failed.append(error)
    all_stages = shown_stages(failed)
    for error in failed:
        terminal.console(stderr=True).print(f"left out: {error}", soft_wrap=True)
    if json:
        rows = [
            {
                "name": name,
                "equation": equation,
                "source": law.source,
                **({"plugin": law.plugin.to_dict()} if law.plugin else {}),
                "parameters": [
                    {"name": s.name, "meaning": s.meaning, "lower": s.lower, "upper": s.upper}
                    for s in (*law.stimulus_shape, *law.shape)
                ]
                + [
                    {"name": g.name, "meaning": g.meaning, "lower": 0.0 if g.nonnegative else None}
                    for g in law.gains
                ],
            }
            for name, law, equation in all_laws
        ]
        terminal.say_json(rows)
        return
    table = terminal.table(
        "Laws of one element (effort for w > 0)", ["model", "effort", "source"], [], left=3
    )
    table.columns[1].overflow = "fold"
    for name, law, equation in all_laws:
        label = (
            name if not name.endswith("-2") else f"{name.removesuffix('2')}N (N = 2 kernels shown)"
        )
        by_plugin = f" ({law.plugin.label})" if law.plugin else ""
        table.add_row(label, equation, law.source + by_plugin)
    terminal.tell(table)
    terminal.tell(
        "NAME/square, /power, /critical, /saturating, /tanh or /constant: how the yield effort grows with the field."
    )
    stages = terminal.table(
        "Stages of --lag, joined by + (w over its root mean square)",
        ["stage", "on", "equation"],
        [],
        left=3,
    )
    stages.columns[2].overflow = "fold"
    for stage in all_stages:
        stages.add_row(stage.name, stage.place, stage.equation)
    terminal.tell(stages)
    terminal.tell(
        "u: command, E: field behind the stage, y(E): strength of the field, T: effort, ': derivative in time, "
        "t: temperature over its reference."
    )
    terminal.tell("dahl-N, stops-N: N states. bouc-wen-N: exponent N.")
