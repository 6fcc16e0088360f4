"""A joint whose speed is made of an encoder's positions: its inertia is found, and no spring in its place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.checks.noisy_acceleration import noisy_acceleration
from erclutch.fit.choice.ladder import grown, in_place_of_a_travel
from erclutch.fit.choice.rungs import Rung
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.array import Array

RATE, SECONDS = 500.0, 12.0
#: Friction in N m, viscosity in N m s/rad, inertia in N m s**2/rad.
FRICTION, VISCOSITY, INERTIA = 1.2, 0.4, 0.08
BASE = Structure(
    "single", "bingham/constant", law_from_name("bingham/constant", "single"), "none", False, True
)
SPRING = replace(BASE, dynamics="stiffness")


def joint(bits: int, spring: float = 0.0) -> Dataset:
    """A joint in three sines whose encoder has so many bits a turn (SYNTHETIC, truth known)."""
    rng = np.random.default_rng(0)
    time: Array = np.arange(SECONDS * RATE) / RATE
    position, speed, acceleration = np.zeros((3, time.size))
    for size, pace in ((0.8, 1.9), (0.35, 5.0), (0.12, 11.9)):  # rad, rad/s
        phase = pace * time + rng.uniform(0.0, 2.0 * np.pi)
        position += size * np.sin(phase)
        speed += size * pace * np.cos(phase)
        acceleration -= size * pace**2 * np.sin(phase)
    torque = FRICTION * np.tanh(speed / 0.05) + VISCOSITY * speed + INERTIA * acceleration
    torque += spring * position + 0.05 * rng.standard_normal(time.size)
    step = 2.0 * np.pi / 2**bits
    read = step * np.round(position / step)
    signals = {"position": read, "effort": torque}
    units = {"position": "rad", "effort": "N*m"}
    return build_dataset(recording_from_arrays(signals, units, rate=RATE))


@pytest.mark.slow
@pytest.mark.parametrize("bits", [13, 16])
def test_an_inertia_of_noisy_positions_is_no_spring(bits: int) -> None:
    """A travel that is forgotten at once said as much: k tau_x**2 was the inertia."""
    rungs = grown(joint(bits), BASE, among=("inertia", "inertia/smooth", "stiffness"))
    assert rungs[-1].structure.dynamics == "inertia/smooth"


@pytest.mark.slow
def test_the_inertia_of_a_joint_is_found_and_a_wider_window_is_named() -> None:
    compared = compare(joint(14), Settings(("bingham", "bingham+inertia/smooth")))
    (alone,) = (e for e in compared.entries if e.name.endswith("+inertia/smooth"))
    (inertia,) = (each for each in alone.outcome.estimates if each.name == "m_a")
    assert inertia.value == pytest.approx(INERTIA, rel=0.03)
    assert "inertia/smooth" in compared.recommended
    assert any("--window" in finding.remedy for finding in compared.findings)


@pytest.mark.slow
def test_positions_that_are_fine_need_no_smooth_acceleration() -> None:
    rungs = grown(joint(20), BASE, among=("inertia", "inertia/smooth", "stiffness"))
    assert rungs[-1].structure.dynamics == "inertia"


@pytest.mark.slow
def test_a_spring_beside_the_inertia_of_a_joint_is_a_spring() -> None:
    data = joint(20, spring=3.0)
    rungs = grown(data, BASE, among=("inertia", "inertia/smooth", "stiffness"))
    assert set(rungs[-1].structure.dynamics.split("+")) == {"inertia", "stiffness"}


@pytest.mark.parametrize(("forgets", "instead"), [(0.02, "inertia/smooth"), (20.0, "")])
def test_a_travel_that_is_forgotten_while_the_slip_lasts_is_none(
    forgets: float, instead: str
) -> None:
    rung = Rung(SPRING, 1.0, {"w_s": 0.1, "tau_x": forgets}, np.inf)
    assert in_place_of_a_travel(joint(16), rung, "stiffness") == instead
    assert in_place_of_a_travel(joint(16), rung, "inertia") == ""


def test_the_window_that_is_named_is_odd_and_grows_with_the_low_pass() -> None:
    short, long = (noisy_acceleration(tau, 2e-3) for tau in (1e-3, 19e-3))
    assert "--window 7" in short.remedy
    assert "--window 39" in long.remedy
    assert "19 ms" in long.message
