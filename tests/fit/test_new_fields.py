"""A band is wider at fields that no log has, as far as fits without the field of a row err (SYNTHETIC, truth known)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import RunError
from erclutch.fit.bands.new_fields import wider_at_new_fields
from erclutch.fit.bands.prediction_bands import LEVEL, calibrated
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.kinds.law_alone import KIND
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.models.band import MOST_FIELD_EDGES, Band
from erclutch.models.load import load_model
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element

PERIOD, ROWS = 5e-3, 900
FIELDS = (0.0, 0.4, 0.7, 1.0)
UNITS = {"field": "A", "slip": "rad/s", "effort": "N*m"}


def device(fields: Sequence[float], saturates_at: float = 0.0, friction: float = 0.0) -> Dataset:
    """A log for each field, with a yield effort in proportion to it, or one that saturates."""
    rng = np.random.default_rng(0)
    slip = 2.0 * np.sin(2.0 * np.pi * 0.7 * PERIOD * np.arange(ROWS))
    logs: list[Dataset] = []
    for field in fields:
        level = np.tanh(field / saturates_at) if saturates_at else field
        whole = friction + level
        effort = whole * np.tanh(slip / 0.1) + 0.1 * slip + 0.01 * rng.standard_normal(ROWS)
        signals = {"field": np.full(ROWS, field), "slip": slip, "effort": effort}
        data = build_dataset(recording_from_arrays(signals, UNITS, rate=1.0 / PERIOD))
        logs.append(replace(data, sources=(f"log at {field:g} A",)))
    return joined(logs)


def calibrated_on(data: Dataset, error: Array) -> Band:
    made = calibrated(data, np.ones(data.rows, np.bool_), [error], [4])[0]
    assert made is not None
    return made[0]


def width_at(band: Band, field: float, slip: float = 1.0) -> float:
    clock = Clock(np.zeros(1), (Span(0, 1, PERIOD),))
    low, high = band.around(np.zeros(1), (Element(np.array([field]), np.array([slip])),), clock)
    return float((high - low)[0])


@pytest.mark.slow
def test_known_fields_keep_their_band_and_new_fields_have_their_own() -> None:
    data = device(FIELDS)
    rng = np.random.default_rng(1)
    seen, new = 0.1 * rng.standard_normal(data.rows), 0.5 * rng.standard_normal(data.rows)
    band = calibrated_on(data, seen)
    wider = wider_at_new_fields(band, data, new)
    for field in FIELDS:
        assert width_at(wider, field) == width_at(band, field)
        assert width_at(wider, field + 0.03) == width_at(band, field)
    for field in (1.1, 1.5, 100.0):
        assert 2.0 * 1.96 * 0.5 < width_at(wider, field) < 2.0 * 2.8 * 0.5
    fresh = 0.5 * rng.standard_normal(10_000)
    assert np.mean(np.abs(fresh) < 0.5 * width_at(wider, 1.1)) > LEVEL


@pytest.mark.slow
@pytest.mark.parametrize(("field", "apart"), [(0.2, 0.4), (0.55, 0.3), (0.85, 0.3)])
def test_an_error_counts_less_where_the_fields_beside_are_nearer(
    field: float, apart: float
) -> None:
    """Without 0.7 A the fields beside it are 0.6 A apart, without 0.4 A they are 0.7 A apart."""
    data = device(FIELDS)
    wider = wider_at_new_fields(
        calibrated_on(data, 0.01 * np.ones(data.rows)), data, 0.5 * np.ones(data.rows)
    )
    assert width_at(wider, field) == pytest.approx(2.0 * 0.5 * apart / 0.6)


@pytest.mark.slow
def test_a_field_that_differs_a_little_from_log_to_log_is_one() -> None:
    once = device(FIELDS)
    again = device((*FIELDS, 0.4003, 0.7002))
    bands: list[Band] = []
    for data in (once, again):
        band = calibrated_on(data, 0.01 * np.ones(data.rows))
        bands.append(wider_at_new_fields(band, data, 0.5 * np.ones(data.rows)))
    for field in (0.2, 0.55, 0.85):
        assert width_at(bands[1], field) == pytest.approx(width_at(bands[0], field), rel=1e-3)


@pytest.mark.slow
def test_a_log_that_is_never_at_its_mean_field_ends_in_no_error() -> None:
    """A row next to no level of its own log had no rows, and their quantile ended in a traceback."""
    data = device((0.0, 0.9, 1.0, 1.1, 2.0))
    (element,) = data.elements
    field = np.where((element.field == 1.0) & (np.arange(data.rows) % 2 == 0), 0.9, element.field)
    field = np.where(field == 1.0, 1.1, field)
    data = replace(data, elements=(Element(field, element.slip),))
    wider = wider_at_new_fields(
        calibrated_on(data, 0.01 * np.ones(data.rows)), data, 0.5 * np.ones(data.rows)
    )
    assert width_at(wider, 0.5) > 0.1


@pytest.mark.slow
def test_each_log_counts_the_same_and_beyond_all_fields_the_worst_slip_decides() -> None:
    """A short log that errs at large slips alone is a third of its field's logs, so the band holds it."""
    data = device((*FIELDS, 0.4, 0.4))
    slip = np.abs(data.elements[0].slip)
    short = np.arange(data.rows) < data.rows - ROWS + 200
    cut = data.take(short)
    errors = np.where((np.arange(data.rows) >= 5 * ROWS) & (slip > 1.8), 7.0, 0.1)[short]
    wider = wider_at_new_fields(calibrated_on(cut, 0.1 * np.ones(cut.rows)), cut, errors)
    assert width_at(wider, 1.2, 0.2) == 14.0
    assert width_at(wider, 0.55, 0.2) == pytest.approx(14.0 * 0.3 / 0.7)


