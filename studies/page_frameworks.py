"""What would a trivial page of `erclutch app` cost on other frameworks? Run by hand, with pip, playwright and Chromium.

    python studies/page_frameworks.py FOLDER

FOLDER gets one virtual environment for each framework and may be deleted afterwards. A page has a heading, a number
field and a button. For each framework the study prints: installed MB over an empty environment, packages, s of
processor of its import (best of 5), s from the start of its server until the heading is seen (median of 5), MB of
memory of the server then, requests to other machines (which are refused, so the page has to do without), and
violations that axe finds.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import Any

PORT = 8731
#: Name: packages, module, the page, words of the command that serves it.
FRAMEWORKS: dict[str, tuple[str, str, str, str]] = {
    "Starlette + Jinja2": (
        "starlette uvicorn jinja2",
        "starlette.applications, uvicorn, jinja2",
        """
import jinja2, uvicorn
from starlette.applications import Starlette
from starlette.responses import HTMLResponse
from starlette.routing import Route
page = jinja2.Template('''<!doctype html><html lang="en"><title>Fit</title><main><h1>Fit</h1><form method="post">
<label>Seed <input name="seed" value="0"></label> <button>Fit</button></form></main></html>''')
async def shown(request):
    return HTMLResponse(page.render())
uvicorn.run(Starlette(routes=[Route("/", shown)]), port=PORT, log_level="error")
""",
        "{python} {file}",
    ),
    "NiceGUI": (
        "nicegui",
        "nicegui",
        """
from nicegui import ui
@ui.page("/")
def page():
    ui.label("Fit").props('role=heading aria-level=1')
    ui.number("Seed", value=0)
    ui.button("Fit")
ui.run(port=PORT, reload=False, show=False, title="Fit")
""",
        "{python} {file}",
    ),
    "Panel": (
        "panel",
        "panel",
        """
import panel as pn
pn.Column("# Fit", pn.widgets.IntInput(name="Seed"), pn.widgets.Button(name="Fit")).servable(title="Fit")
""",
        "{python} -m panel serve {file} --port {port} --index page",
    ),
    "Streamlit": (
        "streamlit",
        "streamlit",
        """
import streamlit as st
st.title("Fit")
st.number_input("Seed", value=0)
st.button("Fit")
""",
        "{python} -m streamlit run {file} --server.port {port} --server.headless true --browser.gatherUsageStats false",
    ),
    "marimo": (
        "marimo",
        "marimo",
        """
import marimo
app = marimo.App()
@app.cell
def _():
    import marimo as mo
    mo.vstack([mo.md("# Fit"), mo.ui.number(label="Seed", value=0, start=0, stop=9), mo.ui.button(label="Fit")])
    return
""",
        "{python} -m marimo run {file} --port {port} --headless --no-token",
    ),
}


def environment(folder: Path, packages: str) -> Path:
    """A virtual environment with some packages; its Python."""
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        if packages:
            subprocess.run([str(python), "-m", "pip", "install", "-q", *packages.split()], check=True)
    return python


def size_of(folder: Path) -> float:
    """MB of the files in a folder, without compiled Python, which is written at the first import."""
    found = (p for p in folder.rglob("*") if p.is_file() and not p.is_symlink() and p.suffix != ".pyc")
    return sum(path.stat().st_size for path in found) / 1e6


def import_time(python: Path, modules: str) -> float:
    """Seconds of processor that an import takes beyond the start of Python, the best of five."""

    def used() -> float:
        spent = resource.getrusage(resource.RUSAGE_CHILDREN)
        return spent.ru_utime + spent.ru_stime

    def taken(code: str) -> float:
        began = used()
        subprocess.run([str(python), "-c", code], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return used() - began

    return min(taken(f"import {modules}") for _ in range(5)) - min(taken("pass") for _ in range(5))


def memory_of(pid: int) -> float:
    """MB that a process and its children hold alone (PSS)."""
    total = 0.0
    with suppress(OSError):
        for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            total += float(line.split()[1]) / 1e3 if line.startswith("Pss:") else 0.0
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            total += memory_of(int(child))
    return total


@contextmanager
def served(command: list[str], folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """The server of a page, ended afterwards."""
    nothing = subprocess.DEVNULL
    process = subprocess.Popen(
        command, cwd=folder, stdout=nothing, stderr=nothing, env={**os.environ, "HOME": str(folder)}
    )
    try:
        yield process
    finally:
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(10.0)
        process.kill()
        process.wait()


def look(browser: Any, began: float) -> tuple[float, list[str], list[str]]:
    """Seconds until the heading is seen, requests to other machines, and what axe finds."""
    axe: Any = import_module("axe_playwright_python.sync_playwright")
    context = browser.new_context()
    page = context.new_page()
    outside: list[str] = []

    def only_here(route: Any) -> None:
        if "://127.0.0.1" in route.request.url or "://localhost" in route.request.url:
            route.continue_()
        else:
            outside.append(route.request.url)
            route.abort()

    page.route("**/*", only_here)
    while True:
        with suppress(Exception):
            page.goto(f"http://127.0.0.1:{PORT}/", wait_until="commit", timeout=30_000)
            break
        time.sleep(0.01)
    page.get_by_role("heading", name="Fit").wait_for(timeout=60_000)
    seconds = time.perf_counter() - began
    page.wait_for_timeout(1000)
    found = [each["id"] for each in axe.Axe().run(page).response["violations"]]
    context.close()
    return seconds, outside, found


def measure(name: str, folder: Path, empty: float, browser: Any) -> str:
    """A row of the table."""
    packages, modules, source, words = FRAMEWORKS[name]
    place = folder / name.split()[0].lower()
    python = environment(place, packages)
    listed = subprocess.run(
        [str(python), "-m", "pip", "list", "--format=freeze"], capture_output=True, text=True, check=True
    )
    pinned = dict(line.split("==", 1) for line in listed.stdout.split() if "==" in line)
    version = pinned[packages.split()[0]]
    file = place / "page.py"
    file.write_text(source.replace("PORT", str(PORT)))
    command = words.format(python=python, file=file, port=PORT).split()
    seconds: list[float] = []
    for _ in range(5):
        began = time.perf_counter()
        with served(command, place) as process:
            taken, outside, found = look(browser, began)
            memory = memory_of(process.pid)
        seconds.append(taken)
    more = len(pinned.keys() - {"pip", "setuptools"})
    figures = (
        f"{size_of(place) - empty:.0f} | {more} | {import_time(python, modules):.2f} | {statistics.median(seconds):.1f}"
    )
    hosts = sorted({url.split("/")[2] for url in outside})
    return f"| {name} {version} | {figures} | {memory:.0f} | {', '.join(hosts) or 'none'} | {', '.join(found) or '0'} |"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    given = parser.parse_args()
    given.folder.mkdir(exist_ok=True)
    environment(given.folder / "empty", "")
    empty = size_of(given.folder / "empty")
    sync: Any = import_module("playwright.sync_api")
    with sync.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=given.chromium, args=["--no-sandbox", "--disable-gpu"])
        browser.new_page().goto("about:blank")
        print("| framework | installed MB | packages | import s | start to heading s | memory MB | outside | axe |")
        for name in FRAMEWORKS:
            print(measure(name, given.folder, empty, browser), flush=True)
        browser.close()


if __name__ == "__main__":
    main()
