"""The pages in the user's way are few words and short; what was measured and decided stands behind them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
#: Parts of the site that are no user's way: for authors of packages, and for who asks why.
BEHIND = ("Extend", "Decisions and measurements")
MOST, LONGEST = 35_000, 2_000


def parts() -> dict[str, list[Path]]:
    """Pages by the caption of their part."""
    found: dict[str, list[Path]] = {}
    for block in re.findall(r"```{toctree}\n(.*?)```", (DOCS / "index.md").read_text("utf-8"), re.DOTALL):
        caption = re.search(r":caption: (.+)", block)
        assert caption is not None
        names = [line.strip() for line in block.splitlines() if line.strip() and not line.startswith(":")]
        found[caption[1]] = [path for name in names for path in sorted(DOCS.glob(f"{name}.md"))]
    found["Look up"] += sorted((DOCS / "api").glob("[!i]*.md"))
    return found


def words(page: Path) -> int:
    return len(page.read_text("utf-8").split())


def test_every_page_is_in_a_part() -> None:
    listed = {page for pages in parts().values() for page in pages}
    below = {page for page in DOCS.rglob("*.md") if "decisions" not in page.parts and page.parent.name != "_ext"}
    assert below - listed == {DOCS / "index.md"}


def test_the_users_way_is_short() -> None:
    way = [page for caption, pages in parts().items() if caption not in BEHIND for page in pages]
    assert sum(map(words, [*way, DOCS / "index.md"])) <= MOST


@pytest.mark.parametrize("page", [p for pages in parts().values() for p in pages], ids=lambda page: page.stem)
def test_no_page_is_long(page: Path) -> None:
    assert words(page) <= LONGEST


def test_histories_stand_behind_the_way() -> None:
    """A table of what was measured once belongs to the decision that it led to."""
    for caption, pages in parts().items():
        for page in pages:
            if caption not in BEHIND:
                text = page.read_text("utf-8")
                assert len(re.findall(r"measured\s+once", text, re.IGNORECASE)) <= 8, page.name