@pytest.mark.slow
def test_a_new_field_is_judged_by_those_that_were_left_out_like_it() -> None:
    """Between fields of logs the errors of inner fields count, beyond the logs all."""
    data = device(FIELDS)
    error_of = dict(zip(FIELDS, (2.0, 0.3, 0.5, 4.0), strict=True))
    errors = np.array([error_of[round(field, 12)] for field in data.elements[0].field.tolist()])
    wider = wider_at_new_fields(calibrated_on(data, 0.1 * np.ones(data.rows)), data, errors)
    assert width_at(wider, 0.2) == pytest.approx(1.0 * 0.4 / 0.6)
    assert width_at(wider, 0.85) == pytest.approx(1.0 * 0.3 / 0.6)
    assert width_at(wider, 1.2) == 8.0


@pytest.mark.slow
def test_between_two_fields_a_band_is_no_narrower_than_the_mean_at_these() -> None:
    data = device(FIELDS)
    seen = np.where(data.elements[0].field == 1.0, 3.0, 0.1) * np.random.default_rng(
        1
    ).standard_normal(data.rows)
    band = calibrated_on(data, seen)
    wider = wider_at_new_fields(band, data, np.zeros(data.rows))
    for field, below, above in ((0.2, 0.0, 0.4), (0.85, 0.7, 1.0)):
        assert width_at(wider, field) == pytest.approx(
            0.5 * (width_at(band, below) + width_at(band, above))
        )


@pytest.mark.slow
def test_small_errors_at_new_fields_narrow_no_band() -> None:
    data = device(FIELDS)
    band = calibrated_on(data, np.random.default_rng(1).standard_normal(data.rows))
    wider = wider_at_new_fields(band, data, np.zeros(data.rows))
    assert width_at(wider, 0.55) >= min(width_at(band, field) for field in (0.4, 0.7))
    assert width_at(wider, 1.2) >= max(width_at(band, field) for field in FIELDS)


@pytest.mark.slow
def test_fields_near_to_each_other_or_too_many_have_nothing_new_between() -> None:
    near = device((0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8))
    band = wider_at_new_fields(calibrated_on(near, near.effort), near, 9.0 * np.ones(near.rows))
    assert width_at(band, 0.63) < 18.0 <= width_at(band, 1.0)
    one = device((0.5, 0.5))
    band = calibrated_on(one, one.effort)
    assert wider_at_new_fields(band, one, 9.0 * np.ones(one.rows)) == band


@pytest.mark.slow
def test_fields_that_run_into_each_other_are_no_levels() -> None:
    ramp = device(tuple(np.linspace(0.5, 1.0, 60).tolist()))
    band = calibrated_on(ramp, ramp.effort)
    assert wider_at_new_fields(band, ramp, 9.0 * np.ones(ramp.rows)) == band


