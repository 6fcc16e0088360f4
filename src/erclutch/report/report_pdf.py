"""The report on paper: the same sections, drawn by matplotlib on A4 pages."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from erclutch.diagnostics.material import Material
from erclutch.errors import CheckError
from erclutch.figures.of_runs import FIGURES
from erclutch.figures.style import style, write_whole
from erclutch.report.page import headings
from erclutch.report.parameters import ParametersSection
from erclutch.report.provenance import Provenance
from erclutch.report.verdict import Verdict

_SIZE = (8.27, 11.69)
_SIDE = 0.75  # margins in inches
_WIDE = 104  # characters of a line
_LINE = 0.165  # height of a line in inches
#: Figures of each page after the first, with their titles.
_PAGES = (
    (("trace", "Measured against estimated"), ("error-map", "Where it errs, and where there are data")),
    (("parity", "How errors are distributed"), ("residual", "What is left in the residual")),
    (("flow-curves", "Flow curves of the laws"), ("lag", "Lag between command and effort")),
)


def write_pdf(material: Material, path: Path) -> Path:
    """Write the report of a run for print, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    backend: Any = import_module("matplotlib.backends.backend_pdf")

    def write(unfinished: Path) -> None:
        about = {"Creator": "erclutch", "Title": f"erclutch: {headings(material)[0]}", "CreationDate": None}
        with style(), backend.PdfPages(unfinished, metadata=about) as book:
            pages: list[Callable[[], Any]] = [partial(_first, material)]
            pages += [partial(_figures, material, names) for names in _PAGES]
            pages += [partial(_last, material)]
            for number, draw in enumerate(pages, start=1):
                page = draw()
                if page is not None:
                    _foot(page, material, number)
                    book.savefig(page, dpi=150)  # of the maps; all else is lines

    return write_whole(path, write)


def _sheet() -> Any:
    return import_module("matplotlib.figure").Figure(figsize=_SIZE, layout="constrained")


def _rows(page: Any, heights: Sequence[float]) -> list[Any]:
    """Areas under one another, in inches, between the margins; the last row takes what is left."""
    margin, width, height = _SIDE, *_SIZE
    rest = max(height - 2 * margin - sum(heights), 0.01)
    areas = page.subfigures(
        len(heights) + 3 - 1,
        3,
        width_ratios=[margin, width - 2 * margin, margin],
        height_ratios=[margin, *heights, rest + margin],
        hspace=0.0,
        wspace=0.0,
    )
    for area in areas.flat:  # empty backgrounds, whose edges the layout puts at 0 or at -0
        area.patch.set_visible(False)
    return [areas[k + 1, 1] for k in range(len(heights))]


def _foot(page: Any, material: Material, number: int) -> None:
    page.text(_SIDE / _SIZE[0], 0.028, f"{headings(material)[0]}   {material.badge}", fontsize=7, color="#555555")
    page.text(1 - _SIDE / _SIZE[0], 0.028, str(number), fontsize=7, color="#555555", ha="right")


