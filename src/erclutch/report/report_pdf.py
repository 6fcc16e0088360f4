"""The report on paper has the same sections, drawn by matplotlib on A4 pages."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from erclutch.errors import CheckError
from erclutch.report.html.parameters_section import PARAMETERS
from erclutch.report.html.provenance_section import PROVENANCE
from erclutch.report.html.report_page import headings
from erclutch.report.html.verdict_section import VERDICT
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.matplotlib_painter import paint
from erclutch.report.plots.paper_style import placed, style
from erclutch.report.plots.plot_description import PAGE, Plot
from erclutch.report.plots.ranking_plot import describe_ranking
from erclutch.report.plots.run_plots import FIGURES

_SIZE = (8.27, 11.69)
_SIDE = 0.75  # margins in inches
_WIDE = 104  # characters of a line
_LINE = 0.165  # height of a line in inches
#: Figures of each page after the first, with their titles.
_PAGES = (
    (("trace", "Measured against estimated"), ("error-map", "Where it errs, and where there are data")),
    (("parity", "How errors are distributed"), ("residual", "What is left in the residual")),
    (("flow-curves", "Flow curves of the laws"), ("loops", "Loops of effort over slip and over travel")),
    (("lag", "Lag and memory"),),
)


def write_pdf(material: Material, path: Path) -> Path:
    """Write the report of a run for print, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    from matplotlib.backends.backend_pdf import PdfPages

    about = {"Creator": "erclutch", "Title": f"erclutch: {headings(material)[0]}", "CreationDate": None}
    with placed(path) as partial, style(), PdfPages(partial, metadata=about) as opened:
        book: Any = opened
        pages = (_first(material), *(_figures(material, names) for names in _PAGES), _last(material))
        for number, page in enumerate(pages, start=1):
            if page is not None:
                _foot(page, material, number)
                book.savefig(page, dpi=150)  # of the maps; all else is lines  # pyright: ignore[reportUnknownMemberType]
    return path


def _sheet() -> Any:
    from matplotlib.figure import Figure

    return Figure(figsize=_SIZE, layout="constrained")


def _rows(page: Any, heights: Sequence[float]) -> list[Any]:
    """Areas under one another, in inches, between the margins; the last row takes what is left."""
    margin, width, height = _SIDE, *_SIZE
    rest = max(height - 2 * margin - sum(heights), 0.01)
    across, down = [margin, width - 2 * margin, margin], [margin, *heights, rest + margin]
    areas = page.subfigures(len(down), 3, width_ratios=across, height_ratios=down, hspace=0.0, wspace=0.0)
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

    def put(self, text: str, size: float = 8.5, *, bold: bool = False) -> None:
        """One paragraph."""
        lines = textwrap.wrap(text, int(_WIDE * 8.5 / size), break_on_hyphens=False) or [""]
        for line in lines:
            self.at -= _LINE * size / 8.5
            self.words(line, size, bold=bold)
        self.at -= 0.04

    def words(self, text: str, size: float, left: float = 0.0, *, bold: bool = False) -> None:
        """Words on the line where the writer is, so many inches from the margin."""
        x, y, weight = (_SIDE + left) / _SIZE[0], self.at / _SIZE[1], "bold" if bold else "normal"
        self.page.text(x, y, text, fontsize=size, fontweight=weight, parse_math=False)

    def skip(self, inches: float) -> None:
        """Leave some space."""
        self.at -= inches


def _first(material: Material) -> Any:
    page = _sheet()
    values = VERDICT.fill(material)
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
    ranking = describe_ranking(material)
    high = min(ranking.height, _SIZE[1] - 2 * _SIDE - used)
    if high > 1.0:
        paint(_rows(page, [used, high])[1], ranking)
    return page


def _figures(material: Material, names: Sequence[tuple[str, str]]) -> Any:
    """A page of figures; one that the run cannot give is left out, with a word why."""
    plots = [_described(material, name) for name, _ in names]
    if not any(isinstance(plot, Plot) for plot in plots):
        return None
    page = _sheet()
    heights = [0.6 if isinstance(p, str) else min(p.height * (1.25 if p.width < PAGE else 1.0), 5.6) for p in plots]
    spare = _SIZE[1] - 2 * _SIDE - 0.6
    shrink = min(1.0, spare / sum(heights))
    areas = _rows(page, [h * shrink for h in heights])
    for plot, (_, title), area in zip(plots, names, areas, strict=True):
        area.suptitle(title, x=0.0, ha="left", fontsize=10, fontweight="bold")
        if isinstance(plot, str):
            area.text(0.0, 0.8, plot, fontsize=8.5)
        else:
            paint(area, plot)
    return page


def _described(material: Material, name: str) -> Plot | str:
    """A figure, or why the run cannot give it."""
    try:
        return FIGURES[name][1](material)
    except CheckError as error:
        return error.problem


def _last(material: Material) -> Any:
    page = _sheet()
    out = _Writer(page)
    parameters = PARAMETERS.fill(material)
    chosen = next((law for law in parameters["laws"] if law["name"] == material.recommended), None)
    out.put("Parameters", 10.0, bold=True)
    if chosen is None:
        out.put(f"{material.recommended} is a network: its weights mean nothing one by one.")
    else:
        out.put(f"{chosen['name']}: {chosen['title']}, {chosen['source']}. {chosen['reference']}")
        _table(out, chosen["rows"])
    out.skip(0.2)
    origin = PROVENANCE.fill(material)
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
    columns = {"plain": 0.0, "value": 0.75, "unit": 1.65, "band": 2.75, "meaning": 4.3}
    for row in rows[: math.floor((out.at - 3.2) / 0.2)]:
        out.skip(0.19)
        for name, left in columns.items():
            out.words(str(row[name]), 8, left)
