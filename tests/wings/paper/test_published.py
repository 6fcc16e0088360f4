"""The figures of `paper.published` are those that the paper prints, held to its text."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from erclutch.wings.paper.published import APPROACHES, WARMING

TEXT = (
    Path(__file__).resolve().parents[3].parent
    / "shared"
    / "paper"
    / "huang-ishikawa-er-clutch-torque.txt"
)


@pytest.fixture(scope="module")
def text() -> str:
    if not TEXT.is_file():
        pytest.skip(f"needs the text of the paper beside the project: {TEXT}")
    return TEXT.read_text(encoding="utf-8")


def printed(text: str, table: str) -> dict[str, tuple[float, float]]:
    """Rows of a table: the approach, without its reference, and its two numbers."""
    body = text.split(f"\nTABLE {table}\n")[1].split("\n\n\n")[0]
    rows = re.findall(r"^([A-Z][^\t\n]*)\t([\d.e+-]+)\t([\d.e+-]+)$", body, re.MULTILINE)
    return {
        re.sub(r" \[\d+\]$", "", name): (float(first), float(second))
        for name, first, second in rows
    }


def test_tables_two_and_three_are_those_of_the_paper(text: str) -> None:
    assert {a.title: (a.train, a.test) for a in APPROACHES.values()} == printed(text, "II")
    third = {
        a.title: (a.zero_field, a.zero_motion)
        for a in APPROACHES.values()
        if a.zero_field is not None
    }
    assert third == printed(text, "III")


def test_the_warming_is_that_of_the_paper(text: str) -> None:
    assert f"around {WARMING:g}°C , confirming that the temperature variation was minimal" in text
