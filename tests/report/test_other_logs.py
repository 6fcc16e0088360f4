"""Reports of a log without a field, and of points in no time: they speak of what there is, and offer nothing else."""

from __future__ import annotations

import re
from collections.abc import Callable
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
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.array import Array
from tests.report.test_in_browser import CHROMIUM, browser, visit

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


def test_a_log_without_a_field_is_told_of_none(without_field: Material) -> None:
    page = report_html(without_field)
    assert "no field in the log" in page
    assert "near field" not in page
    assert "as logged, from" not in page
    assert "the log has no field, so no command switches" in page


def test_points_have_no_seconds_and_no_rest(points: Material) -> None:
    page = report_html(points)
    assert "125 points of a table" in page
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


def test_a_low_shear_rate_is_no_rest(points: Material) -> None:
    assert not points.rows.data.at_rest.any()


@pytest.mark.parametrize(("size", "unit"), [(2e6, "kV/mm"), (2e3, "V/m")])
def test_strong_fields_are_read_in_kilovolts_a_millimetre(size: float, unit: str) -> None:
    assert scale_for("V/m", size).unit == unit


@pytest.mark.slow
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
