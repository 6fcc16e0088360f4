"""Names of strangers' files in the app, in a real browser: no script runs, and the page keeps its width."""

from __future__ import annotations

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
