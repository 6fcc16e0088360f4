"""An empty row (``;;``) or a rule between names, units and numbers takes no names away. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import read_table
from erclutch.logs.readers.dialect import _RULE

pytestmark = pytest.mark.slow

ROWS = np.column_stack([np.arange(60.0), 5.0 * np.sin(np.arange(60.0) / 9.0), np.arange(60.0) / 7])
PLAIN = {"time": None, "speed": None, "torque": None}
IN_UNITS = {"time": "s", "speed": "rpm", "torque": "Nm"}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("delimiter", [";", ",", "\t"])
@pytest.mark.parametrize(
    ("above", "units"),
    [
        (["time|speed|torque", "||"], PLAIN),
        (["time|speed|torque", "s|rpm|Nm", "||"], IN_UNITS),
        (["time|speed|torque", "(s)|(rpm)|(Nm)", "||", " | | "], IN_UNITS),
        (["time|speed|torque", "||", "s|rpm|Nm", "||"], IN_UNITS),
        (["Test 5||", "Operator: x||", "||", "time|speed|torque", "s|rpm|Nm", "||"], IN_UNITS),
        (['"time"|"speed"|"torque"', '""|""|""'], PLAIN),
        (["||", "time|speed|torque"], PLAIN),
    ],
)
def test_an_empty_row_between_names_and_numbers_is_no_line(
    tmp_path: Path, above: list[str], units: dict[str, str | None], delimiter: str
) -> None:
    path = tmp_path / "log.csv"
    head = "\n".join(above).replace("|", delimiter)
    np.savetxt(path, ROWS, fmt="%.4f", delimiter=delimiter, header=head, comments="")
    table = read_table(path)
    assert dict(table.units) == units
    assert table.rows == len(ROWS)
    assert np.allclose(table.columns["torque"], ROWS[:, 2], atol=1e-4)
    assert not any("no header" in note for note in table.notes)


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("beyond", ["∞", "-∞", "+∞"])
def test_the_readings_of_a_scope_beyond_its_range_are_no_numbers(
    tmp_path: Path, beyond: str
) -> None:
    path = tmp_path / "scope.csv"
    lines = ["Time;Channel A", "(s);(V)", ";"]
    lines += [f"{row / 100};{beyond if row in (20, 21) else row / 7:.6}" for row in range(80)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    table = read_table(path)
    lost = np.flatnonzero(np.isnan(table.columns["Channel A"]))
    assert [*lost] == [20, 21]


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("rule", ["-" * 40, "=" * 12, "___", "*" * 30, "# " + "-" * 20, "~~~~"])
@pytest.mark.parametrize(
    ("above", "units"),
    [
        (["time          speed         torque", "RULE"], PLAIN),
        (
            ["time          speed         torque", "s             rpm           Nm", "RULE"],
            IN_UNITS,
        ),
        (["RULE", "time          speed         torque", "RULE"], PLAIN),
        (["Run 7", "RULE", "time,speed,torque", "RULE", "s,rpm,Nm", "RULE"], IN_UNITS),
    ],
)
def test_a_rule_between_names_and_numbers_is_no_line(
    tmp_path: Path, above: list[str], units: dict[str, str | None], rule: str
) -> None:
    path = tmp_path / "log.txt"
    head = "\n".join(above).replace("RULE", rule)
    delimiter = "," if "," in head else "     "
    np.savetxt(path, ROWS, fmt="%.4f", delimiter=delimiter, header=head, comments="")
    table = read_table(path)
    assert dict(table.units) == units
    assert table.rows == len(ROWS)


def test_rules_take_linear_time() -> None:
    for sign in "-=_*~+.":
        assert not _RULE.fullmatch(sign * 20_000 + "x")
