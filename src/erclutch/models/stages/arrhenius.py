"""The viscous effort falls with the temperature as Arrhenius has it.

::

    f = exp(B_eta(1 / T - 1 / T_0)), T and T_0 in K

T_0 is the reference temperature, the root mean square in the training data. B_eta is an activation energy over the
gas constant: 1,000 to 2,000 K for silicone oils, up to some 6,000 K for mineral oils.
"""

from __future__ import annotations

import numpy as np

from erclutch.models.laws.law import Dimension, ShapeParameter
from erclutch.models.stages.stage import StageFamily
from erclutch.models.stages.temperature_factor import TemperatureFactor

_MEANING = "activation energy of the viscosity over the gas constant"
_RATE = ShapeParameter("B_eta", _MEANING, 0.03, 40.0, Dimension(temperature=1), "log", (1.0, 20.0))


_ARRHENIUS = TemperatureFactor(
    "arrhenius",
    "viscosity that falls with the temperature",
    "Andrade 1934, doi 10.1080/14786443409462427, after Arrhenius",
    "viscous effort times exp(B_eta (1/t - 1))",
    "viscous",
    _RATE,
    lambda t, rate: np.exp(rate * ((1.0 - t) / t)),
)
STAGE = StageFamily(lambda count, forms: _ARRHENIUS, ladder=("arrhenius",))
