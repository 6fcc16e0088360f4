"""Some names are understood beside the others of their table only: what all begin or end with says nothing."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from erclutch.logs.columns.names import SpokenName, spoken_name
from erclutch.logs.columns.vocabulary import DRIVES, MODELS, NOT_MEASURED, OTHER, TOLD, set_of

#: The place in front of a name: a device, a program and a block on a bus, a struct.
_PLACE = re.compile(r".{2,}[./:\\|]|[^\W_]{2,}_")
_ENDS_OF_PLACES = "./:\\|_"
#: Words that say of what a signal is, so that a place of such a word is no mere place.
_HAVE_A_MEANING = TOLD | OTHER | NOT_MEASURED | MODELS | DRIVES | set_of("mot pump pumpe esc")
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
    stems |= _without_the_place_of_all(stems)
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


def _without_the_place_of_all(stems: Mapping[str, str]) -> dict[str, str]:
    """Names without the place in front of all but the time: ``I_ist`` for ``BRK.I_ist`` beside ``BRK.M_ist``.

    The place stays where it has a meaning, as that of a motor has; where a name is understood with it; and where no
    effort and motion are understood without it.
    """
    of_place = {
        name: (place[0], stem[place.end() :])
        for name, stem in stems.items()
        if (place := _PLACE.match(stem)) and place.end() < len(stem)
    }
    places = {place for place, _ in of_place.values()}
    others = [spoken_name(stem) for name, stem in stems.items() if name not in of_place]
    if len(of_place) < _FEWEST or len(places) != 1 or not all(said.is_time for said in others):
        return {}
    words = spoken_name(places.pop().rstrip(_ENDS_OF_PLACES)).words
    if not _HAVE_A_MEANING.isdisjoint(words) or any(spoken_name(word).may_be for word in words):
        return {}
    if any(spoken_name(stems[name]).may_be for name in of_place):
        return {}
    said = [spoken_name(rest) for _, rest in of_place.values()]
    efforts = sum("effort" in each.may_be for each in said)
    motions = sum(not _MOTIONS.isdisjoint(each.may_be) for each in said)
    return {name: rest for name, (_, rest) in of_place.items()} if efforts and motions else {}


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
