"""The limit against a ramp, and its three ways of computing against each other."""

from __future__ import annotations

import numpy as np

from erclutch.arithmetic.as_in_c import array_as_in_c
from erclutch.arithmetic.dual import partial_of, seed, value_of
from erclutch.models.stages import stage_named
from erclutch.signals.clock import Clock, Span

PERIOD, RATE = 1e-3, 41.3
TIME = PERIOD * np.arange(200)
CLOCK = Clock(TIME, (Span(0, 100, PERIOD), Span(100, 200, PERIOD)))
COMMAND = np.where(np.arange(200) % 100 < 10, 0.0, 1.0)
ALL = slice(None)


def test_a_step_becomes_a_ramp() -> None:
    x = stage_named("slew-rate").respond(COMMAND, CLOCK, (RATE,), ALL)
    wanted = np.clip(
        RATE * PERIOD * np.arange(1, 91), 0.0, 1.0
    )  # the first row of the step moves already
    np.testing.assert_allclose(x[10:100], wanted, atol=1e-12)
    np.testing.assert_array_equal(x[:100], x[100:])


def test_a_slow_command_passes() -> None:
    slow = 0.5 + 0.5 * np.sin(20.0 * TIME)
    np.testing.assert_allclose(
        stage_named("slew-rate").respond(slow, CLOCK, (RATE,), ALL), slow, atol=1e-12
    )


def test_the_bits_are_those_of_the_fit() -> None:
    stage = stage_named("slew-rate")
    whole = stage.respond(array_as_in_c(COMMAND), CLOCK, (RATE,), ALL)
    np.testing.assert_array_equal(np.asarray(whole), stage.respond(COMMAND, CLOCK, (RATE,), ALL))


def test_derivatives() -> None:
    stage = stage_named("slew-rate")
    x = stage.respond(COMMAND, CLOCK, seed([RATE]), slice(5, 60))
    assert value_of(x).shape == (55,)
    ahead, behind = (stage.respond(COMMAND, CLOCK, (RATE + h,), ALL) for h in (1e-4, -1e-4))
    np.testing.assert_allclose(
        partial_of(x, 0), (ahead - behind)[5:60] / 2e-4, rtol=1e-6, atol=1e-9
    )
