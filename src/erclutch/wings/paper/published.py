"""Huang and Ishikawa print these figures in their tables: facts to compare with. No model and no twin uses them.

Only the calibration of the default twin is told the summary figures that it should come near, and says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Printed:
    """One approach of tables II and III: mean squared errors in N^2 m^2; None where the table has no entry.

    Attributes:
        title: as printed.
        train, test: table II.
        zero_field, zero_motion: table III.
    """

    title: str
    train: float
    test: float
    zero_field: float | None = None
    zero_motion: float | None = None


#: Approaches by our name of the model.
APPROACHES: Mapping[str, Printed] = {
    "bingham/forward": Printed("Bingham basic", 9.3285e-5, 1.8840e-4, 5.5329e-5, 4.4685e-3),
    "seo-seo/forward": Printed("SS model", 6.3870e-5, 6.5099e-5, 7.3162e-5, 2.5201e-3),
    "hem/forward": Printed("HEM", 5.7981e-5, 5.9232e-5, 6.5249e-5, 2.2441e-3),
    "rbfm-5/forward": Printed("RBFM (5 kernels)", 5.6833e-5, 5.4622e-5),
    "rbfm-10/forward": Printed("RBFM (10 kernels)", 5.6757e-5, 5.4524e-5, 1.0183e-4, 2.0413e-3),
    "rbfn-10": Printed("RBFN (10 neurons)", 3.6013e-5, 3.7933e-5),
    "rbfn-50": Printed("RBFN (50 neurons)", 2.6146e-5, 3.3274e-5, 9.7811e-5, 3.4315e-3),
    "fnn-6": Printed("FNN (6 neurons)", 2.1708e-5, 1.8172e-5),
    "fnn-16": Printed("FNN (16 neurons)", 1.8542e-5, 1.6703e-5, 4.0527e-5, 1.9825e-3),
    "fnn-10-6": Printed("FNN (10, 6 neurons)", 1.7718e-5, 1.6382e-5),
}
#: Temperature rise of a housing over about 20 minutes of tracking, section IV-C, in K.
WARMING = 0.4
