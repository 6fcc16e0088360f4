"""What the tests of the laws share: every law in every form, and its columns from field and slip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from erclutch.models.laws import Law, ladder, law_from_name

_FORMS = tuple(
    f"{name}/{form}"
    for name in (
        "bingham",
        "herschel-bulkley",
        "casson",
        "seo-seo",
        "cho-choi-jhon",
        "hem",
        "rbfm-5",
        "eddy-current",
    )
    for form in ("square", "power", "critical")
)
SPECIFICATIONS = tuple(
    dict.fromkeys((*ladder(), *_FORMS, "rbfm-2", "bingham/saturating", "bingham/tanh"))
)


@pytest.fixture(params=SPECIFICATIONS)
def law(request: pytest.FixtureRequest) -> Law:
    return law_from_name(request.param)


@pytest.fixture
def columns() -> Callable[[Law, Any, Any, Sequence[Any]], tuple[Any, ...]]:
    """Columns of one element from field and slip, through the law's stimulus."""

    def of(law: Law, E: Any, w: Any, q: Sequence[Any]) -> tuple[Any, ...]:
        ahead = len(law.stimulus_shape)
        field = E if law.stimulus is None else law.stimulus(E, *q[:ahead])
        return law.columns(field, w, *q[ahead:])

    return of


@pytest.fixture
def point() -> Callable[[Law, Sequence[float]], list[float]]:
    """Shape parameters at shares (0 .. 1) of their range, in the logarithm where they are searched in it."""

    def at(law: Law, shares: Sequence[float]) -> list[float]:
        q: list[float] = []
        for s, share in zip((*law.stimulus_shape, *law.shape), shares, strict=False):
            if s.scale == "log":
                q.append(float(np.exp(np.log(s.lower) + share * np.log(s.upper / s.lower))))
            else:
                q.append(s.lower + share * (s.upper - s.lower))
        return q

    return at
