"""Where no effort is logged, the current of the drive that moves the device is proposed for it.

A servo tells no torque but a current, which is its torque by a constant. The numbers tell such a current: it takes both
signs and follows the motion. The user is asked, for a coil may be driven so too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.two_courses import follows
from erclutch.logs.columns.vocabulary import CURRENTS, NOT_MEASURED, TOLD
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.missing_columns import ELECTRICAL, missing

#: Names of a current; a single letter may be an index.
_WORDS = frozenset(word for word in CURRENTS if len(word) > 1) - {"id", "idc"}
_ACROSS = frozenset({"q", "iq"})
_MOVES = 0.1  # share of what the liveliest joint moves by


def offer_the_current_of_a_drive(draft: Draft) -> None:
    """Ask whether the current of the drive stands for the effort that no column holds; no field is logged then."""
    if "effort" not in draft.missing or draft.questions["effort"].option:
        return
    field = draft.signals.get("field")
    is_guessed = draft.guessed("field") is not None
    taken = {*draft.taken} - {field.column if field is not None and is_guessed else ""}
    currents: list[SeenColumn] = []  # by their names, and measured
    for column in draft.seen.without(taken):
        words = {*column.spoken.stem_words}
        is_measured = words.isdisjoint(TOLD | NOT_MEASURED) and "field" not in column.spoken.turned
        # A controller puts out u; with a unit it may be a voltage.
        is_control = column.spoken.plain == "u" and not column.unit
        is_called_so = bool(words & _WORDS) or any(word.endswith("strom") for word in words)
        if is_measured and (is_control or is_called_so) and column.fits(("A",)) is not False:
            currents.append(column)
    pair = _of_one_joint(draft, currents)
    if pair is None:
        return
    motion, current = pair

    if "slip" in draft.questions and motion.spoken.plain not in ELECTRICAL:
        draft.questions["slip"] = replace(
            draft.questions["slip"], option=f"--slip {_label(draft, motion)}"
        )
    if is_guessed and field is not None and field.column in {each.name for each in currents}:
        draft.take_back("field")
        field = None
    if field is None:
        taken |= {each.name for each in currents}
        draft.ask("field", missing(draft.seen, "field", taken), option="--field none")

    option = f"--effort {_label(draft, current)}"
    if current.written_unit:
        option += f" --scale {shell_word('effort=NUMBER N*m/A')}"
    what = "output of a controller" if current.spoken.plain == "u" else "current of a drive"
    question = draft.questions["effort"]
    problem = f"{question.short}; column {current.name} goes with {motion.name}, as the {what} does"
    remedy = f"If the drive moves the device, its torque is this current times a constant: {option} --field none"
    draft.questions["effort"] = replace(question, problem=problem, remedy=remedy, option=option)


def _label(draft: Draft, column: SeenColumn) -> str:
    return shell_word(draft.table.label(column.name))


def _of_one_joint(draft: Draft, currents: list[SeenColumn]) -> tuple[SeenColumn, SeenColumn] | None:
    """A motion and the current that goes with it: of several joints those of the first that moves.

    Currents that are numbered like the speeds are of the joints; a single one takes both signs and follows the motion.
    """
    moving = draft.signals.get("slip") or draft.signals.get("position")
    if moving is not None and moving.column:
        motions = [draft.seen.columns[moving.column]]
    elif "slip" in draft.questions:
        names, _ = candidates(draft.seen, "slip", draft.taken)
        motions = [draft.seen.columns[name] for name in names]
        motions = motions or [
            each for each in draft.seen.without(()) if each.spoken.plain in ELECTRICAL
        ]
    else:
        return None
    liveliest = max((motion.moved for motion in motions), default=0.0)
    motion = next((each for each in motions if each.moved >= _MOVES * liveliest), None)
    if motion is None or motion.values.size < 2:  # one row has no rate
        return None
    of_joint = [each for each in currents if _number(each) == _number(motion)]
    across = [each for each in of_joint if each.spoken.says(_ACROSS)]
    of_joint = across or of_joint  # of the two currents of a drive that which makes its torque
    if len(of_joint) != 1:
        return None
    current = of_joint[0]
    joints = {_number(each) for each in motions}
    if len(joints) > 1 and joints.issubset(_number(each) for each in currents):
        return motion, current
    position = draft.signals.get("position")
    is_position = position is not None and position.column == motion.name
    speed = np.gradient(motion.values) if is_position else motion.values
    turns = takes_both_signs(current.values)
    return (motion, current) if turns and follows(current.values, speed) else None


def _number(column: SeenColumn) -> str:
    """The number at the end of a name, which tells a joint; "" for none."""
    stem = column.spoken.plain_stem
    return stem[len(stem.rstrip("0123456789")) :]
