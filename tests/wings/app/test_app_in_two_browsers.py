"""Two browsers on one app: each sees what the other made, and cancels what the other began."""

from __future__ import annotations

import re
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import pytest

from tests.wings.app.test_app import CHROMIUM, Served, follow, german, open_page, served

__all__ = ["open_page", "served"]

_LAWS = {"bingham": "Bingham law", "quadratic": "Quadratic law in E"}


@pytest.fixture
def pages(served: Served, open_page: Callable[..., Any]) -> Generator[tuple[Any, Any]]:
    """A page in each of two browsers, each a process of its own."""
    page = open_page()
    other = page.context.browser.browser_type.launch(
        executable_path=str(CHROMIUM), args=["--no-sandbox", "--disable-gpu"]
    )
    other_page = other.new_context().new_page()
    other_page.goto(served.url)
    other_page.wait_for_url(f"**{served.base}/")
    yield page, other_page
    other.close()


def runs(page: Any, place: str) -> list[str]:
    """Rows of the runs as the overview has them."""
    page.goto(f"{place}/")
    rows = page.locator("[aria-label=Runs] tbody tr").all_inner_texts()
    return [" ".join(row.split()) for row in rows]


@pytest.mark.slow
def test_both_fit_at_once_and_either_cancels_what_the_other_began(
    pages: tuple[Any, Any], served: Served, tmp_path: Path
) -> None:
    place = f"http://127.0.0.1:{served.port}{served.base}"
    first, second = pages
    first.set_input_files("#file", str(german(tmp_path / "shared.csv")))
    first.wait_for_url("**/log/**")
    first.select_option("[name='column.temperature']", "Temperatur")
    follow(first, "text=Read it so")
    second.goto(first.url)
    for page, law in zip(pages, _LAWS, strict=True):
        for box in page.locator("[name^='model.']:checked").all():
            box.uncheck()
        page.check(f"[name='model.{law}']")
        page.fill("[name=lag]", "none")
    for page in pages:
        page.click("button:has-text('Fit')")
    made: list[str] = []
    for page, title in zip(pages, _LAWS.values(), strict=True):
        page.wait_for_url("**/run/**", timeout=120_000)
        made.append(re.search(r"/run/([^?#]+)", page.url)[1])  # pyright: ignore[reportOptionalSubscript]
        assert f"The only model: {title}, with an RMSE of" in page.locator("main").inner_text()
    assert made[0] != made[1]
    seen = runs(first, place)
    assert seen == runs(second, place)
    for run, title in zip(made, _LAWS.values(), strict=True):
        assert any(row.startswith(f"{run} shared.csv {title} ") for row in seen), seen

    for begins, cancels in (pages, pages[::-1]):
        begins.goto(f"{place}/")
        begins.click("text=Run the digital TWIN live")
        begins.wait_for_url("**/job/**")
        begins.locator("#address a").wait_for(timeout=120_000)
        cancels.goto(begins.url)
        cancels.click("text=Cancel")
        for page in pages:
            # A loop that runs already brings its fields to zero and ends as a whole session; nothing else ends it.
            page.locator("#state.cancelled, #state.done").wait_for(timeout=60_000)
