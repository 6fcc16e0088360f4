"""Units that stand below the rows, in their order or in a remark, are those of the columns. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path
from time import process_time

import pytest

from erclutch.logs import read_table
from erclutch.logs.readers.told_units import texts_below
from tests.logs.test_units_beside_vectors import LOGGED, assert_read_in_si
from tests.support.pace import within

pytestmark = pytest.mark.usefixtures("read_here")


def _log(folder: Path, *below: str, mark: str = ",") -> Path:
    rows = [mark.join(f"{cell:.12g}" for cell in row) for row in zip(*LOGGED.values(), strict=True)]
    path = folder / "log.csv"
    path.write_text("\n".join([mark.join(LOGGED), *rows, *below, ""]), encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("below", "mark"),
    [
        (("ms,mA,mm/s,kN",), ","),
        (("[ms];[mA];[mm/s];[kN]",), ";"),
        (("", "Units: ms; mA; mm/s; kN"), ","),
        (("", "# units = ms, mA, mm/s, kN"), ","),
        (("", "t in ms, I in mA, v [mm/s], F: force in kN", "end of file"), ","),
    ],
)
def test_units_below_the_rows_are_read(tmp_path: Path, below: tuple[str, ...], mark: str) -> None:
    # The line was left out as one without a number, and numbers in mm/s and kN were taken as logged.
    assert_read_in_si(_log(tmp_path, *below, mark=mark))


@pytest.mark.slow
@pytest.mark.parametrize(
    "below", ["end,of,file", "mA,ms,mm/s,kN", "no,further,rows,here", "ms,mA,mm/s"]
)
def test_other_lines_below_the_rows_tell_none(tmp_path: Path, below: str) -> None:
    assert not any(read_table(_log(tmp_path, below)).units.values())


@pytest.mark.parametrize("sign", "[ _,:;")
def test_long_lines_below_take_no_long_time(sign: str) -> None:
    begin = process_time()
    assert [*texts_below([sign * 20_000])]
    assert within(process_time() - begin, 0.1)
