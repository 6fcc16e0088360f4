"""Some voltages of a bench are no field: of a channel that nothing is plugged into, of a sensor, of a controller.

They are known by what stands beside them or by numbers that no supply has; what is called like a field is left alone.
"""

from __future__ import annotations

import numpy as np

from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.vocabulary import TOLD
from erclutch.logs.planning.draft import Draft

_SUPPLIED = ("V", "A")
_BEYOND_SUPPLIES = 1e5  # V or A: what an amplifier shows for an open input is larger
_STRAIN_GAUGES = frozenset({"dms", "straingauge", "straingage", "dehnungsmessstreifen", "jauge"})
_OUTPUTS = frozenset({"output", "ausgang", "sortie", "salida", "uscita", "drive", "drv"})


def pass_over_idle_and_raw_channels(draft: Draft) -> None:
    """Take volts and amperes for no signal that nothing feeds, or that a sensor or a controller gives."""
    named = {*draft.taken}
    terms = [draft.seen.columns.get(letter) for letter in "PID"]
    of_a_controller = all(term is not None and not term.written_unit for term in terms)
    for column in draft.seen.columns.values():
        if column.name in named:
            continue
        # Some word of the name may mean the field.
        spoken = column.spoken
        speaks = spoken.forms["field"] or spoken.heads.get("field")
        is_called_a_field = bool(speaks) or "field" in spoken.may_be | spoken.within
        why = ""
        if column.name == "I" and of_a_controller:
            why = "stands beside P and D: taken for a term of a controller"
        elif column.fits(_SUPPLIED) and not is_called_a_field:
            why = _why_no_supply(draft, column)
        if why:
            draft.no_signals.append(column.name)
            draft.notes.append(f"column {column.name} {why}, left out")


def _why_no_supply(draft: Draft, column: SeenColumn) -> str:
    """What else a voltage or a current is; "" where it may be that of a supply."""
    level = _level(column)
    if level is not None:
        # Alone, a channel at 0 may be the field of a log beside others with a field.
        others = draft.seen.without([column.name])
        is_one_of_several = any(_level(other) == level for other in others)
        if abs(level) >= _BEYOND_SUPPLIES or (level == 0.0 and is_one_of_several):
            return (
                f"stays at {level:g} all through: taken for a channel that nothing is plugged into"
            )

    own = _without_unit(column)
    for other in draft.seen.without([column.name]):
        if other.written_unit and not other.fits(_SUPPLIED) and _without_unit(other) == own:
            return f"is called like {other.name}: taken for the output of its sensor"

    words = column.spoken.stem_words
    letters = [word.rstrip("0123456789") for word in words]
    if not _STRAIN_GAUGES.isdisjoint([*letters, "".join(letters)]):
        return "is called like a strain gauge: taken for its output"

    # Of "Ch 1 Force", "Ch 1 Force setpoint" and "Ch 1 output" the last one moves the machine that holds the set point.
    if words and words[-1] in _OUTPUTS:
        channel = words[:-1]
        for other in draft.seen.without([column.name]):
            is_of_it = bool(channel) and other.spoken.stem_words[: len(channel)] == channel
            if is_of_it and other.spoken.says(TOLD):
                return f"stands beside {other.name}: taken for the output of a controller"
    return ""


def _level(column: SeenColumn) -> float | None:
    """The number that a column keeps; None where it has others."""
    known = column.values[np.isfinite(column.values)]
    return float(known[0]) if known.size and column.shape.constant else None


def _without_unit(column: SeenColumn) -> str:
    """A name without a unit in brackets, which tells columns of one name apart."""
    front, unit = split_label(column.name)
    return front if unit else column.name
