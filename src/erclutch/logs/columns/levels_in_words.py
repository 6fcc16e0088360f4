"""A valve's level may be a word, ``Soft``, ``mittel``, ``强``: such words have an order, and are counted from 1."""

from __future__ import annotations

import re

from erclutch.logs.columns.vocabulary import set_of

#: Words of one kind, by their places.
_SOFT = set_of(
    "soft weich souple blando suave morbido macio zacht mjuk miekki 软 軟 柔 弱 ソフト 소프트 약"
)
_MEDIUM = set_of(
    "medium mid middle mittel moyen medio media gemiddeld 中 中等 中间 ミディアム 중간 중"
)
_HARD = set_of("hard firm stiff hart dur ferme duro rigido fest 硬 强 強 ハード 하드 강")
_COMFORT, _NORMAL, _SPORT = (
    set_of("comfort komfort confort 舒适"),
    set_of("normal 标准"),
    set_of("sport sports 运动"),
)
_LOW = set_of("low niedrig bas faible bajo baixo basso laag 低")
_HIGH = set_of("high hoch haut fort alto hoog 高")
_OFF = set_of("off aus none zero arret")
_FAMILIES = (
    ((1, _SOFT), (2, _MEDIUM), (3, _HARD)),
    ((1, _COMFORT), (2, _NORMAL), (3, _SPORT)),
)
#: In a column of words, whose name says that it is a level, low and high are no bounds of a measurement.
_ORDERS = (*_FAMILIES, ((0, _OFF), (1, _LOW), (2, _MEDIUM), (3, _HIGH)))
_WORD = re.compile(r"[^\W\d_]+")


def place_of(word: str) -> tuple[int, int] | None:
    """Which family a word in the name of a column is of, and its place there from 1 on; None for another word."""
    letters = _letters(word)
    for number, family in enumerate(_FAMILIES):
        for place, words in family:
            if letters in words:
                return number, place
    return None


def word_of_level(name: str) -> str:
    """The only word of a name that is a level; "" for none or several."""
    levels = [word for word in _WORD.findall(name) if place_of(word) is not None]
    return levels[0] if len(levels) == 1 else ""


def places_of(words: tuple[str, ...]) -> tuple[int, ...] | None:
    """The places of the words of a column, where all are levels of one kind and no two have one place; else None."""
    for family in _ORDERS:
        places: list[int] = []
        for word in words:
            places += [place for place, known in family if _letters(word) in known]
        if len(places) == len({*places}) == len(words) > 1:
            return tuple(places)
    return None


def _letters(word: str) -> str:
    (letters,) = set_of(word.strip().lower()) or {""} if len(word.split()) == 1 else ("",)
    return letters
