"""Figures of a run: three files each, the numbers those of the run, the same bytes again."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from erclutch.errors import CheckError, SettingError
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.report.numbers.run_material import Material, material_of
from erclutch.report.plots.matplotlib_painter import paint
from erclutch.report.plots.paper_style import new_figure, style
from erclutch.report.plots.plot_description import Line, Plot
from erclutch.report.plots.run_plots import FIGURES, write_figure
from erclutch.report.plots.trace_plot import describe_trace
from erclutch.runs.run_folder import Run, read_run
from erclutch.runs.written_run import write_run
from tests.support.slow_params import slow_but


def material_from(folder: Path, models: tuple[str, ...], lag: str) -> Material:
    write_synthetic_log(folder / "log.csv", 4.0)
    recording = read(folder / "log.csv")
    found = compare(build_dataset(recording), Settings(models=models, lag=lag))  # pyright: ignore[reportArgumentType]
    return material_of(read_run(write_run(folder / "run", found, [recording])))


def numbers(path: Path) -> tuple[list[str], list[list[str]]]:
    with path.open(newline="") as file:
        header, *rows = list(csv.reader(file))
    return header, rows


@pytest.mark.slow
@pytest.mark.parametrize("name", slow_but(("trace",), FIGURES))
def test_three_files_each(name: str, material: Material, tmp_path: Path) -> None:
    paths = write_figure(name, material, tmp_path)
    assert [p.name for p in paths] == [f"{name}.pdf", f"{name}.png", f"{name}.csv"]
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(p.name for p in paths)
    assert paths[0].read_bytes().startswith(b"%PDF-")
    assert paths[1].read_bytes().startswith(b"\x89PNG")
    header, rows = numbers(paths[2])
    assert rows
    assert all(len(row) == len(header) for row in rows)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["trace", "residual", "ranking", "parity"])
def test_no_text_is_cut_off_or_left_as_tex(name: str, material: Material) -> None:
    nothing_is_cut_off(FIGURES[name][1](material))


@pytest.mark.slow
@pytest.mark.parametrize(
    "label",
    [
        "casson+fnn-16+rise-fall+lugre/field+inertia+dahl/field",
        "Cho-Choi-Jhon law (one direction) with a network, lags and memory (lugre, inertia, dahl)",
        "a_name_of_ninety_letters_that_no_space_and_no_stage_ever_parts_" + "x" * 27,
    ],
)
def test_a_long_name_in_a_legend_is_not_cut_off(label: str, material: Material) -> None:
    plot = describe_trace(material)
    named = [
        replace(mark, label=label) if isinstance(mark, Line) else mark
        for mark in plot.panels[0].marks[:-1]
    ]
    nothing_is_cut_off(
        replace(plot, panels=[replace(plot.panels[0], marks=[*named, plot.panels[0].marks[-1]])])
    )


def nothing_is_cut_off(plot: Plot) -> None:
    """The legend must not push the axes away, nor leave the figure."""
    with style():
        figure = new_figure(plot.height, plot.width)
        FigureCanvasAgg(figure)
        paint(figure, plot)
        figure.canvas.draw()
        named = [axis.get_legend() for axis in figure.axes]
        texts = [text for legend in named if legend for text in legend.get_texts()]
        labels = [
            one.label
            for axis in figure.axes
            for one in (axis.xaxis, axis.yaxis)
            if one.label.get_text()
        ]
        for text in (*texts, *labels):
            box = text.get_window_extent()
            assert -1 <= box.x0 <= box.x1 <= figure.bbox.width + 1, text
            assert -1 <= box.y0 <= box.y1 <= figure.bbox.height + 1, text
        assert not [text for text in figure.findobj(Text) if "$" in text.get_text()]
        assert all(axis.get_position().width > 0.3 for axis in figure.axes)


@pytest.mark.slow
def test_the_title_of_a_panel_does_not_lie_on_its_legend(material: Material) -> None:
    plot = FIGURES["model"][1](material)
    with style():
        figure = new_figure(plot.height, plot.width)
        FigureCanvasAgg(figure)
        paint(figure, plot)
        figure.canvas.draw()
        titles = [
            text
            for text in figure.findobj(Text)
            if text.get_text().endswith(("over slip", "over the field"))
        ]
        assert len(titles) == len(plot.panels)
        for axis in figure.axes:
            legend = axis.get_legend()
            assert legend is not None
            names = [text.get_window_extent() for text in legend.get_texts()]
            assert not [
                title
                for title in titles
                for name in names
                if title.get_window_extent().overlaps(name)
            ]


def test_a_ranking_says_what_it_leaves_out(material: Material) -> None:
    entries = [dict(material.body["ranking"][0], name=f"model-{k}") for k in range(30)]
    many = replace(material, run=Run(Path("many"), {**material.body, "ranking": entries}))
    assert FIGURES["ranking"][1](many).panels[0].title == "the first 24 of 30 models"
    assert FIGURES["ranking"][1](material).panels[0].title == ""


@pytest.mark.slow
def test_other_formats_and_both_columns(material: Material, tmp_path: Path) -> None:
    paths = write_figure("ranking", material, tmp_path, kinds=("svg",), wide=True)
    assert [p.name for p in paths] == ["ranking.svg", "ranking.csv"]
    assert 'width="515.52pt"' in paths[0].read_text()  # 7.16 inches


@pytest.mark.slow
def test_the_same_bytes_again(material: Material, tmp_path: Path) -> None:
    first, second = (write_figure("ranking", material, tmp_path / name) for name in ("a", "b"))
    assert [p.read_bytes() for p in first] == [p.read_bytes() for p in second]


@pytest.mark.slow
def test_a_trace_holds_the_rows_that_were_asked_for(material: Material, tmp_path: Path) -> None:
    header, rows = numbers(write_figure("trace", material, tmp_path, start=1.0, seconds=0.1)[2])
    time = np.array([float(row[0]) for row in rows])
    assert (time.min(), time.max(), time.size) == (1.0, 1.1, 101)
    at = header.index("effort")
    data = material.rows.data
    assert [float(row[at]) for row in rows] == pytest.approx(
        data.effort[1000:1101].tolist(), rel=1e-8
    )
    with pytest.raises(SettingError, match=r"The log reaches from 0 to 3\.999 s"):
        write_figure("trace", material, tmp_path, start=50.0)


@pytest.mark.slow
def test_what_a_run_cannot_give_is_said(tmp_path: Path) -> None:
    network = material_from(tmp_path, ("fnn-2",), "none")
    with pytest.raises(CheckError, match="the run holds no law"):
        write_figure("flow-curves", network, tmp_path)
    with pytest.raises(SettingError, match="no figure 'fig9'"):
        write_figure("fig9", network, tmp_path)


@pytest.mark.parametrize("name", ["trace", "parity"])
def test_a_legend_calls_a_model_by_its_title(name: str, material: Material) -> None:
    """A specification is longer than a panel; its title fits."""
    labels = {label for panel in FIGURES[name][1](material).panels for _, label in panel.legend()}
    assert material.run.titles[material.recommended] in labels
    assert material.recommended not in labels
