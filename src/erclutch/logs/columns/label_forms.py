"""All labels of a file may have their units in an unusual place: ``[A] Current``, ``Current:A``, ``('Current', 'A')``.

They are put into the usual form, ``Current [A]``, where all labels have the one form: a single label may be a name.
The time may have none.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from erclutch.signals import units

_LONGEST = 200  # letters of such a label
#: Each with the name and the unit.
_FORMS = (
    re.compile(r"\[(?P<unit>[^\[\]]*)\]\s*(?P<name>[^\[\]]*[^\W\d_][^\[\]]*)"),
    re.compile(r"\((?P<unit>[^()]*)\)\s*(?P<name>[^()]*[^\W\d_][^()]*)"),
    re.compile(r"(?P<name>[^\W\d][^:\[\](]*?)\s*:\s*(?P<unit>[^:\s]+)"),
    re.compile(r"(?P<name>[^\W\d][^\[\](]*?)-(?P<unit>[^\s\-]+)"),
    re.compile(r"\(\s*u?'(?P<name>[^']+)'\s*,\s*u?'(?P<unit>[^']*)'\s*\)"),
    re.compile(r"(?P<name>[^{}]+?)\s*\{\s*unit\s*[=:]\s*[\"']?(?P<unit>[^{}\"']*)[\"']?\s*\}"),
)
_NO_UNITS = frozenset(("", "-", "1", "none", "n/a"))
#: Labels of rows, which need no unit.
_OF_ROWS = frozenset(("", "t", "time", "timestamp", "date", "datetime", "index", "zeit", "temps"))
_FEWEST = 2  # labels with a unit


def in_usual_form(labels: Sequence[str]) -> list[str]:
    """The labels with their units behind them, where all have one of the other forms; else as they are."""
    if len(labels) < _FEWEST or any(len(label) > _LONGEST for label in labels):
        return [*labels]
    for form in _FORMS:
        pairs: list[tuple[str, str]] = []
        for label in labels:
            match = form.fullmatch(label.strip())
            if match:
                pairs.append((match["name"].strip(), match["unit"].strip()))
            elif label.strip().lower() in _OF_ROWS:
                pairs.append((label, ""))
        if len(pairs) < len(labels):
            continue
        with_unit = [unit for _, unit in pairs if unit.lower() not in _NO_UNITS]
        are_units = all(map(units.is_known_unit, with_unit))
        # Two labels of one unit may be two of one kind: motor:A and motor:B are none.
        if len(with_unit) >= _FEWEST and len({*with_unit}) > 1 and are_units:
            return [f"{name} [{unit}]" if unit in with_unit else name for name, unit in pairs]
    return [*labels]
