"""A unit in the name of a guessed signal that was not read, or that the unit of the column contradicts, is asked about.

``ForceMN`` may be in meganewtons or millinewtons, ``Force G`` in grams, and ``torque_Nm [Nmm]`` is wrong by 1000 in one
of the two: taken as logged, or as one of them says, the numbers would be wrong in silence.
"""

from __future__ import annotations

import re
from contextlib import suppress

from erclutch.errors import UnitError, shell_word
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.name_ends import ENDS, split_end
from erclutch.logs.columns.seen_columns import SeenColumn
from erclutch.logs.columns.vocabulary import NAMES, set_of
from erclutch.logs.planning.draft import Draft
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_SIGNALS = ("field", "slip", "position", "effort")
_ALIKE = 1e-6  # share by which two spellings of a unit may differ
#: What looks like a unit and is none as it is written: the prefix or the unit has letters of another size.
_LOOKS_LIKE = re.compile(r"(?:[kKMmuµcd]|da)(?:NM|Nm|N|A|V|gf)|G|GM|GR")
_PER_A_TIME = re.compile(r"([^\W_]+)_per_(?:s|sec|second|min|minute)", re.IGNORECASE)
#: What a unit glued to a word for a signal stands behind, besides the names of the signals.
_WORDS = {
    "field": set_of("current voltage strom spannung courant corriente coil"),
    "slip": set_of("speed velocity vel omega rate"),
    "position": set_of("position angle displacement pos"),
    "effort": set_of("force torque load moment thrust kraft drehmoment effort"),
}
_BY_WEIGHT = {"G": "gf", "GM": "gf", "GR": "gf"}


def doubt_units_in_names(draft: Draft) -> None:
    """Doubt each guessed signal whose name holds a unit that was not read, or another than its column has."""
    for signal in _SIGNALS:
        chosen = draft.guessed(signal)
        is_open = chosen is not None and chosen.column and chosen.sureness != "doubtful"
        if chosen is None or not is_open or signal in draft.told.scales:
            continue
        column = draft.seen.columns.get(chosen.column)
        if column is None:
            continue
        contradicted = _contradicted(column, signal)
        if contradicted:
            label = shell_word(draft.table.label(column.name))
            doubt = f"in {column.unit} by its unit and in {contradicted} by its name: {label} takes the unit"
            draft.doubt(signal, doubt, label)
            continue
        if chosen.unit is not None or column.unit is not None:
            continue
        piece = unread_unit(column.name, signal)
        if piece:
            answer = shell_word(f"{column.name} [{likely_unit(piece)}]")
            draft.doubt(signal, f"whose name says {piece}, which may be its unit", answer)


def likely_unit(piece: str) -> str:
    """The unit that what looks like a unit is likely to be; ``UNIT``, a place to fill in, where nobody can tell."""
    if piece in ENDS:
        return ENDS[piece]
    # MNM is mega, or milli with a large letter.
    is_open = _PER_A_TIME.search(piece) or piece.upper() == "MNM"
    return "UNIT" if is_open else _BY_WEIGHT.get(piece, piece)


def _contradicted(column: SeenColumn, signal: str) -> str:
    """The unit in a column's name that its own unit contradicts; "" where they agree, or one of them is missing."""
    _, in_brackets = split_label(column.name)
    _, last = split_end(column.name)
    end = in_brackets or (last if last and len(last) > 1 else "")  # F_N is no force in newtons
    if not end or column.unit is None:
        return ""
    for si in SIGNALS[signal].si_units:
        with suppress(UnitError):
            own = units.fits(column.unit, (si,))
            named = units.fits(end, (si,))
            if own is not None and named is not None:
                return "" if abs(own[0] / named[0] - 1.0) < _ALIKE else end
    return ""


def unread_unit(name: str, signal: str) -> str:
    """What looks like a unit of a signal in a name that no unit was read from; "" for none."""
    quotient = _PER_A_TIME.search(name)
    if signal == "slip" and quotient is not None:
        return quotient[0]
    words = {*NAMES[signal].split(), *_WORDS.get(signal, ())}
    known = sorted(words, key=len, reverse=True)
    for word in re.split(r"[\W_]+", name):
        glued = next(
            (each for each in known if len(each) > 2 and word.lower().startswith(each)), ""
        )
        piece = word[len(glued) :]
        if not piece or piece == name:
            continue
        if _LOOKS_LIKE.fullmatch(piece) and (len(piece) > 1 or signal == "effort"):
            return piece
        if len(piece) > 1 and piece in ENDS and _fits(ENDS[piece], signal):
            return piece
    return ""


def _fits(unit: str, signal: str) -> bool:
    with suppress(UnitError):
        return units.fits(unit, SIGNALS[signal].si_units) is not None
    return False
