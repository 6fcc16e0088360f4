"""Yield stress follows the field in one of these forms, each scaled to one at the reference field (normalised field 1).

All grow with the field but two: `CONSTANT`, and `FALLING` for a device that its field releases.

Sources: power law, Huang and Ishikawa equation (1) with exponents 1 - 2; critical-field form, Choi, Cho, Kim and Jhon
2001, tau_y ~ E**2 tanh(sqrt(E / E_c)) / sqrt(E / E_c), checked in docs/decisions/0003-sources-of-ss-and-ccj.md; the
tanh of magnetic saturation, in which MR fluids are usually quoted (tau_y ~ tanh(6.33e-6 H)), with an exponent of ours.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from erclutch.models.laws.law import FIELD, ShapeParameter, YieldForm
from erclutch.models.laws.smooth import power


def _square(E: Any) -> Any:
    return E * E


def _critical(E: Any, E_c: Any) -> Any:
    # E**2 tanh(sqrt x) / sqrt x with x = E / E_c is E**1.5 tanh(sqrt x) up to a constant, taken up by the gain.
    return power(E, 1.5) * np.tanh(power(E / E_c, 0.5)) / np.tanh(E_c**-0.5)


def _saturating(E: Any, n: Any, E_s: Any) -> Any:
    return np.tanh(power(E / E_s, n)) / np.tanh(power(1.0 / E_s, n))


def _tanh(E: Any, E_s: Any) -> Any:
    return np.tanh(E / E_s) / np.tanh(1.0 / E_s)


def _falling(E: Any, E_r: Any) -> Any:
    return np.exp((1.0 - E) / E_r)


def _constant(E: Any) -> Any:
    return 1.0 + 0.0 * E


SQUARE = YieldForm("square", "E^2", _square, ())
POWER = YieldForm(
    "power",
    "E^n",
    power,
    (ShapeParameter("n", "exponent of the field in the yield effort", 0.2, 4.0),),
)
CRITICAL = YieldForm(
    "critical",
    "Choi",
    _critical,
    (
        ShapeParameter(
            "E_c",
            "critical field, where the exponent turns from 2 to 1.5",
            0.05,
            20.0,
            FIELD,
            scale="log",
        ),
    ),
)

#: A magnetic fluid stops to follow the field where its particles saturate.
SATURATING = YieldForm(
    "saturating",
    "saturating",
    _saturating,
    (
        ShapeParameter("n", "exponent of a small field in the yield effort", 0.2, 4.0),
        ShapeParameter(
            "E_s", "field at which the yield effort saturates", 0.2, 20.0, FIELD, scale="log"
        ),
    ),
)

#: The same with an exponent of one: as many numbers as the power law, and less bent next to zero field.
TANH = YieldForm(
    "tanh",
    "tanh",
    _tanh,
    (
        ShapeParameter(
            "E_s", "field at which the yield effort saturates", 0.2, 20.0, FIELD, scale="log"
        ),
    ),
)

#: A magnet holds the effort and a current takes it away, as in a brake that is safe without power; or the "field" is a
#: magnet's distance, as of an eddy-current brake. Below a bound of 0.1 the field at rest would have e^10 times T_y.
FALLING = YieldForm(
    "falling",
    "falling",
    _falling,
    (
        ShapeParameter(
            "E_r",
            "field over which the yield effort falls to its e-th part",
            0.1,
            20.0,
            FIELD,
            scale="log",
        ),
    ),
)

#: For a log with one field: the yield effort is one number. Any other field gives the same effort.
CONSTANT = YieldForm("constant", "const", _constant, ())

_ALL = (SQUARE, POWER, CRITICAL, SATURATING, TANH, FALLING, CONSTANT)
YIELD_FORMS = {form.name: form for form in _ALL}
