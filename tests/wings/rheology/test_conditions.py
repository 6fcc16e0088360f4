"""Flow curves at several conditions in one table: each condition is a curve, and none is mixed with another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import LogError, MappingError
from erclutch.wings.rheology.conditions import levels_of
from erclutch.wings.rheology.flow_curve_file import FlowFile, read_flow_curves

RATES = np.logspace(0.0, 3.0, 12)
YIELDS = {0.0: 20.0, 0.5: 4020.0, 1.0: 8020.0}


def table(
    path: Path, header: str, scatter: float = 0.0, scale: float = 1.0, before: str = ""
) -> Path:
    """Bingham curves at three levels of a condition, one below the other."""
    noise = np.random.default_rng(7)
    lines = [header]
    for level, yield_stress in YIELDS.items():
        for rate in RATES:
            stress = yield_stress + 0.3 * rate
            lines.append(
                f"{before}{scale * level + noise.normal(0.0, 1.0) * scatter:.6g},{rate:.6g},{stress:.6g}"
            )
    path.write_text("\n".join(lines) + "\n")
    return path


def assert_each_condition_is_a_curve(found: FlowFile) -> None:
    assert len(found.curves) == 3
    for curve, yield_stress in zip(found.curves, YIELDS.values(), strict=True):
        assert curve.rate == pytest.approx(RATES, rel=1e-5)
        assert curve.stress == pytest.approx(yield_stress + 0.3 * RATES, rel=1e-5)


@pytest.mark.parametrize(
    ("header", "scale", "label"),
    [
        ("Current [A],Shear rate [1/s],Shear stress [Pa]", 1.0, "Current 0.5 A"),
        ("B [mT],Shear rate [1/s],Shear stress [Pa]", 200.0, "B 100 mT"),
        ("E [kV/mm],Shear rate [1/s],Shear stress [Pa]", 4.0, "E 2 kV/mm"),
        ("T [°C],Shear rate [1/s],Shear stress [Pa]", 40.0, "T 20 °C"),
        ("I_mA,Shear rate [1/s],Shear stress [Pa]", 1000.0, "I 500 mA"),
    ],
)
def test_each_level_of_a_condition_is_a_curve(
    tmp_path: Path, header: str, scale: float, label: str
) -> None:
    found = read_flow_curves(table(tmp_path / "f.csv", header, scale=scale))
    assert_each_condition_is_a_curve(found)
    assert found.curves[1].label == label
    assert any("a curve for each of 3 conditions" in note for note in found.notes)


@pytest.mark.parametrize(
    "header", ["I [A],Shear rate [1/s],Shear stress [Pa]", "sample,Shear rate [1/s],Stress [Pa]"]
)
def test_measured_levels_scatter(tmp_path: Path, header: str) -> None:
    assert_each_condition_is_a_curve(
        read_flow_curves(table(tmp_path / "f.csv", header, scatter=1e-3))
    )


@pytest.mark.slow
def test_numbers_of_an_unknown_meaning_are_asked_about(tmp_path: Path) -> None:
    path = table(tmp_path / "f.csv", "sample,Shear rate [1/s],Shear stress [Pa]")
    with pytest.raises(
        MappingError, match="column sample parts the points into 3 sweeps"
    ) as refused:
        read_flow_curves(path)
    assert "sample=all" in refused.value.remedy
    assert_each_condition_is_a_curve(read_flow_curves(path, sheet=["sample=all"]))
    assert read_flow_curves(path, sheet=["sample=0.5"]).curves[0].rate.size == RATES.size


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["Meas. Pts.", "Interval", "duration", "Step duration [s]", "Time [s]", "Torque [mN m]"]
)
def test_what_is_no_condition_parts_nothing(tmp_path: Path, name: str) -> None:
    path = table(tmp_path / "f.csv", f"{name},Shear rate [1/s],Shear stress [Pa]", scale=2.0)
    sweeps = [curve.label.rpartition("; ")[2] for curve in read_flow_curves(path).curves]
    assert sweeps == ["sweep 1", "sweep 2", "sweep 3"]
    header, *rows = path.read_text().splitlines()
    of_one_fluid = [
        f"{row.split(',')[0]},{rate:.6g},{20 + rate:.6g}"
        for row, rate in zip(rows, [*RATES] * 3, strict=True)
    ]
    path.write_text("\n".join([header, *of_one_fluid]) + "\n")
    assert len(read_flow_curves(path).curves) == 1


def test_a_temperature_that_drifts_parts_nothing(tmp_path: Path) -> None:
    rows = [f"{25 + 0.01 * k},{rate:.6g},{20 + rate:.6g}" for k, rate in enumerate(RATES)]
    (tmp_path / "f.csv").write_text("\n".join(["T [°C],Shear rate [1/s],Shear stress [Pa]", *rows]))
    assert len(read_flow_curves(tmp_path / "f.csv").curves) == 1


@pytest.mark.slow
@given(
    levels=st.lists(st.integers(-9, 9), min_size=2, max_size=8, unique=True),
    scatter=st.sampled_from([0.0, 1e-4]),
    seed=st.integers(0, 99),
)
def test_levels_are_found_again(levels: list[int], scatter: float, seed: int) -> None:
    noise = np.random.default_rng(seed)
    truth = np.repeat(np.argsort(np.argsort(levels)), 20)
    values = np.repeat(np.asarray(levels, np.float64), 20) + scatter * noise.normal(size=truth.size)
    found = levels_of(values)
    assert found is not None
    assert np.array_equal(found, truth)


def test_numbers_without_levels_have_none() -> None:
    assert levels_of(np.linspace(0.0, 1.0, 200)) is None
    assert levels_of(np.full(20, 3.0)) is None
    assert levels_of(np.full(20, np.nan)) is None


@pytest.mark.parametrize(
    ("upper", "names", "gap"),
    [
        (["0 mT", "", "50 mT", ""], "Shear rate [1/s],Shear stress [Pa]", ""),
        (["0 mT", "0 mT", "50 mT", "50 mT"], "Shear rate [1/s],Shear stress [Pa]", ""),
        (["0 mT", "", "", "50 mT", ""], "Shear rate [1/s],Viscosity [Pa s]", ","),
        (["Oil A at 25 °C", "", "Oil B at time 2", ""], "gamma_dot (1/s),tau (Pa)", ""),
    ],
)
def test_tables_side_by_side_are_called_after_their_headings(
    tmp_path: Path, upper: list[str], names: str, gap: str
) -> None:
    by_viscosity = "Viscosity" in names
    lines = [",".join(upper), f"{names},{gap}{names}"]
    for rate in RATES:
        cells = [
            f"{rate:.6g},{stress / rate if by_viscosity else stress:.6g}"
            for stress in (20 + rate, 400 + rate)
        ]
        lines.append(f",{gap}".join(cells))
    (tmp_path / "f.csv").write_text("\n".join(lines) + "\n")
    found = read_flow_curves(tmp_path / "f.csv")
    assert [curve.label for curve in found.curves] == [
        heading for heading in dict.fromkeys(upper) if heading
    ]
    assert found.curves[1].stress == pytest.approx(400 + RATES, rel=1e-4)


@pytest.mark.parametrize("upper", ["0 mT,,,", "0 mT,,0 mT,", "0 mT,B,50 mT,", "made by hand"])
def test_a_line_that_heads_no_table_is_skipped_as_before(tmp_path: Path, upper: str) -> None:
    rows = "\n".join(f"{rate:.6g},{20 + rate:.6g},{rate:.6g},{400 + rate:.6g}" for rate in RATES)
    names = "Shear rate [1/s],Shear stress [Pa]"
    (tmp_path / "f.csv").write_text(f"{upper}\n{names},{names}\n{rows}\n")
    assert [curve.label for curve in read_flow_curves(tmp_path / "f.csv").curves][
        1
    ] == "Shear stress [Pa] (2)"


@pytest.mark.parametrize("level", [25.0, 298.15, -10.0])
def test_a_regulated_value_that_wobbles_is_one_level(level: float) -> None:
    wobble = np.tile([-0.007, -0.003, 0.0, 0.002, 0.005], 8)
    assert levels_of(level + wobble) is None
    assert levels_of(np.repeat([level, 1.2 * level], 20)) is not None


@pytest.mark.parametrize("sheet", ["sample=all", "sample=A"])
def test_rows_that_the_user_parted_are_not_asked_about_again(tmp_path: Path, sheet: str) -> None:
    rows = [
        f"{word},{phase},{x},{20 + 3 * x}"
        for word in "AB"
        for phase in (1, 2)
        for x in range(1, 13)
    ]
    (tmp_path / "log.csv").write_text("\n".join(["sample,phase,gamma,tau", *rows]) + "\n")
    found = read_flow_curves(tmp_path / "log.csv", shear_rate="gamma [1/s]", sheet=[sheet])
    assert [curve.rate.size for curve in found.curves] == [24] * (2 if sheet.endswith("all") else 1)


def test_conditions_of_too_few_points_are_named(tmp_path: Path) -> None:
    rows = [f"{level},{rate},{20 + rate}" for level in (0, 1) for rate in (1, 10, 100)]
    (tmp_path / "f.csv").write_text("\n".join(["I [A],Shear rate [1/s],Shear stress [Pa]", *rows]))
    with pytest.raises(LogError, match="I 0 A: 3 points, at least"):
        read_flow_curves(tmp_path / "f.csv")


def test_a_sensor_whose_last_digit_wobbles_parts_nothing(tmp_path: Path) -> None:
    rows = [f"{1e-4 * (k % 2):g},{rate:.6g},{20 + rate:.6g}" for k, rate in enumerate(RATES)]
    (tmp_path / "f.csv").write_text("\n".join(["B [T],Shear rate [1/s],Shear stress [Pa]", *rows]))
    assert len(read_flow_curves(tmp_path / "f.csv").curves) == 1


def test_levels_by_turns_at_each_rate_are_conditions(tmp_path: Path) -> None:
    rows = [
        f"{level},{rate:.6g},{20 + 4000 * level + rate:.6g}" for rate in RATES for level in (0, 1)
    ]
    (tmp_path / "f.csv").write_text("\n".join(["B [T],Shear rate [1/s],Shear stress [Pa]", *rows]))
    assert [curve.rate.size for curve in read_flow_curves(tmp_path / "f.csv").curves] == [
        RATES.size
    ] * 2


@pytest.mark.parametrize("between", ["\n", ""])
def test_two_sweeps_of_other_stresses_are_two_curves(tmp_path: Path, between: str) -> None:
    sweeps = [
        "\n".join(f"{rate:.6g},{factor * (20 + rate):.6g}" for rate in RATES)
        for factor in (1.0, 1.6)
    ]
    (tmp_path / "f.csv").write_text(
        "Shear rate [1/s],Shear stress [Pa]\n" + f"\n{between}".join(sweeps) + "\n"
    )
    found = read_flow_curves(tmp_path / "f.csv")
    assert [curve.label for curve in found.curves] == ["sweep 1", "sweep 2"]
    assert found.curves[1].stress == pytest.approx(1.6 * (20 + RATES), rel=1e-5)


@pytest.mark.parametrize("second", [RATES, RATES[::-1]])
def test_a_run_again_and_a_way_back_are_one_curve(tmp_path: Path, second: np.ndarray) -> None:
    factors = np.repeat([1.0, 1.05 if second is RATES else 0.7], RATES.size)
    rates = np.append(RATES, second)
    rows = [
        f"{rate:.6g},{factor * (20 + rate):.6g}"
        for rate, factor in zip(rates, factors, strict=True)
    ]
    (tmp_path / "f.csv").write_text("\n".join(["Shear rate [1/s],Shear stress [Pa]", *rows]) + "\n")
    assert [curve.rate.size for curve in read_flow_curves(tmp_path / "f.csv").curves] == [
        2 * RATES.size
    ]


def test_a_course_in_time_with_noise_about_a_rest_is_not_cut_into_sweeps(tmp_path: Path) -> None:
    noise = np.random.default_rng(6)
    rest = 1e-6 * np.exp(2.0 * noise.normal(size=40))
    rates = np.concatenate([rest, RATES, rest, RATES[::-1], rest])
    rows = [f"{k},{rate:.6g},{(20 + rate) * (1 + k / 50):.6g}" for k, rate in enumerate(rates)]
    (tmp_path / "f.csv").write_text(
        "\n".join(["Time [s],Shear rate [1/s],Shear stress [Pa]", *rows]) + "\n"
    )
    assert [curve.label for curve in read_flow_curves(tmp_path / "f.csv").curves] == ["f"]
