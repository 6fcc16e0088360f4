"""Reports of a log without a field, and of points in no time: they speak of what there is, and offer nothing else."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import build_dataset
from erclutch.report.html.report_page import report_html, write_report
from erclutch.report.numbers.error_map import ErrorMap
from erclutch.report.numbers.number_text import scale_for
from erclutch.report.numbers.run_material import Material, material_of
from erclutch.report.plots.error_map_plot import describe_error_map
from erclutch.report.plots.loops_plot import describe_loops
from erclutch.report.plots.plot_description import Cells
from erclutch.report.plots.svg_painter import svg
from erclutch.report.plots.trace_plot import describe_trace
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.array import Array
from tests.report.test_in_browser import CHROMIUM, browser, visit

pytestmark = pytest.mark.slow

__all__ = ["browser", "visit"]


def reported(
    folder: Path, header: str, columns: tuple[Array, ...], fields: dict[str, str], lag: str = "auto"
) -> Material:
    """Fit laws to a log of these columns."""
    log = folder / "log.csv"
    lines = [",".join(f"{value:.6g}" for value in row) for row in zip(*columns, strict=True)]
    log.write_text("\n".join([header, *lines]) + "\n")
    recording = read(log, fields)
    found = compare(build_dataset(recording), Settings(models=("bingham", "casson"), lag=lag))
    return material_of(read_run(write_run(folder / "run", found, [recording])))


@pytest.fixture(scope="module")
def without_field(tmp_path_factory: pytest.TempPathFactory) -> Material:
    """A brake that nobody drives, SYNTHETIC."""
    time = np.arange(6000) / 500
    slip = 3 * np.sin(np.pi * time) + 1.5 * np.sin(2.6 * np.pi * time)
    noise = np.random.default_rng(1).normal(0, 0.02, time.size)
    torque = 0.04 * np.tanh(slip / 0.1) + 0.02 * slip + 0.1 * noise
    return reported(
        tmp_path_factory.mktemp("without"),
        "time [s],speed [rad/s],torque [N m]",
        (time, slip, torque),
        {"field": "none"},
    )


@pytest.fixture(scope="module")
def points(tmp_path_factory: pytest.TempPathFactory) -> Material:
    """Points of a rheometer at five fields, SYNTHETIC."""
    field = np.repeat(np.linspace(0.0, 2.0, 5), 25)
    rate = np.tile(np.geomspace(0.1, 300.0, 25), 5)
    stress = (5 + 200 * field**1.6 + 0.8 * rate) * (
        1 + np.random.default_rng(2).normal(0, 0.01, rate.size)
    )
    return reported(
        tmp_path_factory.mktemp("points"),
        "field [kV/mm],shear rate [1/s],shear stress [Pa]",
        (field, rate, stress),
        {"time": "none"},
    )


@pytest.fixture(scope="module")
def sheet(tmp_path_factory: pytest.TempPathFactory) -> Material:
    """A brake's bench sheet of 40 points, each one held out between others, SYNTHETIC."""
    field = np.repeat(np.arange(5) / 2.0, 8)
    speed = np.tile(np.linspace(10.0, 80.0, 8), 5)
    noise = np.random.default_rng(4).normal(0.0, 0.01, speed.size)
    torque = 0.2 + 3.0 * field + 0.004 * speed + noise
    names = "I [A],speed [rad/s],torque [Nm]"
    return reported(tmp_path_factory.mktemp("sheet"), names, (field, speed, torque), {})


def test_a_sheet_of_few_points_is_reported_without_holes(sheet: Material) -> None:
    page = report_html(sheet)
    assert "40 points of a table" in page
    assert "range holds no row" not in page
    assert page.count("Log more, or choose a smaller network") <= 1 + page.count("is left out:")
    assert max(cells.blind_share for cells in sheet.error_maps) == 0.0


def test_a_log_without_a_field_is_told_of_none(without_field: Material) -> None:
    page = report_html(without_field)
    assert "no field in the log" in page
    assert "near field" not in page
    assert "as logged, from" not in page
    assert "the log has no field, so no command switches" in page


def test_points_have_no_seconds_and_no_rest(points: Material) -> None:
    page = report_html(points)
    assert "125 points of a table" in page
    assert "point of the table" in page
    assert "time [s]" not in page
    assert "are at rest" not in page
    assert "whose field has stayed" not in page
    assert "the rows are points of a table, none after another in time" in page
    assert points.field.unit == "kV/mm"


