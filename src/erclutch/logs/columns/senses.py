"""A speed without a sign beside a column that says the sense, in words or by two numbers, takes its sign from there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from erclutch.logs.columns.names import spoken_name, words_of
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.columns.word_columns import with_words_used_up
from erclutch.logs.table import Table
from erclutch.signals.array import Array

#: Words of opposite senses: that of the first set is positive.
_OPPOSITES = (
    ({"cw", "clockwise"}, {"ccw", "counterclockwise", "anticlockwise"}),
    ({"forward", "forwards", "fwd"}, {"reverse", "rev", "backward", "backwards", "bwd"}),
    ({"up", "upward"}, {"down", "downward"}),
    (
        {
            "extension",
            "extend",
            "rebound",
            "zug",
            "zugstufe",
            "detente",
            "rebote",
            "r",
            "复原",
            "伸側",
        },
        {
            "compression",
            "retract",
            "bump",
            "druck",
            "druckstufe",
            "compresion",
            "c",
            "压缩",
            "圧側",
        },
    ),
    ({"positive", "pos", "plus"}, {"negative", "neg", "minus"}),
    ({"push"}, {"pull"}),
    ({"right", "rechts", "droite", "derecha"}, {"left", "links", "gauche", "izquierda"}),
    ({"vorwarts", "vor", "avant", "adelante"}, {"ruckwarts", "zuruck", "arriere", "atras"}),
)
_SENSES = frozenset(word for pair in _OPPOSITES for senses in pair for word in senses)
#: Senses of a damper, whose efforts differ.
_STROKES = frozenset(_OPPOSITES[3][0] | _OPPOSITES[3][1])
#: Words in the name of a column that says the sense by numbers.
DIRECTIONS = frozenset(
    {
        "direction",
        "dir",
        "sense",
        "sign",
        "drehrichtung",
        "richtung",
        "laufrichtung",
        "sens",
        "sentido",
        "方向",
        "转向",
    }
)
_LOOKED_AT = 100_000  # rows, for the numbers that a column of a direction has
#: Share of the moving rows in which the effort keeps to the senses, or all the other way.
_AGREES = 0.9


def with_senses(table: Table) -> Table:
    """The table with the signs of its only speed, where an effort of both signs keeps to what the words say."""
    speeds: list[str] = []
    efforts: list[str] = []
    for name, values in table.columns.items():
        may_be = spoken_name(name).may_be
        if "slip" in may_be:
            speeds.append(name)
        elif "effort" in may_be and takes_both_signs(values):
            efforts.append(name)
    if len(speeds) != 1 or len(efforts) != 1:
        return table
    speed = table.columns[speeds[0]]
    effort = table.columns[efforts[0]]
    moving = np.isfinite(effort) & (np.abs(speed) > 0.0) & (effort != 0.0)
    if takes_both_signs(speed) or not moving.any():
        return table

    def keeps_to(sense: Array) -> bool:
        """Whether the effort has the sign of the sense in nearly all rows that move, or the other sign."""
        along = int(np.count_nonzero((effort * sense)[moving] > 0.0))
        agreeing = along / int(np.count_nonzero(moving))
        return max(agreeing, 1.0 - agreeing) >= _AGREES

    for name, values in table.columns.items():
        numbered = _numbered_senses(name, values)
        if numbered is None or not keeps_to(numbered):
            continue
        turned_at = values[int(np.argmin(numbered))]
        note = f"column {speeds[0]} has no sign and {efforts[0]} has: it is turned where {name} is {turned_at:g}"
        columns = {other: each for other, each in table.columns.items() if other != name}
        columns[speeds[0]] = speed * numbered
        return replace(
            table,
            columns=columns,
            notes=(*table.notes, note),
        )
    for name, senses in table.words.items():
        signs = opposite_signs(senses.words)
        if signs is None or not (senses.of_row >= 0).all():
            continue
        sense = signs[senses.of_row]  # +1 or -1, shape (n,)
        if not keeps_to(sense):
            continue
        turned = senses.words[int(np.argmin(signs))]
        note = f"column {speeds[0]} has no sign and {efforts[0]} has: it is turned where {name} is {turned}"
        table = with_words_used_up(table, name)
        return replace(
            table,
            columns={**table.columns, speeds[0]: speed * sense},
            notes=(*table.notes, note),
        )
    return table


def with_senses_of_sizes(table: Table) -> Table:
    """The table with the signs of its only speed and its only effort, where both are sizes beside words of senses.

    So are points of a shock absorber, a row each: Rebound, 0.1 m/s, 300 N. The device is passive: in either sense the
    effort has the sign of the speed. Up and down may be ramps, and a brake is alike in both senses.
    """
    names: dict[str, list[str]] = {"slip": [], "effort": []}
    for name in table.columns:
        for signal in names:
            if spoken_name(name).may_be == frozenset({signal}):
                names[signal].append(name)
    both = [*names["slip"], *names["effort"]]
    are_sizes = not any(bool(np.any(table.columns[name] < 0.0)) for name in both)
    if any(len(each) != 1 for each in names.values()) or not are_sizes:
        return table
    for name, senses in table.words.items():
        signs = opposite_signs(senses.words)
        are_strokes = all(not _STROKES.isdisjoint(words_of(word)) for word in senses.words)
        if signs is None or not are_strokes or not (senses.of_row >= 0).all():
            continue
        sense = signs[senses.of_row]  # +1 or -1, shape (n,)
        turned = senses.words[int(np.argmin(signs))]
        speed, effort = both
        note = f"columns {speed} and {effort} are sizes: both are negative where {name} is {turned}"
        table = with_words_used_up(table, name)
        signed = {each: table.columns[each] * sense for each in both}
        return replace(table, columns={**table.columns, **signed}, notes=(*table.notes, note))
    return table


def _numbered_senses(name: str, values: Array) -> Array | None:
    """The sign of each row, shape (n,), by a column called like a direction that holds two numbers; None for others.

    At 0 between -1 and 1 a device rests.
    """
    words = {word.rstrip("0123456789") for word in words_of(name)}
    if words.isdisjoint(DIRECTIONS) or not np.isfinite(values).all():
        return None
    levels = {*np.unique(values[:_LOOKED_AT]).tolist()}
    if levels in ({-1.0, 1.0}, {-1.0, 0.0, 1.0}):
        return values if np.isin(values, (-1.0, 0.0, 1.0)).all() else None
    if levels == {0.0, 1.0} and np.isin(values, (0.0, 1.0)).all():
        return 2.0 * values - 1.0
    if levels == {1.0, 2.0} and np.isin(values, (1.0, 2.0)).all():
        return 3.0 - 2.0 * values
    return None


def says_a_sense(name: str) -> bool:
    """Whether a word of a name says a sense."""
    return not _SENSES.isdisjoint(words_of(name))


def without_sense(name: str) -> str:
    """A name without words that say a sense: those of two senses of one effort are the same."""
    kept = [word for word in words_of(name) if word not in _SENSES]
    return " ".join(kept)


def opposite_signs(senses: Sequence[str]) -> Array | None:
    """The sign of each of two opposite senses, shape (2,); None for other words."""
    if len(senses) != 2:
        return None
    first, second = ({*words_of(sense)} for sense in senses)
    for positive, negative in _OPPOSITES:
        if first & positive and second & negative:
            return np.array([1.0, -1.0])
        if first & negative and second & positive:
            return np.array([-1.0, 1.0])
    return None
