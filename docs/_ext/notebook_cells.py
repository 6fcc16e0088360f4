"""Pages below docs/notebooks are notebooks kept as text: their Python blocks are cells of one session.

While the site is built the cells run, and below each cell stands what a notebook would show: the HTML of its last
value, and its figures. What a cell prints stands in the page as a block of text; the tests compare it (`tests/docs`).
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

#: Folder of these pages below docs.
FOLDER = "notebooks"
_LONGEST = 600
_VALUE = '<div class="cell-value" tabindex="0" role="group" aria-label="What the cell above shows">{}</div>'
_IMAGE = '<p><img class="drawn-picture" alt="Figure of the cell above" width="{}" src="data:image/png;base64,{}"></p>'


def run_cells(cells: Sequence[str], folder: Path) -> list[dict[str, Any]]:
    """What each cell shows: ``printed``, ``html`` of its last value, ``pictures`` (width, and PNG in base64) of each.

    Raises:
        RuntimeError: a cell failed.
    """
    done = subprocess.run(
        [sys.executable, "-W", "error", __file__],
        cwd=folder,
        env={**os.environ, "MPLBACKEND": "agg", "COLUMNS": "100", "NO_COLOR": "1", "PYTHONUTF8": "1"},
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
        found.append((round(110 * figure.get_figwidth()), base64.b64encode(data.getvalue()).decode()))
    pyplot.close("all")
    return found


def _show_cells(app: Any, tree: Any) -> None:
    """Put what the cells of a page show below them."""
    from docutils import nodes

    if not app.env.docname.startswith(f"{FOLDER}/"):
        return
    cells = [node for node in tree.findall(nodes.literal_block) if node.get("language") == "python"]
    with tempfile.TemporaryDirectory() as folder:
        outputs = run_cells([cell.astext() for cell in cells], Path(folder))
    for cell, output in zip(cells, outputs, strict=True):
        html = (output["html"] or "").replace("<th></th>", "<td></td>")  # pandas heads its index with nothing
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
