"""Of a test that runs for many values: a few of them in the fast tests, all of them in CI."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def slow_but(quick: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """Values for ``parametrize``; those that are not among the quick ones are marked slow."""
    return [
        value if value in quick else pytest.param(value, marks=pytest.mark.slow) for value in values
    ]


def slow_behind(count: int, values: Iterable[Any]) -> list[Any]:
    """Values for ``parametrize``; those behind the first ``count`` are marked slow.

    A tuple stands for several arguments; for one argument that is a tuple take `slow_but`.
    """
    marked = [*values]
    for place, value in enumerate(marked[count:], start=count):
        arguments = value if isinstance(value, tuple) else (value,)
        marked[place] = pytest.param(*arguments, marks=pytest.mark.slow)
    return marked
