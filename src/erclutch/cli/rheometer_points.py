"""A rheometer's points are no log: which tables hold them, and the command of `flowcurve` that reads them."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from erclutch import registry
from erclutch.cli.log_look import LogLook
from erclutch.errors import ErclutchError

if TYPE_CHECKING:
    from erclutch.logs import Plan, Table

#: How packages say by which options a command of theirs reads points: the plug-in has the name of the command.
GROUP = "erclutch.points"
#: Rows of a table that may be points without a name that says so: a log has more.
_MOST_POINTS = 1000
#: What the user writes in place of a unit that the file does not hold.
UNIT_TO_FILL_IN = "UNIT"
_DECADES = 100.0  # the largest shear rate beside the smallest, at least, where no name says that they are rates
#: A strain, or the rate of a strain, by its symbol alone.
_GAMMAS = {"gamma", "γ"}


def flow_command(look: LogLook) -> str:
    """The command that reads a rheometer's points, with what their names leave open.

    A gamma is a strain or a rate, a viscosity without a unit may be in Pa s or in mPa s, and a column of words may part
    the points into curves. No option reads some of them, such as stresses against their rates: such a table is a log.
    """
    from erclutch.logs.columns.rheometer_names import is_a_logarithm
    from erclutch.logs.log_file import EACH, group_of

    path = look.plan.path
    gammas = [name for name in look.raw.columns if name.lower() in _GAMMAS]
    strain_or_rate = [name for name in gammas if not look.raw.units.get(name)]
    words = [name for name in look.raw.words if name != look.raw.clock_name]
    rate: dict[str, list[str]] = {}
    parting: list[str] = []  # columns of words
    if strain_or_rate:
        rate = {"shear-rate": [f"{strain_or_rate[0]} [1/s]"]}
        parting = words[:1]
    else:
        for question in look.plan.questions:
            if question.signal == "variable":  # which rows of a column are a curve
                _, rows = shlex.split(question.option)
                group = group_of(rows)
                parting += [] if group is None else [group.column]
        if not parting and is_of_a_rheometer(look.plan):
            parting = [name for name in words if len(look.raw.words[name].words) > 1][:1]
    sheets = {"sheet": [f"{name}={EACH}" for name in parting]} if parting else {}
    tried = tried_flow_command(path, {**rate, **sheets}) or tried_flow_command(path, rate)
    if tried:
        return tried
    as_a_log = look.plan.command()
    was_tried = bool(registry.plugins(GROUP))  # by a wing that is there
    # Logarithms are no signals either: `flowcurve` says what is to be written in their place.
    has_logarithms = any(map(is_a_logarithm, look.raw.columns))
    if was_tried and "COLUMN" not in as_a_log and not has_logarithms:
        return as_a_log
    stress: dict[str, list[str]] = {}
    if viscosities := viscosities_without_a_unit(look.raw):
        stress = {"stress": [f"{name} [{UNIT_TO_FILL_IN}]" for name in viscosities]}
    return _command("flowcurve", path, {**rate, **sheets, **stress})


def points_command(look: LogLook, *, is_told: bool) -> str:
    """The command that reads a table as points of a rheometer, which are for laws at one field; "" where it holds none.

    Args:
        look: what was found.
        is_told: whether the user said how the log is read: then it is one, unless something is still asked.
    """
    plan = look.plan
    if is_of_a_rheometer(plan) and (plan.questions or not is_told):
        return flow_command(look)  # the time of points may be no clock, and need be none
    is_unnamed = bool(plan.questions) and plan.command().count("COLUMN") > 1
    if is_unnamed and look.raw.rows <= _MOST_POINTS:
        return tried_flow_command(plan.path, {})
    return ""


def may_be_flow_curves(tables: Iterable[Table]) -> bool:
    """Whether each table holds two columns of which the first goes through decades, as shear rates do."""
    import numpy as np

    pairs = [list(table.columns.values()) for table in tables]
    for columns in pairs:
        known = columns[0][np.isfinite(columns[0])]
        goes_far = known.size > 0 and 0.0 < known.min() < known.max() / _DECADES
        if len(columns) != 2 or not goes_far:
            return False
    return bool(pairs)


def tried_flow_command(path: str, given: Mapping[str, Sequence[str]]) -> str:
    """The command of `flowcurve` that was tried, with all options that it asked for; "" where none reads the file.

    Args:
        path: of the file.
        given: options that are known, each with its words.
    """
    readings, _ = registry.sound(GROUP, Callable)  # pyright: ignore[reportArgumentType]
    for plugin, options_for in readings:
        with suppress(ErclutchError), plugin.working():
            options: dict[str, list[str]] | None = options_for(path, given)
            if options is not None:
                return _command(plugin.name, path, options)
    return ""


def _command(name: str, path: str, options: Mapping[str, Sequence[str]]) -> str:
    words = ["erclutch", name, path]
    for option, texts in options.items():
        words += [f"--{option}", *texts]
    return shlex.join(words)


def viscosities_without_a_unit(table: Table) -> list[str]:
    """The viscosities whose unit only the user knows, where the table holds no stress that is read in their place."""
    from erclutch.logs.columns.rheometer_names import said_by_name
    from erclutch.logs.columns.rheometer_units import said_by_unit, unit_of

    units = {name: unit_of(table, name) for name in table.columns}
    said = {name: said_by_name(name) for name in units}
    if "stress" in (*said.values(), *map(said_by_unit, units.values())):
        return []
    viscosities = [name for name in units if said[name] == "viscosity"]
    return [] if any(units[name] for name in viscosities) else viscosities


def without_their_unit(table: Table) -> str:
    """What is said of viscosities whose unit only the user knows."""
    from erclutch.logs.columns.rheometer_units import without_a_unit

    if named := viscosities_without_a_unit(table):
        return without_a_unit(named)
    return "pairs of columns without a unit: only you know whether the second of each holds stresses or viscosities"


def is_of_a_rheometer(plan: Plan) -> bool:
    """Whether a table holds a shear rate and a shear stress, by names; or without a time, by names or units."""
    from erclutch.logs.columns.rheometer_names import tells_a_flow_curve

    if tells_a_flow_curve(plan.labels):
        return True
    clock = plan.clock
    asks_for_time = any(question.signal == "time" for question in plan.questions)
    if not asks_for_time and (clock is None or clock.kind not in ("points", "counter")):
        return False
    letters = {name.lower() for name in plan.labels}
    if _GAMMAS & letters and {"tau", "τ"} & letters:
        return True
    for signal in ("slip", "effort"):
        choice = plan.signal(signal)
        if choice is None or not (choice.unit in ("1/s", "Pa") or "shear" in choice.column.lower()):
            return False
    return True
