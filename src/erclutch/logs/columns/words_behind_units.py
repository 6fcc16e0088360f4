"""Words behind the unit of a name tell what was done with its numbers: ``Force_kN_filtered``, ``Load (lbf) avg``.

A bracket that somebody forgot to open or to close is taken for a whole one: ``Force (kN``, ``Force kN)``.
"""

from __future__ import annotations

import re

_WORDS = (
    "filt filtered flt lp lpf smooth smoothed raw f mean avg average median rms abs max min peak std corr corrected "
    "cal calibrated comp compensated tared zeroed gefiltert roh mittel mittelwert filtree filtre brute moyenne "
    "filtrado filtrada promedio media"
)
_LAST_WORD = re.compile(rf"(?<=.)(?:[\s_.,-]+(?:{'|'.join(_WORDS.split())}))$", re.IGNORECASE)
_WORD_IN_BRACKET = re.compile(
    rf"([\[(][^\[\](),;]+?)\s*[,;]\s*(?:{'|'.join(_WORDS.split())})(?=[\])]$)", re.IGNORECASE
)
_OPENED = re.compile(r"([^\[\]()]*[^\W\d_][^\[\]()]*?)[\s_]*[\[(]([^\[\]()]+)")
_CLOSED = re.compile(r"([^\[\]()]*[^\W\d_][^\[\]()]*)[\s_]([^\[\]()\s_]+)[\])]")
_MOST_WORDS = 3
_LONGEST = 100  # letters of such a name


def without_words_behind(name: str) -> str:
    """``Force_kN`` of ``Force_kN_raw_mean``, ``Force (kN)`` of ``Force (kN`` or ``(kN, raw)``; else the name itself."""
    shorter = name.strip()
    if len(shorter) > _LONGEST:
        return shorter
    for _ in range(_MOST_WORDS):
        shorter = _LAST_WORD.sub("", shorter)
    shorter = _WORD_IN_BRACKET.sub(r"\1", shorter)
    for bracket in (_OPENED, _CLOSED):
        broken = bracket.fullmatch(shorter)
        if broken:
            return f"{broken[1]} ({broken[2].strip()})"
    return shorter
