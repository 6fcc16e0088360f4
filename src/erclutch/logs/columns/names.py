"""Names of columns speak for signals, in the languages and the shorthand that people and instruments write.

A name speaks whole (``drehmoment``), without the words beside it (``motor torque, measured``), or by its head: the last
word of an English name, the first of a French or Spanish one, the end of a German or Chinese compound.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from erclutch.logs.columns.arms_in_names import without_arm
from erclutch.logs.columns.labels import EASTERN
from erclutch.logs.columns.name_ends import KEPT_NAMES, split_end
from erclutch.logs.columns.vocabulary import (
    AGAINST,
    BESIDE,
    CURRENTS,
    EASTERN_COMPUTED,
    EASTERN_OTHERS,
    EASTERN_TOLD,
    GERMAN,
    GERMAN_OTHERS,
    LOOPS,
    MODELS,
    NAMES,
    NOT_MEASURED,
    OF_SEVERAL,
    OTHER,
    ROMANCE,
    SHORT_WITH_A_POINT,
    SINGLE,
    TOLD,
    VOLTAGES,
    set_of,
)


def plain(name: str) -> str:
    """A name in small letters, without signs."""
    letters = unicodedata.normalize("NFKD", name)
    return re.sub(r"[\W_]", "", letters).lower()


def without_numbers(text: str) -> str:
    """A text with one sign for each number: names and titles of a series differ in their numbers alone."""
    return _NUMBER.sub("#", text)


_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
_NAMES = {signal: frozenset(map(plain, names.split())) for signal, names in NAMES.items()}
_OTHER_WHOLE = frozenset(map(plain, OTHER))
_OTHER_WITHIN = tuple(map(plain, (*EASTERN_OTHERS, *EASTERN_TOLD, *EASTERN_COMPUTED)))
_TIME = re.compile(
    r"t|tout|tps|time(?:elapsed|passed|onsample)?|(?:lauf|mess|pru?e?f|versuchs|test|uhr)?zeit|tijd|temps|tiempo|tempo|"
    r"timestamps?|elapsed(?:time)?|steptime|seconds?|sec|tsec|times|"
    r"(?:ros|bag|rosbag|test|run|total|sample|row|relative|local|system|log|rec|elapsed|unix|epoch|date)?time(?:stamp)?s?|"
    rf"время|{plain('시간')}|czas|cas|tid|zaman|aika|süre|sure|"
    r"stamp|zeitstempel|tempsecoule|tiempotranscurrido|.{0,4}时间戳?|时刻|.{0,4}時間|時刻|millis|micros|"
    r"xvalue|time\d+\w{0,12}samplerate|milliseconds|microseconds|time(?:arr|array|vec|vector)",
    re.IGNORECASE,
)
_TIMES = set_of("time timestamp timestamps stamp zeit temps tiempo tempo tijd sec secs seconds")
_NO_TIMES = set_of(
    "dead rise fall settling response delay cycle start end stop begin step dwell hold rest constant lag reaction mean "
    "exposure run duration"
)
#: Load On Sample says where the load works, and counts no samples; torque values are a torque; 0.5 A in F@0.5A and
#: F_0.5A is what was set.
_SAYS_NOTHING = re.compile(
    r"[ _](?:(?:on|into)[ _](?:the[ _])?(?:sample|specimen|surface)|values)$"
    r"|(?<=[^\s@]) ?@ ?[+-]?\d[^@]*$"
    r"|(?<=^[FMT])_\d+(?:[.,xp_]\d+)?m?[ATV]$",
    re.IGNORECASE,
)
_TURNS_ALONE = re.compile(r"\W*(?:[Ur1]|tr)/min\W*")  # a unit of turns in place of a name
_SIDE = re.compile(r"(?<=[^\W\d_]{2})[ _-][A-DLR]$")
_PRIME = re.compile(r"['\"′″](?!\w)")  # force d'amortissement has none
_QUOTED = re.compile(r'"([^"]{2,})"')
#: A letter in front of others that some program could not write: ?i was an angle i, and no current.
_LOST_LETTER = re.compile(r"(?<!\w)[?\ufffd](?=\w)")
#: A length that makes a torque of a force; the load of a lever arm is a load.
_ARM = re.compile(r"\b(?:moment|lever|torque|hebel) ?arm$")
#: Words in front of what a quantity was made of.
_MADE_OF = ("from", "via", "aus")
_AXES = frozenset("xyzr")
_JOINT = re.compile(r"(?:a|j|ax|axis|joint|dof|achse|gelenk)\d{1,2}")  # MeasuredTorque_A1
# Compounds of a told or a measured value: Sollmoment, Istdrehzahl, Momentsoll.
_SOLL_OR_IST = re.compile(
    r"(?<!\w)(soll|ist)[ _-]?(?=(?:dreh)?moment|kraft|drehzahl|geschw|strom|spannung|weg|winkel|position)|"
    r"(?<=moment|.kraft|enzahl|ehzahl|.strom|innung|annung|winkel)(soll|ist)(?:wert)?(?!\w)"
)
#: A letter with what was told or measured behind it, in one word: Iset, Imeas, Uref.
_JOINED = re.compile(r"(?<![^\W_])([iuvnm])(set|meas|act|ist|soll|cmd|ref)(?![^\W_])")
#: Where a word ends in angularVelocity and XVelocity.
_BORDER = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=(?<![A-Za-z])[XYZ])(?=[A-Z][a-z])")
#: The sensor of a force or a torque: no strain of a specimen.
_STRAIN_GAUGE = re.compile(r"\bstrain ?gau?ges?\b")
_WITH_A_POINT = re.compile(r"(?<![\w.])([^\W\d_]{2,})\.(?=$|[\s_-])")
# The rate of a rate: ddq, qdd, d2x, theta_ddot.
_SHORT_POSITIONS = r"(?:q|x|y|z|s|theta|phi|alpha|pos|angle)"
_SECOND_RATE = re.compile(rf"d(?:d|2){_SHORT_POSITIONS}|{_SHORT_POSITIONS}(?:dd|ddot|2dot|dotdot)")


@dataclass(frozen=True)
class SpokenName:
    """What the name of a column says, for all signals at once.

    Attributes:
        stem: the name without the unit that ends it.
        end: that unit, or None.
        plain: the name in small letters, without signs; and so the stem.
        words: of the whole name.
        stem_words: of the stem.
        forms: signal -> the name that speaks for it, see `_called_as`.
        heads: signal of a single device -> the head of the name, see `headed`.
        numbered: signals of a single device whose name stands in front of a joint's or a channel's number (``dq3``).
        may_be: signals of a single device for which its form, its head, or a name in front of a number speaks.
        within: signals of a single device that a word anywhere in the name speaks for (``act_torque_abs``), where no
            word says that it is something else: enough to propose a column, not to take it.
        lettered: signals of a single device that a letter with an index may be (``x_p``, ``i_c``).
        turned: signals of which a word of the name makes another thing: what was computed, a limit, a rolling speed.
        is_of_a_model: whether the column is called like a model of friction or a network: it holds what the model says.
        is_primed: whether the name has a prime, as G' and G" have: the moduli of an oscillation.
        is_time: whether the column is called like the time.
        ends_in_time: whether its last word is a time.
        is_accounted: whether the name says that the column is no field.
    """

    stem: str
    end: str | None
    plain: str
    plain_stem: str
    words: tuple[str, ...]
    stem_words: tuple[str, ...]
    forms: Mapping[str, str | None]
    heads: Mapping[str, str | None]
    numbered: frozenset[str]
    may_be: frozenset[str]
    within: frozenset[str]
    lettered: frozenset[str]
    turned: frozenset[str]
    is_of_a_model: bool
    is_primed: bool
    is_time: bool
    ends_in_time: bool
    is_accounted: bool

    @property
    def bare_stem(self) -> str:
        """The stem in small letters without the number of a joint, a motor or a channel behind it."""
        return self.plain_stem.rstrip("0123456789")

    def says(self, words: frozenset[str]) -> bool:
        """Whether a word of the stem is one of these."""
        return not words.isdisjoint(self.stem_words)


def spoken_name(name: str) -> SpokenName:
    """What a name says."""
    stem, end = split_end(name)
    return spoken(name, stem, end)


@lru_cache(maxsize=KEPT_NAMES)
def spoken(name: str, stem: str, end: str | None) -> SpokenName:
    """What a name says; the same for every column of this name.

    Args:
        name: of a column.
        stem: the name without the unit that ends it.
        end: that unit, or None.
    """
    stem = _SAYS_NOTHING.sub("", without_arm(_written_out(stem)))
    if _TURNS_ALONE.fullmatch(stem):
        stem = "rpm"
    if _LOST_LETTER.search(stem):
        stem = "unknown"
        name = stem
    plain_stem = plain(stem)
    stem_words = _words_of(stem)
    forms = {signal: _called_as(name, stem, signal) for signal in NAMES}
    heads = {signal: headed(stem, signal) for signal in SINGLE}
    is_of_a_model = not MODELS.isdisjoint(
        [plain(name), *stem_words, *map("".join, pairwise(stem_words))]
    )
    if is_of_a_model:
        heads["effort"] = None  # boucwen_force
    may_be = {signal for signal in SINGLE if forms[signal] or heads[signal]}

    turned: set[str] = set()
    for signal in NAMES:
        against = NOT_MEASURED | AGAINST.get(signal, frozenset())
        if signal == "effort" and _is_effort_of_a_loop(stem_words):
            against |= LOOPS
        is_of_its_model = is_of_a_model and signal == "effort"
        if is_of_its_model or not against.isdisjoint(stem_words):
            turned.add(signal)

    numbered: set[str] = set()
    bare = plain_stem.rstrip("0123456789")
    if bare != plain_stem:
        own_words = [word for word in stem_words if word not in BESIDE]
        alone = "".join(own_words).rstrip("0123456789")  # dq of motor_dq_0
        numbered = {signal for signal in SINGLE if not _NAMES[signal].isdisjoint((bare, alone))}

    within: set[str] = set()
    if (TOLD | OTHER | NOT_MEASURED).isdisjoint(stem_words):
        words = {word for word in stem_words if len(word) > 2}
        if any(_NAMES[signal] & (words - {"load"}) for signal in ("slip", "position")):
            words -= {"load"}  # the side of a spring whose angle is meant
        within = {
            signal
            for signal in SINGLE
            if signal not in turned and not _NAMES[signal].isdisjoint(words)
        }

    lettered: set[str] = set()
    if len(stem_words) == 2:  # a letter with an index of one or two letters
        letter, index = stem_words
        if len(letter) == 1 and len(index) <= 2 and index.isalpha():
            lettered = {signal for signal in SINGLE if letter in _NAMES[signal]}
    ends_in_time = False
    if stem_words and (_NO_TIMES | OTHER).isdisjoint(stem_words):  # no word makes a span of it
        # A machine's, a logger's, a channel's time; French and Spanish names may begin with it.
        ends_in_time = stem_words[-1] in _TIMES or stem_words[0] in ("temps", "tiempo")
    is_called_time = any(_TIME.fullmatch(letters) for letters in (plain(name), plain_stem))
    return SpokenName(
        stem,
        end,
        plain(name),
        plain_stem,
        _words_of(name),
        stem_words,
        forms,
        heads,
        numbered=frozenset(numbered),
        may_be=frozenset(may_be | numbered),
        within=frozenset(within),
        turned=frozenset(turned),
        lettered=frozenset(lettered),
        is_of_a_model=is_of_a_model,
        is_primed=_is_primed(stem),
        is_time=is_called_time and name != "T",  # a large T is a torque
        ends_in_time=ends_in_time,
        is_accounted=_is_accounted(stem),
    )


def _written_out(stem: str) -> str:
    """A name whose words are written out where a point behind them tells that they are short: ``kraft`` for ``Kr.``."""

    def whole(short: re.Match[str]) -> str:
        word = short[1]
        if plain(word) == "corr" and short[0] != stem:
            return short[0]  # corrected
        return SHORT_WITH_A_POINT.get(plain(word), short[0])

    return _WITH_A_POINT.sub(whole, stem)


def _is_primed(name: str) -> bool:
    """Whether a name has a prime; quotes around a part of it, as Siemens writes them, are none."""
    return _PRIME.search(_QUOTED.sub(r"\1", name)) is not None


def words_of(name: str) -> list[str]:
    """Words of a name, in small letters: at signs, where a small letter meets a large one, and behind an axis."""
    return [*_words_of(name)]


@lru_cache(maxsize=KEPT_NAMES)  # many rules of a plan ask for the words of the same few names
def _words_of(name: str) -> tuple[str, ...]:
    apart = _BORDER.sub(" ", unicodedata.normalize("NFKD", name))
    letters_alone = re.sub(r"[^\w\s]|_", " ", re.sub("[\u0300-\u036f]", "", apart)).lower()
    letters_alone = _STRAIN_GAUGE.sub("straingauge", letters_alone)
    letters_alone = _ARM.sub("leverarm", letters_alone.rstrip())
    letters_alone = _JOINED.sub(r"\1 \2", letters_alone)
    words = _SOLL_OR_IST.sub(r" \1\2 ", letters_alone).split()
    if "ff" in words and len(words) > 1:
        words[words.index("ff")] = "feedforward"
    if "des" in words and len(words) > 1:
        # At an end it is short for desired; between two French words it is an article.
        of_letters = [
            place for place, word in enumerate(words) if not word.isdecimal() and word not in _AXES
        ]
        for place in (*of_letters[:1], *of_letters[-1:]):
            if words[place] == "des":
                words[place] = "desired"
    if "duty" in words:  # that of a switch goes round, and is no cycle of a test
        words = [word for word in words if word not in ("cycle", "cycles")]
    if words and words[0] == "tau" and words[1:] in (["d"], ["c"]):
        words[1] = "desired" if words[1] == "d" else "commanded"
    # A Chinese, Japanese or Korean compound may say of a signal that it was told, or computed.
    compound = "" if name.isascii() else unicodedata.normalize("NFKC", name)
    if any(told in compound for told in EASTERN_TOLD):
        words.append("setpoint")
    if any(computed in compound for computed in EASTERN_COMPUTED):
        words.append("computed")
    return tuple(OF_SEVERAL.get(word, word) for word in words)


def _called_as(name: str, stem: str, signal: str) -> str | None:
    """The name that speaks for a signal: the whole of it, or what is left without its unit.

    For a single device also what is left without the words beside it; the pair has a motor and an output to tell apart.
    """
    if _is_primed(stem):
        return None  # E' is a fluctuation, G" a loss modulus: neither is E or G
    forms = [plain(name), plain(stem)]
    if signal in SINGLE:
        # A side is a letter: Torque_A beside Torque_B. A coil's A and V are units.
        bare = stem if signal == "field" else _SIDE.sub("", stem)
        forms.append("".join(word for word in words_of(bare) if word not in BESIDE))
    return next((form for form in forms if form in _NAMES[signal]), None)


@lru_cache(maxsize=4 * KEPT_NAMES)  # for four signals
def headed(stem: str, signal: str, shared: frozenset[str] = frozenset()) -> str | None:
    """The head of a name, where that is a name of a signal of a single device; None for another head.

    ``pitch_velocity`` and ``Traction Force`` are headed; a predicted force, a torque's limit, a rolling speed and the
    voltage of a force sensor are not.

    Args:
        stem: the column's name without the unit that ends it.
        signal: its name.
        shared: words that most columns have in their names, which say nothing of a single one.
    """
    if signal not in SINGLE or _is_primed(stem):
        return None
    if EASTERN.search(stem):
        name = plain(stem)
        if any(other in name for other in _OTHER_WITHIN):
            return None
        # The end of a compound names the signal.
        longest_first = sorted(_NAMES[signal], key=len, reverse=True)
        ends = (end for end in longest_first if EASTERN.search(end) and name.endswith(end))
        return next(ends, None)
    parts = [
        re.sub(r"\d+$", "", word)
        for word in words_of(stem)
        if word not in shared and not _JOINT.fullmatch(word)
    ]
    parts = [word for word in parts if word]
    if "per" in parts:
        return None  # a torque per rpm is no speed, and no torque
    if not {"vs", "versus"}.isdisjoint(parts[1:-1]):
        return None  # what was made of two quantities, such as how they correlate
    if signal == "field" and "sensor" in parts and VOLTAGES & {*parts} and CURRENTS & {*parts}:
        return None  # the volts that the sensor of a current gives
    while len(parts) > 1 and parts[-1] in _AXES | BESIDE:
        parts.pop()
    if not parts or {*parts} & (TOLD | OTHER | NOT_MEASURED | AGAINST[signal]):
        return None
    if signal == "effort" and _is_effort_of_a_loop(parts):
        return None

    # A torque from a current is a torque.
    ends = (place for place, word in enumerate(parts) if place and word in _MADE_OF)
    parts = parts[: next(ends, len(parts))]

    heads = [(parts[:-1], parts[-1])]  # the words beside a head, and the head
    if parts[0] in ROMANCE:
        heads.append((parts[1:], parts[0]))
    if len(parts) > 1:
        heads.append((parts[:-2], "".join(parts[-2:])))
    for rest, head in heads:
        known = head in _NAMES[signal] or _german(head, signal)
        if len(head) > 1 and known and not any(_speaks(word, signal) for word in rest):
            return head
    return None


def _is_effort_of_a_loop(words: Iterable[str]) -> bool:
    """Whether a name is that of a control effort: what a loop tells a drive, and no torque or force of a device."""
    return "effort" in words and not LOOPS.isdisjoint(words)


def _speaks(word: str, signal: str) -> bool:
    """Whether a word speaks for another signal than this: the voltage of a force sensor is no field.

    The velocity of a stroke is a velocity, and the load of a load's speed is a shaft.
    """
    if word == "load" and signal in ("slip", "position"):
        return False
    others = {*SINGLE} - {signal} - ({"position"} if signal == "slip" else set())
    return any(len(word) > 2 and word in _NAMES[other] for other in others)


def _german(word: str, signal: str) -> bool:
    ends = tuple(end for end in GERMAN[signal] if len(word) > len(end) + 2)
    return bool(ends) and word.endswith(ends) and not word.startswith(GERMAN_OTHERS)


def _is_accounted(stem: str) -> bool:
    """Whether a name says what the column is, and that it is no field: another quantity, or one of another signal."""
    if EASTERN.search(stem):
        name = plain(stem)
        if name in _OTHER_WHOLE:
            return True
        others = [*_OTHER_WITHIN]
        for signal in SINGLE[1:]:
            others += [word for word in _NAMES[signal] if EASTERN.search(word)]
        return any(word in name for word in others)
    spoken = {re.sub(r"\d+$", "", word) for word in words_of(stem)}
    if _SECOND_RATE.fullmatch(plain(stem).rstrip("0123456789")):
        return True
    is_of_a_gauge = "straingauge" in spoken
    if is_of_a_gauge or spoken & OTHER or any(_speaks(word, "field") for word in spoken):
        return True
    return any(_german(word, signal) for word in spoken for signal in SINGLE[1:])
