"""Painters: both draw any description, from the same numbers, and say what they draw."""

from __future__ import annotations

import csv
import itertools
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg

from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.matplotlib_painter import paint, save_plot
from erclutch.report.plots.paper_style import RAMPS, STYLES, new_figure, style
from erclutch.report.plots.plot_description import (
    Axis,
    Bars,
    Cells,
    Dots,
    Line,
    NamedBars,
    Panel,
    Plot,
    PlotTable,
    ReferenceLine,
    Shade,
)
from erclutch.report.plots.run_plots import FIGURES
from erclutch.report.plots.svg_painter import RAMP, svg, ticks

X = np.linspace(0.0, 4.0, 5)
VALUES = np.array([[1.0, 10.0], [np.nan, 100.0]])
MARKS = {
    "line": Line(X, X**2, "recommended", "a law"),
    "staircase": Line(X, X[:-1], "best", "steps", steps=True),
    "marked": Line(X, X, "series1", "points", dashed=True, marked=True),
    "dots": Dots(X, X, "level3", "rows"),
    "bars": Bars(X, X[:-1], "recommended", "share"),
    "named": NamedBars(["a & b", "two", "three"], X[1:4], X[:3], X[2:], ["best", "other", "other"]),
    "shade": Shade(1.0, 2.0),
    "shade between curves": Shade(
        np.array([1.0, 1.5, 1.0]), np.array([2.0, 2.5, 2.0]), x=np.array([0.0, 1.0, 2.0])
    ),
    "level": ReferenceLine(3.0),
    "upright": ReferenceLine(3.0, "x"),
    "cells": Cells(X[:3], X[:3], VALUES, 100.0, "mass", "rows", log=True, crossed=np.isnan(VALUES)),
}
SVG = "{http://www.w3.org/2000/svg}"


def panel_of(*names: str) -> Panel:
    return Panel(
        Axis("slip", "rad/s", 0.0, 4.0),
        Axis("effort", "N", 0.0, 16.0),
        [MARKS[n] for n in names],
        "What <is> seen & said.",
    )


def parsed(panel: Panel) -> ElementTree.Element:
    return ElementTree.fromstring(
        str(svg(panel)).replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1)
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", MARKS)
def test_both_painters_draw_each_mark(name: str) -> None:
    empty, drawn = (len(str(svg(panel_of(*names)))) for names in ((), (name,)))
    assert drawn > empty
    root = parsed(panel_of(name))
    assert root.get("aria-label") == "What <is> seen & said."
    assert {"slip [rad/s]", "effort [N]"} <= {text.text for text in root.iter(f"{SVG}text")}
    with style():
        counts: list[int] = []
        for names in ((), (name,)):
            figure = new_figure(2.0)
            paint(figure, Plot([panel_of(*names)], PlotTable((), ()), 2.0))
            counts.append(len(figure.axes[0].get_children()))
    assert counts[1] > counts[0]


def test_a_line_lies_where_its_numbers_say() -> None:
    panel = Panel(
        Axis("x", "", 0.0, 1.0),
        Axis("y", "", 0.0, 1.0),
        [Line(np.array([0.0, 1.0]), np.array([0.0, 1.0]), "ref")],
    )
    (path,) = (p for p in parsed(panel).iter(f"{SVG}path") if p.get("class") == "line ref")
    assert (
        path.get("d") == "M46.0 264.0L420.0 24.0"
    )  # the corners of the axes in a drawing of 430 x 300


def test_long_numbers_beside_an_axis_are_not_cut_off() -> None:
    """Of 0.01914 the first digits lay outside of the drawing."""
    ends = np.array([0.0, 1.0])
    panel = Panel(
        Axis("x", "", 0.0, 1.0),
        Axis("y", "", 0.01904, 0.01916),
        [Line(ends, 0.0191 + 0 * ends, "ref")],
    )
    marks = [
        text
        for text in parsed(panel).iter(f"{SVG}text")
        if text.get("text-anchor") == "end" and text.text
    ]
    longest = max(
        (text for text in marks if text.text and text.text.startswith("0.019")),
        key=lambda t: len(t.text or ""),
    )
    assert len(longest.text or "") >= 7
    assert float(longest.get("x", "0")) > 6.0 * len(longest.text or "")


