"""Draw the pictures of README and pages: a report, the page of a log, the live page on the TWIN, the loop's states.

    python studies/pictures.py report LOG    docs/images/report.png; LOG is the NEES damper's ranran_50_converted.csv
    python studies/pictures.py app LOG       docs/images/app.png: the same recording in erclutch app
    python studies/pictures.py live          docs/images/live.png: erclutch live on the TWIN, tracking at 0.4 Hz
    python studies/pictures.py states        docs/images/states.svg, from what erclutch live --explain prints

The first three run the commands that a reader would type, in headless Chromium. Each picture must stay below 150 kB.
`erclutch figure trace RUN` draws docs/images/nees-trace.png.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.state_diagram import draw_states

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
CHROMIUM = "/usr/bin/chromium"
QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
)
LARGEST = 150_000  # bytes
NEES = ("--field", "Y [V]", "--slip", "V [cm/s]", "--effort", "F [N]")
_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+/\S*")


@contextmanager
def page(width: int, height: int) -> Iterator[Page]:
    """An empty page of a browser window of this size, in light colours."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        yield browser.new_context(
            viewport={"width": width, "height": height}, color_scheme="light"
        ).new_page()
        browser.close()


def kept(shot: bytes, name: str) -> None:
    """Write a picture in 256 colours, if it is small enough for a README."""
    packed = io.BytesIO()
    Image.open(io.BytesIO(shot)).convert("RGB").quantize(256).save(packed, "PNG", optimize=True)
    size = packed.tell()
    if size > LARGEST:
        raise SystemExit(f"{name}: {size} bytes, more than {LARGEST}; make the window smaller.")
    (IMAGES / name).write_bytes(packed.getvalue())
    print(f"{IMAGES / name}: {size / 1000:.0f} kB")


def erclutch(*arguments: str) -> list[str]:
    """A command line of this environment's erclutch."""
    return [sys.executable, "-m", "erclutch", *arguments]


def draw_report(log: Path, run: Path) -> None:
    """Fit all models to the recording, write its report, and take the part above the fold."""
    subprocess.run(
        erclutch("fit", str(log), *NEES, "--out", str(run)), check=True, stdout=subprocess.DEVNULL
    )
    subprocess.run(erclutch("report", str(run)), check=True, stdout=subprocess.DEVNULL)
    with page(1180, 1300) as seen:
        seen.goto((run / "report.html").as_uri())
        seen.wait_for_selector("#traces-plot[data-ready=yes]")
        kept(seen.screenshot(), "report.png")


def draw_app(log: Path, folder: Path) -> None:
    """The page of the recording, once its columns are chosen."""
    bench = folder / "bench"  # below a home of its own, so that the picture shows ~/bench
    bench.mkdir()
    home = {**os.environ, "HOME": str(folder.resolve())}
    session = subprocess.Popen(
        erclutch("app", str(bench)), stdout=subprocess.PIPE, text=True, env=home
    )
    try:
        with page(1180, 1000) as seen:
            seen.goto(_address(session))
            seen.wait_for_url("**-*/")
            seen.set_input_files("#file", str(log))
            seen.wait_for_url("**/log/**")
            for signal, column, unit in (
                ("time", "t", "s"),
                ("field", "Y", "V"),
                ("slip", "V", "cm/s"),
                ("position", "D", "cm"),
                ("effort", "F", "N"),
            ):
                seen.select_option(f"[name='column.{signal}']", column)
                seen.fill(f"[name='unit.{signal}']", unit)
            seen.click("text=Read it so")
            seen.wait_for_selector(".good")
            seen.wait_for_selector("#plots canvas")
            kept(seen.screenshot(), "app.png")
    finally:
        session.terminate()
        session.wait()


def draw_live(folder: Path) -> None:
    """Watch a session on the TWIN for some seconds."""
    session = subprocess.Popen(
        erclutch("live", "--seconds", "60", "--folder", str(folder)),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    try:
        with page(1180, 840) as seen:
            seen.goto(_address(session))
            time.sleep(14.0)
            kept(seen.screenshot(), "live.png")
    finally:
        session.terminate()
        session.wait()


def _address(session: subprocess.Popen[str]) -> str:
    assert session.stdout is not None
    said: list[str] = []
    for line in session.stdout:
        said.append(line)
        found = _ADDRESS.search(line)
        if found:
            return found[0]
    raise SystemExit("erclutch live printed no address:\n" + "".join(said))


def main() -> None:
    """See the module."""
    arguments = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments.add_argument("picture", choices=("report", "app", "live", "states"))
    arguments.add_argument(
        "log", type=Path, nargs="?", help="the recording that report and app show"
    )
    given = arguments.parse_args()
    if given.picture in ("report", "app") and given.log is None:
        arguments.error(f"{given.picture} needs the recording")
    with tempfile.TemporaryDirectory() as folder:
        if given.picture == "states":
            draw_states(IMAGES / "states.svg")
        elif given.picture == "report":
            draw_report(given.log.resolve(), Path(folder) / "damper.run")
        elif given.picture == "app":
            draw_app(given.log.resolve(), Path(folder))
        else:
            draw_live(Path(folder))


if __name__ == "__main__":
    main()
