"""The page of `erclutch live --explain-page` answers as the native C does, and a reset starts nothing."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from erclutch.cli import app
from erclutch.errors import RunError
from erclutch.wings.live.explained_states import transitions
from erclutch.wings.live.state_explorer import SETTINGS, write_explorer
from tests.wings.live.page.test_browser import _FLAGS, CHROMIUM


def test_a_page_is_an_html_file(tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"ends in \.html"):
        write_explorer(tmp_path / "states.txt")


@pytest.mark.slow
def test_tripped_reset_nothing_moves_run_and_each_answer_is_the_native_core_s(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="pip install ziglang")
    if not CHROMIUM.exists():
        pytest.skip(f"needs {CHROMIUM}: apt install chromium")
    from playwright.sync_api import sync_playwright

    file = tmp_path / "states.html"
    assert app(["live", "--explain-page", str(file)], exit_on_error=False, result_action="return_value") == 0
    errors: list[str] = []
    requests: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(CHROMIUM), args=_FLAGS)
        page: Any = browser.new_page()
        page.on("console", lambda message: errors.append(message.text))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.goto(file.as_uri())
        page.wait_for_selector("#log li")
        rows = page.eval_on_selector_all("#answers tr", "rows => rows.map(r => [...r.cells].map(c => c.textContent))")
        native = [
            [t.state.name.lower(), t.event, t.next.name.lower(), t.field, ", ".join(t.said)]
            for t in transitions(SETTINGS)
        ]
        assert rows == native

        def press(name: str) -> str:
            page.get_by_role("button", name=name, exact=True).focus()
            page.keyboard.press("Enter")
            return page.text_content("#log li:first-child")

        assert "running" in press("100 good samples")
        assert "→ tripped: order; fields 0.000 and 0.000" in press("order: zero fields")
        assert "→ tripped: order-refused" in press("order: run a program")
        assert "→ ready: order; fields 0.000 and 0.000" in press("order: reset")
        assert press("100 good samples").endswith("ready → ready; fields 0.000 and 0.000")  # nothing moves
        assert page.text_content("#states .now text") == "ready"
        assert "ready → running: order" in press("order: run a program")
        assert not press("100 good samples").endswith("fields 0.000 and 0.000")
        axe: Any = import_module("axe_playwright_python.sync_playwright")
        for width, scheme in ((390, "light"), (1440, "dark")):
            page.emulate_media(color_scheme=scheme)
            page.set_viewport_size({"width": width, "height": 900})
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert axe.Axe().run(page).response["violations"] == []
            page.screenshot(path=str(tmp_path / f"{width}.png"), full_page=True)
        browser.close()
    assert errors == []
    assert requests == [file.as_uri()]
