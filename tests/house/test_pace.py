"""A limit of processor time follows the pace of a slow machine, and no quick machine makes it tighter."""

from __future__ import annotations

import pytest

from tests.support import pace


@pytest.mark.parametrize(
    ("work", "took", "is_within"),
    [
        (0.18, 2.9, True),  # three times slower than usual
        (0.18, 3.1, False),
        (0.02, 1.1, False),
        (0.02, 1.0, True),
    ],
)
def test_a_limit_is_that_of_a_usual_machine(
    monkeypatch: pytest.MonkeyPatch, work: float, took: float, is_within: bool
) -> None:
    monkeypatch.setattr(pace, "_work", lambda: work)
    assert pace.within(took, 1.0) is is_within


def test_a_quick_work_measures_no_pace(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pace, "_work", lambda: pytest.fail("measured"))
    assert pace.within(0.9, 1.0)
