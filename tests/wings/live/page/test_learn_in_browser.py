"""Rounds of ``live --program learn`` in a real browser: after a fault, Run on the page goes on with the next round."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

from tests.wings.live.page.test_browser import chromium  # noqa: F401  # pyright: ignore[reportUnusedImport]
from tests.wings.live.test_learn import served_brake

pytestmark = [pytest.mark.slow, pytest.mark.timed]
_PATIENCE = 120.0  # s, of a busy machine


@pytest.fixture
def failing_rig() -> Generator[int]:
    """Port of a brake whose encoder fails in the middle of the first round."""
    with served_brake(fails=True) as brake:
        yield brake.port


class Told:
    """What a command prints, line by line."""

    def __init__(self, command: subprocess.Popen[str]) -> None:
        self.lines: list[str] = []
        self._command = command
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        assert self._command.stdout is not None
        for line in self._command.stdout:
            self.lines.append(line.rstrip())

    def end(self) -> None:
        """Interrupt the command, and read to its end."""
        self._command.send_signal(signal.SIGINT)
        self._thread.join()

    def after(self, beginning: str) -> str:
        """The rest of the line that begins so; waits for it."""
        limit = time.monotonic() + _PATIENCE
        while time.monotonic() < limit:
            for line in list(self.lines):
                if line.startswith(beginning):
                    return line.removeprefix(beginning).strip()
            time.sleep(0.05)
        raise AssertionError((beginning, self.lines))


def opened(page: Any, url: str) -> None:
    page.goto(url)
    page.wait_for_url(re.compile(r"/\d+-[\w-]+/$"))  # the key leaves the address


def until(page: Any, condition: str) -> None:
    limit = time.monotonic() + _PATIENCE
    while not page.evaluate(condition):
        assert time.monotonic() < limit, (condition, page.text_content("#banner"))
        page.wait_for_timeout(50)


def reset(page: Any) -> None:
    """Click on Reset until the loop takes it: as long as the encoder says nothing, half a second, it must refuse."""
    limit = time.monotonic() + _PATIENCE
    while "nothing moves until" not in page.text_content("#banner"):
        assert time.monotonic() < limit, page.text_content("#banner")
        page.evaluate(
            "const button = document.getElementById('reset'); if (!button.hidden) button.click();"
        )
        page.wait_for_timeout(200)


def test_run_on_the_page_goes_on_with_the_next_round(
    chromium: Any,  # noqa: F811
    failing_rig: int,
    tmp_path: Path,
) -> None:
    rig = (
        "--rig",
        "udp",
        "--address",
        f"127.0.0.1:{failing_rig}",
        "--session",
        "7",
        "--device",
        "single",
    )
    rounds = ("--program", "learn", "--seconds", "4", "--round", "2", "--folder", "logs")
    words = [sys.executable, "-m", "erclutch", "live", *rig, *rounds]
    shown = {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        words, cwd=tmp_path, env=shown, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as command:
        told = Told(command)
        try:
            page = chromium.new_context().new_page()
            opened(page, told.after("page of round 1:"))
            until(
                page,
                "/zero field until a reset/i.test(document.getElementById('banner').textContent)",
            )
            reset(page)
            page.click("#program-form button")
            opened(page, told.after("page of round 2:"))
            until(page, "erclutch.samples > 100")
        finally:
            told.end()
    assert "round 1: " in "\n".join(told.lines)
