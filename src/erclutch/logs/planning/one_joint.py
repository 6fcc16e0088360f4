"""Of several joints in one log, each with a motion and an effort of its own, the first that moves is proposed.

Each of them would be read right, and no sentence of the file says which is meant: the user is asked, and the printed
command takes the first. Logs of one robot have the same columns, so all of them propose the same joint, and so does the
next log that a model is scored on. Where the first joint rests, the liveliest is proposed instead.
"""

from __future__ import annotations

import re

from erclutch.errors import SeveralColumnsError
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.joints import joint_in_name
from erclutch.logs.plan import OF_THE_SAME_JOINT, Joint, of_one_joint
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.guesses import take_guess
from erclutch.logs.planning.one_of_several import Guess

_TOKEN = re.compile(r"[^\W\d_]+|\d+")
_FEWEST = 3  # joints: two may be the two sides of one device
_MOVES = 0.1  # share of what the liveliest joint moves by
#: Words that say that columns are of joints, so that two suffice.
_OF_JOINTS = frozenset(
    (
        "joint joints axis achse gelenk axe eje q dq qd qdot actuator actuators servo servos motor motors 关节 軸 轴"
    ).split()
)
_PLACE = re.compile(r".*\[\d+\]")  # velocity[0], in a message of joints
#: Sides of one device and ways to log a signal, and directions in space: none of them is a joint.
_NO_JOINTS = frozenset(
    (
        "motor rotor link load output input spring drive driven driver engine brake clutch test "
        "dut shaft upper lower top bottom inner outer primary secondary in out side meas "
        "measured est filt filtered raw ref cmd des set min max mean std"
    ).split()
)
_DIRECTIONS = frozenset({"x", "y", "z", "d", "q", "alpha", "beta", "roll", "pitch", "yaw"})

#: What tells a column from those beside it: the number or the word of its joint -> the column's name.
_Joints = dict[tuple[str, ...], str]


def propose_one_joint(draft: Draft) -> None:
    """Doubt slip and effort of the first joint that moves, where both were asked about and are of the same joints."""
    asked = [draft.questions.get(signal) for signal in ("slip", "effort")]
    if any(question is None or question.kind is not SeveralColumnsError for question in asked):
        return
    slips = _joints(draft, "slip")
    efforts = _joints(draft, "effort")
    joints = [joint for joint in slips if joint in efforts]
    said = {token for name in slips.values() for token in _tokens(name)}
    are_places = all(_PLACE.fullmatch(name) for name in slips.values())
    fewest = 2 if are_places or not said.isdisjoint(_OF_JOINTS) else _FEWEST
    if len(joints) < fewest or len(joints) < 0.7 * max(len(slips), len(efforts)):
        return
    every = (*slips, *efforts)
    if any(not _NO_JOINTS.isdisjoint(joint) for joint in every) or any(
        _DIRECTIONS.issuperset(joint) for joint in every
    ):
        return

    in_name = joint_in_name(draft.table.name)
    named = [joint for joint in joints if joint == (in_name,)]
    first = (named or joints)[0]
    columns = draft.seen.columns
    moved = {joint: columns[slips[joint]].moved for joint in joints}
    if moved[first] < _MOVES * max(moved.values()) or columns[efforts[first]].shape.constant:
        return

    why = "its file is called after it" if named else "the first of them"
    reason = f"name, of {len(joints)} joints {why}"
    del draft.questions["slip"], draft.questions["effort"]
    take_guess(draft, "slip", Guess(slips[first], reason), "")
    take_guess(draft, "effort", Guess(efforts[first], reason), slips[first])

    # A current that each joint has is that of its drive.
    fields = _joints(draft, "field") if "field" in draft.questions else {}
    if fields and fields.keys() >= {*joints}:
        del draft.questions["field"]
        draft.take_no_field([f"{name} is the current of a joint" for name in fields.values()])

    proposed_first = [first, *(joint for joint in joints if joint != first)]
    draft.joints = [Joint(_called(joint), slips[joint], efforts[joint]) for joint in proposed_first]
    draft.doubt("slip", of_one_joint(draft.joints, draft.labels))
    draft.doubt("effort", OF_THE_SAME_JOINT)


def _called(joint: tuple[str, ...]) -> str:
    """The joint by what its columns have of their own: a number alone is that of a joint."""
    own = " ".join(joint)
    return f"joint {own}" if own.isdecimal() else own


def _joints(draft: Draft, signal: str) -> _Joints:
    """Columns of a signal by what tells them apart, in the order of the file; none where two are told by the same."""
    speaking, _ = candidates(draft.seen, signal, draft.taken)
    names = [name for name in draft.table.columns if name in speaking]
    tokens = {name: _tokens(name) for name in names}
    shared = set[str].intersection(*map(set, tokens.values())) if tokens else set[str]()
    joints: _Joints = {}
    for name in names:
        own = tuple(token for token in tokens[name] if token not in shared)
        if own in joints or not own:
            return {}
        joints[own] = name
    return joints


def _tokens(name: str) -> list[str]:
    return [token.lower().lstrip("0") or "0" for token in _TOKEN.findall(name)]
