"""Flow curves from wells' laboratories: units above all tables, calibrations, rotor speeds, Russian, odd sheets."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import LogError, MappingError
from erclutch.signals.array import Array
from erclutch.wings.rheology.flow_curve import FlowCurve, fit_flow_curve
from erclutch.wings.rheology.flow_curve_file import read_flow_curves
from tests.support.command import run

RATES = np.array([3.0, 6.0, 100.0, 200.0, 300.0, 600.0])
STRESSES = np.array([5.0, 6.0, 13.0, 18.0, 22.5, 33.0])  # Pa


def written(folder: Path, text: str, name: str = "flow.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def rows(*columns: Array, mark: str = ",") -> str:
    return (
        "\n".join(mark.join(f"{value:.6g}" for value in row) for row in zip(*columns, strict=True))
        + "\n"
    )


def workbook(folder: Path, sheets: dict[str, Sequence[Sequence[Any]]]) -> Path:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, content in sheets.items():
        sheet = book.create_sheet(name)
        for row in content:
            sheet.append(list(row))
    path = folder / "flow.xlsx"
    book.save(path)
    return path


def assert_is_the_curve(path: Path, **options: Any) -> None:
    (curve,) = read_flow_curves(path, **options).curves
    np.testing.assert_allclose(curve.rate, RATES, rtol=1e-5)
    np.testing.assert_allclose(curve.stress, STRESSES, rtol=1e-5)


@pytest.mark.parametrize(
    ("names", "above"),
    [
        ("Shear Rate\tShear Stress", "Shear Stress Unit: Dyne/cm^2\nRate Unit: 1/s"),
        ("S. Rate\tS. Stress", "Shear Stress Unit: Dyne/cm^2\nShear Rate Unit: 1/s"),
        ("Shear Rate\tShear Stress", "Einheit der Probe: keine\nShear Stress Units: dyn/cm^2"),
    ],
)
@pytest.mark.parametrize("tables", [1, 2])
def test_units_that_stand_once_above_all_tables_hold_for_each(
    tmp_path: Path, names: str, above: str, tables: int
) -> None:
    one = f"{names}\n{rows(RATES, 10.0 * STRESSES, mark=chr(9))}"
    text = f"Test: a\n{above}\n\n" + "\n".join(
        f"Sweep {number}:\n{one}" for number in range(tables)
    )
    curves = read_flow_curves(written(tmp_path, text)).curves
    assert len(curves) == tables
    for curve in curves:
        np.testing.assert_allclose(curve.stress, STRESSES, rtol=1e-5)


def test_a_unit_above_the_table_is_of_no_column_that_shares_its_first_letter_alone(
    tmp_path: Path,
) -> None:
    text = f"Time Unit: ms\n\nT,Shear Rate,Shear Stress\n{rows(RATES, RATES, STRESSES)}"
    found = read_flow_curves(written(tmp_path, text))
    assert not any("[ms]" in note for note in found.notes)


CURVE = f"shear rate [1/s],shear stress [Pa]\n{rows(RATES, STRESSES)}"
CHANDLER = """**********
Chandler Engineering Model 5550 Rheometer
Notes:

-- Calibration Data --
Slope = 13.6
Rotor Speed,Shear Rate,Viscosity,Shear Stress
(RPM),(1/sec),(cP),(dyne/cm2)
10,8.5,194,16.5
100,85,194,165
300,255,194,494
**********

