"""The pages of the site by the part that they stand in, as the tree of the first page says."""

from __future__ import annotations

import re
from pathlib import Path

#: Parts that are no user's way: for authors of packages, and for who asks why.
BEHIND = ("Extend", "Decisions and measurements")


def parts(docs: Path) -> dict[str, list[Path]]:
    """Pages by the caption of their part."""
    found: dict[str, list[Path]] = {}
    for block in re.findall(
        r"```{toctree}\n(.*?)```", (docs / "index.md").read_text("utf-8"), re.DOTALL
    ):
        caption = re.search(r":caption: (.+)", block)
        assert caption is not None
        names = [
            line.strip() for line in block.splitlines() if line.strip() and not line.startswith(":")
        ]
        found[caption[1]] = [path for name in names for path in sorted(docs.glob(f"{name}.md"))]
    found["Look up"] = [*found.get("Look up", []), *sorted((docs / "api").glob("[!i]*.md"))]
    return found


def users_way(docs: Path) -> list[Path]:
    """The pages that a user may meet on the way to a model, the first page too."""
    return [
        *(
            page
            for caption, pages in parts(docs).items()
            if caption not in BEHIND
            for page in pages
        ),
        docs / "index.md",
    ]


def words(page: Path) -> int:
    """Words of a page, its code included."""
    return len(page.read_text("utf-8").split())
