"""The pages in the user's way are few words and short; what was measured and decided stands behind them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.support.docs_parts import parts, users_way, words

DOCS = Path(__file__).resolve().parents[2] / "docs"
MOST, LONGEST = 35_000, 2_000


def test_every_page_is_in_a_part() -> None:
    listed = {page for pages in parts(DOCS).values() for page in pages}
    below = {
        page
        for page in DOCS.rglob("*.md")
        if "decisions" not in page.parts and page.parent.name != "_ext"
    }
    assert below - listed == {DOCS / "index.md"}


def test_the_users_way_is_short() -> None:
    assert sum(map(words, users_way(DOCS))) <= MOST


@pytest.mark.parametrize(
    "page", [p for pages in parts(DOCS).values() for p in pages], ids=lambda page: page.stem
)
def test_no_page_is_long(page: Path) -> None:
    assert words(page) <= LONGEST


def test_histories_stand_behind_the_way() -> None:
    """A table of what was measured once belongs to the decision that it led to."""
    for page in users_way(DOCS):
        text = page.read_text("utf-8")
        assert len(re.findall(r"measured\s+once", text, re.IGNORECASE)) <= 8, page.name
