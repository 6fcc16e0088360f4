"""The yield effort changes with the temperature: along a straight line, or in the form ``/exponential``.

::

    f = max(0.01, 1 - b_y (T - T_0))      f = exp(-b_y (T - T_0)),   T and T_0 in K

T_0 is the reference temperature, the root mean square in the training data. The effort of a memory that the field sets
changes with it. The friction of seals does not, nor does a memory without field.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.arithmetic.elementary import less_select
from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import StageFamily
from erclutch.models.stages.temperature_factor import TemperatureFactor

_MEANING = "fall of the yield effort with the temperature"
_FALL = ShapeParameter("b_y", _MEANING, -15.0, 15.0, Dimension(temperature=-1), usual=(-2.0, 4.0))
_SOURCE = "a first-order fit, such as suppliers of fluids print it"
_LEAST = 0.01  # so that a law that divides by the yield effort stays finite


def _linear(t: Any, fall: Any) -> Any:
    left = 1.0 - fall * (t - 1.0)
    return less_select(_LEAST, left, left, _LEAST)


_LINEAR = TemperatureFactor(
    "softening",
    "yield effort that changes in proportion with the temperature",
    _SOURCE,
    "yield effort times max(0.01, 1 - b_y (t - 1))",
    "yield",
    _FALL,
    _linear,
)
_EXPONENTIAL = TemperatureFactor(
    "softening/exponential",
    "yield effort that changes exponentially with the temperature",
    _SOURCE,
    "yield effort times exp(-b_y (t - 1))",
    "yield",
    _FALL,
    lambda t, fall: np.exp(-fall * (t - 1.0)),
)
STAGE = StageFamily(
    lambda count, forms: _EXPONENTIAL if forms else _LINEAR,
    forms=("exponential",),
    ladder=("softening", "softening/exponential"),
)
