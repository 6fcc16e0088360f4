"""How many examples Hypothesis draws: all in CI, a third where somebody waits for the fast tests."""

from __future__ import annotations

import os

_ALL = os.environ.get("ERCLUTCH_NO_SKIP") == "1"


def examples(count: int) -> int:
    """Of so many examples in CI, those of this run."""
    return count if _ALL else max(count // 3, 10)
