"""A plot is described as data: panels, axes, marks and the table behind them. Each painter draws the same description.

A mark names what it means ("measured", "recommended", "heat") and never a colour. `svg_painter` takes the colours from
the page's style sheet, `matplotlib_painter` those of `paper_style.STYLES`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from erclutch.report.numbers.number_text import titled
from erclutch.signals.array import Array

#: Widths of one and two columns of a paper in inches.
COLUMN, PAGE = 3.5, 7.16


@dataclass(frozen=True)
class Axis:
    """One axis.

    Attributes:
        label: what it shows, without a capital.
        unit: as printed; empty for a pure number.
        low, high: its limits; None leaves both to the marks.
        log: whether it is logarithmic.
        whole: whether its ticks stand at whole numbers only.
        unmarked: whether it has no ticks, for it measures nothing.
    """

    label: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    log: bool = False
    whole: bool = False
    unmarked: bool = False

    @staticmethod
    def over(
        label: str,
        unit: str,
        values: Array,
        *,
        log: bool = False,
    ) -> Axis:
        """An axis from the first of some values, shape (n,), to the last."""
        return Axis(label, unit, float(values[0]), float(values[-1]), log=log)

    @property
    def title(self) -> str:
        """The label with the unit in brackets."""
        return titled(self.label, self.unit)


@dataclass(frozen=True)
class Line:
    """A line that breaks where y is not finite.

    Attributes:
        x, y: shapes (n,); of a staircase x may have one value more, which ends the last step.
        style: what the line means.
        label: in the legend; empty leaves the line out.
        steps: whether y holds until the next x.
        dashed: dashes tell two lines of one panel apart in print without colours.
        marked: whether each point has a dot.
    """

    x: Array
    y: Array
    style: str
    label: str = ""
    steps: bool = False
    dashed: bool = False
    marked: bool = False

    def corners(self) -> tuple[Array, Array]:
        """The points that straight lines join."""
        if not self.steps:
            return self.x, self.y
        y = self.y
        if y.size < self.x.size:  # the last step ends at the last x
            y = np.append(y, y[-1:])
        return np.repeat(self.x, 2)[1:], np.repeat(y, 2)[:-1]


@dataclass(frozen=True)
class Dots:
    """Points of shapes (n,), with their radius in units of the page's drawing; those outside the axes are left out."""

    x: Array
    y: Array
    style: str
    label: str = ""
    size: float = 1.6


@dataclass(frozen=True)
class Bars:
    """A filled histogram: edges (n + 1,), heights (n,)."""

    edges: Array
    heights: Array
    style: str
    label: str = ""


@dataclass(frozen=True)
class NamedBars:
    """Bars to the right with whiskers, the first on top: all of shape (n,), and what each bar means."""

    names: Sequence[str]
    values: Array
    low: Array
    high: Array
    styles: Sequence[str]


@dataclass(frozen=True)
class Shade:
    """A band between two values of y; with ``x`` between two curves, all of shape (n,)."""

    low: float | Array
    high: float | Array
    style: str = "band"
    x: Array | None = None


@dataclass(frozen=True)
class ReferenceLine:
    """A thin line over the whole panel at a value of one axis."""

    at: float
    axis: Literal["x", "y"] = "y"


@dataclass(frozen=True)
class Cells:
    """A map of coloured cells.

    Attributes:
        x_edges, y_edges: shapes (nx + 1,), (ny + 1,).
        values: nan leaves a cell out, shape (nx, ny).
        top: value of the strongest colour; what is above has the same colour.
        style: the colour ramp: "heat" or "mass".
        label: of the colour bar.
        log: whether colours follow log(1 + value).
        crossed: cells with a cross, shape (nx, ny).
    """

    x_edges: Array
    y_edges: Array
    values: Array
    top: float
    style: str
    label: str
    log: bool = False
    crossed: NDArray[np.bool_] | None = None

    def steps(self, count: int) -> NDArray[np.int64]:
        """Which of so many colours each cell has, shape (nx, ny); -1 leaves it out."""
        share = self.values / self.top
        if self.log:
            share = np.log1p(self.values) / (np.log1p(self.top) * 1.0001)
        share = np.nan_to_num(share, nan=-1.0)
        colour = np.clip((share * count).astype(np.int64), 0, count - 1)
        return np.where(share < 0, -1, colour)

    @property
    def go_beyond(self) -> bool:
        """Whether a cell has more than the largest value of the colours: it has the last colour too."""
        return bool(np.nanmax(self.values, initial=0.0) > self.top)

    def largest(self, count: int) -> list[float]:
        """Largest value of each of so many colours."""
        shares = np.arange(1, count + 1) / count
        largest = np.expm1(np.log1p(self.top) * shares) if self.log else self.top * shares
        return largest.tolist()


