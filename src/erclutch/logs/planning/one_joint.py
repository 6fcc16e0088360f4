"""Of several joints in one log, each with a motion and an effort of its own, the first that moves is proposed.

Each of them would be read right, and no sentence of the file says which is meant: the user is asked, and the printed
command takes the first. Logs of one robot have the same columns, so all of them propose the same joint, and so does the
next log that a model is scored on. Where the first joint rests, the liveliest is proposed instead.

Two columns of a kind may be the two sides of one device: the words for joints and limbs say that they are not, or the
numbers do, see `erclutch.logs.columns.turn_apart`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from erclutch.errors import SeveralColumnsError
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.joints import joint_in_name
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.turn_apart import are_joined, carry_one_torque, turn_apart, turns_back
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.plan import OF_THE_SAME_JOINT, Joint, of_one_joint
from erclutch.logs.planning.columns_of_joints import OwnWords, why_no_fields
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.guesses import take_guess
from erclutch.logs.planning.one_of_several import Guess

_EASTERN = "\u3040-\u30ff\u3400-\u9fff\uac00-\ud7af"
#: Eastern names have no spaces: each sign is a word, and what two names share falls away.
_TOKEN = re.compile(rf"[{_EASTERN}]|[^\W\d_{_EASTERN}]+|\d+")
_FEWEST = 3  # joints: two may be the two sides of one device
_MOVES = 0.02  # share of what the liveliest joint moves by
#: Words that say that columns are of joints, so that two suffice.
_OF_JOINTS = frozenset(
    (
        "joint joints axis achse gelenk axe eje q dq qd qdot actuator actuators servo servos motor motors 关节 軸 轴"
    ).split()
)
#: Parts of a body, by which joints are called, so that two suffice.
_LIMBS = set_of(
    "hip knee ankle shoulder elbow wrist waist neck torso trunk pelvis arm forearm upperarm leg thigh shank foot toe "
    "hand finger thumb gripper hufte knie knochel sprunggelenk schulter ellbogen ellenbogen handgelenk finger daumen "
    "hals taille hanche genou cheville epaule coude poignet doigt cadera rodilla tobillo hombro codo muneca dedo "
    "anca ginocchio caviglia spalla gomito polso dito quadril joelho tornozelo ombro cotovelo punho "
    "髋 髖 膝 踝 肩 肘 腕 腰 股 бедро колено голеностоп плечо локоть запястье 고관절 무릎 발목"
)
#: Two sides of a body or a vehicle; the two sides of one device are called so too.
_SIDES = set_of(
    "left right l r lh rh links rechts li re gauche droite g d izquierda derecha izquierdo derecho izq der "
    "sinistra destra sinistro destro sx dx esquerda direita esq dir 左 右 левый правый левая правая front rear"
)
_FORCES = ("f", "force", "kraft", "fuerza", "forza", "forca")
_PLACE = re.compile(r".*\[\d+\]")  # velocity[0], in a message of joints
#: Speeds along a line: v1 and v2 are of two floors or two ends, and a damper between them moves by their difference.
_ALONG_A_LINE = re.compile(r"d?[xyzv](?:dot|d|p|t)?")
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
_Joints = dict[OwnWords, str]


def propose_one_joint(draft: Draft) -> None:
    """Doubt slip and effort of the first joint that moves, where both were asked about and are of the same joints."""
    asked = [draft.questions.get(signal) for signal in ("slip", "effort")]
    if any(question is None or question.kind is not SeveralColumnsError for question in asked):
        return
    efforts = _joints(draft, "effort")
    slips = _joints(draft, "slip", beside=[*efforts.values()])
    joints = [joint for joint in slips if joint in efforts]
    if len(joints) < 2 or len(joints) < 0.7 * max(len(slips), len(efforts)):
        return
    if not _are_devices(draft, joints, slips, efforts):
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

    words = {name: _words(name) for name in draft.seen.columns}
    whys = why_no_fields(draft.seen, words, joints)
    draft.no_fields |= whys
    if "field" in draft.questions and "field" not in draft.missing:
        may_be, _ = candidates(draft.seen, "field", draft.taken)
        if whys.keys() >= {*may_be}:
            del draft.questions["field"]
            draft.take_no_field([f"{name} {whys[name]}" for name in may_be])

    proposed_first = [first, *(joint for joint in joints if joint != first)]
    draft.joints = [Joint(_called(joint), slips[joint], efforts[joint]) for joint in proposed_first]
    draft.doubt("slip", of_one_joint(draft.joints, draft.labels))
    draft.doubt("effort", OF_THE_SAME_JOINT)


def _called(joint: tuple[str, ...]) -> str:
    """The joint by what its columns have of their own: a number alone is that of a joint."""
    own = " ".join(joint)
    return f"joint {own}" if own.isdecimal() else own


def _are_devices(
    draft: Draft, joints: Sequence[OwnWords], slips: _Joints, efforts: _Joints
) -> bool:
    """Whether what each joint has is that of a device of its own, by the names; of two of a kind by the numbers.

    Args:
        draft: of the log.
        joints: that have both.
        slips: by the joint.
        efforts: by the joint.
    """
    every = (*slips, *efforts)
    if any(not _NO_JOINTS.isdisjoint(joint) for joint in every) or any(
        _DIRECTIONS.issuperset(joint) for joint in every
    ):
        return False
    names = [*slips.values()]
    speeds = [draft.seen.columns[slips[joint]] for joint in joints]
    torques = [draft.seen.columns[efforts[joint]] for joint in joints]
    if len(joints) == 2 and are_joined(speeds, torques):
        return False
    said = {word for name in names for word in _words(name)}
    are_places = all(_PLACE.fullmatch(name) for name in names)
    are_limbs = all(not _LIMBS.isdisjoint(joint) for joint in joints)
    if are_places or are_limbs or not said.isdisjoint(_OF_JOINTS) or _says_eastern(names):
        return True

    shared = [word for word in _words(names[0]) if all(word in _words(name) for name in names)]
    are_numbered = all(word.isdecimal() for joint in joints for word in joint)
    if are_numbered and _ALONG_A_LINE.fullmatch("".join(shared)):
        return False
    if len(joints) >= _FEWEST:
        return not carry_one_torque(torques)
    if len(every) > 4 or not turn_apart(speeds, torques):
        return False
    if all(_SIDES.issuperset(joint) for joint in joints):
        return True
    # Numbers and letters are those of two ends as well: a joint turns, and turns back.
    are_short = all(len(word) == 1 for joint in joints for word in joint)
    are_forces = any(each.kind == "N" or each.spoken.bare_stem in _FORCES for each in torques)
    return are_short and not are_forces and all(map(turns_back, speeds))


def _says_eastern(names: Collection[str]) -> bool:
    """Whether each name holds an Eastern word for a joint, whose signs are words of their own."""
    words = [word for word in _OF_JOINTS if not word.isascii()]
    return all(any(word in name for word in words) for name in names)


def _joints(draft: Draft, signal: str, beside: Sequence[str] = ()) -> _Joints:
    """Columns of a signal by what tells them apart, in the order of the file; none where two are told by the same.

    Args:
        draft: of the log.
        signal: its name.
        beside: columns of another signal; where all are of one side of a gear, those of the same side are meant.
    """
    speaking, _ = candidates(draft.seen, signal, draft.taken)
    names = [name for name in draft.table.columns if name in speaking]
    columns = draft.seen.columns
    sides = {columns[name].side for name in beside}
    if len(sides) == 1 and "" not in sides:
        names = [name for name in names if columns[name].side in sides] or names
    words = {name: _words(name) for name in names}
    shared = set[str].intersection(*map(set, words.values())) if words else set[str]()
    joints: _Joints = {}
    for name in names:
        own = tuple(word for word in words[name] if word not in shared)
        if own in joints or not own:
            return {}
        joints[own] = name
    return joints


def _words(name: str) -> OwnWords:
    """The words and the numbers of a name, without zeros in front of a number."""
    tokens = [token for word in words_of(name) for token in _TOKEN.findall(word)]
    return tuple(token.lstrip("0") or "0" for token in tokens)
