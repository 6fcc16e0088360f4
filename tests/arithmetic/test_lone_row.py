"""One row by the machine of a record gives the bits of the elementary function that was recorded."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.arithmetic.elementary import BY_NAME, format_of
from erclutch.arithmetic.machine import machine_of
from erclutch.arithmetic.precision import FLOAT64
from erclutch.arithmetic.record import traced

MACHINES = {name: machine_of(traced(name, FLOAT64)) for name in ("exp", "expm1", "tanh")}


@pytest.mark.slow
@settings(deadline=None)
@given(st.sampled_from(sorted(MACHINES)), st.floats(-700.0, 700.0))
def test_a_lone_row_has_the_bits_of_the_function(name: str, x: float) -> None:
    wanted = BY_NAME[name](format_of(FLOAT64), np.array([x]))[0]
    assert MACHINES[name].run(np.array([x])) == wanted


@pytest.mark.parametrize("x", [math.nan, math.inf, -math.inf, 1e61])
def test_a_row_that_may_overflow_is_left_to_the_long_road(x: float) -> None:
    assert math.isnan(MACHINES["exp"].run(np.array([x])))
