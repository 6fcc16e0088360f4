"""``/forward``: a yield effort that keeps its sign, as the paper writes equation (10)."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.errors import SettingError
from erclutch.models.law_model import TorqueModel, model_from_dict
from erclutch.models.laws import PAPER, Specification, law_from_name
from erclutch.models.model import Range
from erclutch.models.structure import Reference, Structure
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

E = np.array([0.0, 0.3, 0.5, 0.5])
UNITS = Units("N*m", "1", "rad/s")


def model(name: str, gains: dict[str, float], shape: dict[str, float] | None = None) -> TorqueModel:
    structure = Structure("coaxial", name, law_from_name(name, "coaxial"))
    anywhere = Range((0.0, 1.0), (-100.0, 100.0), (-1.0, 1.0))
    return TorqueModel(structure, Reference(0.5, 10.0, 1e-3), shape or {}, gains, UNITS, anywhere)


def test_equation_10_term_by_term() -> None:
    gains = {"T_y_1": 0.4, "eta_1": 0.02, "T_y_2": 0.3, "eta_2": 0.01}
    w1, w2 = np.array([5.0, -1.0, 2.0, 30.0]), np.array([-5.0, 1.0, -2.0, -30.0])
    zero = np.zeros(4)
    clock = Clock(np.linspace(0.0, 3e-3, 4), (Span(0, 4, 1e-3),))
    first = model("bingham/forward", gains).effort((Element(E, w1), Element(zero, w2)), clock)
    second = model("bingham/forward", gains).effort((Element(zero, w1), Element(E, w2)), clock)
    viscous = 0.02 * w1 / 10.0 + 0.01 * w2 / 10.0
    # The sign of the yield torque is + for CH1 and - for CH2 even where a slip has turned.
    np.testing.assert_allclose(first, 0.4 * (E / 0.5) ** 2 + viscous, atol=1e-15)
    np.testing.assert_allclose(second, -0.3 * (E / 0.5) ** 2 + viscous, atol=1e-15)


@pytest.mark.parametrize("name", PAPER)
def test_where_slips_never_turn_it_is_the_law_itself(name: str) -> None:
    whole = name.removesuffix("/forward")
    turning, forward = law_from_name(whole, "coaxial"), law_from_name(name, "coaxial")
    assert [s.name for s in turning.shape][1:] == [s.name for s in forward.shape]
    shape = [0.5 * (s.scanned[0] + s.scanned[1]) for s in forward.shape]
    w = np.array([0.5, 1.0, 2.0, 3.0])
    for a, b in zip(
        turning.columns(E, w, 1e-3, *shape), forward.columns(E, w, *shape), strict=True
    ):
        np.testing.assert_allclose(a, b, rtol=1e-12)


def test_kept_and_read_again() -> None:
    made = model(
        "bingham/square/forward", {"T_y_1": 0.4, "eta_1": 0.02, "T_y_2": 0.3, "eta_2": 0.01}
    )
    assert model_from_dict(made.to_dict()).structure.law.forward
    assert model_from_dict(made.to_dict()).to_dict() == made.to_dict()


def test_friction_keeps_its_sign_too() -> None:
    law = law_from_name("bingham/forward", "coaxial")
    structure = Structure("coaxial", "bingham/forward", law, "none", friction=True)
    clock = Clock(np.linspace(0.0, 3e-3, 4), (Span(0, 4, 1e-3),))
    slip = np.array([1.0, -1.0, 0.0, 2.0])
    columns = structure.columns(
        (Element(E, slip), Element(E, -slip)), clock, Reference(0.5, 1.0, 1e-3), []
    )
    np.testing.assert_array_equal(columns[2], np.ones(4))
    np.testing.assert_array_equal(columns[5], -np.ones(4))


@pytest.mark.parametrize("name", ["bingham/forwards", "bingham/square/power", "on-off/square"])
def test_unknown_forms(name: str) -> None:
    with pytest.raises(SettingError):
        law_from_name(name)


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("Bingham/forward/square", "bingham/square/forward"),
        (" hem/square/forward/forward ", "hem/square/forward"),
        ("rbfm-10", "rbfm-10"),
        ("bingham/", "bingham"),
    ],
)
def test_a_specification_is_written_in_one_way(text: str, written: str) -> None:
    assert str(Specification.of(text)) == written