def test_named_bars_lie_from_the_top_and_end_at_their_values() -> None:
    panel = Panel(Axis("x", "", 0.0, 4.0), Axis("", "", -0.6, 2.6), [MARKS["named"]])
    first, second, third = (
        r for r in parsed(panel).iter(f"{SVG}rect") if "bars" in (r.get("class") or "")
    )
    assert [r.get("class") for r in (first, second, third)] == [
        "bars best",
        "bars other",
        "bars other",
    ]
    assert float(first.get("y", "")) < float(second.get("y", "")) < float(third.get("y", ""))
    width = (430 - 46 - 10) / 4.0  # of one unit of x
    assert [float(r.get("width", "")) for r in (first, second)] == pytest.approx(
        [width, 2 * width], abs=0.1
    )
    words = [text.text for text in parsed(panel).iter(f"{SVG}text")]
    assert {"a & b", "two"} <= set(words)
    assert "0.5" not in words  # rows have names in place of numbers


def test_a_gap_breaks_a_line_and_what_leaves_the_axes_is_cut() -> None:
    gap = Line(X, np.array([0.0, 1.0, np.nan, 3.0, 4.0]), "ref")
    assert str(svg(Panel(Axis("x"), Axis("y"), [gap]))).count("M") > str(
        svg(panel_of("line"))
    ).count("M")
    tall = Panel(Axis("x"), Axis("y", "", 0.0, 1.0), [MARKS["line"]])
    assert len(list(parsed(tall).iter(f"{SVG}svg"))) == 2


def test_cells_have_the_colours_of_their_legend() -> None:
    cells = MARKS["cells"]
    assert isinstance(cells, Cells)
    steps, largest = cells.steps(RAMP), cells.largest(RAMP)
    assert steps[1, 0] == -1
    assert largest[-1] == pytest.approx(100.0)
    for value, step in zip(VALUES[np.isfinite(VALUES)], steps[steps >= 0], strict=True):
        assert value <= largest[step] * 1.001
        assert step == 0 or value >= largest[step - 1] * 0.999


@pytest.mark.slow
@pytest.mark.parametrize("log", [False, True])
@given(low=st.floats(-1e6, 1e6), width=st.floats(1e-3, 1e6))
def test_ticks_lie_inside_any_range(log: bool, low: float, width: float) -> None:
    low = abs(low) + 1e-6 if log else low
    found = ticks(low, low + width, 6, log=log)
    assert len(found) <= 8
    slack = 1e-6 * width + 1e-9 * (abs(low) + width)
    assert all(low - slack <= t <= low + width + slack for t in found)


def test_every_meaning_has_its_colour_on_the_page_and_in_print() -> None:
    """A style that only one painter knows would be drawn black, or not at all, by the other."""
    import erclutch

    css = (Path(erclutch.__file__).parent / "report/assets/report.css").read_text()
    for name in (*STYLES, *(f"{ramp}{k}" for ramp in RAMPS for k in range(RAMP))):
        assert name == "other" or re.search(rf"\.{name}\b", css), name


@pytest.mark.slow
def test_the_table_is_the_one_described(tmp_path: Path) -> None:
    table = PlotTable(("a", "b"), [(1, 2.0), (3, 0.1)])
    bars = NamedBars(["one", "two"], X[1:3], X[:2], X[2:4], ["best", "other"])
    paths = save_plot(Plot([Panel(Axis("x"), Axis(""), [bars])], table, 2.0), tmp_path / "p.png")
    assert [p.name for p in paths] == ["p.png", "p.csv"]
    assert list(csv.reader(paths[1].read_text().splitlines())) == [
        ["a", "b"],
        ["1", "2"],
        ["3", "0.1"],
    ]


