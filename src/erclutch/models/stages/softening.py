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
_LEAST = 0.01  # so that a law that divides by the yield effort stays finite


def _linear(t: Any, fall: Any) -> Any:
    left = 1.0 - fall * (t - 1.0)
    return less_select(_LEAST, left, left, _LEAST)


def _exponential(t: Any, fall: Any) -> Any:
    return np.exp(-fall * (t - 1.0))


def _softening(count: int, forms: tuple[str, ...]) -> TemperatureFactor:
    return TemperatureFactor(
        "softening/exponential" if forms else "softening",
        f"yield effort that changes {'exponentially' if forms else 'in proportion'} with the temperature",
        "a first-order fit, such as suppliers of fluids print it",
        "yield effort times " + ("exp(-b_y (t - 1))" if forms else "max(0.01, 1 - b_y (t - 1))"),
        "yield",
        _FALL,
        _exponential if forms else _linear,
    )


STAGE = StageFamily(
    _softening, forms=("exponential",), ladder=("softening", "softening/exponential")
)
