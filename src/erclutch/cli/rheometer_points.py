"""A rheometer's points are no log: which tables hold them, and the command of `flowcurve` that reads them."""

from __future__ import annotations

import re
import shlex
from typing import TYPE_CHECKING

from erclutch.cli.log_look import LogLook

if TYPE_CHECKING:
    from erclutch.logs import Plan, Table

#: What the user writes in place of a unit that the file does not hold.
UNIT_TO_FILL_IN = "UNIT"
#: The column of words that a question is about.
_PARTING = re.compile(r"column (.+?) parts the rows into \d+")
#: A strain, or the rate of a strain, by its symbol alone.
_GAMMAS = {"gamma", "γ"}


def flow_command(look: LogLook) -> str:
    """The command that reads a rheometer's points, with what their names leave open.

    A gamma is a strain or a rate, a viscosity without a unit may be in Pa s or in mPa s, and a column of words may part
    the points into curves.
    """
    from erclutch.logs.log_file import EACH

    words = ["erclutch", "flowcurve", look.plan.path]
    gammas = [name for name in look.raw.columns if name.lower() in _GAMMAS]
    strain_or_rate = [name for name in gammas if not look.raw.units.get(name)]
    parting: list[str] = []  # columns of words
    if strain_or_rate:
        words += ["--shear-rate", f"{strain_or_rate[0]} [1/s]"]
        parting = list(look.raw.words)[:1]
    else:
        for question in look.plan.questions:
            match = _PARTING.match(question.problem)
            if match:
                parting.append(match.group(1))
        if not parting and is_of_a_rheometer(look.plan):
            parting = [name for name, column in look.raw.words.items() if len(column.words) > 1][:1]
    for name in parting:
        words += ["--sheet", f"{name}={EACH}"]
    if viscosities := viscosities_without_a_unit(look.raw):
        words += ["--stress", *(f"{name} [{UNIT_TO_FILL_IN}]" for name in viscosities)]
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
