"""Flow curves in the languages of instruments and with their spellings of units; other tests are told by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError, UnitError
from erclutch.wings.rheology.flow_curve_file import read_flow_curves
from tests.support.command import good

RATES = np.geomspace(0.1, 1000.0, 13)
STRESSES = 5.0 + 2.0 * RATES**0.5


def written(folder: Path, text: str, name: str = "flow.csv", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def table(head: str, *further: str) -> str:
    """A header above rates, stresses in Pa and further cells."""
    rows = [
        ",".join([f"{rate:.5g}", f"{stress:.6g}", *further])
        for rate, stress in zip(RATES, STRESSES, strict=True)
    ]
    return "\n".join([head, *rows]) + "\n"


@pytest.mark.parametrize(
    ("rate", "stress"),
    [
        ("gamma-dot", "shear-stress"),
        ("Taxa de cisalhamento (1/s)", "Tensão de cisalhamento (Pa)"),
        ("Velocidad de deformación [1/s]", "Esfuerzo cortante [Pa]"),
        ("Vitesse de déformation [1/s]", "Contrainte [Pa]"),
        ("Gradiente di velocità [1/s]", "Sforzo di taglio [Pa]"),
        ("Скорость сдвига, 1/с", "Напряжение сдвига, Па"),
        ("전단속도", "전단응력"),
        ("ずり速度 [1/s]", "ずり応力 [Pa]"),
        ("剪切速度", "剪切应力"),
        ("Szybkość ścinania [1/s]", "Naprężenie ścinające [Pa]"),
    ],
)
def test_rates_and_stresses_are_known_in_many_languages(
    tmp_path: Path, rate: str, stress: str
) -> None:
    text = table(f"{rate};{stress}".replace(",", " ")).replace(",", ";")
    (curve,) = read_flow_curves(written(tmp_path, text)).curves
    np.testing.assert_allclose(curve.rate, RATES, rtol=1e-4)
    np.testing.assert_allclose(curve.stress, STRESSES, rtol=1e-4)


@pytest.mark.parametrize(
    ("rate", "stress", "factor"),
    [
        ("Shear Rate 1/s", "Shear Stress Pa", 1.0),
        ("Shear rate (sec-1)", "Shear stress (D/cm2)", 0.1),
        ("Shear rate (s^{-1})", "Shear stress (D/cm²)", 0.1),
        ("Shear rate (/s)", "Shear stress (dyn/cm^2)", 0.1),
        ("Shear rate (reciprocal seconds)", "Shear stress (lb/100ft2)", 0.4788026),
        ("Shear rate [S-1]", "Shear stress [PA]", 1.0),
        ("Shear rate, 1/sec", "Shear stress, kPa", 1000.0),
    ],
)
def test_units_are_read_as_instruments_spell_them(
    tmp_path: Path, rate: str, stress: str, factor: float
) -> None:
    text = table(f"{rate};{stress}").replace(",", ";", 0)
    text = text.replace(f"{rate};{stress}", f'"{rate}","{stress}"')
    (curve,) = read_flow_curves(written(tmp_path, text)).curves
    np.testing.assert_allclose(curve.rate, RATES, rtol=1e-4)
    np.testing.assert_allclose(curve.stress, factor * STRESSES, rtol=1e-4)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("cps", 1e-3), ("cp", 1e-3), ("mPa-s", 1e-3), ("Pa·S", 1.0), ("cPs", 1e-3), ("P", 0.1)],
)
def test_viscosities_times_rates_are_exact_in_each_spelling(
    tmp_path: Path, unit: str, factor: float
) -> None:
    viscosity = 7.0 + 3.0 / RATES
    body = "".join(
        f"{rate!r},{eta!r}\n" for rate, eta in zip(RATES.tolist(), viscosity.tolist(), strict=True)
    )
    (curve,) = read_flow_curves(
        written(tmp_path, f"Shear rate [1/s],Viscosity ({unit})\n{body}")
    ).curves
    np.testing.assert_allclose(curve.stress, factor * viscosity * RATES, rtol=1e-12)


def test_a_megapascal_is_no_millipascal(tmp_path: Path) -> None:
    body = "".join(f"{rate:.6g},{1 + rate:.6g}\n" for rate in RATES)
    (curve,) = read_flow_curves(
        written(tmp_path, f"Shear rate [1/s],Viscosity [MPa*s]\n{body}")
    ).curves
    np.testing.assert_allclose(curve.stress, 1e6 * RATES * (1 + RATES), rtol=1e-4)


@pytest.mark.slow
def test_two_viscosities_without_a_unit_take_one_answer(tmp_path: Path) -> None:
    body = "".join(f"{rate:.6g},{9 + 1 / rate:.6g},{7 + 1 / rate:.6g}\n" for rate in RATES)
    path = written(tmp_path, f"Shear rate [1/s],Viscosity 20 C,Viscosity 40 C\n{body}")
    file = read_flow_curves(path)
    assert [curve.stress_unit for curve in file.curves] == ["?", "?"]
    command = '--stress "Viscosity 20 C [mPa*s]" "Viscosity 40 C [mPa*s]"'
    assert command in file.notes[-1]
    said = good("flowcurve", str(path), "--laws", "bingham", "--stress", *command.split('"')[1::2])
    assert "2 of 2" in said


def test_a_wanted_rate_is_none_that_was_measured(tmp_path: Path) -> None:
    text = table(
        "Shear Rate 1/s,Shear Stress Pa,Target Shear Rate 1/s,Angular Velocity rad/s", "7", "3"
    )
    (curve,) = read_flow_curves(written(tmp_path, text)).curves
    np.testing.assert_allclose(curve.rate, RATES, rtol=1e-4)


@pytest.mark.parametrize(
    "head", ["Strain [%],Shear Stress [Pa],Time [s]", "Time [s],Torque [mN m],Temperature [°C]"]
)
def test_no_column_of_another_quantity_is_offered_as_a_rate_or_stress(
    tmp_path: Path, head: str
) -> None:
    with pytest.raises(
        MappingError, match="no flow curve: no column is surely the shear rate"
    ) as caught:
        read_flow_curves(written(tmp_path, table(head, "3")))
    assert "--" not in caught.value.remedy


def test_a_time_beside_rates_is_not_offered_as_a_stress(tmp_path: Path) -> None:
    with pytest.raises(MappingError, match="no column is surely the shear stress") as caught:
        read_flow_curves(
            written(tmp_path, table("Shear rate [1/s],Time [s],Temperature [°C]", "25"))
        )
    assert "--" not in caught.value.remedy


@pytest.mark.slow
@pytest.mark.parametrize(
    "head",
    [
        "Frequency [Hz],Storage modulus [Pa],Loss modulus [Pa]",
        "Angular frequency [rad/s],G' [Pa],G'' [Pa]",
        "Kreisfrequenz [rad/s],Speichermodul [Pa],Verlustmodul [Pa]",
        "角周波数 [rad/s],貯蔵弾性率 [Pa],損失弾性率 [Pa]",
    ],
)
def test_an_oscillation_is_told_to_be_no_flow_curve_and_no_log(tmp_path: Path, head: str) -> None:
    path = written(tmp_path, table(head, "3"))
    with pytest.raises(MappingError, match="oscillation"):
        read_flow_curves(path)
    last = good("inspect", "flow.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert "an oscillation of a rheometer" in last
    assert last.endswith("no log of a device, no flow curve")


@pytest.mark.slow
def test_an_oscillation_whose_time_stands_still_is_told_as_one(tmp_path: Path) -> None:
    head = "Average Time [s],Deflection Angle [rad],Torque [N*m],Storage Modulus [Pa],Loss Modulus [Pa]"
    swings = [f"{np.sin(row / 9):.5f},{np.cos(row / 9):.5f}" for row in range(256)]
    rows = [f"4,{swing},900,{30 + row}" for row, swing in enumerate(swings)]
    written(tmp_path, "\n".join([head, *rows]) + "\n")
    last = good("inspect", "flow.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert "an oscillation of a rheometer" in last
    asked = ("--position", "Deflection Angle", "--effort", "Torque", "--field", "none")
    last = good("inspect", "flow.csv", *asked, cwd=tmp_path, code=1).splitlines()[-1]
    assert "an oscillation" not in last  # who says how it is read is told what is wrong with that


@pytest.mark.slow
@pytest.mark.parametrize(
    "head",
    [
        "Time [s],Shear Rate [1/s],Torque [mN m],Shear Stress [Pa]",
        "時間 [s],せん断速度 [1/s],トルク [mN*m],せん断応力 [Pa]",
    ],
)
def test_a_shear_rate_beside_a_torque_is_no_slip_of_a_device(tmp_path: Path, head: str) -> None:
    rows = [
        f"{k},{rate:.5g},{0.02 * tau:.5g},{tau:.6g}"
        for k, (rate, tau) in enumerate(zip(RATES, STRESSES, strict=True))
    ]
    written(tmp_path, "\n".join([head, *rows]))
    effort_is_a_stress = head.startswith("Time")
    last = good(
        "inspect", "flow.csv", cwd=tmp_path, code=0 if effort_is_a_stress else 1
    ).splitlines()[-1]
    said = "Or as a flow curve" if effort_is_a_stress else "What settles it"
    assert last == f"{said}: erclutch flowcurve flow.csv"


def compass(marks: list[str], names: str, units: str, number: str) -> str:
    """Two tests as RheoCompass writes them, with marks of a language."""
    lines: list[str] = []
    for test in ("soap 1", "soap 2"):
        *heads, interval, data = marks
        lines += [f"{head}\t{test if k == 0 else 'a result, 0,5'}" for k, head in enumerate(heads)]
        lines += ["", f"{interval}\t1\t13", f"{data}\t{names}", "\t\t\tword\t", f"\t\t{units}"]
        for k, (rate, tau) in enumerate(zip(RATES, STRESSES, strict=True), start=1):
            cells = [
                f"{rate:.4e}".upper() if rate > 100 else f"{rate:.5f}".replace(".", number),
                f"{tau:.6f}".replace(".", number),
            ]
            lines.append("\t".join(["", str(k), *cells]))
        lines.append("")
    return "\r\n".join(lines)


@pytest.mark.parametrize(
    ("marks", "names", "number"),
    [
        (
            ["Versuch:", "Ergebnis:", "Abschnitt und Datenpunkte:", "Abschnittsdaten:"],
            "Punkt Nr.\tScherrate\tSchubspannung",
            ",",
        ),
        (
            ["テスト:", "結果:", "インターバルとデータポイント:", "インターバルデータ:"],
            "ポイント No.\tせん断速度\tせん断応力",
            ".",
        ),
        (
            ["Essai:", "Résultat:", "Intervalle et points:", "Données:"],
            "Point\tTaux de cisaillement\tContrainte de cisaillement",
            ",",
        ),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_exports_of_rheocompass_are_cut_in_any_language(
    tmp_path: Path, marks: list[str], names: str, number: str, encoding: str
) -> None:
    text = compass(marks, names, "[1/s]\t[Pa]", number)
    curves = read_flow_curves(written(tmp_path, text, encoding=encoding)).curves
    assert [curve.label.split(",")[0] for curve in curves] == ["soap 1", "soap 2"]
    for curve in curves:
        np.testing.assert_allclose(curve.rate, RATES, rtol=1e-4)
        np.testing.assert_allclose(curve.stress, STRESSES, rtol=1e-4)


def test_a_head_of_another_instrument_stays_a_plain_table(tmp_path: Path) -> None:
    text = "Channels:\t2\t3\nNames:\tLeft\tRight\n" + table(
        "Shear rate [1/s],Shear stress [Pa]"
    ).replace(",", "\t")
    (curve,) = read_flow_curves(written(tmp_path, text)).curves
    assert curve.rate.size == RATES.size


def test_rates_that_wander_about_rest_are_left_out_with_a_word(tmp_path: Path) -> None:
    rest = "".join(f"{rate},4.{k}\n" for k, rate in enumerate((-0.0003, 0.0002, -0.0001)))
    file = read_flow_curves(written(tmp_path, table("Shear rate [1/s],Shear stress [Pa]") + rest))
    assert (
        file.curves[0].rate.size == RATES.size
    )  # the rate of 0.0002 1/s is noise as its neighbours are
    assert any("3 points left out: a rate of 0.0003 1/s or less" in note for note in file.notes)


def test_pairs_that_all_fall_with_the_rate_are_viscosities_and_one_answer_gives_their_unit(
    tmp_path: Path,
) -> None:
    lines = ["0.3,,0.4,", "X,Y,X,Y"]
    lines += [f"{rate:.6g},{5 + 9 / rate:.6g},{rate:.6g},{6 + 9 / rate:.6g}" for rate in RATES]
    path = written(tmp_path, "\n".join(lines).replace("0.3", "Ht30").replace("0.4", "Ht40", 1))
    file = read_flow_curves(path)
    assert [curve.stress_unit for curve in file.curves] == ["?", "?"]
    np.testing.assert_allclose(file.curves[0].stress, (5 + 9 / RATES) * RATES, rtol=1e-4)
    assert "since each falls all the way: --stress '[mPa*s]' gives the unit" in file.notes[0]
    curves = read_flow_curves(path, stress=["[mPa*s]"]).curves
    assert [curve.label for curve in curves] == ["Ht30", "Ht40"]
    np.testing.assert_allclose(curves[0].stress, 1e-3 * (5 + 9 / RATES) * RATES, rtol=1e-4)
    np.testing.assert_allclose(
        read_flow_curves(path, stress=["[Pa]"]).curves[1].stress, 6 + 9 / RATES, rtol=1e-4
    )
    with pytest.raises(UnitError, match="no unit of a stress"):
        read_flow_curves(path, stress=["[mm]"])


def test_a_pair_that_falls_beside_a_pair_that_rises_is_asked_about(tmp_path: Path) -> None:
    lines = ["oil,,gel,"]
    lines += [f"{rate:.6g},{5 + 9 / rate:.6g},{rate:.6g},{6 + rate:.6g}" for rate in RATES]
    with pytest.raises(MappingError, match="falls as the first grows, as a viscosity does"):
        read_flow_curves(written(tmp_path, "\n".join(lines)))


def test_a_count_beside_one_sweep_of_the_rate_parts_nothing(tmp_path: Path) -> None:
    counts = [1, 3, 7, 6, 7, 7, 7, 5, 4, 3, 1, 3, 3]
    rows = [
        f"{rate:.5g},{tau:.6g},{n}" for rate, tau, n in zip(RATES, STRESSES, counts, strict=True)
    ]
    text = "\n".join(["Shear rate [1/s],Shear stress [Pa],N_Repeticoes", *rows])
    (curve,) = read_flow_curves(written(tmp_path, text)).curves
    assert curve.rate.size == RATES.size


def test_a_creep_at_one_stress_is_no_flow_curve(tmp_path: Path) -> None:
    rows = [f"{k},{2 + 9 * (1 - 0.7**k):.5g},{4.0 + 0.001 * (k % 2)}" for k in range(20)]
    path = written(tmp_path, "\n".join(["Time [s],Shear Rate [1/s],Shear Stress [Pa]", *rows]))
    with pytest.raises(
        MappingError, match="all points have the shear stress 4 Pa, which is no flow curve"
    ):
        read_flow_curves(path)


def test_a_test_that_cannot_be_read_leaves_the_others(tmp_path: Path) -> None:
    text = compass(
        ["Test:", "Result:", "Interval and data points:", "Interval data:"],
        "Point No.\tShear Rate\tShear Stress",
        "[1/s]\t[Pa]",
        ".",
    )
    last = text.rindex("\t13\t")
    broken = text[:last] + text[last:].replace("\t13\t", "\t13\t-")
    file = read_flow_curves(written(tmp_path, broken))
    assert [curve.label.split(",")[0] for curve in file.curves] == ["soap 1"]
    assert any("soap 2" in note and "no flow curve (row 13" in note for note in file.notes)
