"""Beside a column that is said to be measured (``torque actual``), a bare name (``torque``) is what was told."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.vocabulary import MEASURED, set_of

#: Words of a friction, which a controller adds and a study identifies: what was measured may stand beside it.
_FRICTIONS = set_of("fric friction reib reibung frottement friccion attrito")


def of_whole_names(
    named: Sequence[SeenColumn], forms: Mapping[str, str | None]
) -> list[SeenColumn]:
    """The columns that are called like a signal, without any word beside it but for measuring: ``torque actual``.

    Args:
        named: columns whose names speak for the signal.
        forms: what speaks for it in the name of each.
    """
    bare: list[SeenColumn] = []
    measured: list[SeenColumn] = []
    for column in named:
        words = column.spoken.stem_words
        others = [word for word in words if word not in MEASURED]
        if column.spoken.plain_stem == forms[column.name]:
            bare.append(column)
        elif len(others) < len(words) and "".join(others) == forms[column.name]:
            measured.append(column)
    forms_measured = {forms[column.name] for column in measured}
    if not any(forms[column.name] in forms_measured for column in bare):
        return bare
    return [column for column in bare if forms[column.name] not in forms_measured] + measured


def beside_measured_names(names: Iterable[str]) -> set[str]:
    """Those of some names that stand beside their like with a word for measuring: ``tau_1`` beside ``tau_measured_1``.

    The numbers of joints say nothing here.
    """
    words: dict[str, list[str]] = {}  # of each name, without digits at their ends
    for name in names:
        letters = [word.rstrip("0123456789") for word in words_of(name)]
        words[name] = [word for word in letters if word]
    measured: list[list[str]] = []  # without the word for measuring
    for of_name in words.values():
        others = [word for word in of_name if word not in MEASURED]
        if len(others) < len(of_name):
            measured.append(others)
    return {name for name, of_name in words.items() if of_name in measured}


def planned_beside_measured(columns: Sequence[SeenColumn]) -> set[str]:
    """Columns that a column of the same words, a word for measuring and numbers that change stands beside.

    ``elbow_torque`` beside ``elbow_meas_torque`` is what was planned. Where the measured column never changes nothing
    was measured, and the other column may be all there is.
    """
    measured: set[tuple[str, ...]] = set()  # without the word for measuring
    for column in columns:
        words = column.spoken.stem_words
        others = tuple(word for word in words if word not in MEASURED)
        if len(others) < len(words) and not column.shape.constant:
            measured.add(others)
    return {column.name for column in columns if column.spoken.stem_words in measured}


def measured_beside_frictions(
    signal: str, named: Sequence[SeenColumn], others: Iterable[SeenColumn]
) -> list[str]:
    """The names that speak for a signal; where all of them hold a friction, the whole of the effort before them.

    Args:
        signal: its name; only an effort has a friction.
        named: columns whose names speak for it: ``tau_fric``.
        others: columns that may be it by their units: ``tau_meas`` or ``tau`` is the whole.
    """
    names = [column.name for column in named]
    wholes = {_words_without(column, _FRICTIONS) for column in named}
    holds_whole = any(_words_without(column) in wholes for column in named)
    if signal != "effort" or holds_whole:
        return names
    measured = [
        column.name
        for column in others
        if _words_without(column, MEASURED) in wholes and not column.shape.constant
    ]
    return [*measured, *names]


def _words_without(column: SeenColumn, words: Iterable[str] = ()) -> tuple[str, ...]:
    """The words of a name without some, and without the number of a joint at their ends."""
    letters = (word.rstrip("0123456789") for word in column.spoken.stem_words)
    return tuple(word for word in letters if word and word not in words)
