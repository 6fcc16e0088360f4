"""Matplotlib draws a plot's description for papers, at IEEE column width, with the table beside it as CSV."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.files.groups import together
from erclutch.report.numbers.number_text import capital, number
from erclutch.report.plots.paper_style import (
    BLACK,
    RAMPS,
    STYLES,
    new_figure,
    save,
    save_numbers,
    style,
)
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

LONGEST_NAME = 36  # letters of a bar's name in a line
_CHARACTER = 0.073  # inches of a panel's height for each character of a title beside the panel
_KEY = 0.5  # inches of a legend's line with its margins
_LETTER = 0.055  # inches of a letter beside the line
_MARGIN = 9  # letters that the ticks beside a panel take
_TIGHT = "\u00a0"
#: Which meanings a legend names first.
_RANKS = {"measured": 0, "recommended": 1, "best": 2, "baseline": 3}


def save_plot(plot: Plot, *paths: Path) -> list[Path]:
    """Write a plot as the endings of the paths say (.png, .pdf, .svg), and its table beside them: all or none.

    Returns:
        The files written, the table last.

    Raises:
        RunError: another ending, or a folder that cannot be written.
    """
    beside = paths[0].with_suffix(".csv")
    with together(), style():
        figure = new_figure(plot.height, plot.width)
        paint(figure, plot)
        drawn = [save(figure, path) for path in paths]
        return [*drawn, save_numbers(beside, plot.table.header, plot.table.rows)]


def paint(figure: Any, plot: Plot) -> None:
    """Draw a plot in a figure, or in a part of one; call inside `style`."""
    first_panels = range(0, len(plot.panels), plot.columns)  # of the rows of panels
    rows = [plot.panels[first : first + plot.columns] for first in first_panels]
    shares = [max(panel.share for panel in row) for row in rows]
    axes = figure.subplots(len(rows), plot.columns, squeeze=False, height_ratios=shares)
    for axis in list(axes.flat)[len(plot.panels) :]:
        axis.set_visible(False)

    letters = int(plot.width / plot.columns / _LETTER) - _MARGIN  # that fit into a panel's width
    for panel, axis in zip(plot.panels, axes.flat, strict=False):
        x_ends, y_ends = panel.limits()
        axis.set(xscale=_scale(panel.x), yscale=_scale(panel.y), xlim=x_ends, ylim=y_ends)
        if panel.x.log:
            _plain_decades(axis.xaxis, *x_ends)
        if panel.y.log:
            _plain_decades(axis.yaxis, *y_ends)
        if panel.x.unmarked:
            axis.set_xticks([])
        elif panel.x.whole:
            axis.xaxis.get_major_locator().set_params(integer=True)
        for layer, mark in enumerate(panel.marks):  # maps follow in `_maps`
            _draw(axis, mark, 2.0 + 0.01 * layer)
        if panel.square:
            axis.set_aspect("equal")
        if panel.title:
            title = _parted(panel.title, letters)
            side = "right" if _names_bars(panel) else "left"
            weight = "bold" if panel.chosen else "normal"
            axis.set_title(title, loc=side, fontweight=weight, fontsize=7.0)
    _maps(figure, axes, plot)
    _titles(axes, plot, letters)
    _legends(figure, axes, plot, letters)
    if plot.title:  # below, where a shared legend is above
        place = figure.supxlabel if plot.legend == "shared" else figure.suptitle
        place(
            plot.title,
            x=0.02,
            ha="left",
            fontsize=8.0,
        )
    if plot.columns == 1:
        figure.align_ylabels(list(axes.flat))


def _scale(axis: Axis) -> str:
    return "log" if axis.log else "linear"


def _names_bars(panel: Panel) -> bool:
    """Whether names of bars take the room to the left of a panel."""
    return any(isinstance(mark, NamedBars) for mark in panel.marks)


def _parted(name: str, letters: int) -> str:
    """A name that is too long for its panel in several lines, parted at a word or at a stage of the model."""
    lines: list[str] = []
    while len(name) > letters:
        before_plus = name.rfind("+", 1, letters)
        before_space = name.rfind(" ", 1, letters)
        at = max(before_plus, before_space) + 1 or letters
        lines.append(name[:at].rstrip())
        name = name[at:]
    return "\n".join([*lines, name])


def _maps(figure: Any, axes: Any, plot: Plot) -> None:
    """Maps of coloured cells; those with the same label share one colour bar."""
    from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize

    drawn: dict[str, list[tuple[Any, Any, Cells]]] = {}  # image, axis and cells, by label
    for panel, axis in zip(plot.panels, axes.flat, strict=False):
        for cells in panel.cells():
            colours: Any = LinearSegmentedColormap.from_list(cells.style, RAMPS[cells.style])
            norm = Normalize(0.0, cells.top)
            if cells.log:
                norm = LogNorm(1.0, max(2.0, cells.top))
            image = axis.pcolormesh(
                cells.x_edges,
                cells.y_edges,
                cells.values.T,
                cmap=colours,
                norm=norm,
                rasterized=True,
            )
            if cells.crossed is not None:
                i, j = np.nonzero(cells.crossed)
                x_middles = 0.5 * (cells.x_edges[i] + cells.x_edges[i + 1])
                y_middles = 0.5 * (cells.y_edges[j] + cells.y_edges[j + 1])
                axis.plot(x_middles, y_middles, "x", color=BLACK, ms=2.0, mew=0.4)
            drawn.setdefault(cells.label, []).append((image, axis, cells))
    for label, maps in drawn.items():
        if not label:
            continue
        image, _, cells = maps[0]
        beside = [axis for _, axis, _ in maps]
        bar = figure.colorbar(
            image,
            ax=beside,
            location="top",
            shrink=0.9,
            aspect=28,
            pad=0.03,
            label=label,
        )
        if cells.log:
            _plain_decades(bar.ax.xaxis, *bar.ax.get_xlim())


def _plain_decades(axis: Any, low: float, high: float) -> None:
    """Ticks of a logarithmic axis in plain text; matplotlib's own are TeX, which `paper_style` leaves as it stands."""
    from matplotlib.ticker import NullFormatter

    axis.set_major_formatter(_decade)
    axis.set_minor_formatter(_decade if high < 10.0 * low else NullFormatter())