@pytest.mark.slow
def test_the_page_shows_the_panels_of_the_figures(material: Material) -> None:
    """The page and the paper draw the same description."""
    from erclutch.report.html.report_page import report_html

    html = report_html(material)
    for name in ("error-map", "parity", "residual", "lag", "flow-curves"):
        for panel in FIGURES[name][1](material).panels:
            assert panel.says
            assert str(svg(panel)) in html, name


@pytest.mark.slow
def test_panels_of_a_row_name_their_axis_alike() -> None:
    """One of them stands over another axis, so both keep their numbers."""
    time, rate = Axis("time", "s", 0.0, 1.0), Axis("rate", "Hz", 0.0, 1.0)
    y = Axis("value", "", 0.0, 1.0)
    plot = Plot(
        [Panel(x, y, []) for x in (rate, rate, rate, time)], PlotTable((), ()), 4.0, columns=2
    )
    with style():
        figure = new_figure(plot.height, plot.width)
        paint(figure, plot)
        FigureCanvasAgg(figure).draw()
        assert [axis.get_xlabel() for axis in figure.axes] == [
            "Rate [Hz]",
            "Rate [Hz]",
            "Rate [Hz]",
            "Time [s]",
        ]


@pytest.mark.slow
def test_titles_below_narrow_panels_do_not_meet_and_the_badge_stands_once() -> None:
    x, y = Axis("field", "units as logged", 0.0, 1.0), Axis("value")
    plot = Plot(
        [Panel(x, y, []) for _ in range(3)], PlotTable((), ()), 4.0, columns=3, badge="TWIN"
    )
    with style():
        figure = new_figure(plot.height, plot.width)
        paint(figure, plot)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        boxes = [axis.xaxis.label.get_window_extent(canvas.get_renderer()) for axis in figure.axes]
        assert all(one.x1 < other.x0 for one, other in itertools.pairwise(boxes))
        assert boxes[-1].x1 < figure.bbox.x1
        assert [axis.get_xlabel().count("TWIN") for axis in figure.axes] == [0, 0, 1]


def test_an_axis_of_whole_numbers_has_no_other_ticks() -> None:
    panel = Panel(Axis("device", "", 0.9, 3.1, whole=True), Axis("value", "", 5.0, 6.0), [])
    assert re.findall(r'text-anchor="middle">([^<]+)<', str(svg(panel))) == ["1", "2", "3"]


def test_no_number_below_a_plot_is_cut_off_at_its_right_edge() -> None:
    """Of 3000 at the end of an axis half of the last digit was gone."""
    panel = Panel(Axis("slip", "rpm", 0.0, 3000.0), Axis("torque", "N*m"), [Line(X, X, "best")])
    places = re.findall(r'x="([\d.]+)" y="[\d.]+" text-anchor="middle">3000<', svg(panel))
    assert len(places) == 1
    half = 0.5 * 4 * 6.4  # four digits, each at most so wide
    assert float(places[0]) + half <= panel.size[0]


def test_crosses_in_wide_cells_stand_side_by_side() -> None:
    """One cross over a cell as broad as the plot was a pair of flat lines."""
    crossed = np.array([[True] * 20])
    cells = Cells(X[:2], np.arange(21.0), np.ones((1, 20)), 1.0, "heat", "", crossed=crossed)
    blind = re.search(r'class="blind" d="([^"]+)"', svg(Panel(Axis("x"), Axis("y"), [cells])))
    assert blind is not None
    strokes = re.findall(r"M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)", blind[1])
    slopes = [abs(float(d) - float(b)) / abs(float(c) - float(a)) for a, b, c, d in strokes]
    assert min(slopes) > 0.3
    assert len(strokes) >= 20 * 10


def test_an_axis_that_measures_nothing_has_no_ticks(tmp_path: Path) -> None:
    panel = Panel(Axis("no field", "", -0.5, 0.5, unmarked=True), Axis("y"), [Line(X, X, "best")])
    assert 'class="tick"' not in svg(panel)
    with style():
        figure = new_figure(2.0, 3.5)
        paint(figure, Plot([panel], PlotTable((), ()), height=2.0))
    assert list(figure.axes[0].get_xticks()) == []