@pytest.mark.parametrize("name", ["without_field", "points"])
def test_no_sequence_is_offered_that_cannot_be_made(
    name: str, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    material = request.getfixturevalue(name)
    monkeypatch.setattr(ErrorMap, "empty_share_at_its_fields", 0.9)
    page = report_html(material)
    assert "range holds no row (error map)" in page
    assert "erclutch excite" not in page


@pytest.fixture(scope="module")
def noise(tmp_path_factory: pytest.TempPathFactory) -> Material:
    """An effort that follows nothing, SYNTHETIC."""
    random = np.random.default_rng(3)
    time = np.arange(4000) / 500
    columns = (
        time,
        random.uniform(0, 2, time.size),
        3 * np.sin(np.pi * time),
        random.normal(0, 0.3, time.size),
    )
    header = "time [s],current [A],speed [rad/s],torque [N m]"
    return reported(tmp_path_factory.mktemp("noise"), header, columns, {}, lag="none")


def test_where_nothing_explains_no_form_of_the_field_is_praised(noise: Material) -> None:
    page = report_html(noise)
    assert "No model is recommended" in page
    assert "Its torque does not follow the field." in page
    assert "so each torque has one field" not in page


def test_a_share_of_the_variance_near_none_is_read_at_once(noise: Material) -> None:
    """It was 6.308·10⁻⁸."""
    page = report_html(noise)
    fact = page.partition("of the variance explained")[2][:200]
    assert re.search(r"[0−]\.?\d*\.\d{4}\D", fact)
    assert "10⁻" not in fact


@pytest.mark.slow
def test_a_low_shear_rate_is_no_rest(points: Material) -> None:
    assert not points.rows.data.at_rest.any()


@pytest.mark.parametrize(("size", "unit"), [(2e6, "kV/mm"), (2e3, "V/m")])
def test_strong_fields_are_read_in_kilovolts_a_millimetre(size: float, unit: str) -> None:
    assert scale_for("V/m", size).unit == unit


@pytest.mark.skipif(not CHROMIUM.exists(), reason="needs chromium: apt install chromium")
def test_long_numbers_stay_in_their_box(
    without_field: Material, visit: Callable[..., Any], tmp_path: Path
) -> None:
    """Figures of 0.0021 N m are wider than those of 53 N: table and colour scale have room for them."""
    page = visit(write_report(without_field, tmp_path / "report.html"))
    box = page.locator("#ranking .scroll").first
    assert box.evaluate("box => box.scrollWidth - box.clientWidth") <= 0
    swatches = page.locator(".ramps .swatch").evaluate_all(
        "all => all.map(s => s.scrollWidth - s.clientWidth)"
    )
    assert max(swatches) <= 0
    assert re.search(r"RMSE", page.locator(".ramps").inner_text())


EPOCH = 1716392011.25  # s, of the first row


@pytest.fixture(scope="module")
def stamped(without_field: Material) -> Material:
    """The same log with stamps of a computer's clock."""
    rows = without_field.rows
    clock = replace(rows.data.clock, time=rows.data.clock.time + EPOCH)
    return replace(without_field, rows=replace(rows, data=replace(rows.data, clock=clock)))


@pytest.mark.slow
def test_epochs_are_counted_from_the_start_of_the_log(stamped: Material) -> None:
    """Ten digits lay on each other below the traces, and each tick of a plot was 2·10⁹."""
    page = report_html(stamped)
    assert '"time":[[0,0.0],' in page
    assert "Time counts from 1716392011.25 s, the start of the log." in page
    assert "·10⁹" not in page
    assert "e+09" not in page
    held_out = re.search(r"Held-out rows from ([\d.]+) to ([\d.]+) s", page)
    assert held_out is not None
    assert 0.0 < float(held_out[1]) < float(held_out[2]) <= 12.0

    trace = describe_trace(stamped)
    assert trace.panels[0].x.title == "time from 1716392011.25 s [s]"
    assert all(0.0 <= end <= 12.0 for end in trace.panels[0].limits()[0])
    first_cell = trace.table.rows[0][0]
    assert isinstance(first_cell, float)
    assert first_cell >= EPOCH  # numbers beside the plot keep the log's own clock
    assert all("from 1" not in panel.caption for panel in describe_loops(stamped).panels)


@pytest.mark.slow
def test_a_clock_that_begins_near_zero_is_shown_as_it_is(without_field: Material) -> None:
    assert "Time counts from" not in report_html(without_field)
    assert describe_trace(without_field).panels[0].x.label == "time"
    assert without_field.clock_start(5999) == 0.0


def test_each_log_of_a_run_counts_from_its_own_start(stamped: Material) -> None:
    data = replace(stamped.rows.data, sources=("a", "b"), source_rows=((0, 3000), (3000, 6000)))
    material = replace(stamped, rows=replace(stamped.rows, data=data))
    assert material.clock_start(2999) == EPOCH
    assert material.clock_start(3000) == pytest.approx(EPOCH + 6.0)


def test_the_map_of_one_field_is_as_broad_as_its_axis(without_field: Material) -> None:
    """Thirty-two cells beside each other were empty but one."""
    (cells,) = without_field.error_maps
    assert cells.train.shape[0] == 1
    assert cells.empty_share == cells.empty_share_at_its_fields
    errors, training = describe_error_map(without_field).panels
    assert errors.x.unmarked
    assert training.x.unmarked
    assert 'class="tick"' not in svg(errors)


def test_no_plot_shows_a_field_that_no_log_has(without_field: Material) -> None:
    assert len(describe_trace(without_field).panels) == 2
    assert '"kind":"field"' not in report_html(without_field)


def test_a_bar_that_leaves_the_scale_is_torn(without_field: Material) -> None:
    """It ended in the whisker of a band that lay far outside."""
    assert "torn" not in report_html(without_field).partition("</style>")[2]
    *others, last = without_field.body["ranking"]
    far = {**last, "test": {**last["test"], "rmse": [5.0, 4.0, 6.0]}}
    body = {**without_field.body, "ranking": [*others, far]}
    page = report_html(replace(without_field, run=replace(without_field.run, body=body)))
    (torn,) = re.findall(r'<svg class="bar[^>]*>(?:(?!</svg>).)*class="torn".*?</svg>', page)
    assert torn.count("<path") == 1
    assert "A bar that is torn at its end is longer than the scale." in page
    assert '<span class="unseen">off the scale</span>' in page


@pytest.mark.skipif(not CHROMIUM.exists(), reason="needs chromium: apt install chromium")
def test_a_map_without_a_field_speaks_of_slip_alone(
    stamped: Material, visit: Callable[..., Any], tmp_path: Path
) -> None:
    page = visit(write_report(stamped, tmp_path / "report.html"))
    plot = page.locator("[data-map] svg.plot").first
    plot.scroll_into_view_if_needed()
    plot.hover()
    assert page.inner_text("#mapread").startswith("slip ")
    assert page.locator("#panel-field .uplot").count() == 0
    assert page.locator("#panel-slip .uplot").count() == 1


@pytest.mark.skipif(not CHROMIUM.exists(), reason="needs chromium: apt install chromium")
def test_errors_by_log_leave_room_for_the_table(
    without_field: Material, visit: Callable[..., Any], tmp_path: Path
) -> None:
    """Of two logs the last columns were cut off: a reach of 0.0589 to 0.0602 did not break."""
    ranking = [
        {**entry, "rmse_by_log": [0.00589, 0.00602, 2]} for entry in without_field.body["ranking"]
    ]
    run = replace(without_field.run, body={**without_field.body, "ranking": ranking})
    page = visit(write_report(replace(without_field, run=run), tmp_path / "report.html"))
    box = page.locator("#ranking .scroll").first
    assert box.evaluate("box => box.scrollWidth - box.clientWidth") <= 0


@pytest.mark.parametrize(("largest", "beyond"), [(0.5, False), (1.0, False), (3.0, True)])
def test_a_cell_beyond_the_last_colour_is_known(largest: float, beyond: bool) -> None:
    """The key of the map ended at 20 N where a cell had 51.7 N."""
    edges = np.arange(3.0)
    values = np.array([[np.nan, 0.2], [largest, 0.1]])
    cells = Cells(edges, edges, values, top=1.0, style="heat", label="RMSE [N]")
    assert cells.go_beyond == beyond