def _decade(value: float, _: int) -> str:
    if 1e-3 <= value < 1e4:
        return f"{value:g}"
    return number(value, 1).replace("1·", "")


def _draw(axis: Any, mark: Mark, layer: float) -> None:
    match mark:
        case Line():
            look = {**STYLES[mark.style]}
            if mark.dashed:
                look["linestyle"] = (0, (3, 1.5))
            if mark.marked:
                look |= {"marker": "o", "markersize": 2.5}
            if "linestyle" in look:
                layer += 0.5  # dashes over a solid line leave both to be seen
            axis.plot(*mark.corners(), label=mark.label or None, zorder=layer, **look)
        case Dots():
            look = {"ms": 1.8 * mark.size, "mew": 0, "color": STYLES[mark.style]["color"]}
            # Rows beside a curve stay pale; dots that the legend names do not.
            look["alpha"] = 1.0 if mark.label else 0.6
            axis.plot(mark.x, mark.y, ".", label=mark.label or None, zorder=layer, **look)
        case Bars():
            look = {"color": STYLES[mark.style]["color"], "label": mark.label or None}
            axis.stairs(
                mark.heights,
                mark.edges,
                fill=True,
                alpha=0.5,
                zorder=layer,
                **look,
            )
        case NamedBars():
            rows = np.arange(len(mark.names))
            colours = [STYLES[name]["color"] for name in mark.styles]
            axis.barh(rows, mark.values, 0.62, color=colours)
            axis.errorbar(
                mark.values,
                rows,
                xerr=[mark.values - mark.low, mark.high - mark.values],
                fmt="none",
                ecolor=BLACK,
                elinewidth=0.7,
                capsize=1.5,
            )
            names = [_parted(name, LONGEST_NAME) for name in mark.names]
            axis.set_yticks(rows, names, fontsize=6.0)
            axis.invert_yaxis()  # the first bar is on top
            axis.grid(False, axis="y")
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


