"""A unit may be the share of a number: ``% of 3000 rpm``."""

from __future__ import annotations

import pytest

from erclutch.logs.columns.labels import split_label
from erclutch.signals import units


@pytest.mark.parametrize(
    ("written", "number", "unit"),
    [
        ("% of 3000 rpm", 30.0, "rpm"),
        ("%3000 rpm", 30.0, "rpm"),
        ("% von 10 Nm", 0.1, "N*m"),
        ("% 2A", 0.02, "A"),
        ("100% = 2.5 kV/mm", 0.025, "kV/mm"),
    ],
)
def test_a_share_of_a_stated_number_has_its_unit(written: str, number: float, unit: str) -> None:
    share = units.parse(written)
    whole = units.parse(unit)
    assert share.dimension == whole.dimension
    assert share.factor == pytest.approx(number * whole.factor)


def test_a_share_in_round_brackets_is_the_unit_of_its_column() -> None:
    """Percents of 3000 rpm were read in rpm, in silence."""
    assert split_label("Speed (% of 3000 rpm)") == ("Speed", "% of 3000 rpm")


def test_a_share_of_what_nobody_states_is_no_unit() -> None:
    assert not units.is_unit("% of full scale")
    assert not units.is_unit("of 3000 rpm")
