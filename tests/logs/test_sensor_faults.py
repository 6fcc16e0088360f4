"""Spikes, a saturated effort and a stuck one are told apart, left out with a word and a count, or kept."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Table, apply, plan_of
from erclutch.logs.rows.sensor_faults import saturated, spikes, stuck
from erclutch.signals.array import Array
from erclutch.signals.recording import Recording

DRAWN = np.random.default_rng(7)
TIME = np.arange(4000) / 1000
SLIP = 3 * np.sin(TIME * 9)
EFFORT = 2 * np.tanh(SLIP) + 0.3 * SLIP + DRAWN.normal(0, 0.01, 4000)


def recording(effort: Array, slip: Array = SLIP, **how: str) -> Recording:
    columns = {"time": TIME, "slip": slip, "torque": effort}
    units = {"time": "s", "slip": "rad/s", "torque": "N*m"}
    table = Table("a.csv", columns, units, "0" * 64)
    return apply(plan_of(table, ColumnMap(values=how.get("values"))), table)


def told(log: Recording) -> list[str]:
    return [note for note in log.notes if "the first in data row" in note]


def changed(values: Array, rows: slice | list[int], to: float) -> Array:
    other = values.copy()
    other[rows] = to
    return other


def test_a_clean_log_loses_no_row() -> None:
    assert recording(EFFORT).rows == 4000
    assert told(recording(EFFORT)) == []


@pytest.mark.parametrize("rows", [[500], [500, 501], [300, 700, 3000]])
def test_spikes_are_left_out(rows: list[int]) -> None:
    log = recording(changed(EFFORT, rows, 40.0))
    assert log.rows == 4000 - len(rows)
    (note,) = told(log)
    assert f"column torque has spikes (up to 40) in {len(rows)} row" in note
    assert "left out and the log cut there (--keep-values keeps them)" in note


def test_spikes_of_the_slip_are_left_out() -> None:
    assert recording(EFFORT, changed(SLIP, [900], -70.0)).rows == 3999


def test_spikes_are_kept_where_that_is_asked() -> None:
    log = recording(changed(EFFORT, [500], 40.0), values="keep")
    assert log.rows == 4000
    assert "kept, as asked" in told(log)[0]


def test_a_blow_that_rings_is_no_spike() -> None:
    blow = EFFORT + 40 * np.where(
        TIME > 0.5, np.exp(-(TIME - 0.5) * 300) * np.cos((TIME - 0.5) * 2500), 0.0
    )
    assert not spikes(blow).any()
    assert not spikes(EFFORT + 10 * (TIME > 2)).any()  # a step


def test_a_blow_that_comes_up_over_several_rows_is_no_spike() -> None:
    """The highest rows of an impact were left out of a speed that went up to them, as the position said too."""
    speed = 2.0 * np.sin(2 * np.pi * TIME)
    speed[1500:1505] = [1.5, 3.7, 5.4, 7.3, 7.9]
    assert not spikes(speed).any()
    speed[1500:1505] = [1.5, 1.5, 1.5, 1.5, 7.9]
    assert np.flatnonzero(spikes(speed)).tolist() == [1504]


def test_few_large_strokes_of_a_resting_device_are_no_spikes() -> None:
    burst = np.where(np.abs(TIME - 2) < 0.004, 5.0, 0.0) + DRAWN.normal(0, 0.01, 4000)
    assert not spikes(burst).any()


def test_a_saturated_effort_is_left_out() -> None:
    log = recording(np.clip(EFFORT, -2.5, 2.5))
    assert log.rows == int(np.count_nonzero(np.abs(EFFORT) < 2.5))
    assert [note.partition(" in ")[0] for note in told(log)] == [
        "column torque sits at an end of its sensor's range (-2.5)",
        "column torque sits at an end of its sensor's range (2.5)",
    ]


def test_dry_friction_and_rest_are_no_saturation() -> None:
    assert saturated(2 * np.sign(SLIP)) == {}
    assert saturated(np.maximum(EFFORT, 0.0)) == {}  # a torque of one sign rests at 0
    assert saturated(np.round(EFFORT, 1)) == {}  # coarse digits


def test_a_stuck_effort_is_left_out() -> None:
    log = recording(changed(EFFORT, slice(1000, 1500), 0.123))
    assert log.rows == 3500
    (note,) = told(log)
    assert (
        "torque is stuck at 0.123 while column slip moves in 500 rows, the first in data row 1001"
        in note
    )


def test_an_effort_that_stays_while_nothing_moves_is_not_stuck() -> None:
    resting = np.where((TIME > 1) & (TIME < 1.5), 0.0, SLIP)
    assert not stuck(changed(EFFORT, slice(1000, 1500), 0.123), resting).any()
    assert not stuck(np.full(4000, 0.5), SLIP).any()


def of_three(field: Array, slip: Array, effort: Array) -> Recording:
    columns = {"time": TIME, "current": field, "slip": slip, "torque": effort}
    units = {"time": "s", "current": "A", "slip": "rad/s", "torque": "N*m"}
    table = Table("a.csv", columns, units, "0" * 64)
    return apply(plan_of(table, ColumnMap()), table)


LEVELS = np.repeat([0.5, 1.0, 0.2, 0.8], 1000)


@pytest.mark.parametrize("value", [0.0, -1.0, 5.0])
@pytest.mark.parametrize("rows", [slice(560, 561), slice(2560, 2572)])
def test_one_number_in_all_columns_at_once_is_no_measurement(value: float, rows: slice) -> None:
    log = of_three(*(changed(each, rows, value) for each in (LEVELS, SLIP, EFFORT)))
    assert log.rows == 4000 - (rows.stop - rows.start)
    (note,) = told(log)
    assert note.startswith(
        f"columns current, slip, torque all hold {value:g} and jump there and back in"
    )


@pytest.mark.parametrize("many", [30, 200])
def test_rows_that_the_logger_repeats_are_left_out(many: int) -> None:
    stuck_at = slice(560, 560 + many)
    log = of_three(*(changed(each, stuck_at, each[559]) for each in (LEVELS, SLIP, EFFORT)))
    assert log.rows == 4000 - many
    (note,) = told(log)
    assert "stand still together and then jump" in note


def test_a_device_that_rests_and_starts_again_loses_no_row() -> None:
    rests = np.where((TIME > 1.0) & (TIME < 1.5), 0.0, np.sin(9 * TIME))
    slip = np.asarray(np.round(np.cumsum(rests) / 100, 3), dtype=np.float64)
    effort = np.asarray(np.round(2 * np.tanh(rests), 2), dtype=np.float64)
    assert told(of_three(LEVELS, slip, effort)) == []


@pytest.mark.slow
def test_channels_that_repeat_every_sample_ten_times_lose_no_row() -> None:
    slip, effort = (np.repeat(each[::10], 10) for each in (SLIP, EFFORT))
    assert told(of_three(LEVELS, slip, effort)) == []
