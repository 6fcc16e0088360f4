"""Small static plots as inline SVG: colours come from the page's style sheet, so they follow light and dark.

Only what the report needs: lines, dots, cells, bands, axes with round ticks, linear or logarithmic.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from erclutch.diagnostics.text import number

Array = NDArray[np.float64]

_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 10.0, 24.0, 36.0
#: Steps of the colour ramps in the style sheet.
RAMP = 8


@dataclass
class Axis:
    """One axis: its range, whether it is logarithmic, and its heading."""

    low: float
    high: float
    title: str = ""
    log: bool = False

    def share(self, values: Array) -> Array:
        """Where values lie, 0 at the low end, 1 at the high one."""
        a, b, v = self.low, self.high, np.asarray(values, np.float64)
        if self.log:
            a, b, v = math.log(a), math.log(b), np.log(np.maximum(v, 1e-300))
        return (v - a) / ((b - a) or 1.0)

    def ticks(self, most: int) -> list[float]:
        """Round values inside the range."""
        return _decades(self.low, self.high, most) if self.log else _round_steps(self.low, self.high, most)


def _round_steps(low: float, high: float, most: int) -> list[float]:
    rough = (high - low) / max(most, 1)
    if not rough > 0:
        return [low]
    base = 10.0 ** math.floor(math.log10(rough))
    step = next(m * base for m in (1, 2, 5, 10) if m * base >= rough * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _decades(low: float, high: float, most: int) -> list[float]:
    powers = range(math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9) + 1)
    marks = [10.0**p for p in powers]
    if len(marks) <= 2:
        marks = [m * 10.0**p for p in range(powers.start - 1, powers.stop + 1) for m in (1, 2, 5)]
        marks = [m for m in marks if low <= m <= high]
    return marks[:: max(1, math.ceil(len(marks) / most))]


@dataclass
class Plot:
    """A plot that is drawn piece by piece.

    Attributes:
        x, y: axes.
        width, height: of the drawing in its own units.
    """

    x: Axis
    y: Axis
    width: float = 430.0
    height: float = 280.0
    parts: list[str] = field(default_factory=list[str])
    ticks: tuple[int, int] = (6, 5)

    def _px(self, values: Array) -> Array:
        return _LEFT + self.x.share(values) * (self.width - _LEFT - _RIGHT)

    def _py(self, values: Array) -> Array:
        return self.height - _BOTTOM - self.y.share(values) * (self.height - _TOP - _BOTTOM)

    def line(self, x: Array, y: Array, css: str, *, steps: bool = False) -> None:
        """A line; broken where y is not finite."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        if steps:  # y holds over [x_k, x_k+1); x has one value more
            x, y = np.repeat(x, 2)[1:-1], np.repeat(y, 2)
        px, py = self._px(x), np.clip(self._py(y), -50, self.height + 50)
        pen, words = False, list[str]()
        for a, b in zip(px.tolist(), py.tolist(), strict=True):
            if not math.isfinite(b):
                pen = False
                continue
            words.append(f"{'L' if pen else 'M'}{a:.1f} {b:.1f}")
            pen = True
        drawn = f'<path class="{css}" d="{"".join(words)}"/>'
        over = np.any(py < _TOP - 1.0) or np.any(py > self.height - _BOTTOM + 1.0)
        self.parts.append(self._cut(drawn) if over else drawn)

    def _cut(self, drawn: str) -> str:
        """What leaves the axes, cut off there: an inner drawing hides what is outside of it."""
        x, y, width = _LEFT - 1, _TOP - 1, self.width - _LEFT - _RIGHT + 2
        height = self.height - _TOP - _BOTTOM + 2
        box = f"{x:.0f} {y:.0f} {width:.0f} {height:.0f}"
        return f'<svg x="{x:.0f}" y="{y:.0f}" width="{width:.0f}" height="{height:.0f}" viewBox="{box}">{drawn}</svg>'

    def dots(self, x: Array, y: Array, css: str, size: float = 1.6) -> None:
        """Dots inside the axes."""
        px, py = self._px(x), self._py(y)
        keep = (py >= _TOP) & (py <= self.height - _BOTTOM) & (px >= _LEFT) & (px <= self.width - _RIGHT)
        marks = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(px[keep].tolist(), py[keep].tolist(), strict=True))
        if marks:
            self.parts.append(f'<path class="dots {css}" stroke-width="{2 * size:.1f}" d="{marks}"/>')

    def band(self, low: float, high: float, css: str) -> None:
        """A horizontal band."""
        top, bottom = self._py(np.array([high, low])).tolist()
        width = self.width - _LEFT - _RIGHT
        self.parts.append(
            f'<rect class="{css}" x="{_LEFT}" y="{top:.1f}" width="{width:.1f}" height="{bottom - top:.1f}"/>'
        )

    def bars(self, edges: Array, heights: Array, css: str) -> None:
        """A filled histogram."""
        px, py = self._px(edges).tolist(), self._py(heights).tolist()
        base = float(self._py(np.array([self.y.low]))[0])
        words = [f"M{px[0]:.1f} {base:.1f}"]
        for a, b, h in zip(px[:-1], px[1:], py, strict=True):
            words.append(f"L{a:.1f} {h:.1f}L{b:.1f} {h:.1f}")
        self.parts.append(f'<path class="{css}" d="{"".join(words)}L{px[-1]:.1f} {base:.1f}Z"/>')

    def cells(self, x_edges: Array, y_edges: Array, step: NDArray[np.int64], css: str) -> None:
        """Cells in one of `RAMP` colours; -1 leaves a cell out.

        Args:
            x_edges: shape (nx + 1,).
            y_edges: shape (ny + 1,).
            step: colour of each cell, shape (nx, ny).
            css: class of the ramp; its steps are the classes ``css0`` and on.
        """
        px, py = self._px(x_edges).tolist(), self._py(y_edges).tolist()
        for colour in range(RAMP):
            words = [
                f"M{px[i]:.1f} {py[j + 1]:.1f}H{px[i + 1]:.1f}V{py[j]:.1f}H{px[i]:.1f}Z"
                for i, j in np.argwhere(step == colour).tolist()
            ]
            if words:
                self.parts.append(f'<path class="cell {css}{colour}" d="{"".join(words)}"/>')

    def outline(self, x_edges: Array, y_edges: Array, mask: NDArray[np.bool_], css: str) -> None:
        """A mark in each cell of a mask, shape (nx, ny)."""
        px, py = self._px(x_edges).tolist(), self._py(y_edges).tolist()
        words: list[str] = []
        for i, j in np.argwhere(mask).tolist():
            words.append(f"M{px[i]:.1f} {py[j]:.1f}L{px[i + 1]:.1f} {py[j + 1]:.1f}")
            words.append(f"M{px[i]:.1f} {py[j + 1]:.1f}L{px[i + 1]:.1f} {py[j]:.1f}")
        if words:
            self.parts.append(f'<path class="{css}" d="{"".join(words)}"/>')

    def upright(self, x: float, css: str) -> None:
        """A vertical line over the whole height."""
        at = float(self._px(np.array([x]))[0])
        self.parts.append(f'<path class="{css}" d="M{at:.1f} {_TOP}V{self.height - _BOTTOM:.1f}"/>')

    def level(self, y: float, css: str) -> None:
        """A horizontal line over the whole width."""
        at = float(self._py(np.array([y]))[0])
        self.parts.append(f'<path class="{css}" d="M{_LEFT} {at:.1f}H{self.width - _RIGHT:.1f}"/>')

    def words(self, x: float, y: float, text: str, css: str = "note", anchor: str = "start") -> None:
        """Text at a place of the axes."""
        a, b = float(self._px(np.array([x]))[0]), float(self._py(np.array([y]))[0])
        self.parts.append(f'<text class="{css}" x="{a:.1f}" y="{b:.1f}" text-anchor="{anchor}">{escape(text)}</text>')

    def _frame(self) -> str:
        out: list[str] = []
        right, bottom = self.width - _RIGHT, self.height - _BOTTOM
        for value in self.y.ticks(self.ticks[1]):
            at = float(self._py(np.array([value]))[0])
            out.append(f'<path class="grid" d="M{_LEFT} {at:.1f}H{right:.1f}"/>')
            out.append(f'<text x="{_LEFT - 6:.0f}" y="{at + 3.5:.1f}" text-anchor="end">{_mark(value)}</text>')
        for value in self.x.ticks(self.ticks[0]):
            at = float(self._px(np.array([value]))[0])
            out.append(f'<path class="tick" d="M{at:.1f} {bottom:.1f}v4"/>')
            out.append(f'<text x="{at:.1f}" y="{bottom + 16:.1f}" text-anchor="middle">{_mark(value)}</text>')
        out.append(f'<path class="axis" d="M{_LEFT} {bottom:.1f}H{right:.1f}"/>')
        out.append(f'<text class="title" x="4" y="12">{escape(self.y.title)}</text>')
        place = f'x="{right:.1f}" y="{self.height - 4:.1f}" text-anchor="end"'
        out.append(f'<text class="title" {place}>{escape(self.x.title)}</text>')
        return "".join(out)

    def svg(self, label: str, css: str = "") -> Markup:
        """The finished plot, with a sentence that says what is seen for those who do not see it."""
        return Markup(
            f'<svg class="plot {css}" viewBox="0 0 {self.width:.0f} {self.height:.0f}" role="img" '
            f'aria-label="{escape(label)}">{self._frame()}{"".join(self.parts)}</svg>'
        )


def _mark(value: float) -> str:
    if value and (abs(value) < 1e-3 or abs(value) >= 1e5):
        return number(value, 1).replace("1·10", "10")
    return f"{value:g}".replace("-", "−")


def padded(values: Sequence[Array], share: float = 0.04) -> tuple[float, float]:
    """Range of some arrays with a margin."""
    low = min(float(np.nanmin(v)) for v in values)
    high = max(float(np.nanmax(v)) for v in values)
    slack = share * (high - low) or abs(high) or 1.0
    return low - slack, high + slack
