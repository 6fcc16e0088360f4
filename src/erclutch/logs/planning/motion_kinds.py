"""A torque turns and a force goes along a line: a position of the other kind is doubted, and its like is proposed.

Testing machines that pull and twist log both motions; the travel of a pusher stands beside the angle of a brake.
"""

from __future__ import annotations

from dataclasses import replace

from erclutch.errors import shell_word
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.vocabulary import NOT_MEASURED, TOLD, set_of
from erclutch.logs.planning.draft import Draft

_TURNING = set_of(
    "rotation rotary rotational twist angle angular theta phi winkel drehwinkel verdrehung turn turns rotacion giro "
    "angulo rotazione angolo torsion"
)
_ALONG = set_of(
    "displacement stroke travel position extension weg hub linear axial crosshead course deplacement desplazamiento"
)
#: Where a motion along the axis is named so, it is not that of a torque.
_NEVER_TURN = frozenset(("axial", "crosshead", "gap", "height", "lateral", "normal", "vertical"))
#: SI units of an effort and of a motion that make no power: the unit and the words of the motion that would, a place to
#: fill in, and what the effort does.
_OTHERS = {
    ("N*m", "m"): ("rad", _TURNING, "COLUMN [deg]", "a torque turns"),
    ("N", "rad"): ("m", _ALONG, "COLUMN [mm]", "a force goes along a line"),
}


def doubt_a_position_of_another_kind(draft: Draft) -> None:
    """Doubt a guessed position that makes no power with the effort, where another column may or its name says so."""
    position = draft.guessed("position")
    effort = draft.signals.get("effort")
    if position is None or effort is None or "slip" in draft.signals:
        return
    other = _OTHERS.get((effort.si, position.si))
    if other is None:
        return
    unit, words, place, why = other
    likely: list[SeenColumn] = []
    for column in draft.seen.without(draft.taken):
        is_open = column.unit is None and column.spoken.says(words)
        is_measured = not column.spoken.says(TOLD | NOT_MEASURED)
        if (column.fits((unit,)) or is_open) and is_measured and not column.shape.constant:
            likely.append(column)
    doubt = f"in {position.si} beside an effort in {effort.si}, and {why}"
    own = shell_word(draft.table.label(position.column))
    draft.signals["position"] = replace(position, alternatives=())  # of any unit of a motion
    if len(likely) == 1:
        label = shell_word(draft.table.label(likely[0].name))
        draft.doubt(
            "position", f"{doubt}: {likely[0].name} may be it, else --position {own}", label
        )
    elif not _NEVER_TURN.isdisjoint(draft.seen.columns[position.column].spoken.words) or likely:
        draft.doubt(
            "position", f"{doubt}: give that motion, or --position {own}", shell_word(place)
        )
