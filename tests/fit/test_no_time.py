"""Points of a table, none after another in time, are fitted without a lag, a memory or past samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.cli.ranking_table import prediction
from erclutch.errors import SettingError
from erclutch.fit.bands.band_pieces import kind_of_pieces, pieces
from erclutch.fit.bands.prediction_bands import calibrated
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.history import history
from erclutch.logs import recording_from_arrays
from erclutch.logs.clock.timing import of_points
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.held_out import hold_out
from erclutch.signals.device import Element


def points(rows: int = 1200) -> Dataset:
    """A curve with a field that is switched from point to point, whose effort follows the field a row later."""
    rng = np.random.default_rng(0)
    field = np.repeat(rng.integers(0, 3, rows // 4).astype(float), 4)
    slip = np.linspace(1.0, 50.0, rows)
    effort = 2.0 * np.roll(field, 1) + 0.01 * slip + 0.01 * rng.standard_normal(rows)
    signals = {"field": field, "slip": slip, "effort": effort}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    data = build_dataset(recording_from_arrays(signals, units, rate=1.0))
    return replace(data, notes=(*data.notes, *of_points(rows, 1.0).notes))


@pytest.mark.slow
def test_no_lag_is_offered_and_a_line_says_why() -> None:
    comparison = compare(points(), Settings(models=("bingham",)))
    assert [entry.outcome.model.structure.dynamics for entry in comparison.entries] == ["none"]
    assert any("the rows are points of a table" in str(finding) for finding in comparison.findings)

    # No point teaches the next one, and points have no piece that could be the worst.
    (entry,) = comparison.entries
    assert entry.band is not None
    assert entry.band.with_sensor is None
    said = prediction(entry, "N*m")[0]
    assert "of the rows held out; mean width" in said
    assert "sensor" not in said


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (Settings(models=("bingham",), lag="lag"), "the stages lag follow a time"),
        (Settings(models=("bingham+dahl",)), "the stages dahl follow a time.*Leave dahl out"),
        (Settings(models=("bingham+sides+inertia",)), "the stages inertia follow a time"),
        (Settings(models=("bingham",), lag="stiffness+viscous"), "the stages stiffness follow"),
        (Settings(models=("fnn-2",), past=(1,)), "past samples follow a time"),
    ],
)
def test_what_needs_a_time_is_refused(asked: Settings, said: str) -> None:
    with pytest.raises(SettingError, match=said):
        compare(points(), asked)


def test_a_history_is_not_looked_for() -> None:
    data = points()
    assert data.in_no_time
    assert history(data) is None


def swept(levels: int) -> Dataset:
    """A table of points, sorted by speed, with every field at every speed."""
    speed = np.repeat(np.linspace(1.0, 50.0, 60), levels)
    field = np.tile(np.arange(levels) / 2.0, 60)
    signals = {"field": field, "slip": speed, "effort": 0.1 + field + 0.01 * speed}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    data = build_dataset(recording_from_arrays(signals, units, rate=1.0))
    return replace(data, notes=(*data.notes, *of_points(data.rows, 1.0).notes))


@pytest.mark.parametrize("levels", [1, 2, 3, 5])
@pytest.mark.parametrize("share", [0.2, 0.3, 0.5])
def test_points_held_out_lie_within_the_speeds_and_at_all_fields(levels: int, share: float) -> None:
    data = swept(levels)
    held = hold_out(data, share)
    slip, field = data.elements[0].slip, data.elements[0].field
    assert held.mean() == pytest.approx(share, abs=0.03)
    assert slip[~held].min() <= slip[held].min()
    assert slip[held].max() <= slip[~held].max()
    assert np.ptp(slip[held]) > 0.75 * np.ptp(slip)
    for level in np.unique(field):
        assert held[field == level].mean() == pytest.approx(share, abs=0.1)
    # A point between two others that are held out is no stretch of one row: it is kept.
    assert data.take(~held).rows + data.take(held).rows == data.rows


def test_no_point_is_told_to_be_switching_in_whatever_order_they_are_written() -> None:
    data = swept(3)
    rng = np.random.default_rng(5)
    error = rng.standard_normal(data.rows) * (1.0 + data.elements[0].field)
    everything = np.ones(data.rows, np.bool_)
    for order in (np.arange(data.rows), rng.permutation(data.rows)):
        element = data.elements[0]
        written = replace(data, elements=(Element(element.field[order], element.slip[order]),))
        (result,) = calibrated(written, everything, [error[order]], [4])
        assert result is not None
        band, _ = result
        _, fields, slips = band.shape
        assert (band.cells(written.elements, written.clock) < fields * slips).all()


def test_a_band_of_points_is_told_by_points_and_not_by_seconds() -> None:
    data = swept(2)
    held = hold_out(data, 0.3)
    assert [name for name, _ in pieces(data, held)] == [f"{held.sum()} points"]
    assert kind_of_pieces(data) == ""
