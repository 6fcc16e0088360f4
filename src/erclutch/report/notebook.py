"""Cards of values are drawn for notebooks: as a line, as HTML that reads in light and dark, as DataFrames and plots.

The HTML takes the colour of the notebook's text and colours that stand out on white and on black, so it asks for no
theme. Each text in it is escaped: names come from files.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from markupsafe import Markup

from erclutch.errors import SettingError, printable
from erclutch.report.notebook_cards import card_of
from erclutch.report.numbers.number_text import count, number, plain
from erclutch.report.plots.plot_description import Panel, PlotTable

if TYPE_CHECKING:
    from pandas import DataFrame

    from erclutch.runs.run_folder import Run

_MOST = 8  # rows of a table
_SMALL, _WIDE = (262, 165), (400, 200)  # of pictures: three beside each other, or fewer
_RAMP = ("808080", "7a6fd0", "4a7fd6", "0e93a8", "2a9d5f", "9a8a00", "d55e00")
_SERIES = ("0072b2", "d55e00", "009e73", "cc79a7", "a67c00", "7a6fd0")
_ROLES = {"recommended": "d55e00", "best": "0072b2", "baseline": "009e73"}
_STYLE = Markup(
    ".erclutch{font:13px/1.45 system-ui,sans-serif;max-width:66em}"
    ".erclutch p{margin:.3em 0;max-width:56em}.erclutch .facts,.erclutch .more{opacity:.78}"
    ".erclutch .badge{font-size:11px;font-weight:700;border:1px solid;border-radius:4px;padding:0 6px;margin-left:6px}"
    ".erclutch table{font:inherit;border-collapse:collapse;margin:.5em 0;font-variant-numeric:tabular-nums}"
    ".erclutch th,.erclutch td{text-align:left;white-space:nowrap;padding:2px 12px 2px 0;background:none;color:inherit;"
    "border-bottom:1px solid color-mix(in srgb,currentColor 22%,transparent)}"
    ".erclutch .n{text-align:right}.erclutch pre{font-size:12px;white-space:pre-wrap;margin:.4em 0}"
    ".erclutch .panels{display:flex;flex-wrap:wrap;gap:4px 14px}.erclutch figure{margin:0}"
    ".erclutch figcaption{font-size:12px;opacity:.85}.erclutch svg.plot{width:100%;height:auto}"
    ".erclutch svg.key{width:18px;height:8px;margin:0 4px 0 8px}"
    ".erclutch svg span{display:block;font:10.5px sans-serif;white-space:nowrap}.erclutch .untrusted{display:none}"
    ".erclutch svg span::after{content:attr(data-text)}.erclutch .middle{text-align:center}"
    ".erclutch .end{text-align:right}"
    ".erclutch svg path{stroke:currentColor;fill:none}.erclutch svg .grid{opacity:.18}"
    ".erclutch svg .zero,.erclutch svg .axis,.erclutch svg .tick{opacity:.55}"
    ".erclutch svg .line{stroke-width:1.6}.erclutch svg .dashed,.erclutch svg .best{stroke-dasharray:6 3}"
    ".erclutch svg .dots{stroke-linecap:round}"
    ".erclutch svg .white{fill:currentColor;stroke:none;opacity:.16}"
    ".erclutch svg .cell{stroke:none;fill:#0072b2}"
    + "".join(f".erclutch svg .{name}{{stroke:#{colour}}}" for name, colour in _ROLES.items())
    + "".join(f".erclutch svg .series{k}{{stroke:#{colour}}}" for k, colour in enumerate(_SERIES))
    + "".join(f".erclutch svg .level{k}{{stroke:#{colour}}}" for k, colour in enumerate(_RAMP))
    + "".join(f".erclutch svg .mass{k}{{fill-opacity:{0.16 + 0.12 * k:.2f}}}" for k in range(8))
)
_UNTRUSTED = "Pictures are shown where the notebook is trusted: run the cell, or trust the notebook."
_TEXT = re.compile(
    r'<text (?:class="title" )?x="(?P<x>[-\d.]+)" y="(?P<y>[-\d.]+)"(?: text-anchor="(?P<anchor>\w+)")?>'
    r"(?P<words>.*?)</text>"
)
_ROOM = 300  # width of a text


def line(value: Any) -> str:
    """A value in a line, without what could move a terminal's cursor."""
    card = card_of(value)
    return printable(plain(f"{type(value).__name__}({card.name}: {', '.join(card.facts)})"))


def html(value: Any) -> str:
    """A value as HTML: name, facts, sentences, the first rows of its table, a picture or two."""
    card = card_of(value)
    badge = Markup(' <span class="badge">{}</span>').format(card.badge) if card.badge else ""
    panels = card.panels()
    size = _SMALL if len(panels) > 2 else _WIDE
    parts = [
        Markup("<p>{} <b>{}</b>{}</p>").format(type(value).__name__, card.name, badge),
        Markup('<p class="facts">{}</p>').format(", ".join(card.facts)),
        *(Markup("<p>{}</p>").format(sentence) for sentence in card.says()),
        Markup("<pre>{}</pre>").format("\n".join(card.lines)) if card.lines else "",
        _table(card.table()),
        Markup('<p class="untrusted">{}</p>').format(_UNTRUSTED) if panels else "",
        Markup('<div class="panels">{}</div>').format(Markup("").join(_figure(p, size) for p in panels)),
    ]
    return str(Markup('<div class="erclutch"><style>{}</style>{}</div>').format(_STYLE, Markup("").join(parts)))


