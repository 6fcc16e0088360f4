"""Frequencies of a spectrum beside a course of time are called like a force and a speed, and are neither."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.signals.array import Array

ROWS = 300
FREQUENCIES = np.arange(float(ROWS)) * 0.25
INPUT = np.sin(0.11 * np.arange(float(ROWS)))


def _plan(columns: dict[str, Array], told: ColumnMap | None = None) -> Plan:
    time = np.arange(float(ROWS)) * 0.002
    table = Table("a", {"t": time, "input": INPUT, **columns}, {}, "0" * 64)
    return plan_of(table, told or ColumnMap())


def _columns(plan: Plan) -> set[str]:
    return {each.column for each in plan.signals if each.column}


@pytest.mark.parametrize(("frequency", "angular"), [("f", "w"), ("freq", "omega")])
def test_a_frequency_and_an_angular_frequency_are_no_force_and_no_speed(
    frequency: str, angular: str
) -> None:
    plan = _plan({frequency: FREQUENCIES, angular: 2.0 * np.pi * FREQUENCIES})
    assert _columns(plan).isdisjoint({frequency, angular})
    assert any("frequencies" in note for note in plan.notes)


@pytest.mark.parametrize("spectrum", ["mag", "phase_data", "fft_out"])
def test_frequencies_beside_a_spectrum_are_no_signal(spectrum: str) -> None:
    plan = _plan({"f": FREQUENCIES, spectrum: np.cos(0.3 * np.arange(float(ROWS)))})
    assert "f" not in _columns(plan)


def test_a_speed_that_is_ramped_up_beside_a_force_stays_a_speed() -> None:
    plan = _plan({"w": 3.0 * FREQUENCIES, "f": np.tanh(FREQUENCIES) + 0.1 * INPUT})
    assert {"w", "f"} <= _columns(plan)


def test_frequencies_that_the_user_names_are_taken() -> None:
    told = ColumnMap.from_options({"slip": "w", "effort": "f", "field": "none"})
    plan = _plan({"f": FREQUENCIES, "w": 2.0 * np.pi * FREQUENCIES}, told)
    assert {"w", "f"} <= _columns(plan)


@pytest.mark.parametrize(("name", "rows"), [("f", ROWS), ("freq", ROWS + 1), ("w", ROWS)])
def test_an_axis_around_zero_is_no_signal_without_a_spectrum_beside_it(
    name: str, rows: int
) -> None:
    axis = (np.arange(float(rows)) - rows // 2) * (
        200.0 / rows
    )  # Hz, as a shifted transform has them
    table = Table("a", {"t": np.arange(float(rows)) * 0.005, name: axis}, {}, "0" * 64)
    plan = plan_of(table, ColumnMap())
    assert name not in _columns(plan)
    assert any("from minus its end" in note for note in plan.notes)


def test_a_force_that_is_ramped_through_zero_with_its_noise_stays_a_force() -> None:
    force = FREQUENCIES - FREQUENCIES[-1] / 2.0 + 0.01 * np.sin(7.0 * FREQUENCIES)
    assert "f" in _columns(_plan({"f": force, "v [m/s]": np.tanh(force)}))
