"""Pages below docs/notebooks are notebooks kept as text: their Python blocks are cells of one session.

While the site is built the cells run, and below each cell stands what a notebook would show: the HTML of its last
value, and its figures. What a cell prints stands in the page as a block of text; the tests compare it (`tests/docs`).

Site and tests run the same cells, for most of a minute of a processor: who comes second takes what the first has kept,
as long as cells, sources of erclutch, Python and packages are the same.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import hashlib
import io
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

#: Folder of these pages below docs.
FOLDER = "notebooks"
ROOT = Path(__file__).resolve().parents[2]
_KEPT = ROOT / "build" / FOLDER
_LONGEST = 600
_VALUE = '<div class="cell-value" tabindex="0" role="group" aria-label="What the cell above shows">{}</div>'
_IMAGE = '<p><img class="drawn-picture" alt="Figure of the cell above" width="{}" src="data:image/png;base64,{}"></p>'


def cells_of(page: str, cells: Sequence[str]) -> list[dict[str, Any]]:
    """What each cell of a page shows: as it was kept, if it is of the same cells and sources; else they run.

    Raises:
        RuntimeError: a cell failed.
    """
    kept = _KEPT / f"{page}.json"
    made_of = _digest(cells)
    if kept.is_file():
        known = json.loads(kept.read_text("utf-8"))
        if known["made_of"] == made_of:
            return known["shown"]
    with tempfile.TemporaryDirectory() as folder:
        shown = run_cells(cells, Path(folder))
    _KEPT.mkdir(parents=True, exist_ok=True)
    unfinished = _KEPT / f"{page}-{os.getpid()}.json"
    unfinished.write_text(json.dumps({"made_of": made_of, "shown": shown}), "utf-8")
    unfinished.replace(kept)
    return shown


def _digest(cells: Sequence[str]) -> str:
    """Of all that decides on what cells show: themselves, this file, erclutch, Python and the installed packages."""
    sources = [Path(__file__)]
    for path in sorted((ROOT / "src").rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            sources.append(path)
    packages = sorted(f"{package.name} {package.version}" for package in metadata.distributions())
    asked = [[cell.strip() for cell in cells], sys.version, packages]
    made_of = hashlib.sha256(json.dumps(asked).encode())
    for path in sources:
        made_of.update(str(path.relative_to(ROOT)).encode())
        made_of.update(hashlib.sha256(path.read_bytes()).digest())
    return made_of.hexdigest()


def run_cells(cells: Sequence[str], folder: Path) -> list[dict[str, Any]]:
    """What each cell shows: ``printed``, ``html`` of its last value, ``pictures`` (width, and PNG in base64) of each.

    Raises:
        RuntimeError: a cell failed.
    """
    done = subprocess.run(
        [sys.executable, "-W", "error", __file__],
        cwd=folder,
        env={
            **os.environ,
            "MPLBACKEND": "agg",
            "COLUMNS": "100",
            "NO_COLOR": "1",
            "PYTHONUTF8": "1",
        },
        input=json.dumps(list(cells)),
        capture_output=True,
        text=True,
        timeout=_LONGEST,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{done.stdout}\n{done.stderr}")
    return json.loads(done.stdout)


def _shown(cell: str, names: dict[str, Any]) -> dict[str, Any]:
    """Run a cell in the session's names."""
    body, last, printed = ast.parse(cell).body, None, io.StringIO()
    with contextlib.redirect_stdout(printed):
        if body and isinstance(final := body[-1], ast.Expr):
            last, body = ast.Expression(final.value), body[:-1]
        exec(compile(ast.Module(body, []), "<cell>", "exec"), names)
        value = None if last is None else eval(compile(last, "<cell>", "eval"), names)
    html = getattr(value, "_repr_html_", lambda: None)()
    return {"printed": printed.getvalue(), "html": html, "pictures": _pictures()}


def _pictures() -> list[tuple[int, str]]:
    """Figures that are open, which are closed."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is None:
        return []
    found: list[tuple[int, str]] = []
    for number in pyplot.get_fignums():
        data, figure = io.BytesIO(), pyplot.figure(number)
        figure.savefig(data, format="png", dpi=200)
        found.append(
            (round(110 * figure.get_figwidth()), base64.b64encode(data.getvalue()).decode())
        )
    pyplot.close("all")
    return found


def _show_cells(app: Any, tree: Any) -> None:
    """Put what the cells of a page show below them."""
    from docutils import nodes

    if not app.env.docname.startswith(f"{FOLDER}/"):
        return
    cells = [node for node in tree.findall(nodes.literal_block) if node.get("language") == "python"]
    page = app.env.docname.rpartition("/")[2]
    outputs = cells_of(page, [cell.astext() for cell in cells])
    for cell, output in zip(cells, outputs, strict=True):
        html = (output["html"] or "").replace(
            "<th></th>", "<td></td>"
        )  # pandas heads its index with nothing
        shown = _VALUE.format(html) if html else ""
        shown += "".join(_IMAGE.format(*picture) for picture in output["pictures"])
        if shown:
            cell.parent.insert(cell.parent.index(cell) + 1, nodes.raw("", shown, format="html"))


def setup(app: Any) -> dict[str, Any]:
    """Called by Sphinx."""
    app.connect("doctree-read", _show_cells)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    session: dict[str, Any] = {"__name__": "__main__"}
    print(json.dumps([_shown(cell, session) for cell in json.load(sys.stdin)]))
