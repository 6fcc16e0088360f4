"""A unit is short: a text of a million letters, as a damaged file has, is refused at once."""

from __future__ import annotations

import time

import pytest

from erclutch.errors import UnitError
from erclutch.signals.units import is_unit, parse, quantity

MANY = 10**6


@pytest.mark.parametrize(
    "letters", ["N", "N m ", "1", "(", "²", "N-", "x10^3 ", "r/", " ", "lb in "]
)
def test_a_text_of_a_million_letters_is_no_unit(letters: str) -> None:
    text = (letters * MANY)[:MANY] + "?"
    began = time.process_time()
    with pytest.raises(UnitError) as caught:
        parse(text)
    assert not is_unit(text)
    assert time.process_time() - began < 1.0
    assert "a unit at most 60" in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("text", ["1" * MANY, "1 a" + " " * MANY + "b", "1 " + "N" * MANY])
def test_a_number_of_a_million_letters_is_no_quantity(text: str) -> None:
    began = time.process_time()
    with pytest.raises(UnitError) as caught:
        quantity(text)
    assert time.process_time() - began < 1.0
    assert len(str(caught.value)) < 400
