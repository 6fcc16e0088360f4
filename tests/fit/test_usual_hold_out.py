"""Where nobody says what to hold out, it is the end of each log, unless the end goes beyond all rows before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.checks.usual_hold_out import usual_hold_out
from erclutch.fit.comparison import Settings, compare
from erclutch.logs.clock.timing import of_points
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD = 0.01  # s
STRETCHES = ("stretches",)


def damper(size: Array, field: Array | None = None) -> Dataset:
    """A friction and a curved viscosity under a sine whose size changes with time (SYNTHETIC)."""
    rng = np.random.default_rng(6)
    time = PERIOD * np.arange(float(size.size))
    slip = size * np.sin(9.0 * time)
    field = np.zeros(size.size) if field is None else field
    effort = (40.0 + 30.0 * field) * np.tanh(slip / 0.01) + 300.0 * np.sign(slip) * np.sqrt(
        np.abs(slip)
    )
    effort += 2.0 * rng.standard_normal(size.size)
    clock = Clock(time, (Span(0, size.size, PERIOD),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N", "A", "m/s"))


FASTER = np.linspace(0.05, 0.5, 4000)
STEADY = np.full(4000, 0.3)
SLOWER = FASTER[::-1]


@pytest.mark.parametrize(
    ("size", "field", "held"),
    [
        (FASTER, None, STRETCHES),
        (STEADY, np.linspace(0.0, 2.0, 4000), STRETCHES),
        (STEADY, None, 0.3),
        (SLOWER, None, 0.3),
        (FASTER[::20], None, 0.3),  # too short to be cut
    ],
)
def test_the_end_is_held_out_unless_it_goes_beyond(
    size: Array, field: Array | None, held: object
) -> None:
    chosen, findings = usual_hold_out(damper(size, field))
    assert chosen == held
    assert len(findings) == (held == STRETCHES)


def test_points_of_a_table_are_held_out_all_over_as_ever() -> None:
    data = damper(FASTER)
    points = replace(data, notes=of_points(data.rows, PERIOD).notes)
    assert usual_hold_out(points) == (0.3, ())


@pytest.mark.parametrize("rows", [1, 2, 3, 60])
def test_a_log_of_next_to_no_rows_is_left_as_it_is(rows: int) -> None:
    assert usual_hold_out(damper(FASTER[:rows]))[0] == 0.3


def test_rows_of_numbers_that_no_device_has_are_beyond() -> None:
    size = STEADY.copy()
    size[3500:] = 1e307
    data = damper(STEADY)
    far = replace(
        data, elements=(Element(np.zeros(size.size), size * np.sign(data.elements[0].slip)),)
    )
    assert usual_hold_out(far)[0] == STRETCHES


@pytest.mark.slow
def test_a_log_that_goes_faster_and_faster_is_fitted_to_its_fast_rows_too() -> None:
    data = damper(FASTER)
    usual = compare(data, Settings(models=("casson",), lag="none"))
    ends = compare(data, Settings(models=("casson",), lag="none", test=0.3))

    assert usual.settings.test == STRETCHES
    (told,) = [finding for finding in usual.findings if finding.subject == "held out"]
    assert "no row before them comes near" in told.message
    assert told.remedy == "--test 0.3 holds out the end"

    assert ends.settings.test == 0.3
    assert [finding for finding in ends.findings if finding.subject == "coverage"]
    assert data.elements[0].slip[~usual.test].max() > 1.3 * data.elements[0].slip[~ends.test].max()