Mark: TypeAlias = Line | Dots | Bars | NamedBars | Shade | ReferenceLine | Cells


@dataclass(frozen=True)
class Panel:
    """Marks on two axes.

    Attributes:
        x, y: axes.
        marks: the first lies at the bottom.
        says: a sentence for those who do not see the panel.
        title: above the panel.
        caption: below the panel in the page.
        chosen: whether the title stands out.
        square: whether both axes have the same scale in print.
        size: of the drawing in the page, in its own units.
        share: of the height in print, over those of the other panels.
    """

    x: Axis
    y: Axis
    marks: Sequence[Mark]
    says: str = ""
    title: str = ""
    caption: str = ""
    chosen: bool = False
    square: bool = False
    size: tuple[int, int] = (430, 300)
    share: float = 1.0

    def legend(self) -> list[tuple[str, str]]:
        """Style and label of each mark with a label."""
        named: list[tuple[str, str]] = []
        for mark in self.marks:
            if isinstance(mark, Line | Dots | Bars) and mark.label:
                named.append((mark.style, mark.label))
        return named

    def cells(self) -> Iterator[Cells]:
        """The coloured maps of the panel."""
        return (m for m in self.marks if isinstance(m, Cells))

    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ranges of both axes: those given, else around the marks."""
        across: list[Array] = []  # values of each mark along both axes
        up: list[Array] = []
        for mark in self.marks:
            match mark:
                case Line() | Dots():
                    across.append(mark.x)
                    up.append(mark.y)
                case Bars():
                    across.append(mark.edges)
                    up.append(np.append(mark.heights, 0.0))
                case NamedBars():
                    across.append(np.append(mark.high, 0.0))
                    up.append(np.array([-0.6, len(mark.names) - 0.4]))  # ends of the rows of bars
                case Cells():
                    across.append(mark.x_edges)
                    up.append(mark.y_edges)
                case Shade(x=x) if x is not None:
                    across.append(x)
                    up += [np.atleast_1d(mark.low), np.atleast_1d(mark.high)]
                case Shade() | ReferenceLine():  # they lie within what others span
                    pass
        return _range(self.x, across), _range(self.y, up)


def _range(axis: Axis, values: Sequence[Array]) -> tuple[float, float]:
    if axis.low is not None and axis.high is not None:
        return axis.low, axis.high
    flat = np.concatenate([*values, np.zeros(0)])
    flat = flat[np.isfinite(flat)]
    if axis.log:
        flat = flat[flat > 0.0]
    low = float(flat.min()) if flat.size else 0.1
    high = float(flat.max()) if flat.size else 1.0
    if axis.log:
        return low / 1.3, high * 1.3
    slack = 0.05 * (high - low) or 0.5
    return low - slack, high + slack


@dataclass(frozen=True)
class PlotTable:
    """The table behind a plot, in the units of the run: names of the columns, and rows of values."""

    header: Sequence[str]
    rows: Sequence[Sequence[object]]


@dataclass(frozen=True)
class Plot:
    """A whole plot.

    Attributes:
        panels: from left to right, then down.
        table: the numbers behind it.
        height, width: in print, in inches.
        columns: panels beside each other in print.
        title: above all panels in print.
        badge: TWIN or another word where the data are no recording; it stands in the print.
        legend: where print names the marks: inside each panel, above each panel, or above all panels at once.
        legend_title: over the legend above all panels.
    """

    panels: Sequence[Panel]
    table: PlotTable
    height: float
    width: float = COLUMN
    columns: int = 1
    title: str = ""
    badge: str = ""
    legend: Literal["inside", "above", "shared"] = "inside"
    legend_title: str = ""
