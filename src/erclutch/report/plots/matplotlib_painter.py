"""Matplotlib draws a plot's description for papers, at IEEE column width, with the table beside it as CSV."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.report.numbers.number_text import capital, number
from erclutch.report.plots.paper_style import BLACK, RAMPS, STYLES, new_figure, save, save_numbers, style
from erclutch.report.plots.plot_description import (
    Axis,
    Bars,
    Cells,
    Dots,
    Line,
    Mark,
    NamedBars,
    Panel,
    Plot,
    ReferenceLine,
    Shade,
)

_CHARACTER = 0.073  # inches of a panel's height for each character of a title beside the panel
LONGEST_NAME = 36  # letters of a bar's name in a line
_KEY, _LETTER = 0.5, 0.055  # inches of a legend's line with its margins, and of a letter beside it
_MARGIN = 9  # letters that the ticks beside a panel take
_TIGHT = "\u00a0"
#: Which meanings a legend names first.
_RANKS = {"measured": 0, "recommended": 1, "best": 2, "baseline": 3}


def save_plot(plot: Plot, *paths: Path) -> list[Path]:
    """Write a plot as the endings of the paths say (.png, .pdf, .svg), and its table beside them.

    Returns:
        The files written, the table last.

    Raises:
        RunError: another ending, or a folder that cannot be written.
    """
    with style():
        figure = new_figure(plot.height, plot.width)
        paint(figure, plot)
        drawn = [save(figure, path) for path in paths]
    return [*drawn, save_numbers(paths[0].with_suffix(".csv"), plot.table.header, plot.table.rows)]


def paint(figure: Any, plot: Plot) -> None:
    """Draw a plot in a figure, or in a part of one; call inside `style`."""
    rows = [plot.panels[k : k + plot.columns] for k in range(0, len(plot.panels), plot.columns)]
    ratios = [max(panel.share for panel in row) for row in rows]
    room = int(plot.width / plot.columns / _LETTER) - _MARGIN
    axes = figure.subplots(len(rows), plot.columns, squeeze=False, height_ratios=ratios)
    for axis in list(axes.flat)[len(plot.panels) :]:
        axis.set_visible(False)
    maps: dict[str, list[tuple[Any, Any, bool]]] = {}
    for panel, axis in zip(plot.panels, axes.flat, strict=False):
        _panel(axis, panel, room)
        for cells in panel.cells():
            maps.setdefault(cells.label, []).append((_cells(axis, cells), axis, cells.log))
    for label, drawn in maps.items():
        if label:
            at = [axis for _, axis, _ in drawn]
            bar = figure.colorbar(drawn[0][0], ax=at, location="top", shrink=0.9, aspect=28, pad=0.03, label=label)
            if drawn[0][2]:
                _plain_decades(bar.ax.xaxis, *bar.ax.get_xlim())
    _titles(axes, plot, room)
    _legends(figure, axes, plot, room)
    if plot.title:  # below, where a shared legend is above
        place = figure.supxlabel if plot.legend == "shared" else figure.suptitle
        place(plot.title, x=0.02, ha="left", fontsize=8.0)
    if plot.columns == 1:
        figure.align_ylabels(list(axes.flat))


def _panel(axis: Any, panel: Panel, room: int) -> None:
    x, y = panel.limits()
    axis.set(xscale="log" if panel.x.log else "linear", yscale="log" if panel.y.log else "linear", xlim=x, ylim=y)
    for one, log, ends in ((axis.xaxis, panel.x.log, x), (axis.yaxis, panel.y.log, y)):
        if log:
            _plain_decades(one, *ends)
    if panel.x.whole:
        axis.xaxis.get_major_locator().set_params(integer=True)
    for layer, mark in enumerate(panel.marks):
        _draw(axis, mark, 2.0 + 0.01 * layer)
    if panel.square:
        axis.set_aspect("equal")
    if panel.title:
        side = "right" if any(isinstance(mark, NamedBars) for mark in panel.marks) else "left"  # names take the left
        axis.set_title(
            _parted(panel.title, room), loc=side, fontweight="bold" if panel.chosen else "normal", fontsize=7.0
        )


def _parted(name: str, room: int) -> str:
    """A name that is too long for its panel in several lines, parted at a word or at a stage of the model."""
    lines: list[str] = []
    while len(name) > room:
        at = max(name.rfind("+", 1, room), name.rfind(" ", 1, room)) + 1 or room
        lines.append(name[:at].rstrip())
        name = name[at:]
    return "\n".join([*lines, name])


def _plain_decades(axis: Any, low: float, high: float) -> None:
    """Ticks of a logarithmic axis in plain text; matplotlib's own are TeX, which `paper_style` leaves as it stands."""
    from matplotlib.ticker import NullFormatter

    axis.set_major_formatter(_decade)
    axis.set_minor_formatter(_decade if high < 10.0 * low else NullFormatter())


def _decade(value: float, _: int) -> str:
    return f"{value:g}" if 1e-3 <= value < 1e4 else number(value, 1).replace("1·", "")


