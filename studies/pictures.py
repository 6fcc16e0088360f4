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

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
CHROMIUM = "/usr/bin/chromium"
QUIET = ("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking")
LARGEST = 150_000  # bytes
NEES = ("--field", "Y [V]", "--slip", "V [cm/s]", "--effort", "F [N]")
_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+/\S*")


@contextmanager
def page(width: int, height: int) -> Iterator[Page]:
    """An empty page of a browser window of this size, in light colours."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        yield browser.new_context(viewport={"width": width, "height": height}, color_scheme="light").new_page()
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
    subprocess.run(erclutch("fit", str(log), *NEES, "--out", str(run)), check=True, stdout=subprocess.DEVNULL)
    subprocess.run(erclutch("report", str(run)), check=True, stdout=subprocess.DEVNULL)
    with page(1180, 1105) as seen:
        seen.goto((run / "report.html").as_uri())
        seen.wait_for_selector("#traces-plot[data-ready=yes]")
        kept(seen.screenshot(), "report.png")


def draw_app(log: Path, folder: Path) -> None:
    """The page of the recording, once its columns are chosen."""
    session = subprocess.Popen(erclutch("app", str(folder)), stdout=subprocess.PIPE, text=True)
    try:
        with page(1180, 1000) as seen:
            seen.goto(_address(session))
            seen.set_input_files("#file", str(log))
            seen.wait_for_url("**/log/**")
            for signal, column, unit in (
                ("time", "t", "s"),
                ("field", "Y", "V"),
                ("slip", "V", "cm/s"),
                ("effort", "F", "N"),
            ):
                seen.select_option(f"[name='column.{signal}']", column)
                seen.fill(f"[name='unit.{signal}']", unit)
            seen.click("text=Read it so")
            seen.wait_for_selector(".good")
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


def draw_states(file: Path) -> None:
    """States as boxes, events as arrows between them. An event with no more effect than a good sample is not drawn."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from erclutch.wings.live.explained_states import transitions

    places = {"starting": (0.7, 3.0), "running": (4.6, 3.0), "tripped": (9.2, 3.0), "ready": (6.9, 0.6)}
    arrows: dict[tuple[str, str], list[str]] = {}
    usual: dict[str, str] = {}
    for line in transitions():
        state, after = line.state.name.lower(), line.next.name.lower()
        plain = usual.setdefault(state, after)  # a good sample comes first
        if state != after and after in places and (after != plain or not arrows.get((state, after))):
            arrows.setdefault((state, after), []).append(line.event.removeprefix("order: "))
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "states", "font.size": 10}):
        figure = Figure((10, 4.9))
        axes = figure.add_axes((0, 0, 1, 1), xlim=(-0.2, 10.4), ylim=(0.1, 5.2))
        axes.axis("off")
        for (start, end), events in arrows.items():
            (x0, y0), (x1, y1) = places[start], places[end]
            bow = {"startingtripped": -0.4, "trippedready": -0.42, "readytripped": -0.42}.get(start + end, -0.13)
            style = {"arrowstyle": "-|>", "color": "#667", "shrinkA": 50, "shrinkB": 60}
            axes.annotate("", (x1, y1), (x0, y0), arrowprops={**style, "connectionstyle": f"arc3,rad={bow}"})
            at = (x0 + x1) / 2 + bow / 2 * (y1 - y0), (y0 + y1) / 2 - bow / 2 * (x1 - x0)
            axes.text(*at, "\n".join(events), ha="center", va="center", fontsize=8,
                      bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5})  # fmt: skip
        for name, (x, y) in places.items():
            colour = {"running": "#d8ecd9", "tripped": "#f6d9d5"}.get(name, "#e6e9ef")
            box = {"boxstyle": "round,pad=0.6", "facecolor": colour, "edgecolor": "#667"}
            fields = "fields by the program" if name == "running" else "fields at zero"
            axes.text(x, y, f"{name}\n{fields}", ha="center", va="center", bbox=box)
        ending = "Stop, a signal or a parent that is gone:\nfrom each state to the end, at zero field"
        axes.text(0.1, 0.5, ending, fontsize=8)
        figure.savefig(file, metadata={"Date": None, "Title": "States of the live loop"})


def main() -> None:
    """See the module."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("picture", choices=("report", "app", "live", "states"))
    arguments.add_argument("log", type=Path, nargs="?", help="the recording that report and app show")
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
