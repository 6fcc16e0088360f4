"""The report on paper has the same sections, drawn by matplotlib on A4 pages that can be read aloud."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
from erclutch.report.printed_table import ranking_table

if TYPE_CHECKING:
    from erclutch.report.tagged_pdf import TaggedPages

_SIZE = (8.27, 11.69)
_SIDE = 0.75  # margins in inches
_WIDE = 104  # characters of a line
_HEAD = 0.3  # height of a figure's title in inches
_LETTER = 0.062  # width of a letter of a table in inches
_RANKED = 48  # models of a page
#: Columns of the parameters, and their headings.
_COLUMNS = {"plain": "name", "value": "value", "unit": "unit", "band": "95 % interval", "meaning": "meaning"}
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
    from erclutch.report.tagged_pdf import TaggedPages

    about = {"Creator": "erclutch", "Title": f"erclutch: {headings(material)[0]}", "CreationDate": None}
    with placed(path) as partial, style():
        book, whole = TaggedPages(partial, about), False
        try:
            for number, page in enumerate(_pages(material, book), start=1):
                _foot(page, material, number)
                book.save(page)
            whole = True
        finally:
            book.close(whole=whole)
    return path


def _pages(material: Material, book: TaggedPages) -> Iterator[Any]:
    yield _first(material, book)
    yield from _ranking(material, book)
    for names in _PAGES:
        page = _figures(material, names, book)
        if page is not None:
            yield page
    yield _last(material, book)


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

    def __init__(self, book: TaggedPages) -> None:
        self.page = _sheet()
        self.book = book
        self.at = _SIZE[1] - _SIDE

    def put(self, text: str, size: float = 8.5, tag: str = "P") -> None:
        """One paragraph, or a heading: H1 or H2."""
        element = self.book.add(tag)
        lines = textwrap.wrap(text, int(_WIDE * 8.5 / size), break_on_hyphens=False) or [""]
        for line in lines:
            self.at -= _LINE * size / 8.5
            self.words(line, size, element, bold=tag != "P")
        self.at -= 0.04

    def code(self, text: str) -> None:
        """A command, if there is any, in a type of its own."""
        element = self.book.add("P")
        for line in textwrap.wrap(text, int(0.75 * _WIDE), break_on_hyphens=False):
            self.skip(_LINE)
            self.page.text(
                (_SIDE + 0.15) / _SIZE[0], self.at / _SIZE[1], line, size=7.5, family="monospace", gid=element
            )

    def words(self, text: str, size: float, element: str, left: float = 0.0, *, bold: bool = False) -> None:
        """Words of an element on the line where the writer is, so many inches from the margin."""
        x, y, weight = (_SIDE + left) / _SIZE[0], self.at / _SIZE[1], "bold" if bold else "normal"
        self.page.text(x, y, text, fontsize=size, fontweight=weight, parse_math=False, gid=element)

    def table(self, header: Sequence[str], rows: Sequence[Sequence[str]], lefts: Sequence[float]) -> None:
        """Rows under a header, each column so many inches from the margin; texts of the last column are broken."""
        table = self.book.add("Table")
        for number, row in enumerate((header, *rows)):
            self.skip(0.19)
            line = self.book.add("TR", table)
            for text, left in zip(row, lefts, strict=True):
                cell = self.book.add("TD" if number else "TH", line)
                for more, part in enumerate(textwrap.wrap(text, int((_SIZE[0] - 2 * _SIDE - left) / _LETTER)) or [""]):
                    self.skip(0.14 if more else 0.0)
                    self.words(part, 8, cell, left, bold=not number)

    def skip(self, inches: float) -> None:
        """Leave some space."""
        self.at -= inches


def _first(material: Material, book: TaggedPages) -> Any:
    values = VERDICT.fill(material)
    heading, line = headings(material)
    out = _Writer(book)
    out.put(heading, 12.0, "H1")
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
        ("What to worry about", [(text, "") for text in values["worries"]]),
        ("What to do next", [(n["text"], n["code"]) for n in values["next"]]),
    ):
        out.skip(0.12)
        out.put(title, tag="H2")
        for text, code in items or [("Nothing that the checks know of.", "")]:
            out.put(f"•  {text}")
            out.code(code)
    used = _SIZE[1] - _SIDE - out.at + 0.25
    ranking = describe_ranking(material)
    high = min(ranking.height, _SIZE[1] - 2 * _SIDE - used)
    if high > 1.0:
        area = _rows(out.page, [used, high])[1]
        area.set_gid(book.add("Figure", alt=_said(ranking)))
        paint(area, ranking)
    return out.page


def _said(plot: Plot) -> str:
    """What a figure shows, for those who do not see it."""
    return " ".join(dict.fromkeys(panel.says or panel.title for panel in plot.panels)) or plot.title


def _ranking(material: Material, book: TaggedPages) -> Iterator[Any]:
    """All models with their errors, on as many pages as they need."""
    table = ranking_table(material.run)
    rows = [
        [name, count, f"{rmse} ({low} .. {high})", f"{share} %"]
        for name, count, rmse, low, high, share, *_ in table.cells()
    ]
    header = ("Model", "Parameters", f"{table.header[2]}, 95 % band", "Of the std")
    for first in range(0, len(rows), _RANKED):
        out = _Writer(book)
        out.put("All models, ranked" if not first else "All models, ranked, continued", 10.0, "H2")
        out.table(header, rows[first : first + _RANKED], (0.0, 3.5, 4.4, 6.1))
        yield out.page


def _figures(material: Material, names: Sequence[tuple[str, str]], book: TaggedPages) -> Any:
    """A page of figures; one that the run cannot give is left out, with a word why."""
    plots = [_described(material, name) for name, _ in names]
    if not any(isinstance(plot, Plot) for plot in plots):
        return None
    page = _sheet()
    heights = [0.6 if isinstance(p, str) else min(p.height * (1.25 if p.width < PAGE else 1.0), 5.6) for p in plots]
    spare = _SIZE[1] - 2 * _SIDE - 0.6
    shrink = min(1.0, spare / sum(heights))
    areas = _rows(page, [h * shrink for h in heights])
    for plot, (_, title), area, height in zip(plots, names, areas, heights, strict=True):
        above, below = area.subfigures(2, 1, height_ratios=(_HEAD, max(height * shrink - _HEAD, _HEAD)))
        for part in (above, below):
            part.patch.set_visible(False)
        above.text(0.0, 0.3, title, fontsize=10, fontweight="bold", gid=book.add("H2"))
        if isinstance(plot, str):
            below.text(0.0, 0.8, plot, fontsize=8.5, gid=book.add("P"))
        else:
            below.set_gid(book.add("Figure", alt=_said(plot)))
            paint(below, plot)
    return page


def _described(material: Material, name: str) -> Plot | str:
    """A figure, or why the run cannot give it."""
    try:
        return FIGURES[name][1](material)
    except CheckError as error:
        return error.problem


def _last(material: Material, book: TaggedPages) -> Any:
    out = _Writer(book)
    parameters = PARAMETERS.fill(material)
    chosen = next((law for law in parameters["laws"] if law["name"] == material.recommended), None)
    out.put("Parameters", 10.0, "H2")
    if chosen is None:
        out.put(f"{material.recommended} is a network: its weights mean nothing one by one.")
    else:
        out.put(f"{chosen['name']}: {chosen['title']}, {chosen['source']}. {chosen['reference']}")
        most = math.floor((out.at - 3.2) / 0.2)
        rows = [[str(row[name]) for name in _COLUMNS] for row in chosen["rows"][:most]]
        out.table([name.capitalize() for name in _COLUMNS.values()], rows, (0.0, 0.75, 1.65, 2.75, 4.3))
    out.skip(0.2)
    origin = PROVENANCE.fill(material)
    out.put("Provenance", 10.0, "H2")
    out.put(f"{origin['means']} {origin['rows']}.")
    if origin["command"]:
        out.put("To repeat it:")
        out.code(origin["command"])
    for found in origin["mappings"][:5]:
        out.put(f"{found['name']}: mapping file, SHA-256 {found['sha256']}", 7.0)
    for log in origin["logs"][:20]:
        out.put(f"{log['name']}: {log['origin']}, {log['rows']} rows, {log['rate']}, SHA-256 {log['sha256']}", 7.0)
    out.put("Settings: " + ", ".join(f"{k} {v}" for k, v in origin["settings"]))
    out.put("Versions: " + ", ".join(f"{k} {v}" for k, v in origin["versions"]))
    out.put(f"Digest of run.json: {origin['digest']}", 7.0)
    return out.page