def _draw(axis: Any, mark: Mark, layer: float) -> None:
    match mark:
        case Line():
            look = STYLES[mark.style] | ({"linestyle": (0, (3, 1.5))} if mark.dashed else {})
            look |= {"marker": "o", "markersize": 2.5} if mark.marked else {}
            layer += 0.5 if "linestyle" in look else 0.0  # dashes over a solid line leave both to be seen
            axis.plot(*mark.corners(), label=mark.label or None, zorder=layer, **look)
        case Dots():
            colour, size = STYLES[mark.style]["color"], 1.8 * mark.size
            alpha, label = (0.6, None) if not mark.label else (1.0, mark.label)
            axis.plot(mark.x, mark.y, ".", ms=size, mew=0, color=colour, alpha=alpha, label=label, zorder=layer)
        case Bars():
            look = {"color": STYLES[mark.style]["color"], "label": mark.label or None}
            axis.stairs(mark.heights, mark.edges, fill=True, alpha=0.5, zorder=layer, **look)
        case NamedBars():
            _named_bars(axis, mark)
        case Shade() if mark.x is not None:
            axis.fill_between(mark.x, mark.low, mark.high, **STYLES[mark.style], zorder=1.0)
        case Shade():
            axis.axhspan(mark.low, mark.high, **STYLES[mark.style], zorder=1.0)
        case ReferenceLine(axis="x"):
            axis.axvline(mark.at, **STYLES["zero"])
        case ReferenceLine():
            axis.axhline(mark.at, **STYLES["zero"])
        case Cells():  # drawn with their colour bars
            pass


def _named_bars(axis: Any, bars: NamedBars) -> None:
    at = np.arange(len(bars.names))
    axis.barh(at, bars.values, 0.62, color=[STYLES[name]["color"] for name in bars.styles])
    whiskers = [bars.values - bars.low, bars.high - bars.values]
    axis.errorbar(bars.values, at, xerr=whiskers, fmt="none", ecolor=BLACK, elinewidth=0.7, capsize=1.5)
    axis.set_yticks(at, [_parted(name, LONGEST_NAME) for name in bars.names], fontsize=6.0)
    axis.invert_yaxis()
    axis.grid(False, axis="y")


def _cells(axis: Any, cells: Cells) -> Any:
    from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize

    colours: Any = LinearSegmentedColormap.from_list(cells.style, RAMPS[cells.style])
    norm = LogNorm(1.0, max(2.0, cells.top)) if cells.log else Normalize(0.0, cells.top)
    x, y = cells.x_edges, cells.y_edges
    image = axis.pcolormesh(x, y, cells.values.T, cmap=colours, norm=norm, rasterized=True)
    if cells.crossed is not None:
        i, j = np.nonzero(cells.crossed)
        axis.plot(0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1]), "x", color=BLACK, ms=2.0, mew=0.4)
    return image


def _titles(axes: Any, plot: Plot, room: int) -> None:
    """Titles of the axes; panels under one another or side by side name a common axis once."""
    columns, panels = plot.columns, plot.panels
    for k, (panel, axis) in enumerate(zip(panels, axes.flat, strict=False)):
        row = range(k - k % columns, min(k - k % columns + columns, len(panels)))
        below = {j: panels[j + columns].x if j + columns < len(panels) else None for j in row}
        if all(_same(panels[j].x, under) for j, under in below.items()):
            axis.tick_params(labelbottom=False)
        else:
            badge = f" ({plot.badge})" if plot.badge and panel is panels[-1] else ""
            narrow = any(isinstance(mark, NamedBars) for mark in panel.marks)  # names beside it have taken the room
            axis.set_xlabel(_wrapped(capital(panel.x.title) + badge, room), loc="right" if narrow else "center")
        if k % columns and _same(panel.y, panels[k - 1].y):
            axis.tick_params(labelleft=False)
        else:
            inches = plot.height * panel.share / sum(p.share for p in panels[::columns])
            axis.set_ylabel(_wrapped(capital(panel.y.title), int(inches / _CHARACTER)))


def _wrapped(title: str, room: int) -> str:
    """A title in lines of so many letters; a unit stays whole."""
    label, mark, unit = title.partition(" [")
    unit, end, badge = unit.partition("]")
    lines = f"{label}{mark}{unit.replace(' ', _TIGHT)}{end}{badge}"
    return textwrap.fill(lines, max(6, room), break_long_words=False, break_on_hyphens=False)


def _same(one: Axis, other: Axis | None) -> bool:
    return one == other and one.low is not None


def _legends(figure: Any, axes: Any, plot: Plot, room: int) -> None:
    """Names of the marks; a panel with one name has no legend."""
    above = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2}
    for panel, axis in zip(plot.panels, axes.flat, strict=False):
        named = {handle.get_label(): handle for handle in axis.get_legend_handles_labels()[0]}
        labels = [label for _, label in sorted(panel.legend(), key=lambda key: _RANKS.get(key[0], len(_RANKS)))]
        handles = [named[label] for label in labels]
        if plot.legend == "shared":
            ncols = len(labels)
            figure.legend(handles, labels, loc="outside upper center", ncols=ncols, title=plot.legend_title)
            return
        if len(labels) > 1:
            columns = max(1, int(plot.width / plot.columns / (_KEY + _LETTER * max(map(len, labels)))))
            place: dict[str, Any] = above | {"ncols": columns} if plot.legend == "above" else {}
            beside_key = max(8, room - int(_KEY / _LETTER))
            axis.legend(handles, [_parted(label, beside_key) for label in labels], handlelength=1.6, **place)
