"""Flow curves without noise, rounded to few digits: the last digit of the cells is a known error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.wings.rheology.flow_curve import ranked
from erclutch.wings.rheology.flow_curve_file import read_flow_curves
from erclutch.wings.rheology.flow_plateau import half_last_digit, plateau_of
from tests.support.slow_params import slow_but


def exact(folder: Path, seed: int, digits: int, unit: str = "Pa") -> tuple[float, Path]:
    """A yield stress in Pa, and a file of an exact Herschel-Bulkley curve that has it, rounded to some digits."""
    rng = np.random.default_rng(seed)
    yield_stress = 10.0 ** rng.uniform(-1.0, 3.0)
    lowest = rng.uniform(-4.0, -1.0)
    rates = np.logspace(lowest, lowest + rng.uniform(4.0, 6.0), 25)
    stresses = yield_stress * (
        1.0 + 10.0 ** rng.uniform(-2.5, 0.0) * rates ** rng.uniform(0.3, 1.0)
    )
    in_unit = stresses / {"Pa": 1.0, "kPa": 1000.0}[unit]
    rows = [
        f"{rate:.6g},{stress:.{digits - 1}e}" for rate, stress in zip(rates, in_unit, strict=True)
    ]
    path = folder / f"curve{seed}.csv"
    path.write_text("\n".join([f"Shear rate [1/s],Shear stress [{unit}]", *rows]) + "\n")
    return yield_stress, path


@pytest.mark.slow
@pytest.mark.parametrize("digits", slow_but((3,), (3, 4, 5)))
@pytest.mark.parametrize("unit", slow_but(("Pa",), ("Pa", "kPa")))
def test_the_yield_stress_of_an_exact_curve_is_identified_at_any_rounding(
    tmp_path: Path, digits: int, unit: str
) -> None:
    for seed in range(12):
        yield_stress, path = exact(tmp_path, seed, digits, unit)
        (curve,) = read_flow_curves(path).curves
        fit = ranked(curve, ["herschel-bulkley"])[0]
        assert fit.yield_shown is not False, seed
        assert fit.yield_stress.value == pytest.approx(yield_stress, abs=3.0 * curve.rounding)


def test_a_plateau_is_known_to_half_a_digit_and_to_the_fall_that_a_digit_hides() -> None:
    rates = np.logspace(-3.0, 1.0, 20)
    stresses = np.full(20, 167.0)
    assert plateau_of(rates, stresses) == pytest.approx((167.0, 167.0))
    lowest, highest = plateau_of(rates, stresses, rounding=0.5) or (0.0, 0.0)
    assert highest == 167.5
    assert lowest == pytest.approx(166.5 - 2.0, abs=0.05)  # a digit a decade, over two more decades


@pytest.mark.parametrize(
    ("number", "column", "half"),
    [
        (10.0, [10.0, 10.031, 12.5], 0.0005),  # five digits
        (10.0, [10.0, 9.37, 120.44], 0.005),  # two decimals
        (0.0101, [0.0101, 0.01012, 1.234], 5e-6),
        (1e6, [1e6, 1.25e6], 5e3),
        (10.0, [10.0, 10.123456789012345], 0.0),  # nobody rounded these
        (0.0, [0.0, 1.5], 0.0),
    ],
)
def test_half_a_last_digit_is_told_by_the_numbers_with_the_most_digits(
    number: float, column: list[float], half: float
) -> None:
    assert half_last_digit(number, np.array([*column, np.nan])) == pytest.approx(half)
