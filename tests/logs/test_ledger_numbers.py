"""Negative numbers in brackets, with their sign behind or apart are read; brackets of another meaning are left."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import ErclutchError
from erclutch.logs import read, read_table
from erclutch.logs.readers.ledger_numbers import with_leading_minus

TIME = np.arange(300) * 0.01
SPEED = 900.0 * np.sin(4.0 * TIME) + 300.0 * np.sin(11.3 * TIME + 1.0)  # mm/s
FORCE = 1500.0 * np.tanh(SPEED / 200.0) + 0.3 * SPEED  # N
CURRENT = np.repeat([0.0, 1.0, 0.5], 100)  # A


def bracketed(value: float) -> str:
    return f"({-value:.3f})" if value < 0 else f"{value:.3f}"


def behind(value: float) -> str:
    return f"{-value:.3f}-" if value < 0 else f"{value:.3f}"


def apart(value: float) -> str:
    return f"{value:.3f}".replace("-", "- ")


def account(value: float) -> str:
    return f'" ({-value:,.2f})"' if value < 0 else f'" {value:,.2f} "'


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("shown", [bracketed, behind, apart, account])
def test_a_negative_number_of_a_ledger_is_read(
    shown: Callable[[float], str], delimiter: str, tmp_path: Path
) -> None:
    lines = [delimiter.join(["Time [s]", "Velocity [mm/s]", "Force [N]", "Current [A]"])]
    for row in zip(TIME, SPEED, FORCE, CURRENT, strict=True):
        lines.append(delimiter.join([f"{row[0]:.2f}", shown(row[1]), shown(row[2]), f"{row[3]}"]))
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    recording = read(path)
    np.testing.assert_allclose(recording.signals["slip"], SPEED / 1e3, atol=1e-5)
    np.testing.assert_allclose(recording.signals["effort"], FORCE, atol=0.01)
    assert any("are negative" in note for note in recording.notes)


@pytest.mark.parametrize(
    "text",
    [
        "a,b\n1,(2)\n3,(4)\n",  # a column of brackets alone
        "(1),(2),(3)\n4,5,6\n7,8,9\n",  # a line that numbers its columns
        "time,torque (1)\n0,1.5\n1,2.5\n",
        "day,x\n2026-12-01,1\n2026-12-02,2\n",
        "a;b\n1;2-3\n2;3-4\n",
        "a\tb\n1\t-\n2\t3\n",
        "(1.5)\n2.5\n",
    ],
)
def test_what_is_no_negative_number_is_left(text: str) -> None:
    assert with_leading_minus(text) == (text, "")


@given(st.text(alphabet='0123456789.,;-() \t\n"a', max_size=200))
def test_no_text_breaks_the_reading(text: str) -> None:
    changed, note = with_leading_minus(text)
    assert changed == text or note


@given(st.text(alphabet='019.,;-() \n"', max_size=60))
def test_no_file_of_such_cells_ends_in_a_traceback(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.mktemp("ledger") / "log.csv"
    path.write_text(text, encoding="utf-8")
    with suppress(ErclutchError):
        read_table(path)


@pytest.mark.parametrize("blank", [" ", "\u00a0", "\u202f"])
@pytest.mark.parametrize("decimal", [",", "."])
def test_blanks_between_thousands_part_no_cells_where_tabs_do(
    blank: str, decimal: str, tmp_path: Path
) -> None:
    """The last rows, all above a thousand, were cut at these blanks into numbers such as 023,4."""
    lines = ["\t".join(["Time [s]", "Velocity [mm/s]", "Force [N]", "Current [A]"])]
    signs = str.maketrans(",.", blank + decimal)
    force = FORCE + 2500.0
    for row in zip(TIME, SPEED, force, CURRENT, strict=True):
        lines.append("\t".join(f"{value:,.3f}".translate(signs) for value in row))
    path = tmp_path / "log.txt"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    recording = read(path)
    np.testing.assert_allclose(recording.signals["effort"], force, atol=0.01)
