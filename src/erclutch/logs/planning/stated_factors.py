"""A file may state a factor of its numbers above the rows: whether they have been multiplied already, nobody says."""

from __future__ import annotations

import re

from erclutch.logs.planning.draft import Draft

_CALLED_A_FACTOR = re.compile(
    r"(?:.*\W)?(?:scal(?:e|ing)[ _-]?factors?|multiplier|skalierungsfaktor|skalierung|"
    r"(?:multiplied|divided|scaled|multipliziert|geteilt) (?:by|mit|durch))",
    re.IGNORECASE,
)
_NUMBER = re.compile(r"[xX×*]?\s*\d+(?:\.\d+)?(?:[eE][+-]?\d+)?")


def doubt_numbers_with_a_stated_factor(draft: Draft) -> None:
    """Doubt a guessed effort as logged where a factor without a unit stands above the rows."""
    effort = draft.guessed("effort")
    if effort is None or not effort.column or effort.sureness == "doubtful":
        return
    for key, text in draft.table.metadata.items():
        number = _NUMBER.fullmatch(text.strip())
        if number is None or not _CALLED_A_FACTOR.fullmatch(key):
            continue
        if float(number.group().lstrip("xX×* ")) == 1.0:
            continue
        doubt = f"as logged, and the file says {key} {text.strip()}"
        draft.doubt("effort", f"{doubt}: give --scale for each signal that still wants it")
        return
