"""What a reader makes of a table before it is read takes the time of its length, however it is written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, plan_of
from erclutch.logs.log_file import finished, read_table
from erclutch.logs.readers.keyed_heads import with_keyed_heads
from erclutch.logs.readers.numerals import with_plain_digits
from erclutch.logs.readers.pivoted_tables import with_pivoted_heads
from erclutch.logs.readers.spread_cells import without_spread_in_cells
from erclutch.logs.readers.titled_blocks import may_hold_titles, titled_blocks
from erclutch.logs.readers.unit_cells import without_units_in_cells
from erclutch.logs.table import Table
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


@pytest.mark.parametrize(
    "line",
    [
        "Test" + " " * SIZE + "1 x",
        "Test 1 " + "-" * SIZE + "x",
        "#" * SIZE + "Test 1",
        "= " * (SIZE // 2) + "1",
    ],
    ids=["blanks inside", "a line inside", "marks of a comment", "an underline"],
)
def test_a_line_that_may_be_a_title_takes_the_time_of_its_length(line: str) -> None:
    begun = process_time()
    may_hold_titles(line.encode() * 3)
    titled_blocks([line, "1,2", "2,3", "3,4"] * 2, lambda each: each[0].isdecimal())
    assert within(process_time() - begun, MOST_SECONDS)


@pytest.mark.slow
@pytest.mark.parametrize("text", ["1" + " " * SIZE + "x", "1" * SIZE + "x"])
def test_a_remark_of_a_field_takes_the_time_of_its_length(text: str) -> None:
    columns = {"w": np.arange(9.0), "torque": np.arange(9.0) ** 2}
    table = Table("a.csv", columns, dict.fromkeys(columns), "", metadata={"Command": text})
    begun = process_time()
    plan_of(table, ColumnMap())
    assert within(process_time() - begun, MOST_SECONDS)


@pytest.mark.parametrize("part", ["nenn", "torque rated_", "% rated ", "a/", "M [", "x, "])
def test_a_name_that_nobody_reads_is_refused_at_once(tmp_path: Path, part: str) -> None:
    """To understand a name takes the square of its length: 20,000 letters took 7 s."""
    log = tmp_path / "log.csv"
    rows = "".join(f"{k / 100}\t{k % 7}\t{k % 5}\n" for k in range(40))
    log.write_text(
        f"t [s]\tw [rad/s]\ttorque {part * (20_000 // len(part))}\n{rows}", encoding="utf-8"
    )
    begun = process_time()
    with pytest.raises(
        LogError, match=r"log.csv: the name of a column begins with 'torque .*1,000"
    ):
        read_table(log)
    assert within(process_time() - begun, 5.0 * MOST_SECONDS)


def test_a_long_name_of_a_matlab_table_is_refused_too(tmp_path: Path) -> None:
    columns = {"t": np.arange(9.0), "w" * 1001: np.arange(9.0)}
    table = Table("a.mat", columns, dict.fromkeys(columns), "")
    with pytest.raises(LogError, match=r"a.mat: the name of a column .* has 1,001 letters"):
        finished(table, (), tmp_path / "a.mat")
