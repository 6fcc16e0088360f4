"""An option for a column without a unit gets the one that its name ends in, which the user sees beside the name."""

from __future__ import annotations

import re
import shlex

from erclutch.errors import shell_word
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.seen_columns import SeenColumns
from erclutch.logs.columns.words_behind_units import without_words_behind
from erclutch.logs.planning.units_in_names import likely_unit, unread_unit
from erclutch.logs.table import MINUS
from erclutch.signals import units
from erclutch.signals.recording import SIGNALS

_MARK = re.compile(r"[\s_.:/|,=@-]+")
_LETTERS = re.compile(r"[^\W\d_]{2}|°")  # of one letter nobody knows what it is: I_a, u_m

_WORDS = re.compile(
    r"in|[a-z]{0,2}at"
)  # an input, the hat of an estimate: inches and technical atmospheres are rarer
_BRACKET = re.compile(r"[\s_]*[(\[<{]|[)\]>}]$")


def with_unit_of_name(seen: SeenColumns, option: str) -> str:
    """An option for a signal, with the unit at the end of its column's name: ``Torque_lbf-ft``, ``Speed_mph``.

    Such an end is not read as a unit where nobody has said that the column is the signal; here the user looks at it.

    Args:
        seen: the columns of the log.
        option: such as ``--effort Torque_lbf-ft``.
    """
    words = shlex.split(option)
    signal = words[0].removeprefix("--")
    if signal not in SIGNALS or len(words) != 2 or words[1] not in seen.columns:
        return option
    if MINUS in words[1]:  # of two columns, each in its unit
        return option
    name = words[1]
    if seen.columns[name].unit is not None:
        return option
    unit = _unit_at_end(name, SIGNALS[signal].si_units)
    piece = unread_unit(name, signal) if not split_end(name)[1] else ""
    if not unit and piece:
        unit = likely_unit(piece)
    return f"{words[0]} {shell_word(f'{name} [{unit}]')}" if unit else option


def _unit_at_end(name: str, si_units: tuple[str, ...]) -> str:
    """The longest end of a name, behind a mark, that is a unit of a signal; "" for none."""
    shorter = without_words_behind(name)
    if split_end(shorter)[1]:  # a reader has taken it
        return ""
    for mark in _MARK.finditer(shorter):
        end = shorter[mark.end() :].strip("()<>{} ")
        if not mark.start() or not _LETTERS.search(end) or _WORDS.fullmatch(end):
            continue
        if _is_of(end, si_units):
            return end
    _, told = split_end(_BRACKET.sub("_", shorter))  # (deg_per_s) is no unit in a bracket
    return told if told and told != shorter and _is_of(told, si_units) else ""


def _is_of(text: str, si_units: tuple[str, ...]) -> bool:
    """Whether a text is a unit of these dimensions; a number, which passes for an angle, is none."""
    fitting = units.fits(text, si_units) if units.is_unit(text) else None
    return fitting is not None and units.parse(text).dimension == units.parse(fitting[1]).dimension
