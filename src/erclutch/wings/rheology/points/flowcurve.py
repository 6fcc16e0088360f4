"""Which options `flowcurve` needs for a file: it is tried, and what it asks for is given, until it asks no more."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence

from erclutch.errors import ErclutchError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

POINTS = "flow curves of a rheometer"

#: One behind another: the rate and the unit of its stress, the sheet, what parts its rows.
_MOST_QUESTIONS = 3
_UNIT = re.compile(r"\[[^\[\]]+\]")
_LEFT_OPEN = "[UNIT]"


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
            asked = _asked(error.answers, with_units)
            if not asked:
                return None
            with_units |= asked
            options |= asked
            if "stress" in asked and len(error.answers) > 1:
                options["stress"] = [_UNIT.sub(_LEFT_OPEN, each) for each in asked["stress"]]
        else:
            return options
    return None


def _asked(answers: Sequence[str], known: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """The options of the likeliest answer that are not known yet; none where the answers are of different options."""
    of_answers: list[dict[str, list[str]]] = []
    for answer in answers:
        options: dict[str, list[str]] = {}
        words_of_option: list[str] = []
        for word in shlex.split(answer):
            if word.startswith("--"):
                words_of_option = options.setdefault(word.removeprefix("--"), [])
            else:
                words_of_option.append(word)
        of_answers.append(options)
    if not of_answers or any(each.keys() != of_answers[0].keys() for each in of_answers):
        return {}
    return {option: words for option, words in of_answers[0].items() if option not in known}
