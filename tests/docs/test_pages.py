"""What the pages say about commands, laws and names agrees with the code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import erclutch
from docs._ext.pictures import kept_as
from erclutch.models.laws import families, law_from_name, shown_of

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if "decisions" not in page.parts)


def test_every_law_has_its_generated_equation() -> None:
    """The page takes all laws from the registry; each must say what the page shows."""
    assert "```{laws}" in (DOCS / "laws.md").read_text("utf-8")
    for name, family in families().items():
        assert all((family.about, family.formula, family.curves)), name
        law = law_from_name(shown_of(name, family)[0])
        drawn = {pair.partition("=")[0] for pair in family.curves.split()}
        assert drawn == {p.name for p in (*law.stimulus_shape, *law.shape, *law.gains)}, name


def test_every_name_of_the_package_is_in_the_reference() -> None:
    index = (DOCS / "api" / "index.md").read_text("utf-8")
    for name in erclutch.__all__:
        assert name == "__version__" or f"`{name}`" in index, name


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_every_command_named_exists(page: Path) -> None:
    from erclutch.cli import app

    text = page.read_text("utf-8")
    for command in set(re.findall(r"(?:^|`)erclutch ([a-z][\w-]*)", text, re.MULTILINE)):
        assert command in app, command
    for script in set(re.findall(r"`((?:studies|benchmarks)/\w+\.py)`", text)):
        assert (DOCS.parent / script).is_file(), script
    makefile = (DOCS.parent / "Makefile").read_text("utf-8")
    for target in set(re.findall(r"`make (\w+)`", text)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_each_picture_of_the_site_is_a_file_of_its_own() -> None:
    """Runs side by side draw pictures of one name: one must not take the other's place."""
    kept = [
        kept_as(page.relative_to(DOCS).with_suffix("").as_posix(), picture)
        for page in PAGES
        for pictures in re.findall(r"^```\{picture\} (.*)$", page.read_text("utf-8"), re.MULTILINE)
        for picture in pictures.split()
    ]
    assert {"hysteresis-without-loops.png", "hysteresis-with-loops.png"} <= set(kept)
    assert len(set(kept)) == len(kept)
