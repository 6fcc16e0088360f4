"""Names that are cut short, with a point behind or without, speak as the whole words do. SYNTHETIC."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs.columns.names import spoken_name
from tests.support.plans_of_columns import planned

TIME = np.arange(1200) / 200
FIELD = np.repeat([0.0, 1.0, 0.5, 1.5], 300)
SPEED = 12.0 * np.sin(5 * TIME)
TORQUE = (0.2 + 1.5 * FIELD) * np.tanh(SPEED / 0.3)


@pytest.mark.parametrize(
    ("time", "field", "slip", "effort"),
    [
        ("t", "Curr.", "Vel.", "Torq."),
        ("Zeit", "Strom", "Geschw.", "Kr."),
        ("Zeit", "Str.", "Drehz.", "Drehm."),
        ("Zeit", "Spg.", "Drehz.", "Mom."),
        ("Tps", "Cour.", "Vit.", "Cple"),
        ("t", "curr.", "ang. vel.", "torq."),
        ("Zeit", "Str.", "Gesch.", "Kr."),
        ("Tiempo", "Corr.", "Vel.", "Fza."),
        ("time", "Volt.", "Veloc.", "Forc."),
    ],
)
def test_short_names_are_signals(time: str, field: str, slip: str, effort: str) -> None:
    plan = planned({f"{time} [s]": TIME, field: FIELD, slip: SPEED, effort: TORQUE})
    assert not plan.questions, plan.questions
    taken = {each.signal: each.column for each in plan.signals}
    assert taken == {"field": field, "slip": slip, "effort": effort}


@pytest.mark.parametrize("name", ["Torque corr.", "Temp.", "Press.", "Acc.", "Nr.", "Visc."])
def test_a_point_makes_no_signal_of_other_words(name: str) -> None:
    assert not spoken_name(name).may_be


@pytest.mark.parametrize("name", ["kr", "str", "sp", "mom", "int", "corr"])
def test_letters_without_a_point_are_no_signal(name: str) -> None:
    assert not spoken_name(name).may_be
