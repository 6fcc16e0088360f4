"""Commands that fit the same log in the same way, of which a test asks something else, fit it once."""

from __future__ import annotations

from typing import Any

import pytest

from erclutch.fit import comparison
from erclutch.fit.comparison import Comparison, compare


def compare_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on each command gets what the first one fitted; rows and settings must be the same."""
    made: list[tuple[bytes, str, Comparison]] = []

    def once(data: Any, settings: Any, *others: Any, **named: Any) -> Comparison:
        if not made:
            found = compare(data, settings, *others, **named)
            made.append((data.effort.tobytes(), repr(settings), found))
        effort, same, found = made[0]
        assert (data.effort.tobytes(), repr(settings)) == (effort, same), "another fit"
        return found

    monkeypatch.setattr(comparison, "compare", once)
