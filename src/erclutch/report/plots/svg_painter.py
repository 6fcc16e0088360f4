"""Plots are drawn as inline SVG: colours come from the page's style sheet, so they follow light and dark."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from erclutch.report.numbers.number_text import number
from erclutch.report.plots.plot_description import (
    Bars,
    Cells,
    Dots,
    Line,
    Mark,
    NamedBars,
    Panel,
    ReferenceLine,
    Shade,
)
from erclutch.signals.array import Array

#: Margins around the axes.
_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 10.0, 24.0, 36.0
_DIGIT = 6.4  # of a tick's number, at most
_TO_AXIS = 6.0  # from the number to the axis
_SMALL = 400  # width of a drawing with fewer ticks
#: Steps of the colour ramps in the style sheet.
RAMP = 8
_FEWEST_TICKS = 3
_BROAD = 600  # a drawing of more units is shown wider, so that its text stays as large


def svg(panel: Panel) -> Markup:
    """A panel as one drawing, with its sentence for those who do not see it."""
    width, height = panel.size
    (x_low, x_high), (y_low, y_high) = panel.limits()
    x = _Ruler(x_low, x_high, panel.x.log, _left(panel), width - _RIGHT)
    y = _Ruler(y_low, y_high, panel.y.log, height - _BOTTOM, _TOP)

    # Grid, ticks and titles. A small drawing has fewer ticks.
    frame: list[str] = []
    left = x.first
    right = x.last
    bottom = y.first
    for value in _up(panel, y_low, y_high):
        at = y.one(value)
        place = f'x="{left - _TO_AXIS:.0f}" y="{at + 3.5:.1f}" text-anchor="end"'
        frame.append(f'<path class="grid" d="M{left} {at:.1f}H{right:.1f}"/>')
        frame.append(f"<text {place}>{_mark(value)}</text>")
    most = 6 if width > _SMALL else 5
    marked = [] if panel.x.unmarked else ticks(x_low, x_high, most, log=panel.x.log)
    for value in marked:
        if panel.x.whole and abs(value - round(value)) > 1e-9:
            continue
        at = x.one(value)
        text = _mark(value)
        # The last number may reach beyond the axis, and must not reach beyond the drawing.
        middle = min(at, width - 0.5 * _DIGIT * len(text))
        place = f'x="{middle:.1f}" y="{bottom + 16:.1f}" text-anchor="middle"'
        frame.append(f'<path class="tick" d="M{at:.1f} {bottom:.1f}v4"/>')
        frame.append(f"<text {place}>{text}</text>")
    frame.append(f'<path class="axis" d="M{left} {bottom:.1f}H{right:.1f}"/>')
    frame.append(f'<text class="title" x="4" y="12">{escape(panel.y.title)}</text>')
    place = f'x="{right:.1f}" y="{bottom + 32:.1f}" text-anchor="end"'
    frame.append(f'<text class="title" {place}>{escape(panel.x.title)}</text>')

    drawn = "".join(_drawn(mark, x, y) for mark in panel.marks)
    wide = " broad" if width > _BROAD else ""
    return Markup(
        f'<svg class="plot{wide}" viewBox="0 0 {width} {height}" role="img" aria-label="{escape(panel.says)}">'
        f"{''.join(frame)}{drawn}</svg>"
    )


def inside(panel: Panel) -> tuple[float, float, float, float]:
    """Where the axes of a panel lie, as shares of its drawing: left, top, right, bottom."""
    width, height = panel.size
    return _left(panel) / width, _TOP / height, 1 - _RIGHT / width, 1 - _BOTTOM / height


def _left(panel: Panel) -> float:
    """The margin to the left of the axes: of numbers as long as 0.01914 the first digits would be cut off."""
    low, high = panel.limits()[1]
    longest = max((len(_mark(value)) for value in _up(panel, low, high)), default=0)
    return max(_LEFT, _TO_AXIS + _DIGIT * longest)


def _up(panel: Panel, low: float, high: float) -> list[float]:
    """The ticks of the upward axis; names of bars stand in place of them. A small drawing has fewer."""
    if any(isinstance(mark, NamedBars) for mark in panel.marks):
        return []
    return ticks(low, high, 5 if panel.size[0] > _SMALL else 4, log=panel.y.log)


@dataclass(frozen=True)
class _Ruler:
    """Where the values of an axis lie: the low end at ``first``, the high one at ``last``, in units of the drawing."""

    low: float
    high: float
    log: bool
    first: float
    last: float

    def at(self, values: Array) -> Array:
        low = self.low
        high = self.high
        if self.log:
            low = math.log(low)
            high = math.log(high)
            values = np.log(np.maximum(values, 1e-300))
        share = (values - low) / ((high - low) or 1.0)
        return self.first + share * (self.last - self.first)

    def one(self, value: float) -> float:
        return float(self.at(np.array([value]))[0])

    def holds(self, places: Array) -> NDArray[np.bool_]:
        low = min(self.first, self.last)
        high = max(self.first, self.last)
        return (places >= low) & (places <= high)


def ticks(
    low: float,
    high: float,
    most: int,
    *,
    log: bool = False,
) -> list[float]:
    """Round values inside a range; about as many as asked for."""
    if log:
        # Powers of ten; where two at most lie inside, their doubles and halves too.
        first = math.ceil(math.log10(low) - 1e-9)
        last = math.floor(math.log10(high) + 1e-9)
        marks: list[float] = [10.0**power for power in range(first, last + 1)]
        if len(marks) <= 2:
            marks = []
            for power in range(first - 1, last + 2):
                finer = [digit * 10.0**power for digit in (1, 2, 5)]
                marks += [mark for mark in finer if low <= mark <= high]
        every = max(1, math.ceil(len(marks) / most))
        return marks[::every]
    wanted = (high - low) / max(most, 1)
    if not wanted > 0:
        return [low]
    decade = 10.0 ** math.floor(math.log10(wanted))
    round_steps = [digit * decade for digit in (1, 2, 5, 10)]
    step = next(size for size in round_steps if size >= wanted * 0.999)
    values = _multiples(step, low, high)
    if len(values) < _FEWEST_TICKS:  # a lone 0 says nothing of how long the axis is
        values = _multiples(step / 2, low, high)
    return values


def _multiples(step: float, low: float, high: float) -> list[float]:
    """All multiples of a step inside a range; the slack keeps one that rounding puts just outside."""
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return [k * step for k in range(first, last + 1)]


def _drawn(mark: Mark, x: _Ruler, y: _Ruler) -> str:
    match mark:
        case Line():
            return _line(mark, x, y)
        case Dots():
            return _dots(mark, x, y)
        case Bars():
            edges = x.at(mark.edges).tolist()
            tops = y.at(mark.heights).tolist()
            words = [f"M{edges[0]:.1f} {y.first:.1f}"]
            for (left, right), top in zip(itertools.pairwise(edges), tops, strict=True):
                words.append(f"L{left:.1f} {top:.1f}L{right:.1f} {top:.1f}")
            words.append(f"L{edges[-1]:.1f} {y.first:.1f}Z")
            return f'<path class="bars {mark.style}" d="{"".join(words)}"/>'
        case NamedBars():
            return _named_bars(mark, x, y)
        case Cells():
            return _cells(mark, x, y)
        case Shade() if mark.x is not None:
            across = x.at(mark.x)
            upper = y.at(np.asarray(mark.high, np.float64))
            lower = y.at(np.asarray(mark.low, np.float64))
            there = np.column_stack([across, upper]).tolist()
            back = np.column_stack([across, lower])[::-1].tolist()
            path = "L".join(f"{a:.1f} {b:.1f}" for a, b in [*there, *back])
            return f'<path class="{mark.style}" d="M{path}Z"/>'
        case Shade():
            top, bottom = y.at(np.array([mark.high, mark.low], np.float64))
            place = f'x="{x.first}" y="{top:.1f}" width="{x.last - x.first:.1f}" height="{bottom - top:.1f}"'
            return f'<rect class="{mark.style}" {place}/>'
        case ReferenceLine(axis="x"):
            return f'<path class="zero" d="M{x.one(mark.at):.1f} {y.last}V{y.first:.1f}"/>'
        case ReferenceLine():
            return f'<path class="zero" d="M{x.first} {y.one(mark.at):.1f}H{x.last:.1f}"/>'


def _line(line: Line, x: _Ruler, y: _Ruler) -> str:
    across, up = line.corners()
    px = x.at(across)
    py = np.clip(y.at(up), -50, y.first + 86)  # beyond, the line is cut off all the same
    words: list[str] = []
    pen_down = False
    for a, b in zip(px.tolist(), py.tolist(), strict=True):
        if math.isfinite(b):
            words.append(f"{'L' if pen_down else 'M'}{a:.1f} {b:.1f}")
        pen_down = math.isfinite(b)
    css = f"line {line.style} dashed" if line.dashed else f"line {line.style}"
    drawn = f'<path class="{css}" d="{"".join(words)}"/>'
    leaves_axes = np.any(py < y.last - 1.0) or np.any(py > y.first + 1.0)
    if leaves_axes:  # an inner drawing hides what is outside of it
        left = f"{x.first - 1:.0f}"
        top = f"{y.last - 1:.0f}"
        width = f"{x.last - x.first + 2:.0f}"
        height = f"{y.first - y.last + 2:.0f}"
        place = f'x="{left}" y="{top}" width="{width}" height="{height}"'
        drawn = f'<svg {place} viewBox="{left} {top} {width} {height}">{drawn}</svg>'
    if line.marked:
        drawn += _dots(Dots(line.x, line.y, line.style), x, y)
    return drawn


def _dots(dots: Dots, x: _Ruler, y: _Ruler) -> str:
    px = x.at(dots.x)
    py = y.at(dots.y)
    inside = x.holds(px) & y.holds(py)
    places = zip(px[inside].tolist(), py[inside].tolist(), strict=True)
    path = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in places)
    if not path:
        return ""
    return f'<path class="dots {dots.style}" stroke-width="{2 * dots.size:.1f}" d="{path}"/>'


def _named_bars(bars: NamedBars, x: _Ruler, y: _Ruler) -> str:
    """The first bar is on top, so row k lies where an axis that points up has the number of the rows below it."""
    from_below = np.arange(len(bars.names), dtype=np.float64)[::-1]
    rows = y.at(from_below).tolist()
    half = 0.31 * abs(y.one(1.0) - y.one(0.0))
    ends = x.at(bars.values).tolist()
    lows = x.at(bars.low).tolist()
    highs = x.at(bars.high).tolist()
    zero = x.one(0.0)
    out: list[str] = []
    for name, style, at, end, low, high in zip(
        bars.names, bars.styles, rows, ends, lows, highs, strict=True
    ):
        place = f'x="{min(zero, end):.1f}" y="{at - half:.1f}" width="{abs(end - zero):.1f}" height="{2 * half:.1f}"'
        whisker = (
            f"M{low:.1f} {at:.1f}H{high:.1f}M{low:.1f} {at - 3:.1f}v6M{high:.1f} {at - 3:.1f}v6"
        )
        out.append(f'<rect class="bars {style}" {place}/><path class="whisker" d="{whisker}"/>')
        out.append(f'<text x="{x.first + 5:.0f}" y="{at + 3.5:.1f}">{escape(name)}</text>')
    return "".join(out)


def _cells(cells: Cells, x: _Ruler, y: _Ruler) -> str:
    px = x.at(cells.x_edges).tolist()
    py = y.at(cells.y_edges).tolist()
    colours = cells.steps(RAMP)
    drawn: list[str] = []
    for colour in range(RAMP):  # one path a colour keeps the page small
        words: list[str] = []
        for i, j in np.argwhere(colours == colour).tolist():
            words.append(f"M{px[i]:.1f} {py[j + 1]:.1f}H{px[i + 1]:.1f}V{py[j]:.1f}H{px[i]:.1f}Z")
        if words:
            drawn.append(f'<path class="cell {cells.style}{colour}" d="{"".join(words)}"/>')

    crosses: list[str] = []
    if cells.crossed is not None:
        for i, j in np.argwhere(cells.crossed).tolist():
            # In a wide cell crosses stand side by side: a single one would be two flat lines.
            wide = abs(px[i + 1] - px[i]) / abs(py[j + 1] - py[j])
            crosses_beside = max(1, round(0.5 * wide))
            width = (px[i + 1] - px[i]) / crosses_beside
            for place in range(crosses_beside):
                left = px[i] + place * width
                right = left + width
                crosses.append(f"M{left:.1f} {py[j]:.1f}L{right:.1f} {py[j + 1]:.1f}")
                crosses.append(f"M{left:.1f} {py[j + 1]:.1f}L{right:.1f} {py[j]:.1f}")
    if crosses:
        drawn.append(f'<path class="blind" d="{"".join(crosses)}"/>')
    return "".join(drawn)


def _mark(value: float) -> str:
    if value and (abs(value) < 1e-3 or abs(value) >= 1e5):
        return number(value, 1).replace("1·10", "10")
    return f"{value:g}".replace("-", "−")
