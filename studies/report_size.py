"""How long a report is, and how soon it is there: screens, words, bytes, seconds, fill of pages, and what axe finds.

    python studies/report_size.py RUN        RUN is a run folder, such as that of docs/tour.md

A screen is 900 px high at a width of 1440 px, and 844 px at 390 px. The fill of a page of the PDF is the place of its
lowest ink, which pdftoppm (poppler-utils) finds. Prints JSON.
"""

from __future__ import annotations

import argparse
import json
import re
import tempfile
import time
from pathlib import Path
from typing import Any

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright

from erclutch.report.html.printed_page import print_report
from erclutch.report.html.report_page import write_report
from erclutch.report.numbers.run_material import material_of
from erclutch.runs.run_folder import read_run
from tests.support.page_fill import page_fills

CHROMIUM = "/usr/bin/chromium"
QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
)
SCREENS = ((1440, 900), (390, 844))


def measured(page_file: Path) -> dict[str, Any]:
    """Screens, words and findings of axe, in light and dark."""
    found: dict[str, Any] = {}
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        for width, height in SCREENS:
            for scheme in ("light", "dark"):
                context = browser.new_context(
                    viewport={"width": width, "height": height}, color_scheme=scheme
                )
                page = context.new_page()
                page.goto(page_file.as_uri())
                page.wait_for_selector("#traces-plot[data-ready=yes]")
                found[f"screens at {width}"] = round(
                    page.evaluate("document.documentElement.scrollHeight") / height, 2
                )
                found["words"] = len(page.evaluate("document.body.innerText").split())
                found[f"axe at {width}, {scheme}"] = [
                    v["id"] for v in Axe().run(page).response["violations"]
                ]
                context.close()
        browser.close()
    return found


def main() -> None:
    """See the module."""
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("run", type=Path)
    run = arguments.parse_args().run
    began = time.process_time()
    material = material_of(read_run(run))
    with tempfile.TemporaryDirectory() as folder:
        path = write_report(material, Path(folder, "report.html"))
        seconds = time.process_time() - began
        printed = print_report(material, Path(folder, "report.pdf"))
        pdf = printed.read_bytes()
        found = {
            "seconds of processor time": round(seconds, 2),
            "kB": round(path.stat().st_size / 1000),
            "pages of the PDF": len(re.findall(rb"/Type /Page\b", pdf)),
            "fill of each page": page_fills(printed),
            "PDF is tagged": b"/Marked true" in pdf,
            **measured(path),
        }
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