def _table(found: PlotTable) -> Markup:
    rows = [Markup("<tr>{}</tr>").format(_cells(row)) for row in found.rows[:_MOST]]
    sides = ["n" if isinstance(value, float | int) else "" for value in found.rows[0]] if found.rows else []
    heads = zip(found.header, [*sides, *[""] * len(found.header)], strict=False)
    head = Markup("").join(Markup('<th class="{}">{}</th>').format(css, name) for name, css in heads)
    left = len(found.rows) - _MOST
    more = Markup('<p class="more">{} more: .table()</p>').format(count(left)) if left > 0 else ""
    body = Markup("").join(rows)
    return Markup("<table><thead><tr>{}</tr></thead><tbody>{}</tbody></table>{}").format(head, body, more)


def _cells(row: Sequence[object]) -> Markup:
    drawn: list[Markup] = []
    for value in row:
        text = number(float(value), 4) if isinstance(value, float) else "–" if value is None else value
        css = "n" if isinstance(value, float | int) else ""
        drawn.append(Markup('<td class="{}">{}</td>').format(css, text))
    return Markup("").join(drawn)


def _figure(panel: Panel, size: tuple[int, int]) -> Markup:
    """A panel with the names of its lines below."""
    from erclutch.report.plots.svg_painter import svg

    drawn = Markup(_TEXT.sub(_written_by_css, str(svg(replace(panel, size=size)))))
    key = Markup('<svg class="key" viewBox="0 0 18 8"><path class="line {}" d="M0 4H18"/></svg>{}')
    keys = Markup(" ").join(key.format(css, label) for css, label in dict.fromkeys(panel.legend()))
    return Markup('<figure style="flex:0 1 {}px">{}<figcaption>{} {}</figcaption></figure>').format(
        size[0], drawn, panel.title, keys
    )


def _written_by_css(text: re.Match[str]) -> str:
    """A text of a drawing as an attribute: a notebook that is not trusted drops drawings, and keeps what they write."""
    x, y, anchor, words = float(text["x"]), float(text["y"]), text["anchor"] or "start", text["words"]
    first = x - _ROOM * {"start": 0.0, "middle": 0.5, "end": 1.0}[anchor]
    span = f'<span class="{anchor}" data-text="{words}"></span>'
    return f'<foreignObject x="{first:.1f}" y="{y - 11:.1f}" width="{_ROOM}" height="15">{span}</foreignObject>'


@dataclass(frozen=True)
class InlineReport:
    """A report in a frame of its own; `html` is the document."""

    html: str = field(repr=False)

    def _repr_html_(self) -> str:
        frame = '<iframe title="Report" sandbox="allow-scripts" style="{}" srcdoc="{}"></iframe>'
        return str(Markup(frame).format("width:100%;height:720px;border:0;background:#fff", self.html))


def report(run: Run) -> InlineReport:
    """See `Run.report`."""
    from erclutch.report.html.report_page import report_html
    from erclutch.report.numbers.run_material import material_of

    return InlineReport(report_html(material_of(run)))


def table(value: Any) -> DataFrame:
    """See `Shown.table`."""
    from pandas import DataFrame

    found = card_of(value).table()
    return DataFrame([list(row) for row in found.rows], columns=list(found.header))


def frame(value: Any) -> DataFrame:
    """See `Shown.to_frame`; a value without rows of its own gives its table."""
    card = card_of(value)
    return table(value) if card.frame is None else card.frame()


def plot(value: Any, name: str | None = None, **options: Any) -> Any:
    """See `Shown.plot`."""
    from matplotlib import pyplot  # pyright: ignore[reportUnknownVariableType]

    from erclutch.report.plots.matplotlib_painter import paint
    from erclutch.report.plots.paper_style import style

    card = card_of(value)
    if not card.plots:
        raise SettingError(f"{card.name} has no plot", remedy="Plot the log, the comparison or the run")
    chosen = name or next(iter(card.plots))
    if chosen not in card.plots:
        raise SettingError(f"no plot {chosen!r}", remedy=f"Plots of a {type(value).__name__}: {', '.join(card.plots)}")
    described = card.plots[chosen](**options)
    with style():
        figure: Any = cast(Any, pyplot).figure(figsize=(described.width, described.height), layout="constrained")
        paint(figure, described)
    axes = [axis for axis in figure.axes if axis.get_subplotspec() is not None][: len(described.panels)]
    return axes[0] if len(axes) == 1 else np.array(axes, dtype=object)
