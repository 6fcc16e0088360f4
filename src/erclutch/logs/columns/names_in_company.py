"""Some names are understood beside the others of their table only: what all begin or end with says nothing."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from erclutch.logs.columns.names import SpokenName, spoken_name
from erclutch.logs.columns.vocabulary import TOLD

_FEWEST = 3  # columns, from which on what all names share says nothing
#: A letter in front of all names: measured, filtered.
_IN_FRONT = ("m", "f")
#: Where a program calls a column after the file that it is of.
_FILE = re.compile(r"\.(?:txt|csv|dat|log|mat)$", re.IGNORECASE)
#: posa1 beside posd1: what a joint did, and what it was told.
_DID_OR_TOLD = re.compile(r"(pos|vel|acc|tor|trq|torque|force|cur)_?([ad])_?(\d*)", re.IGNORECASE)
_WORDS = {"a": "actual", "d": "desired"}
#: Words for what is now: current_y beside target_y. Alone, the first three are amperes.
_NOW = frozenset({"current", "curr", "cur", "present"})
_AXES = frozenset({"x", "y", "z"})
_MOTIONS = frozenset({"position", "slip"})
_SHORT = 2  # letters, up to which a name means several things


def told_by_company(said: Mapping[str, SpokenName]) -> dict[str, str]:
    """Stems that say more than the names of some columns, by these names.

    Args:
        said: what each column of a table says alone, by its name.
    """
    stems: dict[str, str] = {name: spoken.stem for name, spoken in said.items()}
    if len(stems) >= _FEWEST and all(map(_FILE.search, stems.values())):
        stems = {name: _FILE.sub("", stem) for name, stem in stems.items()}
    for letter in _IN_FRONT:
        bare = {name: stem[1:].lstrip("_") for name, stem in stems.items()}
        begin_so = all(stem[:1].lower() == letter and len(stem) > 1 for stem in stems.values())
        if not begin_so:
            continue
        # Without the letter they name an effort, and two or more of speed, position and time.
        kinds: set[str] = set()
        for stem in bare.values():
            spoken = spoken_name(stem)
            kinds |= spoken.may_be
            if spoken.is_time:
                kinds.add("time")
        if "effort" in kinds and len(kinds & {"slip", "position", "time"}) > 1:
            stems = bare

    # Names may end in an a for actual, each beside the same with a d for desired.
    matches = {name: _DID_OR_TOLD.fullmatch(stem) for name, stem in stems.items()}
    letters: dict[tuple[str, str], set[str]] = {}  # of each quantity and joint
    for match in matches.values():
        if match:
            letters.setdefault((match[1].lower(), match[3]), set()).add(match[2].lower())
    are_paired = {"a", "d"} in letters.values()
    for name, match in matches.items():
        # Once a position is told so, the speeds of the same table are.
        if match and are_paired:
            stems[name] = f"{match[1]} {_WORDS[match[2].lower()]} {match[3]}".strip()

    stems |= dict(_as_it_is_now(said))
    return {name: stem for name, stem in stems.items() if stem != said[name].stem}


def _as_it_is_now(said: Mapping[str, SpokenName]) -> Iterator[tuple[str, str]]:
    """Names of what is now, as current_velocity, and what they mean: no amperes.

    A motion needs a whole word behind, since no current is called after a motion; an effort needs such a motion, or
    what is wanted beside it, as a letter does: current_y and target_y. The current behind the name of an effort stays
    a current: that of torque is the one that makes a torque.
    """
    words = {name: spoken.stem_words for name, spoken in said.items() if len(spoken.stem_words) > 1}
    wanted_in_front = {each[1:] for each in words.values() if each[0] in TOLD}
    wanted_behind = {each[:-1] for each in words.values() if each[-1] in TOLD}
    in_front = {name: each[1:] for name, each in words.items() if each[0] in _NOW}
    motions = [name for name, rest in in_front.items() if _is_a_motion(rest, whole=True)]
    for name, rest in in_front.items():
        is_wanted = rest in wanted_in_front
        is_effort = "effort" in spoken_name(" ".join(rest)).may_be
        is_of_letters = is_wanted and (rest[0] in _AXES or _is_a_motion(rest, whole=False))
        if name in motions or is_of_letters or (is_effort and (is_wanted or motions)):
            yield name, f"actual {' '.join(rest)}"
    for name, each in words.items():
        if each[-1] in _NOW and each[:-1] in wanted_behind and _is_a_motion(each[:-1], whole=False):
            yield name, f"actual {' '.join(each[:-1])}"


def _is_a_motion(words: tuple[str, ...], *, whole: bool) -> bool:
    """Whether words name a position or a speed, or a whole word does, which has one meaning."""
    spoken = spoken_name(" ".join(words))
    is_short = len(spoken.plain_stem) <= _SHORT
    return not _MOTIONS.isdisjoint(spoken.may_be) and not (whole and is_short)