@pytest.mark.slow
def test_a_field_beyond_those_of_the_logs_lies_inside() -> None:
    """A square of the field, where the truth is in proportion to it: the errors grow beyond the fields of the fit."""
    data = device((*FIELDS, 1.2))
    compared = compare(data, Settings(("bingham/square",), "none", ("log at 1.2 A",)))
    entry = compared.entries[0]
    assert compared.chosen_by == ""
    assert entry.band is not None
    assert entry.band.held.share > 0.95
    plain = calibrated(data, ~compared.test, [data.effort - entry.predicted], [4])[0]
    assert plain is not None
    low, high = plain[0].around(entry.predicted, data.elements, data.clock)
    assert np.mean(((low <= data.effort) & (data.effort <= high))[compared.test]) < 0.6


@pytest.mark.slow
def test_two_fields_do_not_tell_how_the_yield_effort_rises() -> None:
    """Without a third of three fields a fit kept the exponent that all three had told, so it seemed to err by little.

    The band held 1 % of the rows at a field between.
    """
    data = device(FIELDS, saturates_at=0.6, friction=0.3)
    compared = compare(data, Settings(("bingham",), "none", ("log at 0.4 A",)))
    band = compared.entries[0].band
    assert band is not None
    assert band.held.share > 0.9


def test_what_is_in_doubt_counts_between_fields_and_below_all_but_not_beyond() -> None:
    data = device((0.35, 0.7, 1.05))
    usual, in_doubt = 0.5 * np.ones(data.rows), 2.0 * np.ones(data.rows)
    band = calibrated_on(data, 0.1 * np.ones(data.rows))
    wider = wider_at_new_fields(band, data, usual, in_doubt)
    assert width_at(wider, 0.1) == pytest.approx(4.0)
    assert width_at(wider, 0.55) == pytest.approx(4.0 * 0.35 / 0.7)
    assert width_at(wider, 1.2) == 1.0


def test_of_the_fields_below_all_only_the_lowest_is_in_doubt() -> None:
    data = device((0.35, 0.7, 1.05))
    usual = 0.5 * np.ones(data.rows)
    in_doubt = np.where(data.elements[0].field == 1.05, 9.0, usual)
    wider = wider_at_new_fields(
        calibrated_on(data, 0.1 * np.ones(data.rows)), data, usual, in_doubt
    )
    assert width_at(wider, 0.1) == pytest.approx(1.0)


def test_below_all_fields_an_error_counts_more_where_the_way_is_longer() -> None:
    """No field is 0.4 A away from 0.4 A, which is 0.3 A away from the next field."""
    data = device((0.4, 0.7, 1.0))
    errors = np.where(data.elements[0].field == 0.4, 0.9, 0.1)
    wider = wider_at_new_fields(calibrated_on(data, 0.1 * np.ones(data.rows)), data, errors)
    assert width_at(wider, 0.1) == pytest.approx(2.0 * 0.9 * 0.4 / 0.3)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["", "/tanh", "/saturating"])
def test_at_two_fields_a_law_may_rise_as_the_square_of_the_field_or_saturate(form: str) -> None:
    data = device(FIELDS, friction=0.3)
    (candidate,) = KIND.candidates(Settings((f"bingham{form}",), "none"), data)
    outcome = candidate.fit(data, (), 1)
    field = data.elements[0].field
    square, saturating = candidate.refits_in_doubt(data, (field == 0.4) | (field == 1.0), outcome)
    assert square.model.shape["n"] == pytest.approx(2.0, rel=0.01)
    assert saturating.model.shape["E_s"] == pytest.approx(0.5, rel=0.01)
    assert candidate.refits_in_doubt(data, field != 0.7, outcome) == ()


@pytest.mark.slow
@pytest.mark.parametrize("more", [0, 1])
def test_the_file_of_a_model_holds_the_edges(more: int, tmp_path: Path) -> None:
    data = device((*FIELDS, 1.2))
    found = (
        compare(data, Settings(("bingham/power",), "none", ("log at 1.2 A",)))
        .entries[0]
        .outcome.model
    )
    count = MOST_FIELD_EDGES + more
    edges = tuple(0.1 * (k + 1) for k in range(count))
    widths = tuple(0.1 + 0.01 * k for k in range(2 * (count + 1)))
    band = replace(found.band, field_edges=edges, slip_edges=(), behind=widths, ahead=widths)
    path = tmp_path / "model.json"
    path.write_text(json.dumps(replace(found, band=band).to_dict()), encoding="utf-8")
    if more:
        with pytest.raises(RunError, match="field_edges"):
            load_model(path)
    else:
        assert load_model(path).band == band
