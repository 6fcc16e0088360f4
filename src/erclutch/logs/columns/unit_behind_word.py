"""A unit behind the word for its quantity: ``Velocity, mm.s-1``, ``Torque: N·mm``, ``Speed_rad/s``, ``Сила кН``.

The word and the unit bear each other out, whatever mark stands between them and however the other columns of the file
are called. A letter alone is no such unit: ``Current, A`` may be the first of three phases.
"""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from erclutch.errors import UnitError
from erclutch.logs.columns.vocabulary import BESIDE, GERMAN, NAMES, ROMANCE, SINGLE, set_of
from erclutch.signals import units

_LONGEST = 100  # letters of such a label
_MARK = re.compile(r"\s*[,:;=|]\s*|\s+[-–—]\s+|[\s_.]")
#: What no word has: the signs of ``mm s^-1``, ``N·mm``, ``°/s``, ``ft-lb``, and letters of other alphabets (``мм/с``).
_SIGN = re.compile(r"[/·*^.⁻⁰¹²³°²\-−]|[^\x00-\x7f]")
#: Units of words alone are told behind such a mark, if any: ``Velocity, mph``.
_CLEAR_MARKS = frozenset(",:;=|")
#: Units that are no other words, behind a mark of any kind.
_WRITTEN_OUT = set_of(
    "ampere amperes milliampere milliamperes milliamps pond grad gradi grados degre degres umdrehungen arcmin"
)
#: Letters that tell no phase and no side: of newtons, seconds, minutes, hours, amperes and volts.
_LETTERS = frozenset("Нсмч牛秒分时時安伏")
_NUMBER = re.compile(r"[\s_][\d.,]+$")
_BEGINS_WITH_A_NUMBER = re.compile(r"[\d.,+-]+(?!/)")  # 1/min does not
_AXES = frozenset("xyzr")
_UNITS = {
    "field": ("A", "V", "T", "V/m", "A/m"),
    "slip": ("rad/s", "m/s"),
    "position": ("rad", "m"),
    "effort": ("N*m", "N", "Pa"),
    "time": ("s",),
}
_TIMES = set_of(
    "t time zeit temps tiempo tempo tijd timestamp elapsed elapsedtime timeelapsed время czas cas tid zaman aika ido "
    "时间 時間 시간"
)


def _bare(text: str) -> str:
    """In small letters, without accents and signs."""
    letters = unicodedata.normalize("NFKD", text)
    return re.sub(r"[\W\d_]", "", letters).lower()


def _signals_by_word() -> dict[str, set[str]]:
    signals: dict[str, set[str]] = {}
    for signal in SINGLE:
        for word in NAMES[signal].split():
            signals.setdefault(_bare(word), set()).add(signal)
    for word in _TIMES:
        signals.setdefault(_bare(word), set()).add("time")
    return signals


#: Signals by the words for them, without accents; a letter alone is the symbol of a quantity.
_SIGNALS = _signals_by_word()


@lru_cache(maxsize=1 << 14)  # as many names as `name_ends` keeps
def split_behind_word(label: str) -> tuple[str, str | None]:
    """``Velocity`` and ``mm.s-1`` of ``Velocity, mm.s-1``; the whole label and None where no such unit ends it."""
    label = label.strip()
    if len(label) > _LONGEST:
        return label, None
    for mark in _MARK.finditer(label):  # the first mark first, for the longest unit: ``Torque N m``
        front = label[: mark.start()]
        end = label[mark.end() :].strip()
        is_clear = mark[0].strip() in _CLEAR_MARKS
        # A number makes a level of what stands behind it: I=0.5A, Torque 5 N·m.
        has_number = _BEGINS_WITH_A_NUMBER.match(end) or (not is_clear and _NUMBER.search(front))
        if has_number or (len(end) < 2 and end not in _LETTERS):
            continue
        is_no_word = _SIGN.search(end) or " " in end or end.lower() in _WRITTEN_OUT
        if (is_clear or is_no_word) and bears_out(front, end):
            return front.rstrip(" _.,:;=|-"), end
    return label, None


def bears_out(name: str, unit: str) -> bool:
    """Whether a name is a word for a quantity, and a text one of the units of this quantity."""
    signals = _signals_of(name)
    return bool(signals) and _is_of(unit, signals)


def _signals_of(front: str) -> set[str]:
    """The signals that a name speaks for: whole, by its last word, by its first as French is, or by its German end."""
    words = [word for word in re.split(r"[\W\d_]+", front) if word]
    while len(words) > 1 and (words[-1].lower() in _AXES or _bare(words[-1]) in BESIDE):
        words.pop()
    if not words:
        return set()
    whole, last, first = (_bare(text) for text in (front, words[-1], words[0]))
    for spoken in (whole, last, first if first in ROMANCE else ""):
        if spoken in _SIGNALS:
            return _SIGNALS[spoken]
    by_end = {signal for signal, ends in GERMAN.items() if last.endswith(ends)}
    if by_end:
        return by_end
    # A compound of Chinese, Japanese or Korean letters ends in the word for its quantity.
    return {
        signal
        for word, signals in _SIGNALS.items()
        if len(word) > 1 and not word.isascii() and last.endswith(word)
        for signal in signals
    }


def _is_of(unit: str, signals: set[str]) -> bool:
    """Whether a unit is one of a signal's; in turns a minute, too, of a speed."""
    if "slip" in signals and (units.is_per_minute(unit) or units.is_per_second(unit)):
        return True
    try:
        return any(units.fits(unit, _UNITS[signal]) for signal in signals)
    except UnitError:
        return False
