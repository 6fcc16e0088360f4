"""Rows of a rheometer's table that are no points of a flow curve: rests, steps of the rate, sums below the rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnitError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves

RATES = np.logspace(0.0, 3.0, 16)
NAMES = "Shear rate [1/s],Shear stress [Pa]"


def herschel_bulkley(rate: np.ndarray) -> np.ndarray:
    return 20.0 + 2.0 * rate**0.6


def written(folder: Path, header: str, *columns: np.ndarray, below: str = "") -> Path:
    rows = [",".join(f"{number:.6g}" for number in row) for row in np.column_stack(columns)]
    path = folder / "flow.csv"
    path.write_text("\n".join([header, *rows]) + "\n" + below)
    return path


def test_both_signs_of_the_noise_about_a_rest_are_left_out(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).normal(0.0, 3e-5, 60)
    rate = np.concatenate([np.full(20, 40.0), noise, RATES])
    stress = np.concatenate([np.full(20, 38.0), np.full(60, 15.0), herschel_bulkley(RATES)])
    file = read_flow_curves(written(tmp_path, NAMES, rate, stress))
    assert file.curves[0].rate.min() == 1.0
    assert any("as noise about a rest has" in note for note in file.notes)


def start_up(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rate = 20.0 * -np.expm1(-times / 0.2)
    return rate, herschel_bulkley(rate) * (1.0 + 0.5 * np.exp(-times / 10.0))


def test_a_start_up_at_one_rate_is_no_flow_curve(tmp_path: Path) -> None:
    times = np.arange(1, 241) * 0.25
    rate, stress = start_up(times)
    with pytest.raises(MappingError, match="a start-up or a step of the rate"):
        read_flow_curves(
            written(tmp_path, "t [s],Shear rate [1/s],Shear stress [Pa]", times, rate, stress)
        )


@pytest.mark.parametrize("time", ["StepTime_s", "t_ms", "Time [min]"])
def test_a_step_of_the_rate_in_logarithmic_times_is_no_flow_curve(
    tmp_path: Path, time: str
) -> None:
    times = np.logspace(-3.0, 2.0, 60)
    rate = 0.1 + 4.9 / (
        1.0 + (times / 0.008) ** 4
    )  # a third of the rows, and a thousandth of the time
    with pytest.raises(MappingError, match="a start-up or a step of the rate"):
        read_flow_curves(
            written(
                tmp_path, f"{time},Stress_Pa,ShearRate_1_s", times, herschel_bulkley(rate), rate
            )
        )


def test_a_ramp_that_ends_in_a_hold_is_a_flow_curve(tmp_path: Path) -> None:
    times = np.arange(1.0, 181.0)
    rate = np.minimum(times / 60.0, 1.0) * 100.0
    file = read_flow_curves(
        written(tmp_path, f"t [s],{NAMES}", times, rate, herschel_bulkley(rate))
    )
    assert file.curves[0].rate.size == 180


@pytest.mark.parametrize(
    "form", ["a,{0:.4g},{1:.4g}\nb,{2:.4g},{3:.4g}\n", ",{0:.4g},{1:.4g}\n,{2:.4g},{3:.4g}\n"]
)
def test_a_mean_and_a_deviation_below_the_rows_are_no_points(tmp_path: Path, form: str) -> None:
    stress = herschel_bulkley(RATES)
    sums = form.format(RATES.mean(), stress.mean(), RATES.std(ddof=1), stress.std(ddof=1))
    file = read_flow_curves(
        written(tmp_path, f"Point,{NAMES}", np.arange(1, 17), RATES, stress, below=sums)
    )
    assert file.curves[0].rate == pytest.approx(RATES, rel=1e-5)


def test_statistics_without_a_word_behind_a_blank_line_are_no_points(tmp_path: Path) -> None:
    stress = herschel_bulkley(RATES)
    rows = [(RATES.mean(), stress.mean()), (RATES.std(), stress.std()), (RATES.max(), stress.max())]
    below = "\n" + "".join(f"{rate:.4g},{number:.4g}\n" for rate, number in rows)
    file = read_flow_curves(written(tmp_path, NAMES, RATES, stress, below=below))
    assert file.curves[0].rate == pytest.approx(RATES, rel=1e-5)
    assert (
        "the last 3 rows are mean, standard deviation, largest of the rows above: left out"
        in file.notes
    )


def test_points_below_a_mean_and_a_deviation_stay_with_all_rows(tmp_path: Path) -> None:
    """What sums up the rows above is left out at the end alone: a further point below it may be of another test."""
    stress = herschel_bulkley(RATES)
    rows = [(RATES.mean(), stress.mean()), (RATES.std(), stress.std()), (7.77, 77.7), (8.88, 8.8)]
    below = "\n" + "".join(f"{rate:.6g},{number:.6g}\n" for rate, number in rows)
    file = read_flow_curves(written(tmp_path, NAMES, RATES, stress, below=below))
    assert not [note for note in file.notes if "of the rows above: left out" in note]


def test_a_point_at_the_mean_of_all_others_stays(tmp_path: Path) -> None:
    rate = np.array(
        [10.0, 20.0, 30.0, 40.0, 50.0, 30.0]
    )  # the middle rate once more, of a fluid without a yield
    file = read_flow_curves(written(tmp_path, NAMES, rate, 2.0 * rate))
    assert file.curves[0].rate.size == 6


@pytest.mark.parametrize("word", ["SD", "StAbw", "média", "desvio padrão", "среднее"])
def test_a_line_that_sums_up_is_told_by_its_word(tmp_path: Path, word: str) -> None:
    below = f"{word},3.5,4.5\n"
    file = read_flow_curves(
        written(
            tmp_path,
            f"Point,{NAMES}",
            np.arange(1, 17),
            RATES,
            herschel_bulkley(RATES),
            below=below,
        )
    )
    assert file.curves[0].rate.size == 16


def test_the_mean_of_the_runs_is_no_further_run(tmp_path: Path) -> None:
    runs = herschel_bulkley(RATES)[:, None] * np.array([0.97, 1.0, 1.05])
    header = (
        "Shear rate [1/s],Stress run 1 [Pa],Stress run 2 [Pa],Stress run 3 [Pa],Mean [Pa],SD [Pa]"
    )
    path = written(tmp_path, header, RATES, *runs.T, runs.mean(axis=1), runs.std(axis=1))
    file = read_flow_curves(path)
    assert [curve.label for curve in file.curves] == [
        "Stress run 1",
        "Stress run 2",
        "Stress run 3",
    ]


def test_a_curve_at_a_middle_field_is_no_mean_of_the_others(tmp_path: Path) -> None:
    # The yield stress grows evenly with the field: the curve at 1 A was left out as the mean.
    stresses = herschel_bulkley(RATES)[:, None] + np.array([0.0, 40.0, 80.0])
    header = "Shear rate [1/s],Stress 0 A [Pa],Stress 1 A [Pa],Stress 2 A [Pa]"
    file = read_flow_curves(written(tmp_path, header, RATES, *stresses.T))
    assert [curve.label for curve in file.curves] == ["Stress 0 A", "Stress 1 A", "Stress 2 A"]


@pytest.mark.parametrize(
    ("factor", "unit"),
    [(10.0, "dyn/cm^2"), (1.0 / 0.478803, "lbf/(100*ft^2)"), (1e-6, "MPa")],
)
def test_a_viscosity_without_a_unit_tells_a_stress_that_is_not_in_pascals(
    tmp_path: Path, factor: float, unit: str
) -> None:
    stress = herschel_bulkley(RATES)  # [Pa]
    viscosity = 1000.0 * stress / RATES  # [mPa s]
    path = written(tmp_path, "Viscosity,Shear Stress,Shear Rate", viscosity, factor * stress, RATES)
    with pytest.raises(UnitError) as raised:
        read_flow_curves(path)
    assert f'--stress "Shear Stress [{unit}]"' in raised.value.remedy

    file = read_flow_curves(path, shear_rate="Shear Rate [1/s]", stress=[f"Shear Stress [{unit}]"])
    assert file.curves[0].stress == pytest.approx(stress, rel=1e-3)


@pytest.mark.parametrize("milli", [1.0, 1000.0])
def test_a_viscosity_without_a_unit_that_fits_pascals_asks_nothing(
    tmp_path: Path, milli: float
) -> None:
    stress = herschel_bulkley(RATES)
    path = written(
        tmp_path, "Viscosity,Shear Stress,Shear Rate", milli * stress / RATES, stress, RATES
    )
    assert read_flow_curves(path).curves[0].stress == pytest.approx(stress, rel=1e-5)


@pytest.mark.parametrize(
    "name", ["duration", "Dauer", "duración", "start_index", "calc_count", "first row"]
)
def test_what_is_counted_beside_each_step_is_no_condition(tmp_path: Path, name: str) -> None:
    rates = np.tile([100.0, 75.0, 50.0, 25.0, 50.0, 75.0, 100.0], 4)
    counted = np.where(rates == 100.0, -1.0, 94.0 + np.arange(rates.size))
    if name.lower().startswith(("d", "c")):
        counted = np.repeat([30.0, 31.0, 33.0, 30.0], 7)
    file = read_flow_curves(
        written(tmp_path, f"{name},{NAMES}", counted, rates, herschel_bulkley(rates))
    )
    assert len(file.curves) == 1


@pytest.mark.parametrize("name", ["T_K", "T (K)", "T_C", "T [K]"])
def test_no_temperature_is_offered_as_a_shear_rate(tmp_path: Path, name: str) -> None:
    kelvin = np.linspace(283.0, 353.0, 12)
    with pytest.raises(MappingError) as raised:
        read_flow_curves(
            written(tmp_path, f"{name},eta [mPas]", kelvin, np.exp(5000.0 / kelvin - 13.0))
        )
    assert "--shear-rate" not in raised.value.remedy


@pytest.mark.parametrize("name", ["T_K", "T (K)", "T_C", "T_°C"])
def test_two_temperatures_in_one_table_are_two_curves(tmp_path: Path, name: str) -> None:
    rate = np.tile(RATES, 2)
    celsius = np.repeat([25.0, 60.0], RATES.size)
    stress = herschel_bulkley(rate) * np.repeat([1.0, 0.5], RATES.size)
    degrees = celsius + 273.15 if "K" in name else celsius
    file = read_flow_curves(written(tmp_path, f"{NAMES},{name}", rate, stress, degrees))
    assert [curve.rate.size for curve in file.curves] == [RATES.size, RATES.size]


@pytest.mark.parametrize(
    ("back", "told"), [(0.5, "0.5 times the stress"), (1.4, "1.4 times the stress"), (1.05, "")]
)
@pytest.mark.parametrize("first", ["up", "down"])
def test_a_wide_loop_of_a_thixotropic_fluid_is_told_with_its_width(
    tmp_path: Path, back: float, told: str, first: str
) -> None:
    there = RATES if first == "up" else RATES[::-1]
    rate = np.concatenate([there, there[::-1]])  # the rate at the turn is measured twice
    factor = np.where(np.arange(rate.size) < RATES.size, 1.0, back)
    (note,) = [
        note
        for note in read_flow_curves(
            written(tmp_path, NAMES, rate, factor * herschel_bulkley(rate))
        ).notes
        if "both sweeps are fitted as one curve" in note
    ]
    assert ("the way back has" in note) == bool(told)
    assert told in note


@pytest.mark.slow
def test_a_workbook_asks_about_its_points_and_not_about_its_parameters(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    workbook = openpyxl.Workbook()
    points = workbook.active
    points.title = "Raw Data"
    points.append(["Viscosity", "Shear Stress", "Shear Rate"])
    for rate, stress in zip(RATES, herschel_bulkley(RATES), strict=True):
        points.append([1000.0 * stress / rate, 10.0 * stress, rate])  # cP, dyn/cm^2
    parameters = workbook.create_sheet("Power Law Data")
    parameters.append(["N'", "K'", *(f"Visc. @ SR {rate}" for rate in (40, 100, 170, 511))])
    for cycle in range(6):
        parameters.append(
            [0.4 + 0.01 * cycle, 30.0 - cycle, 900 - cycle, 500 - cycle, 350 - cycle, 200 - cycle]
        )
    workbook.save(tmp_path / "log.xlsx")
    with pytest.raises(UnitError, match=r"of dyn/cm\^2 beside mPa\*s"):
        read_flow_curves(tmp_path / "log.xlsx")


def test_two_rates_and_the_way_between_them_are_told_as_two_rates(tmp_path: Path) -> None:
    rate = np.concatenate([[18.2, 31.4], np.full(200, 40.0), np.full(300, 0.115)])
    with pytest.raises(MappingError, match="one of two shear rates"):
        read_flow_curves(written(tmp_path, NAMES, rate, herschel_bulkley(rate)))


@pytest.mark.slow
@pytest.mark.parametrize("rate", [np.linspace(1.0, 100.0, 600), np.logspace(-4.0, 5.0, 400)])
def test_a_ramp_of_very_many_points_has_many_rates(tmp_path: Path, rate: np.ndarray) -> None:
    notes = read_flow_curves(written(tmp_path, NAMES, rate, herschel_bulkley(rate))).notes
    assert not any("shear rates, which tell" in note for note in notes)
