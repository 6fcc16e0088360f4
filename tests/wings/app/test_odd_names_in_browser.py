"""Names of strangers' files in the app, in a real browser: no script runs, and the page keeps its width."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from tests.wings.app.test_app import Served, open_page, served

__all__ = ["open_page", "served"]

NAMES = (
    "W" * 240 + ".csv",
    "<img src=x onerror=window.pwned=1>.csv",
    "W" * 116 + ".csv",
    "\u202ex.csv",
)


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1440])
def test_the_overview_keeps_its_width(
    width: int, served: Served, open_page: Callable[..., Any]
) -> None:
    for name in NAMES:
        (served.folder / name).write_text("t [s],F [N]\n0,1\n0.1,2\n", encoding="utf-8")
    page = open_page(width)
    page.wait_for_selector("text=Not shown for their names")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate("window.pwned === undefined && document.images.length === 0")


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1440])
def test_tags_of_a_run_leave_room_for_what_it_found(
    width: int, served: Served, open_page: Callable[..., Any]
) -> None:
    """The model and its error stood some thousand pixels beside the page."""
    run = served.folder / "tagged"
    run.mkdir(exist_ok=True)
    (run / "run.json").write_text("{}", encoding="utf-8")
    said = {"tags": ",".join(map(str, range(500)))}
    (run / "about.json").write_text(json.dumps(said), encoding="utf-8")
    page = open_page(width)
    box = page.locator(".tags").bounding_box()
    assert box["width"] < 300
    assert box["height"] < 60