class _Writer:
    """Text from the top of a page down."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.at = _SIZE[1] - _SIDE

    def put(self, text: str, size: float = 8.5, *, bold: bool = False, width: int = _WIDE, left: float = 0.0) -> None:
        """One paragraph."""
        lines = textwrap.wrap(text, int(width * 8.5 / size), break_on_hyphens=False) or [""]
        for line in lines:
            self.at -= _LINE * size / 8.5
            x, y = (_SIDE + left) / _SIZE[0], self.at / _SIZE[1]
            self.page.text(x, y, line, fontsize=size, fontweight="bold" if bold else "normal", parse_math=False)
        self.at -= 0.04

    def skip(self, inches: float) -> None:
        """Leave some space."""
        self.at -= inches


def _first(material: Material) -> Any:
    page = _sheet()
    values = Verdict().fill(material)
    heading, line = headings(material)
    out = _Writer(page)
    out.put(heading, 12.0, bold=True)
    out.put(f"{line}. {material.badge}")
    out.skip(0.15)
    head = values["headline"]
    out.put(
        f"{head['model']} errs by {head['error']} on data that it has not seen: {head['share']} of the "
        f"{head['word']}'s standard deviation.",
        13.0,
    )
    out.skip(0.05)
    out.put(f"{values['why']} {values['against']}")
    out.skip(0.1)
    for name, value, more in values["facts"]:
        out.put(f"{value}   {name}; {more}")
    for title, items in (
        ("What to worry about", values["worries"]),
        ("What to do next", [f"{n['text']} {n['code']}".strip() for n in values["next"]]),
    ):
        out.skip(0.12)
        out.put(title, bold=True)
        for item in items or ["Nothing that the checks know of."]:
            out.put(f"•  {item}")
    used = _SIZE[1] - _SIDE - out.at + 0.25
    high = min(FIGURES["ranking"].height(material), _SIZE[1] - 2 * _SIDE - used)
    if high > 1.0:
        FIGURES["ranking"].draw(_rows(page, [used, high])[1], material)
    return page


def _figures(material: Material, names: Sequence[tuple[str, str]]) -> Any:
    """A page of figures; one that the run cannot give is left out, with a word why."""
    page = _sheet()
    scale = (_SIZE[0] - 2 * _SIDE) / FIGURES[names[0][0]].width
    heights = [min(FIGURES[n].height(material) * (1.25 if scale > 1.5 else 1.0), 5.6) for n, _ in names]
    spare = _SIZE[1] - 2 * _SIDE - 0.6
    shrink = min(1.0, spare / sum(heights))
    areas = _rows(page, [h * shrink for h in heights])
    drawn = 0
    for (name, title), area in zip(names, areas, strict=True):
        area.suptitle(title, x=0.0, ha="left", fontsize=10, fontweight="bold")
        try:
            FIGURES[name].draw(area, material)
            drawn += 1
        except CheckError as error:
            area.text(0.0, 0.8, error.problem, fontsize=8.5)
    return page if drawn else None


def _last(material: Material) -> Any:
    page = _sheet()
    out = _Writer(page)
    parameters = ParametersSection().fill(material)
    chosen = next((law for law in parameters["laws"] if law["name"] == material.recommended), None)
    out.put("Parameters", 10.0, bold=True)
    if chosen is None:
        out.put(f"{material.recommended} is a network: its weights mean nothing one by one.")
    else:
        out.put(f"{chosen['name']}: {chosen['title']}, {chosen['source']}. {chosen['reference']}")
        _table(out, chosen["rows"])
    out.skip(0.2)
    origin = Provenance().fill(material)
    out.put("Provenance", 10.0, bold=True)
    out.put(f"{origin['means']} {origin['rows']}.")
    if origin["command"]:
        out.put(f"To repeat it: {origin['command']}")
    for found in origin["mappings"][:5]:
        out.put(f"{found['name']}: mapping file, SHA-256 {found['sha256']}", 7.0)
    for log in origin["logs"][:20]:
        out.put(f"{log['name']}: {log['origin']}, {log['rows']} rows, {log['rate']}, SHA-256 {log['sha256']}", 7.0)
    out.put("Settings: " + ", ".join(f"{k} {v}" for k, v in origin["settings"]))
    out.put("Versions: " + ", ".join(f"{k} {v}" for k, v in origin["versions"]))
    out.put(f"Digest of run.json: {origin['digest']}", 7.0)
    return page


def _table(out: _Writer, rows: Sequence[dict[str, Any]]) -> None:
    columns = (0.0, 0.75, 1.65, 2.75, 4.3)
    for row in rows[: math.floor((out.at - 3.2) / 0.2)]:
        out.at -= 0.19
        cells = (row["plain"], row["value"], row["unit"], row["band"], row["meaning"])
        for left, cell in zip(columns, cells, strict=True):
            x, y = (_SIDE + left) / _SIZE[0], out.at / _SIZE[1]
            out.page.text(x, y, str(cell), fontsize=8, parse_math=False)