-- Rheological Model Data --
Elapsed Time,Avg Shear Rate,|Power Law Values --,,
(hh:mm:ss),(1/s),|n',Kv (cP)
~@~
-- Raw Data --
Elapsed Time,Sample Temp,Pressure,Shear Rate,Shear Stress,Aux1
(hh:mm:ss),(C),(PSIg),(1/s),(dyne/cm2)
"""


@pytest.mark.slow
def test_the_calibration_of_an_instrument_is_no_flow_curve_of_the_sample(tmp_path: Path) -> None:
    lines = [
        f"00:00:{second:02d},24.4,{60 + second},{rate:g},{10 * stress:g},0"
        for second, (rate, stress) in POINTS
    ]
    path = written(tmp_path, CHANDLER + "\n".join(lines) + "\n**********\n")
    assert_is_the_curve(path)
    assert any("calibration" in note for note in read_flow_curves(path).notes)


POINTS = list(enumerate(zip(RATES, STRESSES, strict=True)))


def test_an_export_with_the_calibration_alone_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="calibration"):
        read_flow_curves(written(tmp_path, CHANDLER))


def test_a_row_of_the_raw_data_with_a_cell_too_many_is_refused(tmp_path: Path) -> None:
    """A comma as the decimal mark moves all numbers behind it by a column; the last cell was cut off in silence."""
    lines = [f"00:00:{s:02d},24.4,60,{rate:g},{stress:g},0" for s, (rate, stress) in POINTS]
    lines[2] = lines[2].replace("24.4", "24,4")
    with pytest.raises(LogError, match="has 7 cells where 6 are expected"):
        read_flow_curves(written(tmp_path, CHANDLER + "\n".join(lines) + "\n**********\n"))


@pytest.mark.parametrize("name", ["Pressure [psi]", "Druck [kPa]", "Давление [Па]", "Press [Pa]"])
def test_a_pressure_is_no_shear_stress(tmp_path: Path, name: str) -> None:
    text = f"Shear Rate [1/s],Shear Stress [Pa],{name}\n{rows(RATES, STRESSES, STRESSES + 100.0)}"
    assert_is_the_curve(written(tmp_path, text))


@pytest.mark.parametrize("name", ["sigma_max", "tau_peak", "stress overshoot", "shearStress:0"])
def test_a_peak_and_a_component_of_a_tensor_are_no_steady_stress(tmp_path: Path, name: str) -> None:
    text = f"shear rate,{name}\n{rows(RATES, STRESSES)}"
    with pytest.raises(MappingError):
        read_flow_curves(written(tmp_path, text))


@pytest.mark.parametrize(
    ("names", "units", "factor"),
    [
        ("Скорость сдвига\tНапряжение сдвига\tВязкость", "1/с\tПа\tсП", 1.0),
        ("Скорость сдвига\tНапряж сдвига\tВязкость", "с^-1\tдин/см²\tмПа·с", 10.0),
        (
            "Shear Rate (1/ceк)\tShear Stress (D/см2)\tViscosity",
            "",
            10.0,
        ),  # Latin and Russian letters in one unit
    ],
)
def test_russian_names_and_units_are_read(
    tmp_path: Path, names: str, units: str, factor: float
) -> None:
    viscosities = 1000.0 * STRESSES / RATES  # mPa s
    head = f"{names}\n{units}\n" if units else f"{names}\n"
    assert_is_the_curve(
        written(tmp_path, head + rows(RATES, factor * STRESSES, viscosities, mark="\t"))
    )


def test_an_oscillation_beside_a_flow_curve_leaves_its_points_alone(tmp_path: Path) -> None:
    lines = ["time [min],G' [Pa],G'' [Pa],|n*| [Pa.s],shear rate [1/s],viscosity [Pa.s]"]
    for row in range(30):
        flow = f"{RATES[row]},{STRESSES[row] / RATES[row]:.8g}" if row < RATES.size else ","
        swing = f"{5 + row}" if row < 12 else ""
        lines.append(f"{row},{100 + row},{20 + row},{swing},{flow}")
    assert_is_the_curve(written(tmp_path, "\n".join(lines)))


@pytest.mark.parametrize("head", ["rpm,dial reading", "Speed [rpm],Theta", "RPM,Lectura"])
def test_a_rotor_speed_is_asked_about_with_the_factors_of_the_commonest_geometry(
    tmp_path: Path, head: str
) -> None:
    speed, reading = (name.partition(" [")[0] for name in head.split(","))
    path = written(tmp_path, f"{head}\n{rows(RATES / 1.7023, STRESSES / 0.511)}")
    with pytest.raises(MappingError, match="speed of a rotor") as asked:
        read_flow_curves(path)
    answers = {"shear_rate": f"{speed} [1.7023 1/s]", "stress": [f"{reading} [0.511 Pa]"]}
    assert answers["shear_rate"] in asked.value.remedy
    assert answers["stress"][0] in asked.value.remedy
    assert_is_the_curve(path, **answers)


@pytest.mark.parametrize(
    "head",
    [
        "Sample,R600,R300,R200,R100,R6,R3",
        "No,600 rpm,300 rpm,200 rpm,100 rpm,6 rpm,3 rpm",
        "t,Theta 600,Theta 300,Theta 100,Theta 6",
    ],
)
def test_readings_at_one_speed_each_are_a_curve_a_row(tmp_path: Path, head: str) -> None:
    readings = [row * np.linspace(60.0, 5.0, head.count(",")) for row in (1.0, 1.1, 1.3)]
    lines = [
        f"{place},{','.join(f'{value:.1f}' for value in row)}" for place, row in enumerate(readings)
    ]
    with pytest.raises(MappingError, match="a row is a flow curve") as asked:
        read_flow_curves(written(tmp_path, "\n".join([head, *lines])))
    rate, stress = "[1.7023 1/s]", "[0.511 Pa]"
    assert rate in asked.value.remedy
    assert stress in asked.value.remedy
    file = read_flow_curves(tmp_path / "flow.csv", shear_rate=rate, stress=[stress])
    speeds = [float("".join(filter(str.isdigit, name))) for name in head.split(",")[1:]]
    for curve, row in zip(file.curves, readings, strict=True):
        assert curve.rate == pytest.approx(1.7023 * np.array(speeds))
        assert curve.stress == pytest.approx(0.511 * row, rel=1e-3, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    "names", [("KCl polymer", "Bentonite 6 %"), ("A", "A"), ("rpm", "12 ppg [base]")]
)
def test_curves_of_a_dial_have_the_names_of_their_muds(
    tmp_path: Path, names: tuple[str, str]
) -> None:
    lines = ["Mud;R600;R300;R100;R6;PV, cP"]
    lines += [f"{name};{60 + k};{40 + k};{20 + k};{6 + k};19" for k, name in enumerate(names)]
    path = written(tmp_path, "\n".join(lines))
    curves = read_flow_curves(path, shear_rate="[1.7023 1/s]", stress=["[0.511 Pa]"]).curves
    assert [curve.stress[0] / 0.511 for curve in curves] == pytest.approx([60.0, 61.0])
    for curve, name in zip(curves, names, strict=True):
        assert curve.label.startswith(name)
    assert curves[0].label != curves[1].label


@pytest.mark.parametrize("mark", ["\t", ",", ";"])
def test_a_hold_and_an_oscillation_of_rheowin_are_parted_from_the_ramp(
    tmp_path: Path, mark: str
) -> None:
    lines = ["SegIndex,t in s,G' in Pa,\u03c4 in Pa,\u0263\u0307 in 1/s"]
    lines += [f"1|{k},{k},{100 + k},5,0.1" for k in range(1, 8)]  # an oscillation
    lines += [
        f"2|{k},{k},,{40 - k},600" for k in range(1, 30)
    ]  # a hold, in which the structure breaks down
    lines += [f"3|{k},{k},,{stress:g},{rate:g}" for k, (rate, stress) in POINTS]
    assert_is_the_curve(written(tmp_path, "\n".join(lines).replace(",", mark)))


def test_the_segments_of_a_printed_table_of_rheowin_are_parted(tmp_path: Path) -> None:
    lines = ["\tt in s\tt_seg in s\tG' in Pa\tTau in Pa\tGP in 1/s"]
    lines += [f"1-{k}\t{k}\t{k}\t\t{400 - 9 * k}\t300" for k in range(1, 30)]  # a hold
    lines += [f"2-{k}\t{k}\t{k}\t\t{stress:g}\t{rate:g}" for k, (rate, stress) in POINTS]
    assert_is_the_curve(written(tmp_path, "\n".join(lines)))


def test_the_rate_of_a_stress_is_no_stress(tmp_path: Path) -> None:
    text = f"strain_rate [1/s],stress [Pa],stress_rate\n{rows(RATES, STRESSES, 9e3 * STRESSES)}"
    assert_is_the_curve(written(tmp_path, text))


@pytest.mark.parametrize(
    "rates", [np.repeat([100.0, 511.0], 3), np.array([1.0, 1.01, 100.0, 100.0, 1.0, 1.01])]
)
def test_a_course_at_two_rates_is_no_flow_curve(tmp_path: Path, rates: Array) -> None:
    text = f"shear rate [1/s],shear stress [Pa]\n{rows(rates, STRESSES)}"
    with pytest.raises(MappingError, match="one of two shear rates"):
        read_flow_curves(written(tmp_path, text))


def test_a_course_without_a_stress_is_said_to_be_no_steady_rotation(tmp_path: Path) -> None:
    text = f"shear rate [1/s],shear stress [Pa]\n{rows(RATES, -0.5 * STRESSES)}"
    with pytest.raises(LogError, match="6 of 6 points have no stress along their rate"):
        read_flow_curves(written(tmp_path, text))


def test_a_unit_that_nobody_knows_stops_no_column_that_is_not_used(tmp_path: Path) -> None:
    text = f"Shear Rate [1/s],Shear Stress [Pa],Load [PSIg]\n{rows(RATES, STRESSES, np.arange(6.0) // 3)}"
    assert_is_the_curve(written(tmp_path, text))


def test_samples_of_viscosities_without_a_unit_are_asked_about(tmp_path: Path) -> None:
    lines = ["Shear Rate,Viscosity,Particle Size,Temperature"]
    for size in (100, 300):
        for temperature in (20, 30):
            for rate in RATES:
                lines.append(f"{rate},{(size + temperature) / rate:.6g},{size},{temperature}")
    path = written(tmp_path, "\n".join(lines))
    with pytest.raises(MappingError, match="parts the points into 2 sweeps") as asked:
        read_flow_curves(path)
    assert "Particle Size=all" in asked.value.remedy
    curves = read_flow_curves(
        path, stress=["Viscosity [mPa*s]"], sheet=["Particle Size=all"]
    ).curves
    assert len(curves) == 4  # the temperature parts them too
    assert sorted(float(curve.stress[0]) for curve in curves) == pytest.approx(
        [0.12, 0.13, 0.32, 0.33], rel=1e-4
    )


@pytest.mark.slow
def test_words_that_a_spreadsheet_filled_down_are_no_rows(tmp_path: Path) -> None:
    content = [["Shear Rate (1/s)", "Shear Stress (Pa)", "Bob"]]
    content += [[rate, stress, "B5"] for rate, stress in zip(RATES, STRESSES, strict=True)]
    content += [[None, None, "B5"]] * 80
    assert_is_the_curve(workbook(tmp_path, {"Raw Data": content}))


@pytest.mark.slow
def test_a_workbook_may_hold_decimal_commas_as_texts_beside_its_numbers(tmp_path: Path) -> None:
    content: list[list[Any]] = [["t", "Shear Rate (1/s)", "Shear Stress (Pa)"]]
    for place, (rate, stress) in POINTS:
        content.append(
            [
                f"0,{place}5",
                float(rate),
                f"{stress:g}".replace(".", ",") if place == 4 else float(stress),
            ]
        )
    path = workbook(tmp_path, {"Raw Data": content, "Notes": [["a", "b"], ["x", 1], ["y", 2]]})
    assert_is_the_curve(path)


@pytest.mark.slow
def test_numbers_that_a_workbook_took_for_thousands_are_not_read(tmp_path: Path) -> None:
    content: list[list[Any]] = [["Shear Rate (1/s)", "Shear Stress (Pa)"]]
    content += [[float(rate), f"0,{place}17"] for place, (rate, _) in POINTS]
    content.append([700.0, 1017])  # was 1,017
    with pytest.raises((LogError, MappingError)):
        read_flow_curves(workbook(tmp_path, {"Raw Data": content}))


def test_units_of_a_consistency_are_a_line_of_units(tmp_path: Path) -> None:
    lines = [
        "Rate\tStress\tn\tK\tKv\tKp",
        "sec^-1\tdyne/cm^2\t\tlbf*s^n/ft^2\tlbf*s^n/ft^2\tlbf*s^n/ft^2",
    ]
    lines += [
        f"{rate}\t{10 * stress}\t\t\t\t" for rate, stress in zip(RATES, STRESSES, strict=True)
    ]
    assert_is_the_curve(
        workbook(tmp_path, {"a": [[_number(cell) for cell in line.split("\t")] for line in lines]})
    )


def _number(cell: str) -> str | float:
    try:
        return float(cell)
    except ValueError:
        return cell


@pytest.mark.slow
@pytest.mark.parametrize("index", [2.8, 3.9])
@pytest.mark.parametrize("size", [1.0, 1e5])
def test_a_stiff_paste_that_turns_up_at_its_highest_rates_is_fitted(
    index: float, size: float
) -> None:
    rate = np.geomspace(0.1, 250.0, 24)
    stress = size * (1500.0 + 700.0 * (rate / 250.0) ** index)
    stress *= np.exp(0.02 * np.sin(np.arange(24.0) * 2.4))  # what an instrument misses
    fit = fit_flow_curve(FlowCurve("paste", rate, stress), "herschel-bulkley")
    found = {each.name: each.value for each in fit.estimates}
    assert found["m"] == pytest.approx(index, rel=0.3)
    assert next(iter(found.values())) > 0.0
    assert fit.log_rmse < 0.01


TIMES = np.arange(60.0)
DECAY = np.exp(-TIMES / 20.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "kind"),
    [
        (
            "Time [s],Shear Strain [%],Shear Stress [Pa],Shear Rate [1/s]\n"
            + rows(TIMES, 3.0 + 0.01 * TIMES - DECAY, np.full(60, 10.0), 0.01 + 0.05 * DECAY),
            "a creep",
        ),
        (
            "time,strain,stress\n" + rows(TIMES, np.minimum(1.0, TIMES / 3.0), 10.0 * DECAY),
            "a relaxation",
        ),
        (
            "Zeit [s];Dehnung [%];Schubspannung [Pa]\n" + rows(TIMES, np.ones(60), DECAY, mark=";"),
            "a relaxation",
        ),
        (
            "Step time [s],Oscillation displacement [rad],Oscillation torque [N.m],Storage modulus,Loss modulus\n"
            + rows(TIMES, 1.0 + TIMES, 2.0 + TIMES, 9.0 + DECAY, 3.0 + DECAY),
            "an oscillation of a rheometer",
        ),
    ],
)
def test_a_creep_and_a_relaxation_are_said_to_be_for_no_command(
    tmp_path: Path, text: str, kind: str
) -> None:
    done = run("inspect", written(tmp_path, text))
    assert done.code == 1
    last = done.out.splitlines()[-1]
    assert kind in last
    assert "neither fit nor flowcurve" in last


@pytest.mark.slow
def test_a_sweep_of_the_stress_in_time_is_no_creep(tmp_path: Path) -> None:
    stress = np.geomspace(1.0, 100.0, 60)
    text = "Time [s],Shear Strain [%],Shear Stress [Pa],Shear Rate [1/s]\n" + rows(
        TIMES, stress, stress, stress / 2.0
    )
    assert "neither fit" not in run("inspect", written(tmp_path, text)).out


@pytest.mark.parametrize(
    ("stress", "viscosity", "factor"),
    [("N/M2", "mPas", 1.0), ("D/CM2", "CP", 10.0)],
)
def test_lines_that_a_brookfield_prints_are_read(
    tmp_path: Path, stress: str, viscosity: str, factor: float
) -> None:
    lines = [
        f" RPM=0.0 M=LV    S=40 %=0.0   {viscosity}=0.00  {stress}=0.00  1/SEC=0.000 T=----C  Z00:01 "
    ]
    for place, (rate, tau) in POINTS:
        values = f"{viscosity}={1000 * tau / rate:.3f} {stress}={factor * tau:g}  1/SEC={rate:g}"
        lines.append(
            f"?RPM={rate / 7.5:g} M=LV    S=40 %={place + 20}.5  {values}  T=25.0C  Z00:0{place} "
        )
        lines.append(
            f" RPM={rate / 7.5:g} M=LV S=40 %=EEEE {viscosity}=EEEE {stress}=EEEE 1/SEC={rate:g} T=25.0C Z00:0{place} "
        )
    assert_is_the_curve(written(tmp_path, "\n".join(lines) + "\n", "trial.txt"))
