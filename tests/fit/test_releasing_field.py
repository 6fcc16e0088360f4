"""A brake that holds by itself, and that its field releases: no form of the yield effort that grows can say that."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.cli.options import LogOptions
from erclutch.fit.checks.releasing_field import field_releases
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.laws import law_from_name
from erclutch.models.laws.yield_stress import FALLING
from erclutch.models.structure import Structure
from tests.support.command import good

_HELD, _LEFT, _FALL, _VISCOUS, _TURN = 4.6, 0.4, 0.9, 0.05, 0.2  # N m, N m, A, N m s, rad/s
_NOISE = 0.05  # N m


def brake(*, seed: int = 0, sign: float = 1.0, rising: bool = False) -> Dataset:
    """A brake whose magnet a current cancels, or one that a current holds, as MADE-UP rows."""
    noise = np.random.default_rng(seed).normal(0.0, _NOISE, 8_000)
    time = np.arange(8_000) / 200.0
    current = 0.5 * (np.floor(time / 5.0) % 5)
    slip = 6.0 * np.sin(2 * np.pi * 0.5 * time)
    share = np.exp(-current / _FALL)
    held = _LEFT + _HELD * (1.0 - share if rising else share)
    torque = sign * (held * np.tanh(slip / _TURN) + _VISCOUS * slip) + noise
    log = recording_from_arrays(
        {"field": current, "slip": slip, "effort": torque},
        {"field": "A", "slip": "rad/s", "effort": "N*m"},
        time=time,
    )
    return build_dataset(log)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_the_truth_is_found(seed: int) -> None:
    data = brake(seed=seed)
    law = law_from_name("bingham/falling", "single")
    fit = fit_structure(data, Structure("single", "bingham/falling", law, friction=True))
    numbers = {estimate.name: estimate for estimate in fit.estimates}
    at_largest = _HELD * np.exp(-2.0 / _FALL)  # the reference field is 2 A
    truth = {"E_r": _FALL, "T_y": at_largest, "T_f": _LEFT, "eta": _VISCOUS, "w_s": _TURN}
    for name, value in truth.items():
        assert numbers[name].value == pytest.approx(value, rel=0.05), name
    assert numbers["T_f"].meaning == "friction effort that no field takes away"
    assert np.sqrt(fit.train_cost / data.rows) <= 1.02 * _NOISE


def test_it_falls_to_one_at_the_reference_field_and_by_its_own_scale() -> None:
    fields = np.array([0.0, 0.5, 1.0, 1.5])
    np.testing.assert_allclose(FALLING.factor(fields, 0.5), np.exp([2.0, 1.0, 0.0, -1.0]))


def test_which_way_the_field_works_is_seen() -> None:
    assert field_releases(brake())
    assert not field_releases(brake(rising=True))


def test_a_wrong_sign_is_no_release() -> None:
    assert not field_releases(brake(rising=True, sign=-1.0))
    assert not field_releases(brake(sign=-1.0))


def test_a_field_that_says_nothing_releases_nothing() -> None:
    data = brake(rising=True)
    element = replace(data.elements[0], field=np.full(data.rows, 1.5))
    assert not field_releases(replace(data, elements=(element,)))
    mixed = np.random.default_rng(1).permutation(data.elements[0].field)
    assert not field_releases(replace(data, elements=(replace(element, field=mixed),)))


@pytest.mark.slow
def test_laws_without_a_form_of_their_own_take_the_one_that_falls() -> None:
    settings = Settings(models=("bingham", "casson", "bingham/tanh", "quadratic"), lag="none")
    comparison = compare(brake(), settings)
    names = [entry.outcome.model.name for entry in comparison.entries]
    assert sorted(names) == ["bingham/falling", "bingham/tanh", "casson/falling", "quadratic"]
    assert comparison.recommended in {"bingham/falling", "casson/falling"}
    assert any("the effort falls as the field grows" in str(note) for note in comparison.findings)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Air gap [mm]", "Luftspalt [mm]", "entrefer (mm)"])
def test_a_gap_that_is_set_is_asked_about_and_may_be_the_field(name: str, tmp_path: Path) -> None:
    """An eddy-current brake was fitted without a field, and its gap was left out."""
    log = tmp_path / "eddy.csv"
    rows = [f"{name},Speed [rpm],Torque [Nm]"]
    for gap in (2, 4, 6, 8):
        for speed in range(0, 1600, 100):
            torque = 3.0 * np.exp(-gap / 4.0) * speed / 600.0 / (1.0 + (speed / 600.0) ** 2)
            rows.append(f"{gap},{speed},{torque:.4f}")
    log.write_text("\n".join(rows) + "\n", encoding="utf-8")
    said = good("inspect", log.name, cwd=tmp_path, code=1)
    label = name.replace("(", "[").replace(")", "]")
    settled = said.strip().splitlines()[-1]
    assert settled.endswith((f'--field "{label}"', f"--field '{label}'"))
    (read,) = LogOptions(field=label).read([log])
    assert read.units["field"] == "m"
    assert read.signals["field"].max() == pytest.approx(0.008)
