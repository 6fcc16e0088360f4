"""The report for print: a browser that is on this machine prints the page, which has a style sheet for paper.

Chrome and its kin write a tagged PDF, which can be read aloud.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from erclutch.errors import RunError
from erclutch.files import unwritable
from erclutch.report.html.report_page import report_html
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.paper_style import placed

#: Names of browsers that print without a window, and where they stand where no name leads to them.
_NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "microsoft-edge-stable", "msedge"),
)
_PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)
#: The page asks for nothing from outside, and the browser may ask for nothing of its own.
_SAFE = (
    *("--headless", "--disable-gpu", "--no-first-run", "--disable-sync", "--disable-extensions"),
    *("--disable-background-networking", "--disable-component-update", "--disable-default-apps"),
    "--host-resolver-rules=MAP * ~NOTFOUND",
    "--no-pdf-header-footer",
)
_SECONDS = 120.0
_REMEDY = "Write the report without --pdf, open it in a browser and print it (Ctrl-P)"
_CREATOR = b"/Creator ("
#: By this a PDF is known as ours; its length may not change, because the file lists its parts by their places.
_OURS = b"/Creator (erclutch)"


def browser() -> str | None:
    """A browser that can print without a window; None where none is found."""
    by_name = next(filter(None, map(shutil.which, _NAMES)), None)
    return by_name or next((place for place in _PLACES if Path(place).is_file()), None)


def print_report(material: Material, path: Path) -> Path:
    """Print the report of a run to a PDF, whole or not at all.

    Raises:
        RunError: no browser is here, or it does not print; or the folder cannot be written.
    """
    program = browser()
    if program is None:
        raise RunError("no Chromium, Chrome or Edge is here to print with", where=str(path), remedy=_REMEDY)
    # Beside the PDF and not hidden: a browser out of a sandboxed package reads neither /tmp nor hidden folders.
    try:
        folder = TemporaryDirectory(prefix=f"{path.stem}-printing-", dir=path.parent)
    except OSError as error:
        raise unwritable(path, error) from error
    profile = TemporaryDirectory(prefix="erclutch-browser-", ignore_cleanup_errors=True)
    with folder as name, profile as own, placed(path) as partial:
        page, pages = Path(name, "report.html"), Path(name, "report.pdf")
        page.write_text(report_html(material), encoding="utf-8")
        _print(program, page.resolve(), pages.resolve(), own, path)
        partial.write_bytes(_signed(pages.read_bytes()))
    return path


def _print(
    program: str,
    page: Path,
    pages: Path,
    profile: str,
    path: Path,
) -> None:
    """Let a browser print a page.

    Raises:
        RunError: it ends with an error, goes on for too long, or leaves no PDF.
    """
    words = [program, *_SAFE, f"--user-data-dir={profile}", f"--print-to-pdf={pages}"]
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        words.append("--no-sandbox")  # root has none: a browser would not start
    words.append(page.as_uri())
    quiet = subprocess.DEVNULL
    try:
        done = subprocess.run(
            words,
            stdin=quiet,
            stdout=quiet,
            stderr=quiet,
            timeout=_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        problem = f"{Path(program).name} has not printed it in {_SECONDS:g} s"
        raise RunError(problem, where=str(path), remedy=_REMEDY) from error
    except OSError as error:
        problem = f"{program} does not start: {error.strerror or error}"
        raise RunError(problem, where=str(path), remedy=_REMEDY) from error
    if done.returncode or not pages.is_file() or not pages.read_bytes().startswith(b"%PDF-"):
        problem = f"{Path(program).name} did not print it (exit code {done.returncode})"
        raise RunError(problem, where=str(path), remedy=_REMEDY)


def _signed(pdf: bytes) -> bytes:
    """A PDF that names erclutch where the browser named itself, of the same length."""
    start = pdf.find(_CREATOR)
    end = pdf.find(b")\n", start)
    if start < 0 or end < start + len(_OURS):
        return pdf
    return pdf[:start] + _OURS.ljust(end + 1 - start) + pdf[end + 1 :]
