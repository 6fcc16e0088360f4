"""The built site in a real browser: nothing leaves it, it fits the screen, its search answers, all can read it.

`make docs` builds it.
"""

from __future__ import annotations

import re
from collections.abc import Generator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from tests.support.said_words import SAID, first_pages

ROOT = Path(__file__).resolve().parents[2]
SITE = ROOT / "build" / "docs"
CHROMIUM = Path("/usr/bin/chromium")
QUIET = (
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-sync",
)
LOOKS = [(1440, "light"), (390, "dark")]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not CHROMIUM.exists(), reason="needs chromium: apt install chromium"),
    pytest.mark.skipif(
        not (SITE / "index.html").is_file(), reason="needs the built site: make docs"
    ),
]


@pytest.fixture(scope="module")
def browser() -> Generator[Any, None, None]:
    sync: Any = import_module("playwright.sync_api")
    with sync.sync_playwright() as playwright:
        made = playwright.chromium.launch(
            executable_path=str(CHROMIUM), args=[*QUIET, "--disable-component-update"]
        )
        yield made
        made.close()


def tab(browser: Any, width: int, scheme: str) -> tuple[Any, list[str]]:
    """An empty tab, and what its pages will ask for outside the site or complain about."""
    page = browser.new_context(
        viewport={"width": width, "height": 900}, color_scheme=scheme
    ).new_page()
    said: list[str] = []
    page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: said.append(str(error)))
    inside = (SITE.as_uri(), "data:")
    page.on(
        "request",
        lambda request: None if request.url.startswith(inside) else said.append(request.url),
    )
    return page, said


def opened(browser: Any, address: str, width: int, scheme: str) -> tuple[Any, list[str]]:
    """A page in a tab of its own, and what it asked for outside the site or complained about."""
    page, said = tab(browser, width, scheme)
    page.goto(address)
    return page, said


def test_no_page_asks_anyone_or_is_wider_than_the_screen(browser: Any) -> None:
    pages = sorted(SITE.rglob("*.html"))
    assert len(pages) > 20
    # One tab for all, since each tab starts a process of the browser, and one load for all looks.
    page, said = tab(browser, *LOOKS[0])
    for path in pages:
        page.goto(path.as_uri())
        for width, scheme in LOOKS:
            page.set_viewport_size({"width": width, "height": 900})
            page.emulate_media(color_scheme=scheme)
            assert page.evaluate("document.documentElement.scrollWidth") <= width, (
                f"{path.name} at {width} px"
            )
        assert said == [], path.name
    page.context.close()


def test_nothing_in_the_files_would_load_from_elsewhere() -> None:
    loads = re.compile(
        r"""(?:<(?:script|img|link|iframe)\b[^>]*?(?:src|href)=["']?|url\(["']?|@import\s+["'])(?:https?:)?//"""
    )
    for path in (*SITE.rglob("*.html"), *SITE.rglob("*.css")):
        found = loads.search(path.read_text("utf-8"))
        assert found is None, f"{path.name}: {found and found[0]}"


def test_search_answers_without_a_server(browser: Any) -> None:
    page, said = opened(browser, (SITE / "search.html").as_uri() + "?q=bingham", 1440, "light")
    page.wait_for_selector("#search-results li a", timeout=20_000)
    assert any(
        "The laws" in text for text in page.locator("#search-results li a").all_text_contents()
    )
    assert said == []


def test_the_search_knows_what_users_say(browser: Any) -> None:
    assert len(SAID) >= 30
    page, said = opened(browser, (SITE / "search.html").as_uri(), 1440, "light")
    found = {word: first_pages(page, SITE, word) for word in SAID}
    missed = {word: pages for word, pages in found.items() if not set(pages) & set(SAID[word])}
    assert missed == {}
    assert said == []


def test_equations_are_drawn_and_can_be_heard(browser: Any) -> None:
    page, _ = opened(browser, (SITE / "laws.html").as_uri(), 1440, "light")
    drawn = page.locator("div.drawn")
    assert drawn.count() >= 10
    for i in range(drawn.count()):
        assert drawn.nth(i).locator("svg").bounding_box()["height"] > 10
        assert drawn.nth(i).locator("math").count() == 1


@pytest.mark.parametrize(("width", "scheme"), LOOKS)
@pytest.mark.parametrize("name", ["index", "tour", "laws", "wrong"])
def test_accessible(browser: Any, name: str, width: int, scheme: str) -> None:
    axe: Any = import_module("axe_playwright_python.sync_playwright").Axe()
    page, _ = opened(browser, (SITE / f"{name}.html").as_uri(), width, scheme)
    rules = {"runOnly": ["wcag2a", "wcag2aa"], "resultTypes": ["violations"]}
    found = axe.run(page, options=rules).response["violations"]
    assert [(v["id"], [n["html"][:200] for n in v["nodes"]][:3]) for v in found] == []
