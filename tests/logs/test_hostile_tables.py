"""What a reader makes of a table before it is read takes the time of its length, however it is written."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time

import pytest

from erclutch.logs.readers.keyed_heads import with_keyed_heads
from erclutch.logs.readers.numerals import with_plain_digits
from erclutch.logs.readers.pivoted_tables import with_pivoted_heads
from erclutch.logs.readers.spread_cells import without_spread_in_cells
from erclutch.logs.readers.unit_cells import without_units_in_cells
from tests.support.pace import within

MOST_SECONDS = 1.0  # of the processor; texts of the square of their length take minutes
SIZE = 100_000  # characters, about
ROWS = "1,2,3\n2,3,4\n3,4,5\n"
HOSTILE = {
    "tabs before a bracket": "\t" * SIZE + "(\n" * 5,
    "blanks before a bracket": ("1" + " " * SIZE + "(2\n") * 2 + "1 (0.1)\n" * 5,
    "digits before a bracket": "1" * SIZE + "(\n" + "1 (0.1)\n" * 5,
    "brackets": "1 (" * (SIZE // 3) + "\n1 (0.1)" * 5,
    "a corner of blanks": "a" + " " * 16_000 + "b\\c,1,2\n" + ROWS,
    "a corner of strokes": "\\ " * 8_000 + ",1,2\n" + ROWS,
    "keys": "Kanal;a;b\n" + "Einheit;A;V\n" * (SIZE // 12),
    "digits of another script": "\u0661\u066b" * (SIZE // 2),
    "units that nobody knows": "time,x\n" + "".join(f"{k},5 zz{k}\n" for k in range(SIZE // 10)),
    "units of many cells": "time,x\n"
    + "".join(f"{k},{k} {'mA' if k % 2 else 'A'}\n" for k in range(SIZE // 10)),
}
CHANGES = (
    with_keyed_heads,
    with_pivoted_heads,
    with_plain_digits,
    without_spread_in_cells,
    without_units_in_cells,
)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE.keys())
def test_a_hostile_table_takes_the_time_of_its_length(
    change: Callable[[str], tuple[str, str]], text: str
) -> None:
    begun = process_time()
    change(text)
    assert within(process_time() - begun, MOST_SECONDS)
