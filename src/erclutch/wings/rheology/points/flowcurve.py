"""Which options `flowcurve` needs for a file: it is tried, and what it asks for is given, until it asks no more."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from erclutch.errors import ErclutchError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

POINTS = "flow curves of a rheometer"

#: One behind another: the rate and the unit of its stress, the sheet, what parts its rows.
_MOST_QUESTIONS = 3
_WORD = r""" (?:"[^"]+"|'[^']+'|(?!--)[^\s,;'"]+)"""
_OPTION = re.compile(rf"--(shear-rate|stress|sheet)((?:{_WORD})+)")
_UNIT = re.compile(r"\[[^\[\]]+\]")
_LEFT_OPEN = "[UNIT]"
_ANY_UNIT = "Say its unit"
#: In the remedy of an error whose unit only the user knows.
_TWO_ANSWERS = (", or --stress", _ANY_UNIT)


def flowcurve(path: str, given: Mapping[str, Sequence[str]]) -> dict[str, list[str]] | None:
    """The options by which `flowcurve` reads a file, each with its words; None where no options do.

    A unit that only the user knows, since two are as likely, stands in them as ``[UNIT]``.

    Args:
        path: of the file.
        given: options that are known.
    """
    options = {option: [*words] for option, words in given.items()}
    with_units = {option: [*words] for option, words in given.items()}  # one of those as likely
    for _ in range(_MOST_QUESTIONS + 1):
        rate = with_units.get("shear-rate", [None])[0]
        stress = with_units.get("stress", [])
        sheet = with_units.get("sheet", [])
        try:
            read_flow_curves(path, shear_rate=rate, stress=stress, sheet=sheet)
        except ErclutchError as error:
            asked = _asked(error.remedy, with_units)
            if not asked:
                return None
            has_two_answers = any(mark in error.remedy for mark in _TWO_ANSWERS)
            for option, words in asked.items():
                with_units[option] = words
                is_open = has_two_answers and option == "stress"
                options[option] = (
                    [_UNIT.sub(_LEFT_OPEN, each) for each in words] if is_open else words
                )
        else:
            return options
    return None


def _asked(remedy: str, known: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """The options that a remedy gives, the first of each kind; none where it gives an example or nothing new."""
    if "such as" in remedy and not remedy.startswith(_ANY_UNIT):
        return {}
    asked: dict[str, list[str]] = {}
    for option, words in _OPTION.findall(remedy):
        if option not in known and option not in asked:
            asked[option] = [word.strip("\"'") for word in re.findall(_WORD[1:], words)]
    return asked