def _titles(axes: Any, plot: Plot, letters: int) -> None:
    """Titles of the axes; panels under one another or side by side name a common axis once."""
    columns = plot.columns
    panels = plot.panels
    height_shares = sum(panel.share for panel in panels[::columns])
    for place, (panel, axis) in enumerate(zip(panels, axes.flat, strict=False)):
        first = place - place % columns  # of the row of panels
        row = panels[first : first + columns]
        row_below = panels[first + columns : first + columns + len(row)]
        same_below: list[bool] = []
        for own, below in zip(row, row_below, strict=False):
            same_below.append(_same(own.x, below.x))
        if len(row_below) == len(row) and all(same_below):  # the row below names the axis
            axis.tick_params(labelbottom=False)
        else:
            badge = f" ({plot.badge})" if plot.badge and panel is panels[-1] else ""
            title = _wrapped(capital(panel.x.title) + badge, letters)
            axis.set_xlabel(title, loc="right" if _names_bars(panel) else "center")

        y_named_before = place > first and _same(panel.y, panels[place - 1].y)
        if y_named_before:
            axis.tick_params(labelleft=False)
        else:
            inches = plot.height * panel.share / height_shares
            characters = int(inches / _CHARACTER)
            axis.set_ylabel(_wrapped(capital(panel.y.title), characters))


def _same(one: Axis, other: Axis) -> bool:
    """Whether two axes show the same, between the same ends; ends that follow from the marks may differ."""
    return one == other and one.low is not None


def _wrapped(title: str, letters: int) -> str:
    """A title in lines of so many letters; a unit stays whole."""
    label, mark, unit = title.partition(" [")
    unit, end, badge = unit.partition("]")
    text = f"{label}{mark}{unit.replace(' ', _TIGHT)}{end}{badge}"
    return textwrap.fill(text, max(6, letters), break_long_words=False, break_on_hyphens=False)


def _legends(
    figure: Any,
    axes: Any,
    plot: Plot,
    letters: int,
) -> None:
    """Names of the marks; a panel with one name has no legend."""
    for panel, axis in zip(plot.panels, axes.flat, strict=False):
        drawn, _ = axis.get_legend_handles_labels()
        by_label = {handle.get_label(): handle for handle in drawn}
        named = sorted(panel.legend(), key=lambda mark: _RANKS.get(mark[0], len(_RANKS)))
        labels = [label for _, label in named]
        handles = [by_label[label] for label in labels]
        if plot.legend == "shared":
            columns = len(labels)
            figure.legend(
                handles,
                labels,
                loc="outside upper center",
                ncols=columns,
                title=plot.legend_title,
            )
            return
        if len(labels) < 2:
            continue
        place: dict[str, Any] = {}
        if plot.legend == "above":
            longest = max(map(len, labels))
            columns = int(plot.width / plot.columns / (_KEY + _LETTER * longest))
            place = {
                "loc": "lower left",
                "bbox_to_anchor": (0.0, 1.0),
                "borderaxespad": 0.2,
                "ncols": max(1, columns),
            }
            if panel.title:  # both stand above the panel: the title over the names, not on them
                side = "right" if _names_bars(panel) else "left"
                axis.set_title("", loc=side)
                weight = "bold" if panel.chosen else "normal"
                place |= {
                    "title": _parted(panel.title, letters),
                    "title_fontproperties": {"size": 7.0, "weight": weight},
                    "alignment": side,
                }
        beside_key = max(8, letters - int(_KEY / _LETTER))
        parted = [_parted(label, beside_key) for label in labels]
        axis.legend(handles, parted, handlelength=1.6, **place)
