"""Files of flow curves are read by names and units, in every form that instruments write, or asked about."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError, MappingError, SettingError, UnitError
from erclutch.wings.rheology.flow_curve_file import FlowFile, read_flow_curves
from tests.support.examples import examples

RATES = [0.1, 0.4642, 2.154, 10.0, 46.42, 215.4]
STRESSES = [80.3, 81.1, 83.2, 88.4, 102.7, 139.5]
Written = Callable[..., Path]


@pytest.fixture
def written(tmp_path: Path) -> Written:
    """Writes a file of flow curves."""

    def write(text: str, encoding: str = "utf-8", name: str = "curve.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(text.encode(encoding))
        return path

    return write


def rows(
    *columns: list[float] | list[str],
    head: str = "",
    between: str = ",",
    decimal: str = ".",
    form: str = "{:.6g}",
) -> str:
    lines = [head] if head else []
    for row in zip(*columns, strict=True):
        cells = [
            cell if isinstance(cell, str) else form.format(cell).replace(".", decimal)
            for cell in row
        ]
        lines.append(between.join(cells))
    return "\n".join(lines) + "\n"


def holds_the_curve(file: FlowFile, count: int = 1) -> bool:
    """Whether each curve has the points above, in 1/s and Pa, to the digits that were written."""
    return len(file.curves) == count and all(
        np.allclose(curve.rate, RATES, rtol=1e-5) and np.allclose(curve.stress, STRESSES, rtol=1e-5)
        for curve in file.curves
    )


# --- names and units --------------------------------------------------------------------------------------------------

#: Header, factor of the written rates, factor of the written stresses.
HEADERS = {
    "plain": ("rate [1/s],stress [Pa]", 1.0, 1.0),
    "kilopascal": ("rate [1/s],1 kV/mm [kPa]", 1.0, 1e-3),
    "per minute": ("rate [1/min],1 kV/mm [Pa]", 60.0, 1.0),
    "dyn": ("shear rate (1/s),shear stress (dyn/cm^2)", 1.0, 10.0),
    "german": ("Schergeschwindigkeit [1/s],Schubspannung [Pa]", 1.0, 1.0),
    "french": ("taux de cisaillement [1/s],contrainte [Pa]", 1.0, 1.0),
    "spanish": ("velocidad de cizalla [1/s],esfuerzo cortante [Pa]", 1.0, 1.0),
    "chinese": ("剪切速率 [1/s],剪切应力 [Pa]", 1.0, 1.0),
    "japanese": ("せん断速度 [1/s],せん断応力 [Pa]", 1.0, 1.0),
    "malvern": ("Shear rate(s-¹),Shear stress(Pa)", 1.0, 1.0),
    "greek": ("γ̇ [1/s],τ [Pa]", 1.0, 1.0),
}


@pytest.mark.parametrize("kind", HEADERS)
def test_names_and_units(written: Written, kind: str) -> None:
    head, per_second, pascal = HEADERS[kind]
    text = rows([x * per_second for x in RATES], [y * pascal for y in STRESSES], head=head)
    assert holds_the_curve(read_flow_curves(written(text)))


@pytest.mark.parametrize(
    ("unit", "factor"), [("Pa.s", 1.0), ("mPa·s", 1e3), ("Pas", 1.0), ("mPas", 1e3), ("cP", 1e3)]
)
def test_a_viscosity_becomes_a_stress(written: Written, unit: str, factor: float) -> None:
    viscosity = [factor * y / x for x, y in zip(RATES, STRESSES, strict=True)]
    text = rows(RATES, viscosity, head=f"rate [1/s],viscosity [{unit}]", form="{:.9g}")
    file = read_flow_curves(written(text))
    assert holds_the_curve(file)
    assert "stress = viscosity x shear rate" in file.notes


@pytest.mark.parametrize(
    ("name", "factor"), [("Viscosity_cP", 1e3), ("eta_mPas", 1e3), ("viscosity_Pa_s", 1.0)]
)
def test_a_unit_at_the_end_of_a_name_is_that_of_a_viscosity(
    written: Written, name: str, factor: float
) -> None:
    viscosity = [factor * y / x for x, y in zip(RATES, STRESSES, strict=True)]
    assert holds_the_curve(
        read_flow_curves(written(rows(RATES, viscosity, head=f"rate,{name}", form="{:.9g}")))
    )


def test_a_slash_behind_an_underscore_is_within_the_unit(written: Written) -> None:
    viscosity = [1e3 * y / x for x, y in zip(RATES, STRESSES, strict=True)]
    head = "speed_RPM,SR_1/s,Viscosity_cP,SS_dyne/cm2"
    text = rows(RATES, RATES, viscosity, [10.0 * y for y in STRESSES], head=head, form="{:.9g}")
    assert holds_the_curve(read_flow_curves(written(text)))


@pytest.mark.slow
@pytest.mark.parametrize("column", ["sample", "Probe", "direction"])
def test_points_of_several_words_are_a_curve_each_and_none_is_mixed(
    written: Written, column: str
) -> None:
    lines = [
        f"{word},{x:.6g},{y:.6g}"
        for word in ("A", "B 2")
        for x, y in zip(RATES, STRESSES, strict=True)
    ]
    path = written(
        f"{column},rate [1/s],stress [Pa]\n" + "\n".join(lines) + "\nC,1,1\nC,1,1\nC,1,1\n"
    )
    for file in (read_flow_curves(path), read_flow_curves(path, sheet=[f"{column}=all"])):
        assert holds_the_curve(file, count=2)
    said = f'column {column} parts the points into 3: A, B 2, C: each is a curve (--sheet "{column}=A" takes one)'
    assert read_flow_curves(path).notes[0] == said
    assert [curve.label for curve in file.curves] == [f"{column}=A", f"{column}=B 2"]
    assert holds_the_curve(read_flow_curves(path, sheet=[f"{column}=A"]))


@pytest.mark.slow
def test_points_that_two_columns_of_words_part_are_asked_about(written: Written) -> None:
    lines: list[str] = []
    for oil, state in (("A", "new"), ("A", "used"), ("B", "new"), ("B", "used")):
        lines += [f"{oil},{state},{x:.6g},{y:.6g}" for x, y in zip(RATES, STRESSES, strict=True)]
    path = written("oil,state,rate [1/s],stress [Pa]\n" + "\n".join(lines) + "\n")
    with pytest.raises(MappingError, match="column oil parts the points into 2: A, B") as caught:
        read_flow_curves(path)
    assert '--sheet "oil=all"' in caught.value.remedy


@pytest.mark.slow
def test_a_gamma_beside_a_tau_of_several_samples_is_settled_by_one_command(
    written: Written,
) -> None:
    lines = [
        f"{word},1,{x:.6g},{y:.6g}"
        for word in ("A", "B")
        for x, y in zip(RATES, STRESSES, strict=True)
    ]
    path = written("amostra,fase,gamma,tau\n" + "\n".join(lines) + "\n")
    with pytest.raises(MappingError, match="no column is surely the shear rate") as caught:
        read_flow_curves(path)
    assert caught.value.remedy.endswith('such as --shear-rate "gamma [1/s]" --sheet "amostra=all"')
    assert holds_the_curve(
        read_flow_curves(path, shear_rate="gamma [1/s]", sheet=["amostra=all"]), count=2
    )


def test_what_an_instrument_notes_beside_points_parts_no_curve(written: Written) -> None:
    status = ["low"] * 3 + ["ok"] * 3
    text = rows(status, RATES, STRESSES, head="Status,rate [1/s],stress [Pa]")
    assert holds_the_curve(read_flow_curves(written(text)))


def test_other_columns_are_left_out_and_listed(written: Written) -> None:
    viscosity = [1e3 * y / x for x, y in zip(RATES, STRESSES, strict=True)]
    number = [float(i) for i in range(1, 7)]
    head = "Point No.,Temperature [°C],Shear Rate [1/s],Shear Stress [Pa],Viscosity [mPa·s]"
    file = read_flow_curves(
        written(rows(number, [25.1] * 6, RATES, STRESSES, viscosity, head=head, form="{:.9g}"))
    )
    assert holds_the_curve(file)
    assert any(note.startswith("not used: Point No., Temperature") for note in file.notes)


def test_stresses_ahead_of_rates(written: Written) -> None:
    assert holds_the_curve(
        read_flow_curves(written(rows(STRESSES, RATES, head="shear stress [Pa],shear rate [1/s]")))
    )


@pytest.mark.parametrize(
    ("between", "decimal", "encoding", "before"),
    [
        (",", ".", "utf-8-sig", ""),
        (",", ".", "utf-8", "# rheometer X\n"),
        ("\t", ".", "utf-16", ""),
        ("\t", ",", "utf-8", ""),
        (";", ",", "latin-1", ""),
        (";", ",", "utf-8", ""),
    ],
)
def test_dialects(written: Written, between: str, decimal: str, encoding: str, before: str) -> None:
    text = before + rows(
        RATES,
        STRESSES,
        head=f"Scherrate [1/s]{between}1 kV/mm [Pa]",
        between=between,
        decimal=decimal,
    )
    assert holds_the_curve(read_flow_curves(written(text, encoding)))


def test_a_column_of_each_field(written: Written) -> None:
    head = "rate [1/s],0 kV/mm [Pa],1 kV/mm [Pa]"
    file = read_flow_curves(written(rows(RATES, STRESSES, STRESSES, head=head)))
    assert holds_the_curve(file, count=2)
    assert [curve.label for curve in file.curves] == ["0 kV/mm", "1 kV/mm"]


@pytest.mark.slow
def test_options_settle_what_is_not_known(written: Written) -> None:
    path = written(rows(RATES, [y * 1e-3 for y in STRESSES], [1.0] * 6, head="a,b,c"))
    with pytest.raises(
        MappingError, match=r"no column is surely the shear rate .*--shear-rate \"a \[1/s\]\""
    ):
        read_flow_curves(path)
    with pytest.raises(MappingError, match=r"--stress"):
        read_flow_curves(
            written(rows(RATES, [5.0, 4, 3, 2, 1, 0.5], head="a,b"), name="falling.csv"),
            shear_rate="a [1/s]",
        )
    assert holds_the_curve(read_flow_curves(path, shear_rate="a [1/s]", stress=["b [kPa]"]))
    with pytest.raises(MappingError, match="there is no column 'z'"):
        read_flow_curves(path, shear_rate="z")


def test_columns_named_after_the_sample_are_told(written: Written) -> None:
    file = read_flow_curves(written(rows(RATES, STRESSES, STRESSES, head="rate,A,B")))
    assert holds_the_curve(file, count=2)
    assert any(
        "taken for a stress in Pa because it grows with the rate" in note for note in file.notes
    )


@pytest.mark.parametrize(
    ("head", "words"),
    [
        (
            "shear rate [rpm],stress [Pa]",
            "no column is the shear rate: 'shear rate' is the speed of a rotor",
        ),
        (
            "shear rate [Pa],shear stress [Pa]",
            "is a shear rate by its name and a shear stress by its unit",
        ),
        ("frequency [Hz],storage modulus [Pa]", "the test is an oscillation"),
        ("shear rate [1/s],normal stress [Pa]", "no column is surely the shear stress"),
        ("shear rate [1/s],G' storage modulus [Pa]", "the test is an oscillation"),
    ],
)
def test_other_quantities_are_not_taken(written: Written, head: str, words: str) -> None:
    with pytest.raises(MappingError, match=words):
        read_flow_curves(written(rows(RATES, STRESSES, head=head)))


def test_a_stress_that_its_viscosity_contradicts_is_asked_about(written: Written) -> None:
    viscosity = [y / x for x, y in zip(RATES, STRESSES, strict=True)]
    path = written(
        rows(
            RATES,
            STRESSES,
            viscosity,
            head="rate [1/s],stress [Pa],viscosity [mPa·s]",
            form="{:.9g}",
        )
    )
    with pytest.raises(
        UnitError, match=r"'stress' \[Pa\] is 1000 times .* one of these units is wrong"
    ):
        read_flow_curves(path)
    assert holds_the_curve(read_flow_curves(path, shear_rate="rate [1/s]", stress=["stress [Pa]"]))


# --- points -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("never", [-999.0, -9999.0, 9999.0])
def test_what_was_not_measured_is_left_out(written: Written, never: float) -> None:
    text = rows([0.05, *RATES, 500.0], [never, *STRESSES, never], head="rate [1/s],1 kV/mm [Pa]")
    file = read_flow_curves(written(text))
    assert holds_the_curve(file)
    assert any("2 of 8 points left out" in note for note in file.notes)


def test_points_at_rest_and_half_points_are_left_out(written: Written) -> None:
    text = "rate [1/s],stress [Pa]\n0,0\n" + rows(RATES, STRESSES) + "300,\n"
    file = read_flow_curves(written(text))
    assert holds_the_curve(file)
    assert sum("1 of 8 points left out" in note for note in file.notes) == 2


def test_magnitudes_of_a_turn_the_other_way(written: Written) -> None:
    text = rows([-x for x in RATES], [-y for y in STRESSES], head="rate [1/s],stress [Pa]")
    file = read_flow_curves(written(text))
    assert holds_the_curve(file)
    assert any("6 points turn the other way" in note for note in file.notes)


def test_signs_that_contradict_each_other_are_refused(written: Written) -> None:
    text = rows(RATES, [80.3, -81.1, 83.2, 88.4, 102.7, 139.5], head="rate [1/s],stress [Pa]")
    with pytest.raises(LogError, match="row 2 of the table"):
        read_flow_curves(written(text))


def test_faint_stresses_of_the_wrong_sign_are_noise_and_told(written: Written) -> None:
    text = rows([0.001, 0.01, *RATES], [-0.2, -0.02, *STRESSES], head="rate [1/s],stress [Pa]")
    file = read_flow_curves(written(text))
    assert holds_the_curve(file)
    assert any(
        "2 points left out: a stress of the other sign than its rate, below 2 %" in note
        for note in file.notes
    )
    with pytest.raises(LogError, match="row 1 of the table"):
        read_flow_curves(written(text.replace("-0.2", "-20")))


# --- pairs of columns -------------------------------------------------------------------------------------------------


def test_pairs_of_columns_of_different_length(written: Written) -> None:
    file = read_flow_curves(written("0.68,,0.70,\n1,10,1,20\n2,11,3,21\n,,5,22\n,,7,23\n"))
    assert [(c.label, c.rate.tolist(), c.stress.tolist()) for c in file.curves] == [
        ("0.68", [1.0, 2.0], [10.0, 11.0]),
        ("0.7", [1.0, 3.0, 5.0, 7.0], [20.0, 21.0, 22.0, 23.0]),
    ]


def test_pairs_under_texts(written: Written) -> None:
    file = read_flow_curves(written("0 V;;1 kV;\n1,5;2;1;3\n2,5;3;2;4\n3;4;;\n"))
    assert [(c.label, c.rate.tolist()) for c in file.curves] == [
        ("0 V", [1.5, 2.5, 3.0]),
        ("1 kV", [1.0, 2.0]),
    ]


def test_numbers_without_labels_are_asked_about(written: Written) -> None:
    with pytest.raises(MappingError, match="no column is surely the shear rate"):
        read_flow_curves(written("1,10\n2,20\n3,30\n4,40\n"))


# --- exports of instruments -------------------------------------------------------------------------------------------


def rheocompass(between: str = "\t", decimal: str = ".") -> str:
    def number(x: float) -> str:
        return f"{x:.6g}".replace(".", decimal)

    lines = [between.join(("Project:", "ER fluid")), between.join(("Test:", "sample 7")), ""]
    for interval, field in ((1, 0), (2, 1)):
        lines += [
            between.join(("Result:", f"{field} kV/mm")),
            between.join(("Interval and data points:", str(interval), "6")),
            between.join(
                ("Interval data:", "Point No.", "Shear Rate", "Shear Stress", "Viscosity", "Status")
            ),
            between * 5,
            between.join(("", "", "[1/s]", "[Pa]", "[mPa·s]", "")),
        ]
        for i, (x, y) in enumerate(zip(RATES, STRESSES, strict=True), start=1):
            lines.append(
                between.join(
                    (
                        "",
                        str(i),
                        number(x),
                        number(y),
                        f"{1e3 * y / x:.9g}".replace(".", decimal),
                        "WMa",
                    )
                )
            )
        lines.append("")
    return "\n".join(lines)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("between", "decimal", "encoding"),
    [("\t", ".", "utf-16"), ("\t", ",", "utf-16"), (";", ",", "utf-8"), (",", ".", "utf-8")],
)
def test_an_export_of_rheocompass_has_all_its_tests(
    written: Written, between: str, decimal: str, encoding: str
) -> None:
    file = read_flow_curves(written(rheocompass(between, decimal), encoding))
    assert holds_the_curve(file, count=2)
    assert [curve.label for curve in file.curves] == ["0 kV/mm, interval 1", "1 kV/mm, interval 2"]
    one = read_flow_curves(written(rheocompass(between, decimal), encoding), sheet=["2"])
    assert [curve.label for curve in one.curves] == ["1 kV/mm, interval 2"]
    with pytest.raises(SettingError, match="there is no test 'three'"):
        read_flow_curves(written(rheocompass()), sheet=["three"])


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_workbook_of_rheocompass_has_its_tests_under_their_names(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for oil in ("oil A", "oil B"):
        for cells in (["Project:", "fluids"], [], ["Test:", oil], ["Result:", "Viscosity curve 1"]):
            book.active.append(cells)
        book.active.append(["Interval and data points:", 1, 6])
        book.active.append(["Interval data:", "Point No.", "Shear Rate", "Shear Stress", "Status"])
        book.active.append(["", "", "Constant component"])
        book.active.append(["", "", "[1/s]", "[Pa]"])
        for i, (x, y) in enumerate(zip(RATES, STRESSES, strict=True), start=1):
            book.active.append(["", i, x, y, "Dy_auto"])
        book.active.append([])
    book.save(tmp_path / "book.xlsx")
    file = read_flow_curves(tmp_path / "book.xlsx")
    assert holds_the_curve(file, count=2)
    names = [f"{oil}, Viscosity curve 1, interval 1" for oil in ("oil A", "oil B")]
    assert [curve.label for curve in file.curves] == names


def test_an_export_of_rheoplus(written: Written) -> None:
    points = "\n".join(
        f"{i};{x:g};{y:g};{1e3 * y / x:.9g};"
        for i, (x, y) in enumerate(zip(RATES, STRESSES, strict=True), 1)
    )
    text = (
        "Data Series Information\nName:;sample 1\nNumber of Intervals:;1\n\nInterval:;1\nNumber of Data Points:;6\n\n"
        f"Meas. Pts.;Shear Rate;Shear Stress;Viscosity;Status\n;[1/s];[Pa];[mPa·s];[]\n\n{points}\n"
    ).replace("[]\n\n", "[]\n")
    file = read_flow_curves(written(text))
    assert holds_the_curve(file)


def test_an_export_of_rheowin(written: Written) -> None:
    def number(x: float) -> str:
        return f"{x:.9g}".replace(".", ",")

    points = "".join(
        f"3|{i};{number(x)};{number(y)};{number(y / x)};25,0;{i},5;\n"
        for i, (x, y) in enumerate(zip(RATES, STRESSES, strict=True), start=1)
    )
    rest = "".join(f"1|{i}; ;0,0{i}; ;17,86;{i},239;\n" for i in range(1, 5))
    text = "C:\\job.rwd\nDate / Time / Version: - / - / HAAKE RheoWin 4\n\n"
    text += ";GP in 1/s;Tau in Pa;Eta in Pas;T in °C;t in s;\n"
    file = read_flow_curves(written(text + rest + points, "latin-1", "job.txt"))
    assert holds_the_curve(file)
    assert [curve.label for curve in file.curves] == ["segment 3"]
    assert any(note.startswith("segment 1: no flow curve") for note in file.notes)


def test_an_export_of_trios(written: Written) -> None:
    points = "".join(
        f"{y:.9g}\t{x:.9g}\t{y / x:.9g}\t25.0\n" for x, y in zip(RATES, STRESSES, strict=True)
    )
    names = "Stress\tShear rate\tViscosity\tTemperature\nPa\t1/s\tPa.s\t°C\n"
    text = "Filename\tsample\n[Parameters]\nRunBy\tTRIOS\n\n[step]\nConditioning\n\n"
    text += f"[step]\nFlow sweep - 1\n{names}{points}"
    file = read_flow_curves(written(text, name="trios.txt"))
    assert holds_the_curve(file)


@pytest.mark.slow
def test_sheets_of_a_workbook(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["remarks", "none"])
    for field in (0, 1):
        sheet = book.create_sheet(f"{field} kV")
        sheet.append(["shear rate [1/s]", "shear stress [Pa]"])
        for row in zip(RATES, STRESSES, strict=True):
            sheet.append(list(row))
    book.save(tmp_path / "book.xlsx")
    file = read_flow_curves(tmp_path / "book.xlsx")
    assert holds_the_curve(file, count=2)
    assert [curve.label for curve in file.curves] == ["0 kV", "1 kV"]


# --- what cannot be read ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"\n\n,,,\n", "no row of numbers"),
        (b"rate,stress\n", "no row of numbers"),
        (bytes(range(128, 256)) * 10, "text|table|numbers"),
    ],
)
def test_bad_files(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_bytes(content)
    with pytest.raises(ErclutchError, match=words):
        read_flow_curves(path)


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="there is no such file"):
        read_flow_curves(tmp_path / "gone.csv")
    with pytest.raises(LogError, match="this is a folder"):
        read_flow_curves(tmp_path)


def curves_or_an_error(path: Path) -> None:
    """Whatever is read has a label, and positive finite numbers, a rate and a stress each."""
    try:
        file = read_flow_curves(path)
    except ErclutchError:
        return
    assert file.curves
    for curve in file.curves:
        assert curve.label
        assert curve.rate.shape == curve.stress.shape
        assert np.all(
            np.isfinite(curve.rate)
            & (curve.rate > 0)
            & np.isfinite(curve.stress)
            & (curve.stress > 0)
        )


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.text("0123456789.,;eE-+\t\n\"' rateP1/s[]", max_size=120))
def test_almost_tables_give_curves_or_an_error_of_ours(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "almost.csv"
    path.write_text("rate [1/s],stress [Pa]\n" + text)
    curves_or_an_error(path)


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.integers(0, 900), st.binary(min_size=1, max_size=6))
def test_damaged_exports_give_curves_or_an_error_of_ours(
    tmp_path_factory: pytest.TempPathFactory, place: int, damage: bytes
) -> None:
    data = rheocompass().encode()
    path = tmp_path_factory.getbasetemp() / "damaged.csv"
    path.write_bytes(data[:place] + damage + data[place + len(damage) :])
    curves_or_an_error(path)
