"""Names that may stand over other columns are asked about: a header may have more names than the rows have cells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.logs.planning.draft import Draft

_WHY = "whose name may be that of another column"
_UNITS_OF_TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}


def doubt_what_unsure_names_say(draft: Draft) -> None:
    """Doubt each guess, and the clock, where the names of the columns may be those of others.

    Who gives a column by its name says that the name is right.
    """
    if not draft.table.unsure_names:
        return
    for signal, chosen in [*draft.signals.items()]:
        if draft.guessed(signal) is not None and chosen.column:
            doubt = f"{chosen.doubt}; and it is one {_WHY}" if chosen.doubt else _WHY
            draft.doubt(signal, doubt, chosen.answer)
    clock = draft.clock
    is_guessed = clock is not None and clock.reason.startswith("guessed")
    if clock is None or not is_guessed or clock.kind != "column" or clock.doubt:
        return
    by_size = {
        unit: size for unit, size in _UNITS_OF_TIME.items() if np.isclose(size, clock.factor)
    }
    likely = clock.unit or next(iter(by_size), "s")
    doubt = f"time is column {clock.column} in {likely}, {_WHY}"
    draft.clock = replace(clock, doubt=doubt, likely=likely)
