"""Of several columns that may be the effort one is chosen: the motion tells a torque from a force.

A gear has an effort on one side, and a coefficient of friction says which force rubs.
"""

from __future__ import annotations

from erclutch.logs.columns.quotients import rubbing_force
from erclutch.logs.columns.seen_columns import KINDS, SeenColumns
from erclutch.logs.columns.two_courses import goes_along, is_multiple_of, is_sum_of
from erclutch.logs.columns.vocabulary import CURRENTS, DRIVES

#: Words for a sensor of a torque or a force.
_CELLS = frozenset(
    {"sensor", "adc", "transducer", "cell", "loadcell", "futek", "flange", "messwelle", "daq"}
)
_LAST_DIGITS = 1e-5  # of the largest number
_SUMS = frozenset({"sum", "summe", "total", "gesamt", "somme", "suma", "somma", "tot"})


def one_effort(seen: SeenColumns, efforts: list[str], motion: str) -> tuple[list[str], str]:
    """The effort of the motion's kind, or that on its side of a gear; or the friction by its coefficient; else all.

    What a model says of the effort is none of them.
    """
    efforts = [name for name in efforts if not seen.columns[name].spoken.is_of_a_model] or efforts
    if motion:
        kind = seen.columns[motion].kind
        kinds = {name: seen.columns[name].kind for name in efforts}
        of_that_kind = [name for name in efforts if kind and kinds[name] == kind]
        # Each of the others must be known to be of another kind.
        if len(of_that_kind) == 1 and all(kinds.values()):
            return of_that_kind, f", and it is that of a {KINDS[kind]}"
    # An effort that is called like a drive's may be one of the currents times a number, in each row.
    currents = [column for column in seen.columns.values() if column.spoken.says(CURRENTS)]
    computed: list[str] = []
    for name in efforts:
        effort = seen.columns[name]
        beside = currents if effort.spoken.says(DRIVES) else []
        if any(is_multiple_of(effort.values, each.values, _LAST_DIGITS) for each in beside):
            computed.append(name)
    sensed = [name for name in efforts if seen.columns[name].spoken.says(_CELLS)]
    if len(efforts) == 2 and len(computed) == len(sensed) == 1 and computed != sensed:
        return sensed, f", and {computed[0]} is a current of its drive times a number"
    on_its_side = seen.of_one_side(efforts, [motion])
    if len(on_its_side) == 1:
        # A torque sensor at the end of a joint's shaft is of no side by its name, and goes along with the joint's own.
        own = seen.columns[on_its_side[0]]
        of_no_side = [seen.columns[name] for name in efforts if not seen.columns[name].side]
        for other in of_no_side:
            if other.name != own.name and goes_along(other.values, own.values):
                on_its_side.append(other.name)
    efforts = on_its_side
    # Two cells that bear one arm are logged beside their sum.
    columns = [seen.columns[name] for name in efforts]
    sums: list[str] = []
    for total in columns:
        parts = [each.values for each in columns if each.name != total.name]
        if len(parts) == 2 and is_sum_of(total.values, *parts):
            sums.append(total.name)
    if len(sums) == 1 and seen.columns[sums[0]].spoken.says(_SUMS):
        return sums, ", and the others add up to it"
    # A coefficient of friction says by its numbers which force is the friction and which presses.
    rubbing = rubbing_force(seen) if len(efforts) > 1 else ""
    if rubbing in efforts:
        return [rubbing], ", and a coefficient of friction is made of it"
    return efforts, ""
