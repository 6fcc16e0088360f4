"""What a folder of the app with very many runs is in a real browser. SYNTHETIC.

    python studies/many_runs.py [--runs 1000000] [--where FOLDER]

Each run is a record in a folder of its own. The last one is of a real fit: it must be the first row, with its error.
Two browsers look at the folder, one after the other and then at once; one fits again, the other must see that run.
Printed are seconds by the clock, seconds of processor of the app, bytes of its memory, and what stands on the page.
Needs Chromium, and some 10 GB of disk for 10^6 runs.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.hostile import fitted, make_runs

CHROMIUM = "/usr/bin/chromium"
PATIENCE = 600_000.0  # ms
ROWS = "document.querySelectorAll('[aria-label=Runs] tbody tr').length"


class App:
    """A running `erclutch app`, and what it has cost."""

    def __init__(self, folder: Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "erclutch", "app", str(folder)],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().strip()

    def seconds(self) -> float:
        """Of processor until now."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def mebibytes(self) -> int:
        """Of memory, the most until now."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        found = re.search(r"VmHWM:\s+(\d+)", status)
        assert found is not None
        return int(found[1]) // 1024


def told(app: App, what: str, look: Any) -> None:
    """A row of the table: what a look took."""
    began, before = time.monotonic(), app.seconds()
    seen = look()
    took, cost = time.monotonic() - began, app.seconds() - before
    print(f"| {what} | {took:.1f} | {cost:.1f} | {app.mebibytes()} | {seen} |", flush=True)


def shown(page: Any) -> str:
    """What a page says: how many runs it leaves out, its rows, and the first of them."""
    note = page.locator("#left-out").inner_text() if page.locator("#left-out").count() else ""
    first = page.locator("[aria-label=Runs] tbody tr").first.inner_text()
    return f"{note} {page.evaluate(ROWS)} rows, the first: {' '.join(first.split())}".strip()


def main() -> int:
    """Make the runs, look at them, print the table; 1 if a page does not show the newest run."""
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=1_000_000)
    parser.add_argument("--where", type=Path, help="a folder in which the runs are made")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=asked.where) as name:
        folder = Path(name)
        began = time.monotonic()
        make_runs(folder, asked.runs)
        fitted(folder)
        print(f"{asked.runs:,} runs made in {time.monotonic() - began:.0f} s, and a fit, `run`")
        app = App(folder)
        print("| look | seconds | of processor | memory [MiB] | what is seen |")
        print("| --- | ---: | ---: | ---: | --- |")
        with sync_playwright() as playwright:
            browsers = [
                playwright.chromium.launch(
                    executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
                )
                for _ in range(2)
            ]
            first, second = (browser.new_context().new_page() for browser in browsers)
            for page in (first, second):
                page.set_default_timeout(PATIENCE)

            def enters(page: Any) -> str:
                page.goto(app.url)
                page.wait_for_selector("#drop")
                return shown(page)

            def looks_again(page: Any) -> str:
                page.reload()
                page.wait_for_selector("#drop")
                return shown(page)

            def fits(page: Any) -> str:
                page.click("a:text-is('log.csv')")
                page.wait_for_selector("[name^='model.']")
                for box in page.locator("[name^='model.']:checked").all():
                    box.uncheck()
                page.check("[name='model.bingham']")
                page.fill("[name=lag]", "none")
                page.click("button:has-text('Fit')")
                page.wait_for_url("**/run/**")
                return page.url.rpartition("/")[2]

            told(app, "one browser enters", lambda: enters(first))
            told(app, "it looks again", lambda: looks_again(first))
            told(app, "another enters", lambda: enters(second))
            told(app, "one fits", lambda: fits(first))
            told(app, "the other looks", lambda: looks_again(second))
            newest = " ".join(
                second.locator("[aria-label=Runs] tbody tr").first.inner_text().split()
            )
            for browser in browsers:
                browser.close()
        app.process.terminate()
        app.process.wait()
        print(f"removing {asked.runs:,} runs")
    return 0 if newest.startswith("log-run") else 1


if __name__ == "__main__":
    raise SystemExit(main())
