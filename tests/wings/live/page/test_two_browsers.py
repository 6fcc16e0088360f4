"""Two browsers on one page of a loop: both show its numbers, and each of them stops it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import pytest

from erclutch.wings.live.companions import Observers
from erclutch.wings.live.page_commands import PageCommand
from erclutch.wings.live.ring import State
from tests.wings.live.page.test_browser import _FLAGS as FLAGS
from tests.wings.live.page.test_browser import (
    CHROMIUM,
    PROGRAMS,
    Seen,
    chromium,  # pyright: ignore[reportUnusedImport]
)
from tests.wings.live.page.test_learn_in_browser import Told, opened, until

__all__ = ["chromium"]

pytestmark = [pytest.mark.slow, pytest.mark.timed]
_STOPPED = (
    "/zero field, as ordered, until a reset/i.test(document.getElementById('banner').textContent)"
)
_READY = "document.getElementById('banner').textContent.includes('nothing moves until')"
_RUNS = "document.getElementById('banner').hidden && erclutch.samples > 100"


@pytest.fixture
def browsers(chromium: Any) -> Generator[tuple[Any, Any]]:
    """Two of them, each a process of its own."""
    other = chromium.browser_type.launch(executable_path=str(CHROMIUM), args=FLAGS)
    yield chromium, other
    other.close()


def test_both_show_what_the_ring_holds_and_both_give_commands(
    browsers: tuple[Any, Any], start_loop: Callable[..., Any], tmp_path: Path
) -> None:
    """SYNTHETIC frames: what follows 5 sin(wt) 20 ms late errs by 0.444 rad, as in `test_browser`."""
    loop = start_loop()
    commands: list[PageCommand] = []
    with Observers(
        loop.path,
        commands.append,
        programs=PROGRAMS,
        motor_limit=0.95,
        folder=tmp_path / "recordings",
        lead=0.01,
    ) as observers:
        contexts = [browser.new_context() for browser in browsers]
        pages = [Seen(context.new_page(), observers, commands, loop) for context in contexts]
        for seen in pages:
            seen.until("document.getElementById('error').textContent === '0.444 rad · 0.71 mm'")
            seen.until("document.getElementById('lateness').textContent.includes('p50 30 µs')")
        for seen, key, command in zip(
            pages, ("z", "s"), (PageCommand("zero"), PageCommand("program", 1.0)), strict=True
        ):
            seen.page.keyboard.press(key)
            assert seen.command() == command
        loop.writer.put(state=State.TRIPPED, trip_reason=1)
        for seen in pages:
            seen.until(
                "document.getElementById('banner').textContent.includes('Tripped by sample-lost')"
            )
        contexts[0].close()  # whoever leaves takes nothing from the other one
        samples = pages[1].page.evaluate("erclutch.samples")
        pages[1].until(f"erclutch.samples > {samples + 300}")
        assert commands == []
        assert [seen.errors for seen in pages] == [[], []]
        contexts[1].close()


def test_a_stop_of_either_browser_takes_a_real_loop_to_zero_field(
    browsers: tuple[Any, Any], tmp_path: Path
) -> None:
    """TWIN: one zeroes the fields, the other resets and runs; then the other way round."""
    words = [sys.executable, "-m", "erclutch", "live", "--no-model"]
    shown = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        words, cwd=tmp_path, env=shown, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as command:
        told = Told(command)
        try:
            url = told.after("page:")
            first, second = (browser.new_context().new_page() for browser in browsers)
            for page in (first, second):
                opened(page, url)
                until(page, _RUNS)
            for stops, goes_on in ((first, second), (second, first)):
                stops.click("#zero")
                until(goes_on, _STOPPED)
                until(stops, _STOPPED)
                goes_on.click("#reset")
                until(stops, _READY)
                goes_on.click("#program-form button")
                for page in (stops, goes_on):
                    until(page, _RUNS)
        finally:
            told.end()
    assert command.returncode == 0
    assert sum(line.strip().startswith("order") for line in told.lines) >= 1, told.lines
