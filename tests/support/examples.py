"""How many examples Hypothesis draws: all in CI, a fifth where somebody waits for the fast tests."""

from __future__ import annotations

import os

# `tests/house/test_wings_off.py` runs tests again of which CI has drawn all examples before.
_ALL = os.environ.get("ERCLUTCH_NO_SKIP") == "1" and "ERCLUTCH_FEW_EXAMPLES" not in os.environ


def examples(count: int) -> int:
    """Of so many examples in CI, those of this run."""
    return count if _ALL else min(count, max(count // 5, 10))
