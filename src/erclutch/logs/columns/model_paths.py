"""Names may be paths through a model, as ControlDesk and dSPACE write them: the last part is the name of the signal."""

from __future__ import annotations

import re
from collections.abc import Sequence

_PATH = re.compile(
    r'"?(?:[^/]+/)+"?([^/]*[^/"])"?/"?(?:(?:Out|In)\d*|Value)"?(?:\[0\])?', re.IGNORECASE
)
_IN_A_MODEL = re.compile(r'"?(?:Platform\(\)://)?Model Root/(?:[^/]+/)*"?([^/"]+)"?', re.IGNORECASE)


def ends_of_paths(labels: Sequence[tuple[str, str | None, str]]) -> list[str]:
    """Labels without the way through a model and the port behind it: ``Torque`` for ``Model Root/Sensors/Torque/Out1``.

    As they were where that leaves two labels the same, or no two are such paths.

    Args:
        labels: name, unit and whole label of each column.
    """
    ends: list[str] = []
    paths = 0
    for name, unit, label in labels:
        with_port = _PATH.fullmatch(label)
        match = with_port or _IN_A_MODEL.fullmatch(name)
        if match is None:
            ends.append(label)
            continue
        paths += 1
        ends.append(match[1] if with_port or not unit else f"{match[1]} [{unit}]")
    return ends if paths > 1 and len({*ends}) == len(labels) else [label for _, _, label in labels]
