"""Where neither a speed nor an effort is logged, a flow rate and a pressure drop are proposed: those of a valve.

In flow mode the fluid is pressed through a gap, so its flow rate is the slip and the pressure that it loses the effort:
both make a power, and the laws are the same. The user is asked, for a pump has a flow rate and a pressure too.
"""

from __future__ import annotations

from erclutch.errors import MissingColumnError, shell_word
from erclutch.logs.columns.vocabulary import NOT_MEASURED, TOLD, set_of
from erclutch.logs.planning.draft import Draft
from erclutch.logs.table import MINUS

_DROP = set_of(
    "drop difference differential delta diff loss dp deltap δp differenzdruck druckdifferenz druckabfall druckverlust "
    "différentielle perte caída diferencial 压差 压降 差圧 圧力損失 "
)
_BEFORE = set_of(
    "in inlet upstream before supply entry ein eingang vor zulauf entrée amont entrada 入口 上流 1 p1 a pa"
)
_BEHIND = set_of(
    "out outlet downstream after return exit aus ausgang nach ablauf sortie aval salida 出口 下流 2 p2 b pb"
)


def propose_flow_and_pressure(draft: Draft) -> None:
    """Ask whether the one flow rate is the slip, and the one pressure drop the effort, where no column is a speed."""
    effort = draft.guessed("effort")
    is_open = "effort" in draft.questions or (effort is not None and effort.si == "Pa")
    if "slip" not in draft.missing or not is_open:
        return
    taken = {*draft.taken} - {effort.column if effort is not None else ""}
    measured = [
        column
        for column in draft.seen.without(taken)
        if not column.spoken.says(TOLD | NOT_MEASURED)
    ]
    flow_rates = [column for column in measured if column.fits(("m^3/s",))]
    pressures = [column for column in measured if column.fits(("Pa",))]
    drops = [column for column in pressures if column.spoken.says(_DROP)]
    before = [column for column in pressures if column.spoken.says(_BEFORE)]
    behind = [column for column in pressures if column.spoken.says(_BEHIND)]
    drop = ""
    if len(drops) == 1:
        drop = draft.table.label(drops[0].name)
    elif not drops and len(before) == len(behind) == 1 and before[0].unit == behind[0].unit:
        drop = f"{before[0].name}{MINUS}{behind[0].name}"
    if len(flow_rates) != 1 or not drop:
        return

    what = "the flow rate of a valve is its slip, and its pressure drop its effort"
    proposed = {"slip": draft.table.label(flow_rates[0].name)}
    if effort is None:
        proposed["effort"] = drop
    for signal, label in proposed.items():
        option = f"--{signal} {shell_word(label)}"
        problem = f"no column for {signal} by its name; {what}"
        draft.ask(
            signal, MissingColumnError(problem, remedy=f"If this is a valve, {option}"), option
        )
