"""The report for print: a browser that is on this machine prints the page, which has a style sheet for paper.

Chrome and its kin write a tagged PDF, which can be read aloud.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from erclutch.errors import RunError
from erclutch.files import scratch_folder
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
_HALF = 0.55  # of a page; a line more than its half
_REMEDY = "Write the report without --pdf, open it in a browser and print it (Ctrl-P)"
#: Where the last page would be half empty, the first of these that fills it is printed: with more chapters unfolded
#: (their names), or with the tables of quantiles and of the band folded, which may save the page.
_FILLING: tuple[tuple[str, ...], ...] = (
    ("residual",),
    ("flow_curves",),
    (),
    ("residual", "flow_curves"),
)
#: Where the page's end stands, from below: a browser keeps the places to which the links of a page lead.
_END = re.compile(rb"/end \[\d+ 0 R /XYZ \S+ (\S+) ")
_HEIGHT = re.compile(rb"/MediaBox \[\S+ \S+ \S+ ([0-9.]+)\]")
_CREATOR = b"/Creator ("
#: By this a PDF is known as ours; its length may not change, because the file lists its parts by their places.
_OURS = b"/Creator (erclutch)"


def browser() -> str | None:
    """A browser that can print without a window; None where none is found."""
    browsers = map(shutil.which, _NAMES)
    by_name = next(filter(None, browsers), None)
    return by_name or next((place for place in _PLACES if Path(place).is_file()), None)


def print_report(material: Material, path: Path) -> Path:
    """Print the report of a run to a PDF, whole or not at all; chapters that fill its last page are printed too.

    Raises:
        RunError: no browser is here, or it does not print; or the folder cannot be written.
    """
    program = browser()
    if program is None:
        raise RunError(
            "no Chromium, Chrome or Edge is here to print with", where=str(path), remedy=_REMEDY
        )
    # Beside the PDF and not hidden: a browser out of a sandboxed package reads neither /tmp nor hidden folders.
    beside = scratch_folder(f"{path.stem}-printing-", path)
    profile = scratch_folder("erclutch-browser-")
    with placed(path) as partial, beside as name, profile as own:
        page = Path(name, "report.html")
        pages = Path(name, "report.pdf")
        text = report_html(material)
        fullest = b""
        for variant in (text, *_fuller(text)):
            page.write_text(variant, encoding="utf-8")
            _print(program, page.resolve(), pages.resolve(), own, path)
            printed = pages.read_bytes()
            fullest = max(fullest, printed, key=last_page_fill)
            if last_page_fill(fullest) >= _HALF:
                break
        partial.write_bytes(signed(fullest))
    return path


def last_page_fill(pdf: bytes) -> float:
    """How far down the last page the report ends, 0 .. 1; 1 where the browser does not say."""
    end = _END.search(pdf)
    height = _HEIGHT.search(pdf)
    if not pdf:
        return 0.0
    if end is None or height is None:
        return 1.0
    return 1.0 - float(end[1]) / float(height[1])


def _fuller(text: str) -> Iterator[str]:
    """The page with other parts folded, as far as it has them."""
    for chapters in _FILLING:
        variant = text if chapters else text.replace('<details class="onpaper">', "<details>")
        for chapter in chapters:
            folded = f'<details id="{chapter}" class="chapter">'
            variant = variant.replace(folded, folded.replace('"chapter"', '"chapter onpaper"'))
        if variant != text:
            yield variant


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
        with subprocess.Popen(
            words,
            stdin=quiet,
            stdout=quiet,
            stderr=quiet,
            env={**os.environ, "TMPDIR": profile},  # what it leaves when it is ended goes with that
            start_new_session=True,
        ) as process:
            try:
                code = process.wait(_SECONDS)
            finally:
                # The browser ends, and all that it started: these write into its folder as that is taken away.
                if os.name == "nt":
                    process.kill()
                else:
                    with suppress(ProcessLookupError, PermissionError):
                        os.killpg(process.pid, signal.SIGKILL)
    except subprocess.TimeoutExpired as error:
        problem = f"{Path(program).name} has not printed it in {_SECONDS:g} s"
        raise RunError(problem, where=str(path), remedy=_REMEDY) from error
    except OSError as error:
        problem = f"{program} does not start: {error.strerror or error}"
        raise RunError(problem, where=str(path), remedy=_REMEDY) from error
    if code or not pages.is_file() or not pages.read_bytes().startswith(b"%PDF-"):
        problem = f"{Path(program).name} did not print it (exit code {code})"
        raise RunError(problem, where=str(path), remedy=_REMEDY)


def signed(pdf: bytes) -> bytes:
    """A PDF that names erclutch where the browser named itself, of the same length."""
    start = pdf.find(_CREATOR)
    end = pdf.find(b")\n", start)
    if start < 0 or end < start + len(_OURS):
        return pdf
    return pdf[:start] + _OURS.ljust(end + 1 - start) + pdf[end + 1 :]
